//! `simrun draw`: one episode as a picture or a film.

use super::scenarios::{AtPoint, Changes};
use super::traced::Traced;
use super::{Failure, cannot_write, print, say};
use crate::episode::Recording;
use crate::experiment::Experiment;
use crate::geometry::{Rect, Vec2};
use crate::report::drawing::{self, Caption, Crop, Film, Style, shown_cs};
use crate::report::picture::{self, Picture};
use crate::results::Row;
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario file; folder of results, one of whose episodes is driven again as it was; or a trace, whose drive is driven again.
    #[arg(value_name = "SCENARIO")]
    scenario: PathBuf,
    /// Which episode; the first stack of the scenario drives unless --stack names one.
    #[arg(long, default_value_t = 0)]
    episode: u64,
    /// Where to write; the ending says what: .svg, .png, .pdf, or .gif for a film; without an ending, and for `-`, which is stdout, SVG. Default: episode.svg.
    #[arg(short, long, alias = "output", value_name = "FILE")]
    out: Option<PathBuf>,
    #[command(flatten)]
    look: Look,
    #[command(flatten)]
    point: AtPoint,
    #[command(flatten)]
    changes: Changes,
}

/// What is drawn of the episode, and how.
#[derive(Debug, clap::Args)]
struct Look {
    /// Which part of the world: `auto` (the map without its unknown rim; what the drive touched where that is less than a fifth of it), `map`
    /// (all of it), `drive` (what the drive touched and a margin), or two corners X0,Y0,X1,Y1, m.
    #[arg(long, value_name = "PART", default_value = "auto", value_parser = crop, allow_hyphen_values = true)]
    crop: Crop,
    /// Several stacks in the same world, one colour each, joined by commas.
    #[arg(long, value_name = "STACKS", value_delimiter = ',', conflicts_with_all = ["stacks", "world"])]
    overlay: Vec<String>,
    /// The world without a drive: map, start, goal, obstacles, and the ways of the movers in the first 30 s as if no robot were there.
    #[arg(long)]
    world: bool,
    /// Write pictures of the drive, moment by moment, to this folder: 000000.png, 000001.png and so on.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["overlay", "world", "out"])]
    frames: Option<PathBuf>,
    /// Seconds from one moment of a film to the next. Default: what makes a film of about fifteen seconds.
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    every: Option<f64>,
    /// Width of the page in pixels of 1/96 inch. Texts keep their size: a narrow page suits a column of a paper.
    #[arg(long, value_name = "PIXELS", default_value_t = 800, value_parser = clap::value_parser!(u32).range(240..=4000))]
    width: u32,
    /// Dots of an image to a pixel of the page. Default: 2 for .png, 1 for films.
    #[arg(long, value_name = "N", value_parser = scale)]
    scale: Option<f64>,
    /// Seconds between two marks of a track; 0 for none. Default: a round number that suits the drive.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    marks: Option<f64>,
    /// Words above the picture in place of scenario, stack and outcome; empty for none.
    #[arg(long, value_name = "TEXT")]
    title: Option<String>,
}

/// How long the movers of a world without a drive are watched, s.
const WATCHED_S: f64 = 30.0;

fn number(text: &str) -> Result<f64, String> {
    text.trim().parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| "expected a number".to_owned())
}

fn positive(text: &str) -> Result<f64, String> {
    number(text).and_then(|number| if number > 0.0 { Ok(number) } else { Err("expected a positive number".to_owned()) })
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text)
        .and_then(|number| if number >= 0.0 { Ok(number) } else { Err("expected no negative number".to_owned()) })
}

fn scale(text: &str) -> Result<f64, String> {
    let expected = || "expected a number from 0.1 to 8".to_owned();
    number(text).and_then(|number| if (0.1..=8.0).contains(&number) { Ok(number) } else { Err(expected()) })
}

