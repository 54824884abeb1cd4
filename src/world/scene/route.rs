//! The reference route: a way from start to goal that belongs to no planner.
//!
//! Dijkstra's algorithm on the known map, 8 neighbours, no corner cut, the cost of entering a cell being the
//! length of the step times 1 + 0.3 U(0, 1) with one draw per cell. This search is the world's own: were a
//! planner's used, obstacles "on the route" would lie in the way of the stacks that plan like it.

use crate::geometry::{Path, Vec2};
use crate::map::{Cell, OccupancyGrid};
use crate::math;
use crate::rng::{EpisodeSeed, Purpose};
use core::cmp::Reverse;
use std::collections::BinaryHeap;

/// Largest surcharge on the length of a step, as a share of it.
const NOISE: f64 = 0.3;

/// The straight steps, counter-clockwise: the diagonal after each lies between it and the next.
const STRAIGHT: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];

/// The reference route from `start` to `goal` (grid frame) over the `passable` cells; the cells of the ends need not be
/// passable. `None` if the ends are not connected.
///
/// Ties: the smaller cell index is expanded first, and a parent is replaced only by a cheaper one.
pub(super) fn reference_route(
    grid: &OccupancyGrid,
    passable: &[bool],
    start: Vec2,
    goal: Vec2,
    seed: EpisodeSeed,
) -> Option<Path> {
    let mut stream = seed.stream(Purpose::ReferenceRoute, 0);
    let price: Vec<f64> = passable.iter().map(|_| 1.0 + NOISE * stream.uniform()).collect();
    let (from, to) = (grid.index(grid.cell_at(start)), grid.index(grid.cell_at(goal)));
    let open = |cell: Cell| {
        grid.contains(cell) && {
            let index = grid.index(cell);
            passable[index] || index == from || index == to
        }
    };

    let mut cost = vec![f64::INFINITY; passable.len()];
    let mut parent = vec![from; passable.len()];
    // Costs are positive, and the bits of positive floats are in the order of the floats.
    let mut queue = BinaryHeap::from([Reverse((0u64, from))]);
    cost[from] = 0.0;
    while let Some(Reverse((bits, index))) = queue.pop() {
        if bits != cost[index].to_bits() {
            continue;
        }
        if index == to {
            break;
        }
        let cell = grid.cell(index);
        let mut relax = |next: Cell, length: f64| {
            let next = grid.index(next);
            let candidate = cost[index] + length * price[next];
            if candidate < cost[next] {
                cost[next] = candidate;
                parent[next] = index;
                queue.push(Reverse((candidate.to_bits(), next)));
            }
        };
        for (k, (dx, dy)) in STRAIGHT.into_iter().enumerate() {
            let beside = Cell { col: cell.col + dx, row: cell.row + dy };
            if !open(beside) {
                continue;
            }
            relax(beside, 1.0);
            let (ex, ey) = STRAIGHT[(k + 1) % 4];
            let diagonal = Cell { col: beside.col + ex, row: beside.row + ey };
            if open(Cell { col: cell.col + ex, row: cell.row + ey }) && open(diagonal) {
                relax(diagonal, math::SQRT_2);
            }
        }
    }
    if cost[to].is_infinite() {
        return None;
    }

    // From the goal back; the first and last cells are represented by start and goal themselves.
    let mut vertices = vec![goal];
    let mut index = parent[to];
    while index != from {
        vertices.push(grid.centre(grid.cell(index)));
        index = parent[index];
    }
    vertices.push(start);
    vertices.reverse();
    Some(Path::polyline(&vertices))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::DistanceField;
    use crate::map::connectivity::passable;

    fn route_cost(grid: &OccupancyGrid, route: &Path, price: &[f64]) -> f64 {
        let cells: Vec<Cell> = route.vertices().map(|p| grid.cell_at(p)).collect();
        cells
            .windows(2)
            .map(|pair| {
                let (dx, dy) = (pair[1].col - pair[0].col, pair[1].row - pair[0].row);
                let length = match dx.abs() + dy.abs() {
                    1 => 1.0,
                    2 if dx != 0 && dy != 0 => math::SQRT_2,
                    _ => panic!("the route jumps"),
                };
                length * price[grid.index(pair[1])]
            })
            .sum()
    }

    #[test]
    fn the_route_is_the_cheapest_way_over_the_perturbed_cells() {
        for episode in 0..40 {
            let seed = EpisodeSeed { seed: 5, episode };
            let mut stream = seed.stream(Purpose::Map, 0);
            let mut grid = OccupancyGrid::empty(20, 15, 1.0);
            for index in 1..grid.occupied().len() - 1 {
                if stream.uniform() < 0.25 {
                    grid.set_occupied(grid.cell(index));
                }
            }
            let (start, goal) = (Cell { col: 0, row: 0 }, Cell { col: 19, row: 14 });
            let free = passable(&DistanceField::new(&grid), 0.25);
            let mut noise = seed.stream(Purpose::ReferenceRoute, 0);
            let price: Vec<f64> = free.iter().map(|_| 1.0 + NOISE * noise.uniform()).collect();
            // The oracle works in whole billionths.
            let oracle = pathfinding::prelude::dijkstra(
                &grid.index(start),
                |&index| {
                    let cell = grid.cell(index);
                    let steps = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy)));
                    let open = |col, row| grid.is_free(Cell { col, row });
                    steps
                        .filter(|&(dx, dy)| (dx, dy) != (0, 0))
                        .filter(|&(dx, dy)| {
                            open(cell.col + dx, cell.row + dy)
                                && open(cell.col + dx, cell.row)
                                && open(cell.col, cell.row + dy)
                        })
                        .map(|(dx, dy)| {
                            let next = Cell { col: cell.col + dx, row: cell.row + dy };
                            let length = if dx != 0 && dy != 0 { math::SQRT_2 } else { 1.0 };
                            (grid.index(next), (1e9 * length * price[grid.index(next)]) as u64)
                        })
                        .collect::<Vec<_>>()
                },
                |&index| index == grid.index(goal),
            );
            let route = reference_route(&grid, &free, grid.centre(start), grid.centre(goal), seed);
            assert_eq!(route.is_some(), oracle.is_some());
            if let (Some(route), Some((_, cost))) = (route, oracle) {
                assert!((route_cost(&grid, &route, &price) - 1e-9 * cost as f64).abs() < 1e-6);
                assert_eq!((route.start(), route.end()), (grid.centre(start), grid.centre(goal)));
            }
        }
    }

    #[test]
    fn start_and_goal_in_one_cell_or_at_one_point_have_a_route() {
        let grid = OccupancyGrid::empty(3, 3, 1.0);
        let seed = EpisodeSeed { seed: 1, episode: 1 };
        let (a, b) = (Vec2::new(1.2, 1.3), Vec2::new(1.8, 1.7));
        for (start, goal, length) in [(a, b, (b - a).norm()), (a, a, 0.0)] {
            let route = reference_route(&grid, &[true; 9], start, goal, seed).unwrap();
            assert!((route.length() - length).abs() < 1e-12 && route.start() == start && route.end() == goal);
        }
    }
}
