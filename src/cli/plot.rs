//! `simrun plot`: figures for papers.

use super::{Failure, print, say};
use crate::report::figure::{self, Asked, Figure, FigureError, Style};
use crate::report::picture;
use crate::results::EPISODES_CSV;
use std::path::{Path, PathBuf};

/// Pixels of a PNG for each of a picture, of which an inch has 96.
const PNG_SCALE: f64 = 600.0 / 96.0;

#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
pub(super) struct Args {
    #[command(subcommand)]
    kind: Option<Kind>,
    #[command(flatten)]
    columns: Columns,
}

#[derive(Debug, clap::Subcommand)]
enum Kind {
    /// Values over a swept key, a curve for each stack and each value of the other keys.
    Sweep(Sweep),
    /// Stacks side by side: means with intervals, and the worlds behind them.
    Stacks(Stacks),
    /// Differences to one stack on the same worlds.
    Pairs(Pairs),
}

#[derive(Debug, clap::Args)]
struct Columns {
    #[command(flatten)]
    table: Table,
    /// Column along the horizontal axis: any of episodes.csv, swept keys included.
    #[arg(long, value_name = "COLUMN", required = true)]
    x: Option<String>,
    /// Columns along the vertical axis, joined by commas: a panel each.
    #[arg(long, value_name = "COLUMNS", value_delimiter = ',', required = true)]
    y: Vec<String>,
    /// Column that tells curves apart; the stacks by default.
    #[arg(long, value_name = "COLUMN")]
    by: Option<String>,
    /// Only this point of a sweep.
    #[arg(long, value_name = "N")]
    point: Option<u32>,
    #[command(flatten)]
    looks: Looks,
}

#[derive(Debug, clap::Args)]
struct Sweep {
    #[command(flatten)]
    table: Table,
    /// Swept key along the horizontal axis; the first one by default.
    #[arg(long, value_name = "KEY")]
    x: Option<String>,
    /// Columns to show, joined by commas: a panel each.
    #[arg(long, visible_alias = "y", value_name = "COLUMNS", value_delimiter = ',')]
    metrics: Vec<String>,
    #[command(flatten)]
    looks: Looks,
}

#[derive(Debug, clap::Args)]
struct Stacks {
    #[command(flatten)]
    table: Table,
    /// Columns to show, joined by commas: a panel each.
    #[arg(long, visible_alias = "y", value_name = "COLUMNS", value_delimiter = ',')]
    metrics: Vec<String>,
    /// Which point of a sweep.
    #[arg(long, value_name = "N")]
    point: Option<u32>,
    #[command(flatten)]
    looks: Looks,
}

#[derive(Debug, clap::Args)]
struct Pairs {
    #[command(flatten)]
    stacks: Stacks,
    /// The stack that the others are compared with; the first one by default.
    #[arg(long, value_name = "STACK")]
    reference: Option<String>,
}

#[derive(Debug, clap::Args)]
struct Table {
    /// `episodes.csv` of a run, or its folder.
    #[arg(value_name = "FOLDER", required = true)]
    table: Option<PathBuf>,
    /// Only this stack (repeatable).
    #[arg(long = "stack", value_name = "NAME")]
    stacks: Vec<String>,
    /// Drives that failed count as well for what depends on the drive, such as time; else only those that arrived do.
    #[arg(long)]
    failures: bool,
}

#[derive(Debug, clap::Args)]
struct Looks {
    /// File to write: .svg, .pdf or .png (600 dots an inch) by its ending; `-` is SVG on stdout.
    #[arg(short, long, value_name = "FILE", default_value = "plot.svg")]
    out: PathBuf,
    /// Width of the figure, mm: 88 for a column, 180 for a page.
    #[arg(long, value_name = "MM", default_value_t = 88.0, value_parser = between::<30, 600>)]
    width_mm: f64,
    /// Size of the letters, pt.
    #[arg(long, value_name = "PT", default_value_t = 8.0, value_parser = between::<4, 40>)]
    font_size_pt: f64,
    /// Title above the figure; papers have captions instead, for which the command prints a text.
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
    /// Logarithmic axes: x, y or both; of stacks x is the axis of the values.
    #[arg(long, value_name = "AXES", value_delimiter = ',', value_enum)]
    log: Vec<LogAxis>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum LogAxis {
    X,
    Y,
}

fn between<const LOW: u16, const HIGH: u16>(text: &str) -> Result<f64, String> {
    let is_within = |number: &f64| (f64::from(LOW)..=f64::from(HIGH)).contains(number);
    text.parse().ok().filter(is_within).ok_or_else(|| format!("expected a number from {LOW} to {HIGH}, found {text}"))
}

impl Looks {
    fn style(&self) -> Style {
        Style {
            width_mm: self.width_mm,
            font_size_pt: self.font_size_pt,
            title: self.title.clone(),
            is_log: [LogAxis::X, LogAxis::Y].map(|axis| self.log.contains(&axis)),
        }
    }
}

impl Table {
    /// The table; clap has refused a command without one.
    fn path(&self) -> &Path {
        self.table.as_deref().unwrap_or(Path::new(EPISODES_CSV))
    }

    fn asked(&self, metrics: &[String], point: Option<u32>, reference: Option<&String>) -> Asked {
        Asked {
            metrics: metrics.to_vec(),
            point,
            stacks: self.stacks.clone(),
            reference: reference.cloned(),
            failures: self.failures,
        }
    }
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    match &args.kind {
        Some(Kind::Sweep(Sweep { table, x, metrics, looks })) => {
            let (asked, style) = (table.asked(metrics, None, None), looks.style());
            write(figure::sweep(table.path(), x.as_deref(), &asked, &style), looks)
        }
        Some(Kind::Stacks(Stacks { table, metrics, point, looks })) => {
            let (asked, style) = (table.asked(metrics, *point, None), looks.style());
            write(figure::stacks(table.path(), &asked, &style), looks)
        }
        Some(Kind::Pairs(Pairs { stacks: Stacks { table, metrics, point, looks }, reference })) => {
            let asked = table.asked(metrics, *point, reference.as_ref());
            write(figure::pairs(table.path(), &asked), looks)
        }
        None => {
            let Columns { table, x, y, by, point, looks } = &args.columns;
            let (asked, style) = (table.asked(y, *point, None), looks.style());
            let x = x.as_deref().unwrap_or_default();
            write(figure::columns(table.path(), x, by.as_deref(), &asked, &style), looks)
        }
    }
}

fn write(figure: Result<Figure, FigureError>, looks: &Looks) -> Result<(), Failure> {
    let (style, shown) = (looks.style(), looks.out.display());
    let ending = looks.out.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    let is_known = ["svg", "pdf", "png"].iter().any(|known| ending.as_deref() == Some(known));
    if looks.out.as_os_str() != "-" && !is_known {
        return Err(Failure::usage(format!("{shown}: figures are written as .svg, .pdf or .png")));
    }
    let figure = figure.map_err(Failure::usage)?;
    if looks.out.as_os_str() == "-" {
        print(&figure.svg(&style))?;
    } else {
        let bytes = match ending.as_deref() {
            Some("pdf") => picture::pdf(&figure.picture(&style)),
            Some("png") => picture::png(&picture::raster(&figure.picture(&style), PNG_SCALE)),
            _ => figure.svg(&style).into_bytes(),
        };
        std::fs::write(&looks.out, bytes).map_err(|error| super::cannot_write(&looks.out, &error))?;
    }
    say(&format!("{shown}: {}", figure.caption));
    Ok(())
}