fn crop(text: &str) -> Result<Crop, String> {
    let expected = "expected auto, map, drive or two corners such as 0,0,12.5,8";
    match text {
        "auto" => Ok(Crop::Auto),
        "map" => Ok(Crop::Map),
        "drive" => Ok(Crop::Drive),
        _ => {
            let numbers: Result<Vec<f64>, _> = text.split(',').map(number).collect();
            let Ok([x0, y0, x1, y1]) = <[f64; 4]>::try_from(numbers.map_err(|_| expected)?) else {
                return Err(expected.to_owned());
            };
            let (a, b) = (Vec2::new(x0, y0), Vec2::new(x1, y1));
            let window = Rect { min: a.inf(&b), max: a.sup(&b) };
            if window.min.x < window.max.x && window.min.y < window.max.y {
                Ok(Crop::Window(window))
            } else {
                Err(format!("{expected}: these hold no area"))
            }
        }
    }
}

/// What is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Svg,
    Png,
    Pdf,
    Gif,
}

impl Format {
    fn of(file: &Path) -> Result<Self, Failure> {
        let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        match ending.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("png") => Ok(Self::Png),
            Some("pdf") => Ok(Self::Pdf),
            Some("gif") => Ok(Self::Gif),
            None => Ok(Self::Svg),
            Some(_) => Err(Failure::usage(format!(
                "cannot tell from `{}` what to write: the ending has to be .svg, .png, .pdf or .gif",
                file.display()
            ))),
        }
    }
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("episode.svg"));
    let format = Format::of(&out)?;
    let look = &args.look;
    if format == Format::Gif && (look.world || !look.overlay.is_empty()) {
        return Err(Failure::usage("a .gif shows one drive: write --world and --overlay as .svg, .png or .pdf"));
    }
    if look.every.is_some() && format != Format::Gif && look.frames.is_none() {
        return Err(Failure::usage("--every is for films: write to a .gif, or name a folder with --frames"));
    }
    let traced = Traced::of(&args.scenario)?;
    let (experiment, point, episode) = match &traced {
        Some(_) if args.changes != Changes::default() || look.world || !look.overlay.is_empty() => {
            return Err(Failure::usage("a trace is drawn as it was driven: nothing of it can be changed"));
        }
        Some(traced) => traced.load()?,
        None => {
            let changes = args.changes.clone();
            let changes = if look.overlay.is_empty() { changes } else { changes.with_stacks(&look.overlay) };
            let experiment = changes.load(&args.scenario)?;
            let point = args.point.driven(&experiment)?;
            (experiment, point, args.episode)
        }
    };
    let style = Style { width: f64::from(look.width), crop: look.crop, marks_s: look.marks };
    if look.world {
        let recording = experiment.watch_one(point, episode, WATCHED_S).map_err(Failure::run)?;
        let movers = recording.scene.movers.len();
        let subtitle =
            if movers > 0 { "The ways of the movers are those of the first 30 s without a robot." } else { "" };
        let caption = look.caption(title(&experiment, "world", episode), subtitle.to_owned());
        return write(&out, format, look, &drawing::world(&recording, &caption, &style), "");
    }
    if !look.overlay.is_empty() {
        return overlay(args, &experiment, point, &out, format, &style);
    }
    let stack = experiment.stacks(point).next().map_or("", |stack| stack.name.as_str());
    let drive = experiment.drive_one(point, episode, 0).map_err(Failure::run)?;
    if let Some(traced) = &traced {
        traced.check(&experiment, &drive.row)?;
    }
    let outcome = sentence(&drive.row);
    let caption = look.caption(title(&experiment, stack, episode), outcome.clone());
    if let Some(folder) = &look.frames {
        return frames(folder, look, &drive.recording, &caption, &style);
    }
    if format == Format::Gif {
        let film = Film::new(&drive.recording, look.every);
        let count = film.rows.len();
        let moment = |index: usize| drawing::film(&drive.recording, film.rows[index], &caption, &style);
        let bytes = picture::gif(count, &moment, &|index| shown_cs(index, count), look.scale.unwrap_or(1.0));
        std::fs::write(&out, &bytes).map_err(|error| cannot_write(&out, &error))?;
        say(&format!("{}: {count} pictures, {} kB; {outcome}", out.display(), bytes.len() / 1000));
        return Ok(());
    }
    write(&out, format, look, &drawing::draw(&drive.recording, &caption, &style), &outcome)
}

