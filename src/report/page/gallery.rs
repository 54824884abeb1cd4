//! The episodes of a page, driven again from the manifest of the run and packed.

use super::choose::{Choice, Reason};
use super::episode::{self, Entry, Episode, Map};
use super::gather::Gathered;
use super::html::number;
use super::thumbnail;
use crate::command::quoted;
use crate::digest::Digest;
use crate::experiment::{Experiment, in_order};
use crate::math;
use crate::metrics::failure::Cause;
use crate::paper::{Paper, folder_of};
use crate::results::{Identity, Row, metric_columns};
use crate::scenario::ScenarioFile;
use crate::settings::quantity::counted;
use std::collections::{BTreeMap, BTreeSet};
use std::iter;
use std::path::{Path, PathBuf};

/// An episode of the gallery.
#[derive(Debug)]
pub(super) struct Shown {
    /// Why it is here.
    pub reason: Reason,
    /// Its cause if it failed.
    pub cause: Option<Cause>,
    /// Its row.
    pub row: Row,
    /// What the player gets.
    pub entry: Entry,
    /// The small picture.
    pub thumbnail: String,
    /// The map: its id, the packed map, and its symbol.
    pub map: (String, String, String),
}

/// The gallery of one run.
#[derive(Debug, Default)]
pub(super) struct Gallery {
    /// The episodes: failures by cause, then the others by reason.
    pub shown: Vec<Shown>,
    /// Why episodes are missing, in words.
    pub notes: Vec<String>,
    /// What the scenario says of itself.
    pub description: String,
}

/// How the experiment of a folder is made again.
pub(super) struct Source {
    /// The experiment, if it is the one that wrote the rows.
    pub experiment: Result<Experiment, String>,
    /// The words of a command that name the scenario with its changes: `scenarios/02_wall.yaml --seed 3`.
    pub words: String,
}

impl Source {
    /// The experiment that a manifest describes, from its own text of the scenario.
    pub fn new(gathered: &Gathered) -> Self {
        let words = scenario_words(gathered);
        let Some(identity) = gathered.identity() else {
            let experiment = Err("there is no readable manifest.json beside the table".to_owned());
            return Self { experiment, words };
        };
        Self { experiment: experiment(gathered, identity), words }
    }
}

/// The scenario as a command names it, from the last start that wrote here: its file, settings, seed. Absolute paths stay at home.
fn scenario_words(gathered: &Gathered) -> String {
    let Some(launch) = gathered.launch() else { return format!("{}.yaml", gathered.scenario) };
    let words = launch.command.get(1..).unwrap_or_default();
    if let Some(table) = table_words(&launch.folder, words, &gathered.scenario) {
        return table;
    }
    let is_scenario = |word: &&String| word.ends_with(".yaml") || word.ends_with(".yml");
    let named: Vec<&String> = words.iter().filter(is_scenario).collect();
    let stem = |word: &str| Path::new(word).file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let file = named.iter().find(|word| stem(word).is_some_and(|stem| stem == gathered.scenario)).or(named.first());
    let mut out = match file {
        Some(file) if Path::new(file).is_absolute() => {
            Path::new(file).file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
        }
        Some(file) => (*file).clone(),
        None => format!("{}.yaml", gathered.scenario),
    };
    out = quoted(&out);
    let mut rest = words.iter();
    while let Some(word) = rest.next() {
        for option in ["--set", "--seed"] {
            let value = match word.strip_prefix(option) {
                Some("") => rest.next().cloned(),
                Some(value) => value.strip_prefix('=').map(str::to_owned),
                None => continue,
            };
            if let Some(value) = value {
                out += &format!(" {option} {}", quoted(&value));
            }
            break;
        }
    }
    out
}

