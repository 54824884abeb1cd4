//! A planner of your own, outside the crate, in a world built in code: no YAML.
//!
//! Run with `cargo run --release --example own_planner`.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use simrun::episode::{DT_S, Runner, Setting, TerminationSpec};
use simrun::geometry::Twist;
use simrun::map::OccupancyGrid;
use simrun::plan::contract::{Decision, Failure, Guidance, LocalPlanner, Situation};
use simrun::plan::global::GlobalChoice;
use simrun::plan::stack::Stack;
use simrun::rng::EpisodeSeed;
use simrun::robot::Robot;
use simrun::world::{Conditions, Scene, SceneSpec, StaticMap};
use std::error::Error;
use std::sync::Arc;

/// Turns towards the sub-goal and drives the faster, the better it points there. Avoids nothing.
struct TurnAndDrive {
    /// Yaw rate per radian of bearing, 1/s.
    gain: f64,
}

impl LocalPlanner for TurnAndDrive {
    fn decide(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>) -> Result<Decision, Failure> {
        let bearing = situation.pose.bearing_to(guidance.sub_goal);
        let alignment = if bearing.abs() < 1.0 { 1.0 - bearing.abs() } else { 0.0 };
        let command = Twist { v: situation.robot.speed_max_mps * alignment, omega: self.gain * bearing };
        Ok(Decision::track(command))
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let hall = OccupancyGrid::from_ascii(
        &[
            "....................",
            "....................",
            "....................",
            ".........##.........",
            ".........##.........",
            "....................",
            "....................",
            "....................",
        ],
        0.5,
    );
    let map = Arc::new(StaticMap::new(hall));
    let robot = Robot::default();
    let global = GlobalChoice::by_name("a_star")?.build();

    let mut stack = Stack::new(Some(global), Vec::new(), Box::new(TurnAndDrive { gain: 1.5 }));
    let (conditions, termination) = (Conditions::default(), TerminationSpec::default());
    let mut runner = Runner::default();
    for episode in 0..5 {
        let seed = EpisodeSeed { seed: 1, episode };
        let scene = Scene::generate(&SceneSpec::default(), &map, &robot, seed)?;
        let setting =
            Setting { scene: &scene, robot: &robot, conditions: &conditions, termination: &termination, way_m: None };
        let outcome = runner.run(setting, &mut stack);
        let time_s = (runner.record.trace.ticks.len() - 1) as f64 * DT_S;
        println!("episode {episode}: {} after {time_s:.1} s", outcome.name());
    }
    Ok(())
}
