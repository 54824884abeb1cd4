//! How movers move, from tick to tick: one file per motion.
//!
//! A [`Motion`] is drawn once and is equal for all stacks. At the beginning of an episode it makes a driver, which keeps the
//! state of the motion and lays the mover's course through each tick: straight pieces, split where they meet a
//! static obstacle, turn at a waypoint or pass a sample. Movers pass through each other, and the robot never pushes them.

mod course;
pub mod patrol;
pub mod replay;

use super::obstacles::moving::{Mover, OnRobot};
use super::scene::{Digest, SceneError};
use super::statics::Statics;
use crate::geometry::Vec2;
use crate::rng::Stream;
use crate::settings::{Entry, registry};
use core::fmt::Debug;
use std::sync::Arc;

pub(super) use course::{Course, free_run};
pub use irregular::Irregular;
pub use patrol::Patrol;
pub use replay::{Replay, Sample};

registry! {
    /// How a mover goes on after it has set out.
    pub enum MotionChoice: "motion", Entry, dyn MotionSpec { uniform, irregular }
}

/// Behaviour of a motion that scenarios can choose.
pub trait MotionSpec {
    /// Checks the parameters; `key` is that of the motion, such as `….motion.irregular`.
    ///
    /// # Errors
    /// The first invalid parameter.
    fn check(&self, key: &str) -> Result<(), SceneError> {
        let _ = key;
        Ok(())
    }

    /// The motion of one mover. Its first speed is in the range `speed_mps`; `stream` is its own.
    fn motion(&self, speed_mps: [f64; 2], stream: Stream) -> Motion;
}

impl Default for MotionChoice {
    fn default() -> Self {
        Self::uniform(uniform::Params {})
    }
}

impl MotionChoice {
    /// Checks the parameters; `key` is that of the mover.
    ///
    /// # Errors
    /// The first invalid parameter.
    pub(super) fn check(&self, key: &str) -> Result<(), SceneError> {
        self.kind().check(&format!("{key}.motion.{}", self.name()))
    }
}

/// Motion of a mover; by default straight on at its velocity.
///
/// Two motions are equal if their fingerprints are.
#[derive(Clone, Debug)]
pub struct Motion(Arc<dyn MotionKind>);

/// Behaviour of every motion.
pub(super) trait MotionKind: Debug + Send + Sync {
    /// Adds everything that distinguishes this motion from a uniform one to a fingerprint.
    fn digest(&self, digest: &mut Digest);

    /// The driver of a mover that sets out with `velocity`.
    fn driver(&self, velocity: Vec2) -> Box<dyn Drive>;
}

/// Driver of one mover in one episode.
pub(super) trait Drive: Debug {
    /// Makes the changes with which a tick begins: another velocity, whether the mover is there.
    fn begin(&mut self, mover: &mut Mover, tick: Span) {
        let _ = (mover, tick);
    }

    /// Direction in which the mover wants to go (any length), by which it yields to a robot ahead; zero if it never yields.
    fn way(&self, mover: &Mover) -> Vec2;

    /// The course through a tick in which the mover is present, not halted and not yielding.
    fn course(&mut self, mover: &Mover, statics: &Statics<'_>, tick: Span) -> Course;

    /// Sets another velocity by order of the script; a motion with a way of its own ignores it.
    fn set_velocity(&mut self, velocity: Vec2) {
        let _ = velocity;
    }
}

/// The interval of time of a tick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// Beginning, s after the beginning of the episode.
    pub(super) begin_s: f64,
    /// Duration, s.
    pub(super) lasts_s: f64,
}

impl Motion {
    pub(super) fn digest(&self, digest: &mut Digest) {
        self.0.digest(digest);
    }
}

impl<M: MotionKind + 'static> From<M> for Motion {
    fn from(motion: M) -> Self {
        Self(Arc::new(motion))
    }
}

impl Default for Motion {
    fn default() -> Self {
        uniform::Uniform.into()
    }
}

impl PartialEq for Motion {
    fn eq(&self, other: &Self) -> bool {
        let [ours, theirs] = [self, other].map(|motion| {
            let mut digest = Digest::default();
            motion.digest(&mut digest);
            digest.value()
        });
        ours == theirs
    }
}

/// Drives one mover through an episode.
#[derive(Debug)]
pub(super) struct Driver {
    drive: Box<dyn Drive>,
    /// Whether the script has halted the mover.
    pub(super) halted: bool,
}

impl Driver {
    /// The driver of a mover at the beginning of an episode.
    pub(super) fn new(mover: &Mover) -> Self {
        Self { drive: mover.motion.0.driver(mover.velocity), halted: false }
    }

    /// Gives the mover another velocity from now on.
    pub(super) fn set_velocity(&mut self, mover: &mut Mover, velocity: Vec2) {
        self.drive.set_velocity(velocity);
        mover.velocity = velocity;
    }

    /// Makes the changes with which a tick begins.
    pub(super) fn begin(&mut self, mover: &mut Mover, tick: Span) {
        self.drive.begin(mover, tick);
    }

    /// The course through a tick, given the position of the robot's centre and the distance to its footprint.
    pub(super) fn course(
        &mut self,
        mover: &Mover,
        statics: &Statics<'_>,
        (robot, gap_m): (Vec2, f64),
        tick: Span,
    ) -> Course {
        let stands = !mover.present || self.halted || yields(mover, self.drive.way(mover), robot, gap_m);
        if stands { Course::standing(mover.position) } else { self.drive.course(mover, statics, tick) }
    }
}

/// Whether a yielding mover stands this tick: the robot's centre lies in the half plane ahead of it and their surfaces
/// are within its distance, at the beginning of the tick.
fn yields(mover: &Mover, way: Vec2, robot: Vec2, gap_m: f64) -> bool {
    mover.on_robot == OnRobot::Yield && (robot - mover.position).dot(&way) > 0.0 && gap_m <= mover.yield_distance_m
}

#[cfg(test)]
mod tests {
    use super::super::obstacles::moving::OnStatic;
    use super::*;

    #[test]
    fn yielding_depends_on_who_is_ahead_and_how_near() {
        let mover = Mover { on_static: OnStatic::Reflect, ..Mover::new(Vec2::zeros(), Vec2::zeros(), 0.3) };
        let cruise = Vec2::new(1.0, 0.0);
        let gap_m = |x: f64| x.abs() - 0.3 - 0.25;
        let ahead =
            |x| yields(&Mover { on_robot: OnRobot::Yield, ..mover.clone() }, cruise, Vec2::new(x, 0.0), gap_m(x));
        // Surfaces are 1 m apart where the centres are 1.55 m apart.
        assert!(ahead(1.54) && !ahead(1.56) && !ahead(-1.0));
        assert!(!yields(&mover, cruise, Vec2::new(1.0, 0.0), gap_m(1.0)), "movers ignore the robot unless told");
    }
}