/// A run of `simrun reproduce` as a command names it: the scenario of the paper's table with the edits of the table and of the choice.
fn table_words(folder: &Path, words: &[String], name: &str) -> Option<String> {
    let papers = Path::new("scenarios/papers");
    let named = words.strip_prefix(&["reproduce".to_owned()])?.iter().filter(|word| !word.starts_with('-'));
    for paper in named.filter_map(|word| Paper::read(&folder.join(papers), word).ok()) {
        for table in &paper.manifest.tables {
            let choices = paper.manifest.ablate.iter().map(Some);
            let Some(choice) = iter::once(None).chain(choices).find(|choice| folder_of(table, *choice) == name) else {
                continue;
            };
            let edits = table.set.iter().chain(choice.iter().flat_map(|choice| &choice.set));
            let edits: String = edits.map(|edit| format!(" --set {}", quoted(edit))).collect();
            return Some(quoted(papers.join(&table.scenario)) + &edits);
        }
    }
    None
}

/// The experiment of a run, if it is the same to the last bit: this build, this scenario, its files.
fn experiment(gathered: &Gathered, identity: &Identity) -> Result<Experiment, String> {
    let ours = Identity::new(&identity.scenario, identity.seed, identity.stacks.clone(), BTreeMap::new());
    if ours.version != identity.version || ours.build != identity.build {
        return Err(format!(
            "another build of simrun wrote these results (version {}, build {}), so its episodes are not driven again here",
            identity.version, identity.build
        ));
    }
    // Files that a scenario names are beside the file that was started, or beside the papers' scenarios.
    let mut places: Vec<PathBuf> =
        gathered.manifest.iter().filter_map(|run| run.scenario_folder(&gathered.scenario)).collect();
    places.extend(gathered.launch().map(|launch| launch.folder.join("scenarios/papers")));
    places.push(PathBuf::new());
    let mut refusals = Vec::new();
    for place in places {
        let name = format!("{}.yaml", gathered.scenario);
        let file = ScenarioFile::from_text(name, identity.scenario.as_str()).in_folder(place);
        match Experiment::load(&file, &[]) {
            Ok(mut experiment) => {
                let files = experiment.identity().files;
                let is_same = |(name, hash): &(&String, &String)| files.get(*name) == Some(hash);
                if let Some((name, _)) = identity.files.iter().find(|file| !is_same(file)) {
                    refusals.insert(0, format!("the file `{name}` is not the one that was driven with"));
                    continue;
                }
                experiment.keep_stacks(&identity.stacks).map_err(|error| error.to_string())?;
                return Ok(experiment);
            }
            Err(error) => refusals.push(error.to_string()),
        }
    }
    let refusal = refusals.into_iter().next().unwrap_or_default();
    // Only the first line: the rest shows the place in a text that nobody has.
    let line = refusal.lines().next().unwrap_or_default().to_owned();
    Err(line)
}

/// What is said of an episode, in words.
fn sentence(row: &Row) -> String {
    let metrics = &row.metrics;
    let mut words = row.outcome.words();
    let mut add = |what: &str, value: Option<f64>, unit: &str| {
        if let Some(value) = value {
            words += &format!(", {what} {} {unit}", number(value, 2));
        }
    };
    add("after", metrics.time_s, "s");
    add("driven", metrics.length_m, "m");
    add("smallest clearance", metrics.clearance_min_m, "m");
    if !row.outcome.message().is_empty() {
        words += &format!(" ({})", row.outcome.message());
    }
    words
}

/// The metrics that a reader of an episode looks at.
const STATS: [&str; 12] = [
    "time_s",
    "length_m",
    "shortest_m",
    "planned_length_m",
    "clearance_min_m",
    "clearance_movers_min_m",
    "speed_mean_mps",
    "stopped_s",
    "turning_angle_deg",
    "encounters",
    "replans",
    "near_miss_s",
];

