//! `simrun explain`: what a key of scenario files means.

use super::{Failure, Out};
use crate::scenario::reference;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Path of a key, for example planning.inflation_m or stacks.local.dwa; the top-level keys without.
    #[arg(value_name = "KEY", default_value = "", hide_default_value = true)]
    key: String,
    #[command(flatten)]
    out: Out,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    let text = reference::explain(&args.key).map_err(|message| Failure::Usage(format!("error: {message}")))?;
    args.out.write(&text)
}