impl Look {
    fn caption(&self, title: String, subtitle: String) -> Caption {
        match &self.title {
            Some(words) => Caption { title: words.clone(), subtitle: String::new() },
            None => Caption { title, subtitle },
        }
    }
}

fn title(experiment: &Experiment, what: &str, episode: u64) -> String {
    let scenario = experiment.scenario();
    format!("{}: {what}, episode {episode}, seed {}", scenario.name, scenario.seed)
}

/// Several stacks in one picture, in the order in which they were named.
fn overlay(
    args: &Args,
    experiment: &Experiment,
    point: u32,
    out: &Path,
    format: Format,
    style: &Style,
) -> Result<(), Failure> {
    let names: Vec<&str> = experiment.stacks(point).map(|stack| stack.name.as_str()).collect();
    let mut drives = Vec::new();
    for wanted in &args.look.overlay {
        let Some(index) = names.iter().position(|name| name == wanted) else {
            return Err(Failure::usage(format!("the stack {wanted} does not run at point {point}")));
        };
        let drive = experiment.drive_one(point, args.episode, index).map_err(Failure::run)?;
        let time = drive.row.metrics.time_s.map_or_else(String::new, |time_s| format!(", {time_s:.1} s"));
        drives.push((format!("{wanted}: {}{time}", drive.row.outcome.words()), drive.recording));
    }
    let drives: Vec<(String, &Recording)> = drives.iter().map(|(name, recording)| (name.clone(), recording)).collect();
    let subtitle = match drives.first() {
        Some((_, first)) if !first.scene.movers.is_empty() => {
            format!("Movers as {} met them.", args.look.overlay.first().map_or("", String::as_str))
        }
        _ => String::new(),
    };
    let caption = args.look.caption(title(experiment, "several stacks", args.episode), subtitle);
    write(out, format, &args.look, &drawing::overlay(&drives, &caption, style), "")
}

/// Numbered pictures of a drive, moment by moment.
fn frames(folder: &Path, look: &Look, recording: &Recording, caption: &Caption, style: &Style) -> Result<(), Failure> {
    std::fs::create_dir_all(folder).map_err(|error| cannot_write(folder, &error))?;
    let film = Film::new(recording, look.every);
    for (index, row) in film.rows.iter().enumerate() {
        let file = folder.join(format!("{index:06}.png"));
        let page = drawing::film(recording, *row, caption, style);
        let bytes = picture::png(&picture::raster(&page, look.scale.unwrap_or(1.0)));
        std::fs::write(&file, bytes).map_err(|error| cannot_write(&file, &error))?;
    }
    say(&format!("{}: {} pictures", folder.display(), film.rows.len()));
    Ok(())
}

fn write(out: &Path, format: Format, look: &Look, page: &Picture, outcome: &str) -> Result<(), Failure> {
    if out.as_os_str() == "-" {
        return print(&picture::svg(page));
    }
    let bytes = match format {
        Format::Svg => picture::svg(page).into_bytes(),
        Format::Pdf => picture::pdf(page),
        Format::Png | Format::Gif => picture::png(&picture::raster(page, look.scale.unwrap_or(2.0))),
    };
    std::fs::write(out, bytes).map_err(|error| cannot_write(out, &error))?;
    let outcome = if outcome.is_empty() { String::new() } else { format!(": {outcome}") };
    say(&format!("{}{outcome}", out.display()));
    Ok(())
}

/// Outcome of an episode, in words.
fn sentence(row: &Row) -> String {
    let metrics = &row.metrics;
    let mut words = row.outcome.words();
    let mut add = |what: &str, value: Option<f64>, unit: &str| {
        if let Some(value) = value {
            words += &format!(", {what} {value:.2} {unit}");
        }
    };
    add("after", metrics.time_s, "s");
    add("driven", metrics.length_m, "m");
    add("planned", metrics.planned_length_m, "m");
    add("no way is shorter than", metrics.shortest_m, "m");
    add("smallest clearance", metrics.clearance_min_m, "m");
    words
}
