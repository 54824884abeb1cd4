//! `simrun schema`: the JSON Schema of scenario files, for editors.

use super::{Failure, Out};
use crate::scenario::Scenario;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    out: Out,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    args.out.write(&Scenario::schema_text())
}
