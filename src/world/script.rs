//! The script: what happens in the world at given ticks, besides what moves by itself.

use super::statics::Digest;
use crate::geometry::Vec2;
use crate::settings::quantity::Fraction;

/// Something that happens at the beginning of a tick, before the robot senses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Event {
    /// When.
    pub tick: u32,
    /// What.
    pub change: Change,
}

/// What an event changes. Obstacles and movers are numbered as in the scene, from 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// An obstacle that stands still is there or not from now on. One that appears on the robot hits it.
    Obstacle {
        /// Its number among the unknown statics.
        number: usize,
        /// Whether it is there.
        present: bool,
    },
    /// A mover is there or not from now on; while it is away it stays where it was.
    Mover {
        /// Its number.
        number: usize,
        /// Whether it is there.
        present: bool,
    },
    /// A mover stands, or does again what it did before.
    Halt {
        /// Its number.
        number: usize,
        /// Whether it stands.
        halted: bool,
    },
    /// A mover has another velocity from now on, m/s, grid frame.
    Velocity {
        /// Its number.
        number: usize,
        /// The velocity.
        velocity: Vec2,
    },
    /// The goal is elsewhere, grid frame, m.
    Goal(Vec2),
    /// The sensor for obstacles has another range, m.
    SensorRange(f64),
    /// The wheels slip by other shares; see [`ActuationSpec`](super::spec::ActuationSpec).
    WheelSlip {
        /// The left wheel's range.
        left: [Fraction; 2],
        /// The right wheel's range.
        right: [Fraction; 2],
    },
}

impl Change {
    /// Whether the shortest way from start to goal may be another one afterwards.
    pub fn moves_the_task(&self) -> bool {
        matches!(self, Self::Obstacle { .. } | Self::Goal(_))
    }
}

impl Event {
    pub(super) fn digest(&self, digest: &mut Digest) {
        digest.word(u64::from(self.tick));
        match self.change {
            Change::Obstacle { number, present } => digest.words([0, number as u64, u64::from(present)]),
            Change::Mover { number, present } => digest.words([1, number as u64, u64::from(present)]),
            Change::Halt { number, halted } => digest.words([2, number as u64, u64::from(halted)]),
            Change::Velocity { number, velocity } => {
                digest.words([3, number as u64]);
                digest.point(velocity);
            }
            Change::Goal(goal) => {
                digest.word(4);
                digest.point(goal);
            }
            Change::SensorRange(range_m) => {
                digest.word(5);
                digest.real(range_m);
            }
            Change::WheelSlip { left, right } => {
                digest.word(6);
                [left, right].as_flattened().iter().for_each(|share| digest.real(share.get()));
            }
        }
    }
}
