//! `simrun report`: folders of results as one page that opens from disk and asks the network for nothing.
//!
//! [`report`] reads each folder row by row ([`gather`]), chooses episodes to look at ([`choose`]), drives these again and packs them for the
//! player ([`gallery`], [`episode`]), and writes tables and charts ([`tables`], [`plots`], [`sweep`], [`published`]). The same results make
//! the same bytes: no clock, no name of a machine, no absolute path.

mod choose;
pub mod episode;
mod gallery;
mod gather;
mod html;
mod plots;
mod published;
mod sweep;
mod tables;
mod thumbnail;

use crate::comparison::{self, Pairing, Report, Section, TableError};
use crate::experiment::threads_available;
use crate::files;
use crate::results::EPISODES_CSV;
use crate::settings::quantity::counted;
use gallery::{Gallery, Source};
use gather::Gathered;
use html::{escape, table};
use published::Published;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Bytes of pictures and episodes that a page may hold: with its tables and charts it stays below 3 MB.
const GALLERY_BYTES_MAX: usize = 2_200_000;
/// Resampled worlds times pairs of stacks: more worlds than this allows are not tested, since the page would take minutes.
const TESTED_MAX: u64 = 24_000;
/// Up to so many stacks all pairs are tested; of more each against the first.
const ALL_PAIRS_MAX: usize = 6;

/// What a page shows.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Largest number of episodes in the gallery.
    pub episodes_shown: usize,
    /// Threads that drive them.
    pub threads: usize,
}

impl Default for Settings {
    fn default() -> Self {
        Self { episodes_shown: 60, threads: threads_available() }
    }
}

/// Reason why there is no page.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// A table cannot be read.
    #[error(transparent)]
    Table(#[from] TableError),
    /// A folder holds no results.
    #[error("`{}` holds no results: expected an {EPISODES_CSV}, or folders with one each (as `simrun reproduce` writes them)", folder.display())]
    NoResults {
        /// The folder.
        folder: PathBuf,
    },
    /// A table has no row.
    #[error("`{}` has no rows yet", folder.display())]
    NoRows {
        /// The folder.
        folder: PathBuf,
    },
    /// A file beside the tables cannot be read.
    #[error("{path}: {message}", path = path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        message: String,
    },
}

/// One table of results with all that the page says of it.
struct Run {
    /// What it is called on the page: unique.
    name: String,
    /// Fragment and prefix of its ids.
    id: String,
    gathered: Gathered,
    source: Source,
    gallery: Gallery,
    /// The analysis of each point, in order.
    reports: Vec<Report>,
    /// Why fewer worlds are tested than were driven.
    note: Option<String>,
}

/// The page on the results in `folders`: each a folder of one run, an `episodes.csv`, or a folder of `simrun reproduce`.
///
/// # Errors
/// If a folder holds no results, or they cannot be read.
pub fn report(folders: &[PathBuf], settings: &Settings) -> Result<String, ReportError> {
    let mut tables: Vec<(String, PathBuf)> = Vec::new();
    let mut published = Vec::new();
    for folder in folders {
        let found = tables_of(folder)?;
        if folder.is_dir() && !folder.join(EPISODES_CSV).is_file() {
            published.extend(Published::read(folder)?);
        }
        tables.extend(found);
    }
    distinguish(&mut tables);
    let is_one = tables.len() == 1;
    let shown = settings.episodes_shown / tables.len().max(1);
    let shown = if settings.episodes_shown > 0 { shown.max(1) } else { 0 };
    let (mut runs, mut worlds, mut room) = (Vec::new(), BTreeMap::new(), GALLERY_BYTES_MAX);
    for (index, (name, path)) in tables.into_iter().enumerate() {
        let id = if is_one { String::new() } else { format!("r{index}-") };
        let mut gathered = Gathered::read(&path, shown)?;
        if gathered.rows == 0 {
            return Err(ReportError::NoRows { folder: path });
        }
        let (reports, note) = analyse(&mut gathered);
        let source = Source::new(&gathered);
        let gallery = Gallery::drive(&gathered, &source, &id, &mut worlds, settings.threads, &mut room);
        runs.push(Run { name, id, gathered, source, gallery, reports, note });
    }
    Ok(write(&runs, &published))
}

