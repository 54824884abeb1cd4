//! Parts that the events of movers share.

use super::{Change, Effect, Given};
use crate::settings::quantity::CountOrZero;
use crate::world::obstacles::moving::Order;
use crate::world::scene::{Digest, SceneError};
use crate::world::truth::World;

/// Checks that a mover of that number exists and takes the order.
pub(super) fn check(key: &str, mover: CountOrZero, order: Order, given: &Given<'_>) -> Result<(), SceneError> {
    let (mover, count) = (mover.get(), given.movers.len());
    let message = match given.movers.get(mover as usize).map(|kind| kind.refuses(order)) {
        None => format!("there is no mover {mover}: `obstacles.moving` gives {count}, numbered from 0"),
        Some(Some(refusal)) => format!("mover {mover} {refusal}"),
        Some(None) => return Ok(()),
    };
    Err(SceneError::new(format!("{key}.mover"), message))
}

/// Declares the parameters and the check of an event that needs nothing but the number of a mover.
macro_rules! event_of_a_mover {
    ($order:expr, $change:expr) => {
        /// Which mover.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
        #[serde(deny_unknown_fields)]
        pub struct Params {
            /// Its number.
            pub mover: CountOrZero,
        }

        impl EventKind for Params {
            fn check(&self, key: &str, _: NonNegative, given: &Given<'_>) -> Result<(), SceneError> {
                movers::check(key, self.mover, $order, given)
            }

            fn write(&self, at_s: NonNegative, scene: &mut Scene) {
                scene.script.push(Event::at(at_s, $change(self.mover.get() as usize)));
            }
        }
    };
}
pub(super) use event_of_a_mover;

/// The change that makes a mover appear or vanish.
#[derive(Debug)]
struct Presence {
    number: usize,
    present: bool,
}

/// The change that stops a mover or lets it resume its motion.
#[derive(Debug)]
struct Halt {
    number: usize,
    halted: bool,
}

impl Change {
    /// Makes mover `number` appear or vanish; while it is absent it stays where it was.
    pub fn mover(number: usize, present: bool) -> Self {
        Self::new(Presence { number, present })
    }

    /// Stops mover `number` or lets it resume its motion.
    pub fn halt(number: usize, halted: bool) -> Self {
        Self::new(Halt { number, halted })
    }
}

impl Effect for Presence {
    fn apply(&self, world: &mut World<'_>) {
        world.set_mover_presence(self.number, self.present);
    }

    fn digest(&self, digest: &mut Digest) {
        digest.words([1, self.number as u64, u64::from(self.present)]);
    }
}

impl Effect for Halt {
    fn apply(&self, world: &mut World<'_>) {
        world.halt_mover(self.number, self.halted);
    }

    fn digest(&self, digest: &mut Digest) {
        digest.words([2, self.number as u64, u64::from(self.halted)]);
    }
}
