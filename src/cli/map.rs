//! `simrun map`: what a map file holds, and the same map in another format.

use super::{Failure, Out, print, say};
use crate::map::MapError;
use crate::map::connectivity::Components;
use crate::map::file::{self, Draft, FileFormat, Loaded, Unknown};
use crate::map::from_image::Params;
use crate::settings::quantity::Positive;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, clap::Subcommand)]
enum Action {
    /// Describe a map file: size, cells, the largest connected free part.
    Info {
        #[arg(help = format!("Map file: {}", FileFormat::known()))]
        file: PathBuf,
        #[command(flatten)]
        reading: Reading,
        #[command(flatten)]
        out: Out,
    },
    /// Write a map in another format; the extensions say which. A .yaml comes with a .pgm beside it.
    /// Nothing that is there already is replaced without --force.
    Convert {
        #[arg(help = format!("Map file: {}", FileFormat::known()))]
        input: PathBuf,
        #[command(flatten)]
        target: Target,
        #[command(flatten)]
        replacing: Replacing,
        #[command(flatten)]
        reading: Reading,
    },
    /// Make a map from a colour picture: what stands out by its colour is an obstacle. Look at the preview, which is written beside
    /// the map under the same name with .preview.png, then turn the knobs.
    FromImage {
        /// Picture, a .png.
        input: PathBuf,
        #[command(flatten)]
        target: Target,
        #[command(flatten)]
        replacing: Replacing,
        #[command(flatten)]
        knobs: Knobs,
    },
}

/// The map file to write, named with or without `--out`.
#[derive(Debug, clap::Args)]
#[group(required = true, multiple = false)]
struct Target {
    #[arg(value_name = "OUTPUT", help = format!("File to write: {}", FileFormat::written()))]
    output: Option<PathBuf>,
    /// The same as OUTPUT.
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
}

/// Whether files may be replaced.
#[derive(Debug, clap::Args)]
struct Replacing {
    /// Replace files that are there already.
    #[arg(long)]
    force: bool,
}

impl Replacing {
    /// Writes all drafts and prints their names, or refuses and writes none.
    fn save(&self, drafts: &[Draft]) -> Result<(), Failure> {
        file::save_all(drafts, self.force).map_err(|error| match error {
            MapError::Exist { .. } => {
                Failure::Usage(format!("error: {error}: write elsewhere, or replace with --force"))
            }
            other => Failure::Run(format!("error: {other}")),
        })?;
        drafts.iter().try_for_each(|draft| print(&format!("{}\n", draft.file.display())))
    }
}

impl Target {
    fn file(&self) -> &Path {
        self.output.as_deref().or(self.out.as_deref()).unwrap_or(Path::new(""))
    }
}

/// How a picture becomes a map.
#[derive(Debug, clap::Args)]
struct Knobs {
    /// Hues of obstacles, degrees from 0 to 360; 300,60 goes through red.
    #[arg(long, value_name = "FROM,TO", default_value = "0,360", value_parser = hues)]
    hue_deg: Hues,
    /// Obstacles are more saturated than this, 0 to 1: grey ground is left out.
    #[arg(long, value_name = "SHARE", default_value_t = 0.25)]
    saturation_min: f64,
    /// Obstacles are darker than this, 0 to 1: glare is left out; above 1 takes all.
    #[arg(long, value_name = "SHARE", default_value_t = 0.95)]
    value_max: f64,
    /// Opening: specks narrower than twice this and one vanish, px.
    #[arg(long, value_name = "PX", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=1000))]
    opening_px: u32,
    /// Closing: gaps narrower than twice this and one are filled, px.
    #[arg(long, value_name = "PX", default_value_t = 1, value_parser = clap::value_parser!(u32).range(..=1000))]
    closing_px: u32,
    /// Columns of the map; with --rows. The picture's own size without.
    #[arg(long, requires = "rows", value_parser = clap::value_parser!(u32).range(1..=16384))]
    cols: Option<u32>,
    /// Rows of the map; with --cols.
    #[arg(long, requires = "cols", value_parser = clap::value_parser!(u32).range(1..=16384))]
    rows: Option<u32>,
    /// Side of a cell, m.
    #[arg(long, value_name = "METRES", default_value = "1", value_parser = resolution)]
    resolution_m: Positive,
}

