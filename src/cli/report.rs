//! `simrun report`: folders of results as one page.

use super::{Failure, print, say};
use crate::experiment::threads_available;
use crate::report::{self, Settings};
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Folder of a run, an `episodes.csv`, or a folder of `simrun reproduce`; runs that share worlds are compared.
    #[arg(required = true, value_name = "FOLDER")]
    folders: Vec<PathBuf>,
    /// Where to write; `-` for stdout.
    #[arg(short, long, value_name = "FILE", default_value = "report.html")]
    out: PathBuf,
    /// At most so many episodes in the gallery, which are driven again; 0 for none.
    #[arg(long, value_name = "N", default_value_t = 60)]
    episodes_shown: usize,
    /// Threads; as many as there are processors by default. The page does not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    let threads = args.threads.unwrap_or_else(threads_available).max(1);
    let settings = Settings { episodes_shown: args.episodes_shown, threads };
    let page = report::report(&args.folders, &settings).map_err(Failure::usage)?;
    if args.out.as_os_str() == "-" {
        return print(&page);
    }
    std::fs::write(&args.out, &page).map_err(|error| super::cannot_write(&args.out, &error))?;
    say(&format!("{}: {} kB, one file", args.out.display(), page.len().div_ceil(1000)));
    Ok(())
}