/// The tables that a folder stands for, each with a name for the page.
fn tables_of(folder: &Path) -> Result<Vec<(String, PathBuf)>, ReportError> {
    let name =
        |path: &Path| path.file_name().map_or_else(|| "results".to_owned(), |name| name.to_string_lossy().into_owned());
    if folder.is_file() || folder.join(EPISODES_CSV).is_file() {
        let named = if folder.is_file() { folder.parent().unwrap_or(folder) } else { folder };
        return Ok(vec![(name(named), folder.to_owned())]);
    }
    let inside = std::fs::read_dir(folder).map(|entries| {
        let paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
        let mut paths: Vec<PathBuf> = paths.filter(|path| path.join(EPISODES_CSV).is_file()).collect();
        paths.sort();
        paths
    });
    match inside {
        Ok(paths) if !paths.is_empty() => Ok(paths.into_iter().map(|path| (name(&path), path)).collect()),
        _ => Err(ReportError::NoResults { folder: folder.to_owned() }),
    }
}

/// Makes names unique: those of folders in other folders get these in front.
fn distinguish(tables: &mut [(String, PathBuf)]) {
    let names: Vec<String> = tables.iter().map(|(name, _)| name.clone()).collect();
    for (index, (name, path)) in tables.iter_mut().enumerate() {
        if names.iter().filter(|other| *other == name).count() > 1 {
            let above = path.parent().and_then(Path::file_name);
            let above = above.map_or_else(|| (index + 1).to_string(), |above| above.to_string_lossy().into_owned());
            *name = format!("{above}/{name}");
        }
    }
    let names: Vec<String> = tables.iter().map(|(name, _)| name.clone()).collect();
    for (index, (name, _)) in tables.iter_mut().enumerate() {
        if names.iter().filter(|other| *other == name).count() > 1 {
            *name = format!("{name} ({})", index + 1);
        }
    }
}

/// The analysis of each point, of as many worlds as can be tested in bounded time.
fn analyse(gathered: &mut Gathered) -> (Vec<Report>, Option<String>) {
    let pairs: u64 = gathered.points.iter().map(|point| pairs_of(point.stacks.len())).sum();
    let most = (TESTED_MAX / pairs.max(1)).max(200);
    let largest = gathered.points.iter().flat_map(|point| &point.stacks).map(|stack| stack.n).max().unwrap_or(0);
    let kept = gathered.kept_below.unwrap_or(u64::MAX);
    if most < largest.min(kept) {
        gathered.keep_below(most);
    }
    let reports = gathered.sections().map(analysed).collect();
    let note = gathered.kept_below.map(|below| {
        format!(
            "Tests and groups rest on the first {} of each point, which is enough to see small differences in bounded time; rates, \
             means and points are those of all {}.",
            counted(below, "world"),
            counted(gathered.rows, "row"),
        )
    });
    (reports, note)
}

fn pairs_of(stacks: usize) -> u64 {
    if stacks <= ALL_PAIRS_MAX { (stacks * stacks.saturating_sub(1) / 2) as u64 } else { stacks as u64 - 1 }
}

fn analysed(section: &Section) -> Report {
    let pairing = Pairing { all_pairs: section.stacks.len() <= ALL_PAIRS_MAX, ..Pairing::default() };
    comparison::analyse(section, &pairing).expect("without a named reference nothing is unknown")
}

