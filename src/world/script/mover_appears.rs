//! Event: a mover appears again where it vanished.

use super::movers::{self, event_of_a_mover};
use super::{Change, Event, EventKind, Given};
use crate::settings::Entry;
use crate::settings::quantity::{CountOrZero, NonNegative};
use crate::world::obstacles::moving::Order;
use crate::world::scene::{Scene, SceneError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "a mover is there again, where it vanished" };

event_of_a_mover!(Order::Presence, |mover| Change::mover(mover, true));
