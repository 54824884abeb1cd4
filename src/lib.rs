//! simrun drives a differential-drive AGV through a 2-D world, headless, tick by tick.

pub mod analysis;
pub mod choice;
pub mod cli;
pub mod clock;
pub mod episode;
pub mod experiment;
pub mod geometry;
pub mod map;
pub mod math;
pub mod metrics;
pub mod observation;
pub mod plan;
pub mod quantity;
pub mod report;
pub mod results;
pub mod rng;
pub mod robot;
pub mod scenario;
pub mod trace;
pub mod world;
