//! The weight alpha of zhao2025's improved A* along its path, on maps of two sizes.
//!
//! ```sh
//! cargo run --release --example alpha_along_path
//! ```
//!
//! Its estimate counts alpha = atan(obstacles in the box from the node to the goal / distance from start to goal) times. A weight above 1 hurries to
//! the goal, one below 1 searches more widely than A*, 0 is Dijkstra's search.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use simrun::experiment::Experiment;
use simrun::plan::PlanningGrid;
use simrun::plan::contract::Problem;
use simrun::plan::global::GlobalChoice;
use simrun::plan::global::atan_a_star::{Density, WeightForm};
use simrun::scenario::{Edit, ScenarioFile};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    println!("| map | alpha at the start | after 1/4 | 1/2 | 3/4 of the path | nodes of the path with alpha >= 1 |");
    println!("|---|---|---|---|---|---|");
    for (side, obstacles) in [(20, 60), (40, 240)] {
        let file = ScenarioFile::open("scenarios/papers/zhao2025_table1.yaml")?;
        let sizes = [("cols", side), ("rows", side), ("obstacles", obstacles)];
        let mut edits = sizes
            .map(|(key, value)| Edit::parse(&format!("map.random.{key}={value}")))
            .into_iter()
            .collect::<Result<Vec<_>, _>>()?;
        edits.push(Edit::parse(&format!("goal={{cell: [{0}, {0}]}}", side - 1))?);
        let experiment = Experiment::load(&file, &edits)?;
        let mut planner = GlobalChoice::by_name("atan_a_star")?.build();
        let planner = planner.as_grid().ok_or("no planner on the grid")?;
        let (mut at, mut greedy, mut nodes, worlds) = ([0.0; 4], 0, 0, 100);
        for episode in 0..worlds {
            let scene = experiment.scene(0, episode)?;
            let (map, field) = (&scene.map.grid, &scene.map.field);
            let grid = PlanningGrid::new(map, field, 0.0);
            let problem =
                Problem { grid: &grid, start: map.cell_at(scene.start.position), goal: map.cell_at(scene.goal) };
            let mut path = Vec::new();
            planner.search(&problem, &mut path).result?;
            let density = Density::new(&problem);
            let alpha = |k: usize| density.alpha_at(path[k], WeightForm::AtanMu);
            for (quarter, sum) in at.iter_mut().enumerate() {
                *sum += alpha((path.len() - 1) * quarter / 4) / f64::from(worlds as u32);
            }
            greedy += (0..path.len()).filter(|&k| alpha(k) >= 1.0).count();
            nodes += path.len();
        }
        let [start, quarter, half, last] = at;
        let share = 100.0 * greedy as f64 / nodes as f64;
        println!("| {side} x {side} | {start:.2} | {quarter:.2} | {half:.2} | {last:.2} | {share:.0} % |");
    }
    Ok(())
}