/// A range of hues, degrees.
#[derive(Clone, Copy, Debug)]
struct Hues([f64; 2]);

fn hues(text: &str) -> Result<Hues, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|number| number.trim().parse().ok()).collect();
    match numbers[..] {
        [from, to] if [from, to].iter().all(|hue| (0.0..=360.0).contains(hue)) => Ok(Hues([from, to])),
        _ => Err(format!("expected two hues from 0 to 360, such as 90,150; found {text}")),
    }
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

/// [`Unknown`] as an option.
#[derive(Clone, Copy, Debug, clap::ValueEnum)]
pub(super) enum UnknownArg {
    Occupied,
    Free,
}

impl From<UnknownArg> for Unknown {
    fn from(argument: UnknownArg) -> Self {
        match argument {
            UnknownArg::Occupied => Self::Occupied,
            UnknownArg::Free => Self::Free,
        }
    }
}

fn resolution(text: &str) -> Result<Positive, String> {
    let number: f64 = text.parse().map_err(|_| format!("expected a number above 0, found {text}"))?;
    Positive::try_from(number)
}

impl Reading {
    fn read(&self, file: &Path) -> Result<Loaded, Failure> {
        let read = file::read(file, self.resolution_m, self.unknown.into());
        let loaded = read.map_err(|error| Failure::Usage(format!("error: {error}")))?;
        for note in &loaded.notes {
            say(&format!("note: {note}"));
        }
        Ok(loaded)
    }
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    match &args.action {
        Action::Info { file, reading, out } => out.write(&info(&reading.read(file)?, reading.unknown)),
        Action::Convert { input, target, replacing, reading } => {
            let output = target.file();
            let loaded = reading.read(input)?;
            let (drafts, format) = FileFormat::drafts(&loaded.grid, output).map_err(Failure::usage)?;
            replacing.save(&drafts)?;
            if loaded.unknown > 0 {
                let counted = format!("{:?}", reading.unknown).to_lowercase();
                say(&format!("note: {} unknown cells are written as {counted}", loaded.unknown));
            }
            if let Some(loss) = file::loss(&loaded.grid, format) {
                say(&format!("note: {loss}"));
            }
            Ok(())
        }
        Action::FromImage { input, target, replacing, knobs } => from_image(input, target.file(), replacing, knobs),
    }
}

fn from_image(input: &Path, output: &Path, replacing: &Replacing, knobs: &Knobs) -> Result<(), Failure> {
    let usage = |message: String| Failure::Usage(format!("error: {message}"));
    FileFormat::to_write(output).map_err(|error| usage(error.to_string()))?;
    let picture = file::read_picture(input).map_err(|error| usage(error.to_string()))?;
    let params = Params {
        hue_deg: knobs.hue_deg.0,
        saturation_min: knobs.saturation_min,
        value_max: knobs.value_max,
        opening_px: knobs.opening_px,
        closing_px: knobs.closing_px,
        size: knobs.cols.zip(knobs.rows).map(|(cols, rows)| [cols, rows]),
        resolution_m: knobs.resolution_m.get(),
    };
    let grid = params.grid(&picture.pixels, picture.width);
    let (mut drafts, format) = FileFormat::drafts(&grid, output).map_err(Failure::usage)?;
    drafts.push(file::preview(&picture, &grid, &output.with_extension("preview.png")));
    replacing.save(&drafts)?;
    let share = 100.0 * grid.occupied_count() as f64 / grid.occupied().len() as f64;
    say(&format!("{} x {} cells, {share:.1} % occupied", grid.cols(), grid.rows()));
    if let Some(loss) = file::loss(&grid, format) {
        say(&format!("note: {loss}"));
    }
    Ok(())
}

/// The facts of a map, one a line. Unknown cells are counted apart and block or not, as they were read.
fn info(loaded: &Loaded, unknown: UnknownArg) -> String {
    let Loaded { grid, unknown: unknown_cells, .. } = loaded;
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
        let loaded = Loaded { unknown: 2, ..Loaded::known(grid) };
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
