//! Motion straight on.

use super::{Course, Drive, Motion, MotionKind, MotionSpec, Span};
use crate::geometry::Vec2;
use crate::rng::Stream;
use crate::settings::Entry;
use crate::world::obstacles::moving::Mover;
use crate::world::scene::Digest;
use crate::world::statics::Statics;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "straight on" };

/// No parameters.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Params {}

impl MotionSpec for Params {
    fn motion(&self, _: [f64; 2], _: Stream) -> Motion {
        Uniform.into()
    }
}

/// Straight on at the mover's velocity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Uniform;

impl MotionKind for Uniform {
    fn digest(&self, _: &mut Digest) {}

    fn driver(&self, velocity: Vec2) -> Box<dyn Drive> {
        Box::new(StraightOn { cruise: velocity })
    }
}

/// Goes straight on, and bounces off, stops at or passes through statics.
#[derive(Clone, Copy, Debug)]
pub(super) struct StraightOn {
    /// Velocity of the mover while it is neither halted nor yielding, m/s.
    pub(super) cruise: Vec2,
}

impl Drive for StraightOn {
    fn way(&self, _: &Mover) -> Vec2 {
        self.cruise
    }

    fn course(&mut self, mover: &Mover, statics: &Statics<'_>, tick: Span) -> Course {
        Course::drive(mover, &mut self.cruise, statics, tick.lasts_s)
    }

    fn set_velocity(&mut self, velocity: Vec2) {
        self.cruise = velocity;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;
    use crate::world::statics::StaticMap;

    #[test]
    fn it_goes_straight_bounces_and_takes_a_new_velocity() {
        let map = StaticMap::new(OccupancyGrid::empty(4, 3, 1.0));
        let statics = Statics { map: &map, unknown: &[] };
        let mut mover = Mover::new(Vec2::new(3.0, 1.5), Vec2::new(1.0, 0.0), 0.5);
        let mut driver = Uniform.driver(mover.velocity);
        let mut step = |driver: &mut Box<dyn Drive>| {
            let course = driver.course(&mover, &statics, Span { begin_s: 0.0, lasts_s: 1.0 });
            (mover.position, mover.velocity) = course.at(1.0);
            (mover.position, mover.velocity)
        };
        // The edge is met after 0.5 s, with the centre at x = 3.5.
        let (position, velocity) = step(&mut driver);
        assert!((position - Vec2::new(3.0, 1.5)).norm() < 1e-12 && velocity == Vec2::new(-1.0, 0.0));
        driver.set_velocity(Vec2::new(0.0, -0.25));
        let (position, velocity) = step(&mut driver);
        assert!((position - Vec2::new(3.0, 1.25)).norm() < 1e-12 && velocity == Vec2::new(0.0, -0.25));
    }
}
