//! qin2026, section 3.1: from a picture of a port to its grids of 25, 50 and 100 cells a side.

use super::support::root;
use simrun::experiment::Experiment;
use simrun::map::from_image::Params;
use simrun::map::{Cell, OccupancyGrid};
use simrun::scenario::{Edit, ScenarioFile};

/// The port of one map seed with cells of `resolution_m`.
fn port(resolution_m: f64) -> OccupancyGrid {
    let file = ScenarioFile::open(root().join("scenarios/papers/qin2026_table2.yaml")).unwrap();
    let map = format!("map={{port: {{resolution_m: {resolution_m}, map_seed: 5}}}}");
    let edits = [map.as_str(), "start=[1, 1, 0]", "goal=[24, 24]"].map(|edit| Edit::parse(edit).unwrap());
    OccupancyGrid::clone(&Experiment::load(&file, &edits).unwrap().scene(0, 0).unwrap().map.grid)
}

/// What a satellite would see of it, 20 pixels a metre, from the top: containers in four colours with dark gaps between them, grey ground with
/// oil and glare.
fn picture(port: &OccupancyGrid) -> Vec<[u8; 3]> {
    const CONTAINERS: [[u8; 3]; 4] = [[176, 58, 46], [31, 97, 141], [25, 111, 61], [183, 149, 11]];
    let (cols, rows) = (port.cols(), port.rows());
    let noise = |col: i32, row: i32| (col.wrapping_mul(7919) ^ row.wrapping_mul(104_729)).rem_euclid(23) as u8;
    let pixel = |index: i32| {
        let cell = Cell { col: index % cols, row: rows - 1 - index / cols };
        let dirt = noise(cell.col, cell.row);
        if !port.is_free(cell) {
            let [r, g, b] = CONTAINERS[((cell.col / 40 + 3 * (cell.row / 20)) % 4) as usize];
            return [r - dirt / 2, g - dirt / 2, b.saturating_sub(dirt / 2)];
        }
        if dirt == 3 { [250, 252, 255] } else { [118 + dirt, 120 + dirt, 122 + dirt] }
    };
    (0..cols * rows).map(pixel).collect()
}

#[test]
fn a_picture_of_a_port_becomes_the_port_at_every_resolution() {
    let fine = port(0.05);
    let pixels = picture(&fine);
    for (side, resolution_m) in [(25, 1.0), (50, 0.5), (100, 0.25)] {
        let params = Params { size: Some([side, side]), resolution_m, ..Params::default() };
        let (ours, drawn) = (params.grid(&pixels, fine.cols() as usize), port(resolution_m));
        let differ = ours.occupied().iter().zip(drawn.occupied()).filter(|(a, b)| a != b).count();
        assert_eq!(differ, 0, "{side} cells a side");
        assert!(drawn.occupied().iter().any(|&occupied| occupied));
    }
}