/// Runs in the same worlds, their stacks side by side: one section with every stack of every run that drove them.
fn side_by_side(runs: &[Run]) -> Option<Report> {
    let alone: Vec<&Run> = runs.iter().filter(|run| run.gathered.points.len() == 1).collect();
    let (first, others) = alone.split_first()?;
    let reference = first.gathered.points[0].section.stacks.first()?;
    let same = others.iter().filter(|run| {
        run.gathered.points[0].section.stacks.first().is_some_and(|stack| stack.is_of_same_worlds(reference))
    });
    let together: Vec<&Run> = std::iter::once(*first).chain(same.copied()).collect();
    if together.len() < 2 {
        return None;
    }
    let mut section = Section { title: String::new(), stacks: Vec::new(), ..first.gathered.points[0].section.clone() };
    for run in together {
        for stack in &run.gathered.points[0].section.stacks {
            let mut stack = stack.clone();
            stack.name = format!("{}: {}", run.name, stack.name);
            stack.rows.values_mut().for_each(|row| row.stack.clone_from(&stack.name));
            section.stacks.push(stack);
        }
    }
    Some(analysed(&section))
}

/// Puts the page together.
fn write(runs: &[Run], published: &[Published]) -> String {
    let title = match (published, runs) {
        ([paper, ..], _) => paper.title.clone(),
        (_, [run]) => run.gathered.scenario.clone(),
        _ => runs.iter().map(|run| run.name.as_str()).collect::<Vec<_>>().join(", "),
    };
    let mut body = String::new();
    let mut nav: Vec<(String, &str)> = Vec::new();
    let description = runs.iter().map(|run| run.gallery.description.as_str()).find(|text| !text.is_empty());
    body += &format!("<header><p class=\"kicker\">simrun report</p><h1>{}</h1>\n", escape(&title));
    if let (Some(text), true) = (description, published.is_empty() && runs.len() == 1) {
        body += &format!("<p class=\"lead\">{}</p>\n", escape(text));
    }
    body += &facts(runs);
    for run in runs.iter().filter(|run| run.gathered.is_altered) {
        let name = escape(&run.name);
        body +=
            &format!("<p class=\"note\">The table of {name} is not as its run left it: it was altered since.</p>\n");
    }
    body += "</header>\n";
    let mut sections = String::new();
    for paper in published {
        sections += &paper.section();
        nav.push(("published".to_owned(), "Published and measured"));
    }
    if let Some(report) = side_by_side(runs) {
        sections += "<section id=\"runs\"><h2>Runs side by side</h2>\n<p>These runs drove the same worlds: their stacks are compared world by world.</p>\n";
        sections += &tables::of_report(&report);
        sections += &tables::pairs(std::slice::from_ref(&report));
        sections += "</section>\n";
        nav.push(("runs".to_owned(), "Side by side"));
    }
    for run in runs {
        let many = runs.len() > 1;
        if many {
            sections += &format!(
                "<article class=\"run\" id=\"{}run\"><h2 class=\"run-name\">{}</h2>\n",
                run.id,
                escape(&run.name)
            );
        }
        sections += &section_of(run, many, &mut nav);
        if many {
            sections += "</article>\n";
        }
    }
    sections += &gallery_section(runs, &mut nav);
    sections += &again(runs, &mut nav);
    let links: String = nav.iter().map(|(id, words)| format!("<a href=\"#{id}\">{words}</a>")).collect();
    body += &format!("<nav aria-label=\"Sections\">{links}</nav>\n<main>\n{sections}</main>\n");
    let mut maps: BTreeMap<&str, &str> = BTreeMap::new();
    let entries: Vec<&episode::Entry> = runs
        .iter()
        .flat_map(|run| &run.gallery.shown)
        .map(|shown| {
            maps.insert(&shown.map.0, &shown.map.1);
            &shown.entry
        })
        .collect();
    let scripts = if entries.is_empty() {
        String::new()
    } else {
        format!(
            "<script type=\"application/json\" id=\"maps\">{}</script>\n<script type=\"application/json\" id=\"episodes\">{}</script>\n\
             <script>{}\nSimrunReplay.mount(document);</script>\n",
            episode::json_in_script(&maps),
            episode::json_in_script(&entries),
            include_str!("replay.js")
        )
    };
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{}: simrun report</title>\n<style>\n{}{}</style>\n</head>\n<body>\n{body}\
         <footer><p>Written by <code>simrun report</code> {}. This page is one file and asks the network for nothing.</p></footer>\n{scripts}</body>\n</html>\n",
        escape(&title),
        include_str!("page.css"),
        include_str!("replay.css"),
        env!("CARGO_PKG_VERSION"),
    )
}

