//! One decision of the dynamic window: beside a peer, and beside the least work that the answer needs.
//!
//! The scenes are `benches/scenes/*.dwa`: 20 × 20 samples, 30 points each, obstacles that are points. simrun knows statics as
//! cells of a map and movers as discs, so the points are shown to it in two forms: as occupied cells of a known map of 0.1 m
//! (the decision with the patch in place; what a patch costs is a row of its own), and as sensed movers of radius 0.
//! simrun adds what the robot drives now to the 20 samples of each axis: 21 × 21 rollouts.

use crate::floor::Floor;
use crate::measure::{alone, pair};
use crate::{Line, Row, Settings, Target, scenes};
use rust_robotics_core::Point2D;
use rust_robotics_planning::dwa::{DWAConfig, DWAPlanner, DWAState};
use simrun::geometry::{Path, Pose, Twist, Vec2};
use simrun::map::OccupancyGrid;
use simrun::observation::{Belief, SensedObstacle};
use simrun::plan::contract::Situation;
use simrun::plan::contract::{Decision, Guidance, LocalPlanner};
use simrun::plan::local::dwa::{Params, Planner};
use simrun::robot::Robot;
use simrun::settings::quantity::Samples;
use std::collections::HashMap;

/// Side of the known map's cells, m.
const RESOLUTION_M: f64 = 0.1;
/// Side of the map, m.
const SIDE_M: f64 = 30.0;

/// Its rows.
pub const ROWS: &[Row] = &[
    Row {
        name: "decision/ring30",
        what: "one decision, points as cells of a known map, against rust_robotics_planning",
        target: Some(Target::AtMost(1.0 / 10.0)),
        measure: |settings| against_peer(settings, "ring30"),
    },
    Row {
        name: "decision/ring200",
        what: "the same",
        target: Some(Target::AtMost(1.0 / 40.0)),
        measure: |settings| against_peer(settings, "ring200"),
    },
    Row {
        name: "decision/mixed30",
        what: "the same",
        target: Some(Target::AtMost(1.0 / 10.0)),
        measure: |settings| against_peer(settings, "mixed30"),
    },
    Row {
        name: "decision/mixed200",
        what: "the same",
        target: Some(Target::AtMost(1.0 / 10.0)),
        measure: |settings| against_peer(settings, "mixed200"),
    },
    Row {
        name: "decision/as_movers",
        what: "one decision, points as sensed movers, against rust_robotics_planning",
        target: None,
        measure: as_movers,
    },
    Row {
        name: "decision/floor",
        what: "one decision against only the loads and the arithmetic that the answer needs",
        target: Some(Target::AtMost(2.5)),
        measure: against_floor,
    },
    Row {
        name: "decision/10_movers",
        what: "one decision among ten movers, predicted, in an open hall",
        target: None,
        measure: among_movers,
    },
    Row {
        name: "decision/fresh_patch",
        what: "one decision that also builds its patch (once per metre of motion), against one with the patch in place",
        target: None,
        measure: fresh_patch,
    },
];

const SCENES: [&str; 4] = ["ring30", "ring200", "mixed30", "mixed200"];

/// One decision: what is asked and all that it depends on.
pub struct Scene {
    numbers: HashMap<String, Vec<f64>>,
    points: Vec<Vec2>,
}

impl Scene {
    pub fn read(name: &str) -> Result<Self, String> {
        let file = scenes::folder().join(format!("{name}.dwa"));
        let text = std::fs::read_to_string(&file).map_err(|error| format!("{}: {error}", file.display()))?;
        let (mut numbers, mut points) = (HashMap::new(), Vec::new());
        for line in text.lines().filter(|line| !line.starts_with('#') && !line.starts_with("type")) {
            let mut words = line.split_whitespace();
            let Some(key) = words.next() else { continue };
            let values: Result<Vec<f64>, _> = words.map(str::parse).collect();
            let values = values.map_err(|error| format!("{}: `{line}`: {error}", file.display()))?;
            if key == "obs" {
                points.push(Vec2::new(values[0], values[1]));
            } else {
                numbers.insert(key.to_owned(), values);
            }
        }
        Ok(Self { numbers, points })
    }

