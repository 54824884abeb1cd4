//! Conditions of one episode: sensing, localisation and actuation of the robot.

use super::DT_S;
use super::drive::ActuationSpec;
use super::sense::{LocalisationSpec, SensingSpec};
use crate::rng::EpisodeSeed;
use crate::settings::quantity::Period;

/// Sensing, localisation and actuation of the robot in one episode. The default is a perfect robot that senses 5 m around
/// itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Conditions {
    /// Source of the episode's noise.
    pub seed: EpisodeSeed,
    /// Control period, s: how long a tick lasts. Default: 0.1.
    pub control_period_s: Period,
    /// Sensing of the surroundings (scenario key `sensing`).
    pub sensing: SensingSpec,
    /// Errors of the believed pose (scenario key `localisation`).
    pub localisation: LocalisationSpec,
    /// Errors and delay of the drive (scenario key `actuation`).
    pub actuation: ActuationSpec,
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            seed: EpisodeSeed::default(),
            control_period_s: Period::new(DT_S),
            sensing: SensingSpec::default(),
            localisation: LocalisationSpec::default(),
            actuation: ActuationSpec::default(),
        }
    }
}