/// What ran, in one line a run.
fn facts(runs: &[Run]) -> String {
    let mut rows = Vec::new();
    for run in runs {
        let gathered = &run.gathered;
        let identity = gathered.identity();
        let seed = identity.map_or_else(|| "-".to_owned(), |identity| identity.seed.to_string());
        let build =
            identity.map_or_else(|| "-".to_owned(), |identity| format!("{} ({})", identity.version, identity.build));
        rows.push([
            ("run", run.name.clone()),
            ("scenario", gathered.scenario.clone()),
            ("episodes", html::count(gathered.rows)),
            ("stacks", gathered.stack_names().len().to_string()),
            ("points", gathered.points.len().to_string()),
            ("worlds", html::count(gathered.worlds())),
            ("seed", seed),
            ("simrun (build)", build),
        ]);
    }
    if let [row] = rows.as_slice() {
        let items = row.iter().filter(|(key, value)| *key != "run" && !(*key == "points" && value == "1"));
        let items: String =
            items.map(|(key, value)| format!("<div><dt>{key}</dt><dd>{}</dd></div>", escape(value))).collect();
        return format!("<dl class=\"facts\">{items}</dl>\n");
    }
    let Some(first) = rows.first() else { return String::new() };
    let head: Vec<String> = first.iter().map(|(key, _)| (*key).to_owned()).collect();
    let cells: Vec<Vec<String>> = rows.iter().map(|row| row.iter().map(|(_, value)| escape(value)).collect()).collect();
    table(&head, &cells, 2, "facts-table")
}

/// Tables and charts of one run.
fn section_of(run: &Run, many: bool, nav: &mut Vec<(String, &'static str)>) -> String {
    let (id, gathered) = (&run.id, &run.gathered);
    let level = if many { "h3" } else { "h2" };
    let mut text = String::new();
    let mut section = |name: &str, title: &'static str, content: String| {
        if content.is_empty() {
            return;
        }
        text += &format!("<section id=\"{id}{name}\"><{level}>{title}</{level}>\n{content}</section>\n");
        if !many {
            nav.push((format!("{id}{name}"), title));
        }
    };
    if gathered.is_sweep() {
        section("sweep", "Sweep", sweep::section(gathered, &run.source.words));
    } else {
        section("stacks", "Stacks", tables::stacks(gathered, &run.reports, run.note.as_deref()));
        section("plots", "Worlds", plots::worlds(gathered));
    }
    section("pairs", "Pairs that differ", tables::pairs(&run.reports));
    section("outcomes", "How episodes ended", plots::outcomes(gathered) + &tables::endings(gathered));
    text
}