    fn number(&self, key: &str) -> f64 {
        self.numbers[key][0]
    }

    fn goal(&self) -> Vec2 {
        Vec2::new(self.numbers["goal"][0], self.numbers["goal"][1])
    }

    fn pose(&self) -> Pose {
        let start = &self.numbers["start"];
        Pose::new(start[0], start[1], start[2])
    }

    fn twist(&self) -> Twist {
        let start = &self.numbers["start"];
        Twist { v: start[3], omega: start[4] }
    }

    /// A robot whose window is the one that the scene asks for.
    fn robot(&self) -> Robot {
        let (dt_s, twist) = (self.number("dt"), self.twist());
        Robot {
            radius_m: self.number("robot_radius"),
            reverse_speed_max_mps: 0.0 - self.number("v_lo"),
            speed_max_mps: self.number("v_hi"),
            acceleration_max_mps2: (self.number("v_hi") - twist.v) / dt_s,
            deceleration_max_mps2: (twist.v - self.number("v_lo")) / dt_s,
            yaw_rate_max_radps: self.number("w_hi"),
            yaw_acceleration_max_radps2: (self.number("w_hi") - twist.omega) / dt_s,
            ..Robot::default()
        }
    }

    /// An empty map, or one whose cells with a point in them are occupied.
    fn map(&self, with_points: bool) -> OccupancyGrid {
        let side = (SIDE_M / RESOLUTION_M).round() as i32;
        let mut map = OccupancyGrid::empty(side, side, RESOLUTION_M);
        for &point in self.points.iter().filter(|_| with_points) {
            map.set_occupied(map.cell_at(point));
        }
        map
    }

    fn movers(&self) -> Vec<SensedObstacle> {
        let still = |&position| SensedObstacle::disc(0, position, Vec2::zeros(), 0.0);
        self.points.iter().map(still).collect()
    }
}

/// A planner and what it sees.
pub struct Question {
    robot: Robot,
    belief: Belief,
    movers: Vec<SensedObstacle>,
    path: Path,
    pose: Pose,
    twist: Twist,
    planner: Planner,
}

impl Question {
    /// The scene's points as cells of the map.
    fn on_map(scene: &Scene) -> Self {
        Self::new(scene, &scene.map(true), Vec::new(), false)
    }

    /// The scene's points as movers.
    fn among_movers(scene: &Scene) -> Self {
        Self::new(scene, &scene.map(false), scene.movers(), false)
    }

    fn new(scene: &Scene, map: &OccupancyGrid, movers: Vec<SensedObstacle>, predict_dynamic: bool) -> Self {
        let params = Params {
            speed_samples: Samples::new(scene.number("n_v") as u32),
            yaw_rate_samples: Samples::new(scene.number("n_w") as u32),
            predict_dynamic,
            ..Params::default()
        };
        Self {
            robot: scene.robot(),
            belief: Belief::from(map),
            movers,
            path: Path::polyline(&[scene.pose().position, scene.goal()]),
            pose: scene.pose(),
            twist: scene.twist(),
            planner: Planner::new(&params),
        }
    }

    fn decide(&mut self) -> Decision {
        let (twist, obstacles) = (self.twist, self.movers.as_slice());
        let situation =
            Situation { twist, obstacles, ..Situation::new(&self.robot, &self.belief, self.pose, self.path.end()) };
        let guidance = Guidance::to_end(&self.path, 0.0);
        self.planner.decide(&situation, &guidance).expect("an answer")
    }

    /// The decision in words.
    fn answer(&mut self) -> String {
        let Decision { command, rollouts, rollout_points, .. } = self.decide();
        format!("{rollouts} rollouts, {rollout_points} points; v {:.3} omega {:.3}", command.v, command.omega)
    }
}

