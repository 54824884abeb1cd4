//! Event: a mover stops.

use super::movers::{self, event_of_a_mover};
use super::{Change, Event, EventKind, Given};
use crate::settings::Entry;
use crate::settings::quantity::{CountOrZero, NonNegative};
use crate::world::obstacles::moving::Order;
use crate::world::scene::{Scene, SceneError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "a mover stands" };

event_of_a_mover!(Order::Halt, |mover| Change::halt(mover, true));
