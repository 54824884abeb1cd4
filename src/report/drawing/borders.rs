//! Borders of areas of cells: few long lines rather than many squares, without seams between them.

/// A corner between cells: column and row of the cell above and to the right of it.
pub(super) type Corner = [i32; 2];

/// The borders of the cells of a grid of `cols` × `rows` for which `inside` holds. Each closes, holds only the corners at which it
/// turns, and has the inside on its left, so that a hole runs the other way round. Cells that only meet at a corner are apart.
pub(super) fn borders(cols: i32, rows: i32, inside: &dyn Fn(i32, i32) -> bool) -> Vec<Vec<Corner>> {
    let is_inside = |[col, row]: Corner| (0..cols).contains(&col) && (0..rows).contains(&row) && inside(col, row);
    let index = |[col, row]: Corner| row as usize * cols as usize + col as usize;
    // Every border has a lower edge, along which it goes to the right.
    let mut walked = vec![false; cols as usize * rows as usize];
    let mut all = Vec::new();
    for row in 0..rows {
        for col in 0..cols {
            let cell = [col, row];
            if !is_inside(cell) || is_inside([col, row - 1]) || walked[index(cell)] {
                continue;
            }
            let mut border = Vec::new();
            let (mut at, mut way) = (cell, RIGHT);
            loop {
                if way == RIGHT {
                    // Once round.
                    if core::mem::replace(&mut walked[index(at)], true) {
                        break;
                    }
                }
                at = [at[0] + way[0], at[1] + way[1]];
                let (left, right) = ahead(at, way);
                if !is_inside(left) {
                    border.push(at);
                    way = [-way[1], way[0]];
                } else if is_inside(right) {
                    border.push(at);
                    way = [way[1], -way[0]];
                }
            }
            all.push(border);
        }
    }
    all
}

const RIGHT: Corner = [1, 0];

/// The cells ahead to the left and to the right of one who comes to a corner.
fn ahead([col, row]: Corner, way: Corner) -> (Corner, Corner) {
    let [upper_right, upper_left, lower_left, lower_right] =
        [[col, row], [col - 1, row], [col - 1, row - 1], [col, row - 1]];
    match way {
        RIGHT => (upper_right, lower_right),
        [0, 1] => (upper_left, upper_right),
        [-1, 0] => (lower_left, upper_left),
        _ => (lower_right, lower_left),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Cell, OccupancyGrid};

    fn of(lines: &[&str]) -> Vec<Vec<Corner>> {
        let grid = OccupancyGrid::from_ascii(lines, 1.0);
        borders(grid.cols(), grid.rows(), &|col, row| !grid.is_free(Cell { col, row }))
    }

    /// Twice the area inside a border, positive if it runs counter-clockwise.
    fn doubled_area(border: &[Corner]) -> i32 {
        let next = border.iter().cycle().skip(1);
        border.iter().zip(next).map(|([x0, y0], [x1, y1])| x0 * y1 - x1 * y0).sum()
    }

    #[test]
    fn a_block_is_four_corners() {
        assert_eq!(of(&["....", ".##.", ".##."]), [vec![[3, 0], [3, 2], [1, 2], [1, 0]]]);
    }

    #[test]
    fn a_hole_runs_the_other_way_and_areas_add_up() {
        let ring = of(&["####", "#..#", "####"]);
        assert_eq!(ring.iter().map(|border| doubled_area(border)).collect::<Vec<_>>(), [24, -4]);
    }

    #[test]
    fn cells_that_meet_at_a_corner_are_apart() {
        let two = of(&[".#", "#."]);
        assert_eq!(two.iter().map(|border| doubled_area(border)).collect::<Vec<_>>(), [2, 2]);
    }

    #[test]
    fn the_areas_of_a_wild_map_add_up_to_its_cells() {
        let mut state = 7_u32;
        let mut occupied = vec![false; 40 * 30];
        for cell in &mut occupied {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            *cell = state >> 30 > 1;
        }
        let count = occupied.iter().filter(|&&cell| cell).count() as i32;
        let borders = borders(40, 30, &|col, row| occupied[(row * 40 + col) as usize]);
        assert_eq!(borders.iter().map(|border| doubled_area(border)).sum::<i32>(), 2 * count);
    }
}
