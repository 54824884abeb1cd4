//! `simrun map`: what a map file holds, and the same map in another format.

use super::{Failure, print, say};
use crate::map::connectivity::Components;
use crate::map::file::{self, Format, Loaded};
use crate::map::ros::Unknown;
use crate::quantity::Positive;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Describe a map file: size, cells, the largest connected free part.
    Info {
        /// Map file: .map, .yaml (ROS), .png, .pgm or .txt.
        file: PathBuf,
        #[command(flatten)]
        reading: Reading,
    },
    /// Write a map in another format; the extensions say which. A .yaml comes with a .pgm beside it.
    Convert {
        /// Map file: .map, .yaml (ROS), .png, .pgm or .txt.
        input: PathBuf,
        /// File to write: .map, .yaml (ROS), .png, .pgm or .txt.
        output: PathBuf,
        #[command(flatten)]
        reading: Reading,
    },
}

/// What a map file may leave open.
#[derive(Debug, clap::Args)]
struct Reading {
    /// Side of a cell, m, for formats that do not say it.
    #[arg(long, value_name = "METRES", default_value = "1", value_parser = resolution)]
    resolution_m: Positive,
    /// What unknown cells count as.
    #[arg(long, value_enum, default_value = "occupied")]
    unknown: UnknownArg,
}

#[derive(Clone, Copy, Debug, clap::ValueEnum)]
enum UnknownArg {
    Occupied,
    Free,
}

fn resolution(text: &str) -> Result<Positive, String> {
    let number: f64 = text.parse().map_err(|_| format!("expected a number above 0, found {text}"))?;
    Positive::try_from(number)
}

impl Reading {
    fn read(&self, file: &std::path::Path) -> Result<Loaded, Failure> {
        let unknown = match self.unknown {
            UnknownArg::Occupied => Unknown::Occupied,
            UnknownArg::Free => Unknown::Free,
        };
        file::read(file, self.resolution_m, unknown).map_err(|error| Failure::Usage(format!("error: {error}")))
    }
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    match &args.action {
        Action::Info { file, reading } => print(&info(&reading.read(file)?, reading.unknown)),
        Action::Convert { input, output, reading } => {
            let loaded = reading.read(input)?;
            let format = Format::of(output).map_err(|error| Failure::Usage(format!("error: {error}")))?;
            for written in file::write(&loaded.grid, output).map_err(|error| Failure::Run(format!("error: {error}")))? {
                print(&format!("{}\n", written.display()))?;
            }
            if loaded.unknown > 0 {
                let counted = format!("{:?}", reading.unknown).to_lowercase();
                say(&format!("note: {} unknown cells are written as {counted}", loaded.unknown));
            }
            if let Some(loss) = file::loss(&loaded.grid, format) {
                say(&format!("note: {loss}"));
            }
            Ok(())
        }
    }
}

/// The facts of a map, one a line. Unknown cells are counted apart and block or not, as they were read.
fn info(loaded: &Loaded, unknown: UnknownArg) -> String {
    let Loaded { grid, unknown: unknown_cells } = loaded;
    let passable: Vec<bool> = grid.occupied().iter().map(|&occupied| !occupied).collect();
    let cells = passable.len();
    let blocked = grid.occupied_count();
    let (occupied, free) = match unknown {
        UnknownArg::Occupied => (blocked - unknown_cells, cells - blocked),
        UnknownArg::Free => (blocked, cells - blocked - unknown_cells),
    };
    let largest = Components::new(grid, &passable).sizes().iter().copied().max().unwrap_or(0);
    let (extent, origin) = (grid.extent_m(), grid.frame().origin);
    let percent = |part: usize, whole: usize| if whole == 0 { 0.0 } else { 100.0 * part as f64 / whole as f64 };
    format!(
        "size            {} x {} cells, {} x {} m\n\
         resolution_m    {}\n\
         origin          [{}, {}, {}]\n\
         free            {free}\n\
         occupied        {occupied}\n\
         unknown         {unknown_cells}\n\
         largest_part    {largest} ({:.1} % of the passable cells, 4-connected)\n\
         obstacle_share  {:.1} % of all cells occupied\n",
        grid.cols(),
        grid.rows(),
        rounded(extent.x),
        rounded(extent.y),
        grid.resolution_m(),
        origin.position.x,
        origin.position.y,
        origin.theta,
        percent(largest, cells - blocked),
        percent(occupied, cells),
    )
}

/// A length for people, to the millimetre.
fn rounded(metres: f64) -> f64 {
    (metres * 1000.0).round() / 1000.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::OccupancyGrid;

    #[test]
    fn the_facts_of_a_map_are_counted() {
        // 12 cells: 5 occupied of which 2 unknown; free parts of 4 and 3.
        let grid = OccupancyGrid::from_ascii(&["..#.", "..#.", "###."], 0.5);
        let loaded = Loaded { grid, unknown: 2 };
        assert_eq!(
            info(&loaded, UnknownArg::Occupied),
            "size            4 x 3 cells, 2 x 1.5 m\n\
             resolution_m    0.5\n\
             origin          [0, 0, 0]\n\
             free            7\n\
             occupied        3\n\
             unknown         2\n\
             largest_part    4 (57.1 % of the passable cells, 4-connected)\n\
             obstacle_share  25.0 % of all cells occupied\n"
        );
        let free = info(&loaded, UnknownArg::Free);
        assert!(free.contains("free            5\noccupied        5\nunknown         2\n"), "{free}");
    }
}