/// The player and the list of episodes.
fn gallery_section(runs: &[Run], nav: &mut Vec<(String, &'static str)>) -> String {
    let shown: usize = runs.iter().map(|run| run.gallery.shown.len()).sum();
    let notes: Vec<String> = runs
        .iter()
        .flat_map(|run| run.gallery.notes.iter().map(move |note| (run, note)))
        .map(|(run, note)| if runs.len() > 1 { format!("{}: {note}", run.name) } else { note.clone() })
        .collect();
    if shown == 0 && notes.is_empty() {
        return String::new();
    }
    nav.push(("episodes-shown".to_owned(), "Episodes"));
    let mut text = "<section id=\"episodes-shown\"><h2>Episodes, failures first</h2>\n".to_owned();
    for note in &notes {
        text += &format!("<p class=\"note\">{}</p>\n", escape(note));
    }
    if shown == 0 {
        return text + "</section>\n";
    }
    text += "<section id=\"replay\" aria-label=\"Replay\"><noscript><p class=\"note\">The pictures below show the way driven; replaying needs a script.</p></noscript></section>\n";
    let mut symbols: BTreeMap<&str, &str> = BTreeMap::new();
    for shown in runs.iter().flat_map(|run| &run.gallery.shown) {
        symbols.insert(&shown.map.0, &shown.map.2);
    }
    text += &format!(
        "<svg class=\"symbols\" aria-hidden=\"true\">{}</svg>\n",
        symbols.values().copied().collect::<String>()
    );
    for run in runs {
        let mut heading = String::new();
        for shown in &run.gallery.shown {
            let words = match (shown.reason, shown.cause) {
                (choose::Reason::Failure, Some(cause)) => cause.words(),
                (reason, _) => reason.words(),
            };
            if words != heading {
                if !heading.is_empty() {
                    text += "</ul>\n";
                }
                let name = if runs.len() > 1 { format!("{}: ", escape(&run.name)) } else { String::new() };
                text += &format!("<h3>{name}{}</h3>\n<ul class=\"episodes\">\n", html::capitalised(words));
                words.clone_into(&mut heading);
            }
            text += &card(shown, run.gathered.is_sweep());
        }
        if !heading.is_empty() {
            text += "</ul>\n";
        }
    }
    text + "</section>\n"
}

fn card(shown: &gallery::Shown, is_sweep: bool) -> String {
    let episode::Entry { id, stack, outcome, episode, command, .. } = &shown.entry;
    let metrics = &shown.row.metrics;
    let figure = |value: Option<f64>, unit: &str| value.map(|value| format!("{} {unit}", html::number(value, 1)));
    let figures: Vec<String> =
        [figure(metrics.time_s, "s"), figure(metrics.length_m, "m")].into_iter().flatten().collect();
    let point = if is_sweep { format!("point {}, ", shown.row.point) } else { String::new() };
    format!(
        "<li><a class=\"episode\" href=\"#{href}\">{picture}<span class=\"what\"><b>{stack}</b> \
         <span class=\"badge\" data-outcome=\"{outcome}\">{ending}</span></span>\
         <span class=\"small\">{point}episode {episode}{figures}</span></a>\
         <details><summary>run it again</summary><code>{command}</code></details></li>\n",
        href = escape(id),
        picture = shown.thumbnail,
        stack = escape(stack),
        outcome = escape(outcome),
        ending = escape(&shown.row.outcome.words()),
        figures = figures.iter().map(|figure| format!(" · {figure}")).collect::<String>(),
        command = escape(command),
    )
}

/// How to run it again.
fn again(runs: &[Run], nav: &mut Vec<(String, &'static str)>) -> String {
    nav.push(("again".to_owned(), "Run it again"));
    let mut text = "<section id=\"again\"><h2>Run it again</h2>\n".to_owned();
    text += "<p>The same scenario, seed and build write the same rows, byte for byte.</p>\n";
    for run in runs {
        let episodes = run.gathered.manifest.as_ref().map(|manifest| manifest.episodes);
        let episodes = episodes.map_or_else(String::new, |count| format!(" --episodes {count}"));
        if runs.len() > 1 {
            text += &format!("<h3>{}</h3>\n", escape(&run.name));
        }
        text += &format!("<pre><code>simrun run {}{episodes}</code></pre>\n", escape(&run.source.words));
        if let Some(identity) = run.gathered.identity() {
            text += &format!(
                "<details><summary>The scenario with every default (hash {})</summary><pre><code>{}</code></pre></details>\n",
                escape(&identity.scenario_hash),
                escape(&identity.scenario)
            );
        }
        if !run.gathered.missing.is_empty() {
            let missing = run.gathered.missing.join(", ");
            text += &format!(
                "<p class=\"note\">An older version wrote this table; the columns that it lacks are empty: {missing}.</p>\n"
            );
        }
    }
    text + "</section>\n"
}

/// Reads a table beside the results.
fn read_text(path: &Path) -> Result<String, ReportError> {
    files::text(path, 1 << 24).map_err(|error| ReportError::File { path: path.to_owned(), message: error.to_string() })
}