/// The peer at the same question, set up as its own example does.
fn peer(scene: &Scene) -> DWAPlanner {
    let (start, dt) = (&scene.numbers["start"], scene.number("dt"));
    let config = DWAConfig {
        max_speed: scene.number("v_hi"),
        min_speed: scene.number("v_lo"),
        max_yaw_rate: scene.number("w_hi"),
        max_accel: (scene.number("v_hi") - start[3]) / dt,
        max_delta_yaw_rate: scene.number("w_hi") / dt,
        v_resolution: (scene.number("v_hi") - scene.number("v_lo")) / scene.number("n_v"),
        yaw_rate_resolution: (scene.number("w_hi") - scene.number("w_lo")) / scene.number("n_w"),
        dt,
        predict_time: scene.number("horizon") - 0.5 * dt,
        robot_radius: scene.number("robot_radius"),
        ..Default::default()
    };
    let mut peer = DWAPlanner::new(config);
    peer.set_state(DWAState::new(start[0], start[1], start[2], start[3], start[4]));
    peer.set_goal(Point2D::new(scene.goal().x, scene.goal().y));
    peer.set_obstacles(scene.points.iter().map(|point| Point2D::new(point.x, point.y)).collect());
    peer
}

fn against_peer(settings: &Settings, name: &str) -> Result<Vec<Line>, String> {
    let scene = Scene::read(name)?;
    let mut ours = Question::on_map(&scene);
    let mut peer = peer(&scene);
    let counts = ours.answer();
    let times = pair(settings.pairs, || ours.decide(), || peer.plan_step());
    Ok(vec![Line::of(name, times, 1.0, counts)])
}

fn as_movers(settings: &Settings) -> Result<Vec<Line>, String> {
    let line = |name: &str| {
        let scene = Scene::read(name)?;
        let mut ours = Question::among_movers(&scene);
        let mut peer = peer(&scene);
        let counts = ours.answer();
        let times = pair(settings.pairs, || ours.decide(), || peer.plan_step());
        Ok(Line::of(name, times, 1.0, counts))
    };
    SCENES.into_iter().map(line).collect()
}

fn against_floor(settings: &Settings) -> Result<Vec<Line>, String> {
    let line = |name: &str| {
        let scene = Scene::read(name)?;
        let mut ours = Question::on_map(&scene);
        let counts = ours.answer();
        let robot = &ours.robot;
        let mut floor = Floor::new(&scene.map(true), scene.pose(), scene.goal(), robot, scene.number("n_v") as u32 + 1);
        let command = floor.decide();
        let counts =
            format!("{counts}; floor: {} points, v {:.3} omega {:.3}", floor.points(), command.v, command.omega);
        let times = pair(settings.pairs, || ours.decide(), || floor.decide());
        Ok(Line::of(name, times, 1.0, counts))
    };
    SCENES.into_iter().map(line).collect()
}

fn among_movers(settings: &Settings) -> Result<Vec<Line>, String> {
    let scene = Scene::read("mixed30")?;
    let centre = scene.pose().position;
    let movers = (0..10).map(|k| {
        let angle = std::f64::consts::TAU * f64::from(k) / 10.0;
        let away = Vec2::new(angle.cos(), angle.sin());
        let across = Vec2::new(-away.y, away.x);
        SensedObstacle::disc(0, centre + (1.5 + 0.3 * f64::from(k)) * away, 0.8 * across, 0.3)
    });
    let mut ours = Question::new(&scene, &scene.map(false), movers.collect(), true);
    let counts = ours.answer();
    Ok(vec![Line::alone("hall", alone(settings.pairs, || ours.decide()), 1.0, counts)])
}

fn fresh_patch(settings: &Settings) -> Result<Vec<Line>, String> {
    let line = |name: &str| {
        let scene = Scene::read(name)?;
        let (mut fresh, mut used) = (Question::on_map(&scene), Question::on_map(&scene));
        let counts = used.answer();
        let times = pair(
            settings.pairs,
            || {
                fresh.planner.reset();
                fresh.decide()
            },
            || used.decide(),
        );
        let build_us = (times.first.median - times.second.median) * 1e6;
        let speed = used.robot.speed_max_mps;
        let per_decision_us = build_us * speed * 0.1;
        let counts = format!("patch {build_us:.1} us, at {speed} m/s {per_decision_us:.2} us per decision; {counts}");
        Ok(Line::of(name, times, 1.0, counts))
    };
    SCENES.into_iter().map(line).collect()
}
