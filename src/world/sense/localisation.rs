//! The believed pose of the robot.

use crate::geometry::{Pose, Vec2, wrap_angle};
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::settings::quantity::NonNegative;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How well the robot knows where it is (scenario key `localisation`); perfectly by default.
///
/// The believed pose is the true one plus an error in x, y and heading: a random walk that starts at 0 with the episode (the
/// drift of dead reckoning) plus noise that is drawn anew every tick. All of it is normal. What the robot senses it sees from
/// where it is and places as seen from where it believes to be. Goal and contact are judged on the truth.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct LocalisationSpec {
    /// Standard deviation of the noise of x and of y, m; default 0.
    pub position_noise_m: NonNegative,
    /// Standard deviation of the noise of the heading, rad; default 0.
    pub heading_noise_rad: NonNegative,
    /// Standard deviation of the drift of x and of y after one second, m; it grows with the root of time. Default 0.
    pub position_drift_m: NonNegative,
    /// Standard deviation of the drift of the heading after one second, rad; it grows with the root of time. Default 0.
    pub heading_drift_rad: NonNegative,
}

impl Default for LocalisationSpec {
    fn default() -> Self {
        let none = NonNegative::new(0.0);
        Self { position_noise_m: none, heading_noise_rad: none, position_drift_m: none, heading_drift_rad: none }
    }
}

/// The believed pose of the robot.
#[derive(Clone, Debug)]
pub(super) struct Localisation {
    spec: LocalisationSpec,
    noise: Stream,
    walk: Stream,
    drift: Pose,
    is_exact: bool,
    /// Root of the control period, √s: the drift of a tick grows with it.
    root_period: f64,
}

impl Localisation {
    pub(super) fn new(spec: &LocalisationSpec, seed: EpisodeSeed, period_s: f64) -> Self {
        Self {
            root_period: period_s.sqrt(),
            is_exact: *spec == LocalisationSpec::default(),
            noise: seed.stream(Purpose::Localisation, 0),
            walk: seed.stream(Purpose::Localisation, 1),
            drift: Pose::new(0.0, 0.0, 0.0),
            spec: spec.clone(),
        }
    }

    /// The believed pose at `tick` for the true pose `pose`. Must be called once a tick, in order.
    pub(super) fn believe(&mut self, pose: Pose, tick: u32) -> Pose {
        if self.is_exact {
            return pose;
        }
        if tick > 0 {
            let step = self.root_period;
            let draws = self.walk.at_tick(tick);
            let walked = self.spec.position_drift_m.get() * step * Vec2::new(draws.normal(), draws.normal());
            self.drift.position += walked;
            self.drift.theta += self.spec.heading_drift_rad.get() * step * draws.normal();
        }
        let draws = self.noise.at_tick(tick);
        let noise = self.spec.position_noise_m.get() * Vec2::new(draws.normal(), draws.normal());
        let turn = self.spec.heading_noise_rad.get() * draws.normal();
        Pose {
            position: pose.position + self.drift.position + noise,
            theta: wrap_angle(pose.theta + self.drift.theta + turn),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEED: EpisodeSeed = EpisodeSeed { seed: 4, episode: 2 };

    /// The errors in x, y and heading at the first ticks of a robot that stands at the origin.
    fn errors(spec: &LocalisationSpec, ticks: u32) -> Vec<Pose> {
        let mut localisation = Localisation::new(spec, SEED, 0.1);
        (0..ticks).map(|tick| localisation.believe(Pose::new(0.0, 0.0, 0.0), tick)).collect()
    }

    #[test]
    fn without_noise_the_robot_knows_where_it_is() {
        let pose = Pose::new(1.0, 2.0, 3.0);
        assert_eq!(Localisation::new(&LocalisationSpec::default(), SEED, 0.1).believe(pose, 5), pose);
    }

    #[test]
    fn drift_begins_at_zero_and_adds_up_in_steps_of_the_root_of_the_period() {
        let spec = LocalisationSpec { position_drift_m: NonNegative::new(0.2), ..LocalisationSpec::default() };
        let errors = errors(&spec, 5);
        assert_eq!(errors[0].position, Vec2::zeros());
        let mut walk = SEED.stream(Purpose::Localisation, 1);
        let mut expected = Vec2::zeros();
        for (tick, error) in (1..).zip(&errors[1..]) {
            let draws = walk.at_tick(tick);
            expected += 0.2 * 0.1f64.sqrt() * Vec2::new(draws.normal(), draws.normal());
            assert!((error.position - expected).norm() < 1e-12);
            assert_eq!(error.theta, 0.0);
        }
    }

    #[test]
    fn noise_does_not_add_up() {
        let spec = LocalisationSpec { heading_noise_rad: NonNegative::new(0.1), ..LocalisationSpec::default() };
        let errors = errors(&spec, 4);
        let mut noise = SEED.stream(Purpose::Localisation, 0);
        for (tick, error) in (0..).zip(&errors) {
            let draws = noise.at_tick(tick);
            let (_, _, turn) = (draws.normal(), draws.normal(), draws.normal());
            assert_eq!(error.theta, wrap_angle(0.1 * turn));
            assert_eq!(error.position, Vec2::zeros());
        }
    }
}
