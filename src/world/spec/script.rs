//! What a scenario's script says: timed events.

use super::ShapeChoice;
use crate::settings::choice::choice;
use crate::settings::quantity::{CountOrZero, Finite, Fraction, NonNegative, Positive};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One line of the script (scenario key `script`).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScriptEntry {
    /// When it happens, s after the beginning; rounded to a whole tick.
    pub at_s: NonNegative,
    /// What happens.
    pub event: EventChoice,
}

choice! {
    /// Something that happens at a given time. Movers are numbered from 0 in the order of `obstacles.moving`.
    pub enum EventChoice: "event" {
        obstacle, mover_appears, mover_vanishes, mover_stops, mover_starts, mover_velocity, goal, sensor_range, wheel_slip
    }
}

/// An obstacle that stands still appears: an aisle is blocked. On no map; the robot knows of it when it senses it.
pub mod obstacle {
    use super::*;

    /// Where, what, how long.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// Pose [x, y, theta] of the centre in the world frame, m and rad.
        pub pose: [Finite; 3],
        /// Outline. Default: a rectangle of 1 m by 1 m.
        #[serde(default)]
        pub shape: ShapeChoice,
        /// When it vanishes again, s after the beginning; by default it stays. The robot believes in it until it sees that it
        /// is gone.
        #[serde(default)]
        pub until_s: Option<NonNegative>,
    }
}

macro_rules! of_a_mover {
    ($($(#[$doc:meta])* $name:ident;)+) => {$(
        $(#[$doc])*
        pub mod $name {
            use super::*;

            /// Which mover.
            #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
            #[serde(deny_unknown_fields)]
            pub struct Params {
                /// Its number.
                pub mover: CountOrZero,
            }
        }
    )+};
}

of_a_mover! {
    /// A mover is there again, where it vanished.
    mover_appears;
    /// A mover is gone.
    mover_vanishes;
    /// A mover stands.
    mover_stops;
    /// A mover goes on with what it did.
    mover_starts;
}

/// A mover that goes straight on has another velocity from now on.
pub mod mover_velocity {
    use super::*;

    /// Which mover, and how it moves.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// Its number.
        pub mover: CountOrZero,
        /// Velocity [x, y] in the world frame, m/s.
        pub velocity_mps: [Finite; 2],
    }
}

/// The goal is elsewhere; the robot is told at once and plans anew, whatever its replanning rule.
pub mod goal {
    use super::*;

    /// Where to.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// [x, y] in the world frame, m.
        pub to: [Finite; 2],
    }
}

/// The sensor for obstacles reaches farther or less far.
pub mod sensor_range {
    use super::*;

    /// How far.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// The range, m.
        pub range_m: Positive,
    }
}

/// The wheels lose other shares of their speed to the ground: see `actuation`.
pub mod wheel_slip {
    use super::*;

    /// How much.
    #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
    #[serde(deny_unknown_fields)]
    pub struct Params {
        /// Range of the left wheel's share; default [0, 0].
        #[serde(default = "grip")]
        pub left: [Fraction; 2],
        /// Range of the right wheel's share; default [0, 0].
        #[serde(default = "grip")]
        pub right: [Fraction; 2],
    }

    fn grip() -> [Fraction; 2] {
        [Fraction::new(0.0); 2]
    }
}
