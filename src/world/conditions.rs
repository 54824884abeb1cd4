//! How the robot perceives and obeys in one episode.

use super::drive::ActuationSpec;
use super::sense::{LocalisationSpec, SensingSpec};
use crate::rng::EpisodeSeed;

/// How the robot perceives and obeys in one episode. The default is a perfect robot that senses 5 m around itself.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// Source of the episode's noise.
    pub seed: EpisodeSeed,
    /// What it senses of its surroundings (scenario key `sensing`).
    pub sensing: SensingSpec,
    /// How well it knows where it is (scenario key `localisation`).
    pub localisation: LocalisationSpec,
    /// How well it does what it is told (scenario key `actuation`).
    pub actuation: ActuationSpec,
}
