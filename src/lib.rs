//! simrun drives a differential-drive AGV through a 2-D world, headless, tick by tick, and compares the planners that drive it.
//!
//! ```text
//! scenario.yaml ──► Scenario ──► map, world, stacks, seeds
//!                                  │   one block = one world (an episode), driven by every stack
//!                                  ▼
//!     ┌──────────────────── episode: every control period ──────────────────┐
//!     │  world (rapier2d, the truth) ── Situation ──► stack ──► Decision     │
//!     │        ▲                         (the belief)   global × local │     │
//!     │        └──────────── actuate, step, judge ◄────────────────────┘     │
//!     └─────────────────────────────┬───────────────────────────────────────┘
//!                                   ▼ Trace
//!                        metrics ──► results (CSV) ──► pictures
//! ```
//!
//! **Data flows one way**, and a module imports only from those above it in this order: [`math`], [`settings`], [`geometry`],
//! [`digest`], [`rng`], [`clock`], [`guard`], [`files`]; [`map`], [`robot`], [`observation`]; [`plan`]; [`world`]; [`trace`], [`episode`],
//! [`metrics`]; [`scenario`]; [`analysis`], [`results`], [`experiment`], [`comparison`], [`mod@paper`]; [`report`], [`cli`]. Planners never see the world: they
//! meet in [`episode`] alone, through a [`plan::contract::Situation`] and a [`plan::contract::Decision`].
//!
//! **Frames and units.** SI throughout, angles in radians, x forward or east, y left or north, yaw counter-clockwise. Inside, positions
//! are in the *grid frame*, whose origin is the map's lower left corner; scenario files, tables and traces use the map's own
//! *world frame* ([`map::Frame`]). Time is an integer tick of the control period.
//!
//! **Determinism.** The same scenario, seed and build give the same bytes for any number of threads, in debug and release: named random
//! streams ([`rng`]), portable transcendental functions ([`math`]), no wall clock ([`clock`] feeds `timings.csv` alone), specified ties.
//!
//! **Papers.** What a planner's documentation cites as G-A11, §7.4 or `systems.md` stands in `docs/book/src/papers/systems.md`: each formula of
//! the papers, what is unclear in it, and how simrun reads it.
//!
//! A world built in code, driven by planners of the registry:
//!
//! ```
//! use simrun::episode::{Outcome, Runner, Setting, TerminationSpec};
//! use simrun::map::OccupancyGrid;
//! use simrun::plan::{global::GlobalChoice, local::LocalChoice, stack::Stack};
//! use simrun::rng::EpisodeSeed;
//! use simrun::robot::Robot;
//! use simrun::world::{Conditions, Scene, SceneSpec, StaticMap};
//! use std::sync::Arc;
//!
//! let hall = OccupancyGrid::from_ascii(&["..........", "....##....", "..........", ".........."], 1.0);
//! let robot = Robot::default();
//! let seed = EpisodeSeed { seed: 1, episode: 0 };
//! let scene = Scene::generate(&SceneSpec::default(), &Arc::new(StaticMap::new(hall)), &robot, seed)?;
//!
//! let (global, local) = (GlobalChoice::by_name("a_star")?, LocalChoice::by_name("dwa")?);
//! let mut stack = Stack::new(Some(global.build()), Vec::new(), local.build());
//! let (conditions, termination) = (Conditions::default(), TerminationSpec::default());
//! let setting = Setting { scene: &scene, robot: &robot, conditions: &conditions, termination: &termination, way_m: None };
//! let outcome = Runner::default().run(setting, &mut stack);
//! assert_eq!(outcome, Outcome::Success);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod analysis;

pub mod cli;
pub mod clock;
pub mod command;
pub mod comparison;
pub mod digest;
pub mod episode;
pub mod experiment;
pub mod files;
pub mod geometry;
pub mod guard;
pub mod map;
pub mod math;
pub mod metrics;
pub mod observation;
pub mod paper;
pub mod plan;
pub mod report;
pub mod results;
pub mod rng;
pub mod robot;
pub mod scenario;
pub mod settings;
pub mod trace;
pub mod world;
