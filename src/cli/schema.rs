//! `simrun schema`: the JSON Schema of scenario files, for editors.

use super::{Failure, print};
use crate::scenario::Scenario;

pub(super) fn main() -> Result<(), Failure> {
    print(&Scenario::schema_text())
}