impl Gallery {
    /// Drives the chosen episodes again. `prefix` makes ids unique among runs; `worlds` names worlds by their digests; `room` is the number
    /// of bytes that may be used, of which those used are taken off.
    pub fn drive(
        gathered: &Gathered,
        source: &Source,
        prefix: &str,
        worlds: &mut BTreeMap<(u64, u64), String>,
        threads: usize,
        room: &mut usize,
    ) -> Self {
        let mut gallery = Self::default();
        let choices = gathered.candidates.choose();
        let experiment = match &source.experiment {
            Ok(experiment) => experiment,
            Err(reason) => {
                if !choices.is_empty() {
                    gallery.notes.push(format!("No replays: {reason}."));
                }
                return gallery;
            }
        };
        gallery.description = experiment.scenario().description.trim().to_owned();
        let driven = in_order(choices.len(), threads, |index| drive(experiment, &choices[index]));
        let (mut other, mut lost, mut too_large) = (0_u64, 0_u64, 0_u64);
        let mut maps: BTreeSet<String> = BTreeSet::new();
        for (choice, driven) in choices.into_iter().zip(driven) {
            let Some(driven) = driven else {
                lost += 1;
                continue;
            };
            if driven.digests != [choice.row.world_digest, choice.row.trace_digest] {
                other += 1;
                continue;
            }
            let map_bytes = if maps.contains(&driven.map.0) { 0 } else { driven.map.1.len() + driven.map.2.len() };
            let fixed = map_bytes + driven.thumbnail.len() + 1200;
            let data = driven.data.into_iter().find(|data| data.len() + fixed <= *room);
            let Some(data) = data else {
                too_large += 1;
                continue;
            };
            *room -= data.len() + fixed;
            maps.insert(driven.map.0.clone());
            let row = choice.row;
            let digest = row.world_digest.map_or(0, |digest| digest.0);
            let named = worlds.len();
            let world = worlds.entry((digest, row.episode)).or_insert_with(|| {
                let name = format!("{prefix}p{}-e{}", row.point, row.episode);
                if digest == 0 { format!("{name}-{named}") } else { name }
            });
            let point = if gathered.is_sweep() { format!(" --point {}", row.point) } else { String::new() };
            let entry = Entry {
                id: format!("{prefix}p{}-e{}-{}", row.point, row.episode, row.stack),
                point: row.point,
                episode: row.episode,
                stack: row.stack.clone(),
                world: world.clone(),
                outcome: row.outcome.name().to_owned(),
                cause: driven.cause.map_or_else(String::new, |cause| cause.words().to_owned()),
                sentence: sentence(&row),
                command: format!(
                    "simrun draw {}{point} --episode {} --stack {}",
                    source.words,
                    row.episode,
                    quoted(&row.stack)
                ),
                stats: stats(&row),
                data,
            };
            gallery.shown.push(Shown {
                reason: choice.reason,
                cause: driven.cause,
                row,
                entry,
                thumbnail: driven.thumbnail,
                map: driven.map,
            });
        }
        gallery.shown.sort_by_key(|shown| (shown.reason, shown.cause));
        let mut note = |count: u64, text: &str| {
            if count > 0 {
                let noun = counted(count, "episode");
                gallery.notes.push(format!("{noun} {text}"));
            }
        };
        note(
            other,
            "of the gallery went another way when driven again (the trace differs: a file that the scenario names has changed), and are not shown.",
        );
        note(lost, "of the gallery could not be driven again, and are not shown.");
        note(too_large, "of the gallery are left out, so that the page stays small.");
        gallery
    }
}

fn stats(row: &Row) -> BTreeMap<&'static str, f64> {
    let columns = metric_columns().filter(|column| STATS.contains(&column.name));
    columns.filter_map(|column| Some((column.name, math::canonical(column.number(&row.metrics)?)))).collect()
}

struct Driven {
    digests: [Option<Digest>; 2],
    cause: Option<Cause>,
    /// The packed episode; then the same without its scans, if it has any.
    data: Vec<String>,
    thumbnail: String,
    map: (String, String, String),
}

fn drive(experiment: &Experiment, choice: &Choice) -> Option<Driven> {
    let drive = experiment.drive_again(&choice.row)?;
    let digests = [drive.row.world_digest, drive.row.trace_digest];
    let recording = &drive.recording;
    let grid = &recording.scene.map.grid;
    let id = format!("m{:08x}", recording.scene.map.digest() >> 32);
    let packed = |with_scans| episode::pack(&Episode::new(recording, &id, with_scans));
    let mut data = vec![packed(true)];
    if recording.trace.ray_count > 0 {
        data.push(packed(false));
    }
    Some(Driven {
        digests,
        cause: drive.cause(),
        data,
        thumbnail: thumbnail::draw(recording, &format!("t{id}"), &sentence(&drive.row)),
        map: (id.clone(), episode::pack(&Map::new(grid)), thumbnail::symbol(grid, &format!("t{id}"))),
    })
}
