//! The report on a paper, in words for a reader who does not know it.

use super::evidence::{Evidence, TableEvidence};
use super::judge::{Ruling, Verdict, judge};
use super::published::{Measured, Published, Quantity, mean_of, measured};
use super::{Paper, manifest};
use crate::comparison::{Comparison, Format, Pairing, Section, StackRows, analyse, compare_pairs, table};
use std::fmt::Write as _;

/// The whole report in Markdown.
pub fn report(paper: &Paper, evidence: &Evidence) -> String {
    let manifest = &paper.manifest;
    let verdicts: Vec<Verdict> =
        manifest.claims.iter().map(|claim| judge(&claim.test, evidence, &paper.published)).collect();
    let mut text = format!("# {}\n\n{}\n\n", manifest.title, manifest.citation);
    let _ = write!(
        text,
        "## What the paper says\n\n{}\n\n## What was run\n\n{}\n\n",
        manifest.about.trim(),
        manifest.method.trim()
    );
    text += &ran(paper, evidence);
    text += &rulings(manifest, &verdicts);
    for (spec, found) in manifest.tables.iter().filter_map(|spec| Some((spec, evidence.tables.get(spec.id.as_str())?)))
    {
        text += &of_table(spec, found, &paper.published);
    }
    text += &changes(manifest, evidence);
    text += &causes(manifest, evidence);
    text += &bounds(manifest, evidence);
    text + &numbers(&paper.published, evidence)
}

fn ran(paper: &Paper, evidence: &Evidence) -> String {
    let mut rows = vec![["what", "folder", "scenario", "changed", "episodes"].map(str::to_owned).to_vec()];
    let mut total = 0;
    for spec in &paper.manifest.tables {
        let Some(found) = evidence.tables.get(spec.id.as_str()) else { continue };
        let episodes: usize =
            found.sections.iter().flat_map(|section| &section.stacks).map(|stack| stack.rows.len()).sum();
        total += episodes;
        rows.push(vec![
            spec.title.clone(),
            format!("`{}`", spec.id),
            format!("`{}`", spec.scenario),
            if spec.set.is_empty() { "as it is".to_owned() } else { format!("`{}`", spec.set.join("`, `")) },
            episodes.to_string(),
        ]);
    }
    format!(
        "{}\n{total} episodes in all. `simrun reproduce {}` runs them again; the same build writes the same rows.\n\n",
        table(&rows, 4, Format::Markdown),
        paper.name
    )
}

fn rulings(manifest: &manifest::Manifest, verdicts: &[Verdict]) -> String {
    let mut text = "## The claims\n\n".to_owned();
    let count = |ruling: Ruling| verdicts.iter().filter(|verdict| verdict.ruling == ruling).count();
    let all = [Ruling::Holds, Ruling::Fails, Ruling::Undecided, Ruling::Untestable];
    let counts: Vec<String> = all.iter().map(|&ruling| format!("{} {}", count(ruling), ruling.words())).collect();
    let _ = writeln!(
        text,
        "{} claims: {}. *Undecided* means that the data fit both the claim and its opposite.\n",
        verdicts.len(),
        counts.join(", ")
    );
    let mut rows = vec![["", "claim", "verdict", "because"].map(str::to_owned).to_vec()];
    for (claim, verdict) in manifest.claims.iter().zip(verdicts) {
        let says =
            [&claim.says, &claim.doubt].into_iter().filter(|part| !part.is_empty()).map(|part| part.trim().to_owned());
        let because = [&verdict.why, &claim.remark]
            .into_iter()
            .filter(|part| !part.is_empty())
            .map(|part| part.trim().to_owned());
        rows.push(vec![
            claim.id.clone(),
            cell(&says.collect::<Vec<_>>().join(". *Doubt:* ")),
            format!("**{}**", verdict.ruling.words()),
            cell(&because.collect::<Vec<_>>().join(". ")),
        ]);
    }
    text + &table(&rows, 4, Format::Markdown) + "\n"
}

/// A text as the cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

fn of_table(spec: &manifest::Table, found: &TableEvidence, published: &[Published]) -> String {
    let mut text = format!("## {}\n\n", spec.title);
    for section in &found.sections {
        if !section.swept.is_empty() {
            let point: Vec<String> = section.swept.iter().map(|(key, value)| format!("`{key}` = {value}")).collect();
            let _ = writeln!(text, "{}:\n", point.join(", "));
        }
        text += &stacks(spec.id.as_str(), section, published);
    }
    text
}

/// One row per stack: our number, then the published one.
fn stacks(id: &str, section: &Section, published: &[Published]) -> String {
    let printed = |stack: &str, metric: &str| {
        let found = published.iter().find(|number| {
            number.table == id && number.stack == stack && number.metric == metric && number.quantity == Quantity::Mean
        });
        found.map_or_else(String::new, |number| format!(" ({})", number.value))
    };
    let letters = analyse(section, &Pairing::default()).map(|report| report.letters).unwrap_or_default();
    let head = [
        "stack",
        "n",
        "success % [95 %]",
        "group",
        "length m",
        "time s",
        "planned m",
        "expanded",
        "clearance min m",
        "encounters",
        "success of those that met something %",
        "replans",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (index, stack) in section.stacks.iter().enumerate() {
        let of = |metric: &str, decimals: usize| {
            let ours =
                mean_of(stack, metric).map_or_else(|| "-".to_owned(), |mean| format!("{:.decimals$}", mean.value));
            ours + &printed(&stack.name, metric)
        };
        let success = mean_of(stack, "success").map_or_else(
            || "-".to_owned(),
            |mean| {
                let (low, high) = mean.interval.unwrap_or((mean.value, mean.value));
                format!("{:.1} [{low:.1}, {high:.1}]", mean.value)
            },
        );
        rows.push(vec![
            stack.name.clone(),
            stack.rows.len().to_string(),
            success + &printed(&stack.name, "success"),
            letters.get(index).cloned().unwrap_or_default(),
            of("length_m", 2),
            of("time_s", 2),
            of("planned_length_m", 2),
            of("expanded", 0),
            of("clearance_min_m", 2),
            all_mean(stack, |row| row.metrics.encounters.map(f64::from)),
            given_an_encounter(stack),
            all_mean(stack, |row| row.metrics.replans.map(f64::from)),
        ]);
    }
    format!(
        "{}\nIn brackets behind a number: what the paper prints in this place. Lengths, times and clearances are means over the successes; \
         stacks that share a letter are not told apart by success.\n\n",
        table(&rows, 1, Format::Markdown)
    )
}

/// Each table with changes against the table of the same scenario with the most changes, on the same worlds. Other stacks are
/// no change of a scenario: stacks are matched by name.
fn changes(manifest: &manifest::Manifest, evidence: &Evidence) -> String {
    let head = [
        "folder",
        "against",
        "what changes",
        "stack",
        "worlds",
        "success, points [95 %]",
        "p",
        "solved",
        "time, s [95 %]",
        "p",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for changed in manifest.tables.iter().filter(|table| !table.set.iter().any(|change| change.starts_with("stacks=")))
    {
        let is_part = |other: &&manifest::Table| {
            other.scenario == changed.scenario
                && other.set.len() < changed.set.len()
                && other.set.iter().all(|change| changed.set.contains(change))
        };
        let Some(base) = manifest.tables.iter().filter(is_part).max_by_key(|other| other.set.len()) else { continue };
        let sections = (evidence.section(base.id.as_str()), evidence.section(changed.id.as_str()));
        let (Some(before), Some(after)) = sections else { continue };
        let added = changed.set.iter().filter(|change| !base.set.contains(change));
        let added: Vec<String> = added.map(|change| format!("`{change}`")).collect();
        for stack in &after.stacks {
            let Some(reference) = before.stacks.iter().find(|other| other.name == stack.name) else { continue };
            let tests = compare_pairs(reference, stack);
            let find = |metric: &str| tests.iter().find(|test| test.metric == metric && test.n > 0);
            let Some(success) = find("success") else { continue };
            let shown = |test: Option<&Comparison>| {
                let Some(test) = test else { return ["0", "-", "-"].map(str::to_owned) };
                let (low, high) = test.interval.unwrap_or_default();
                let difference = format!("{:+.1} [{low:+.1}, {high:+.1}]", test.difference.unwrap_or_default());
                let p = if test.p < 0.0005 { "<0.001".to_owned() } else { format!("{:.3}", test.p) };
                [test.n.to_string(), difference, p]
            };
            let mut row = [&changed.id, &base.id].map(|id| format!("`{id}`")).to_vec();
            row.extend([cell(&added.join(", ")), stack.name.clone()]);
            row.extend(shown(Some(success)));
            row.extend(shown(find("time_s")));
            rows.push(row);
        }
    }
    if rows.len() == 1 {
        return String::new();
    }
    format!(
        "## What the changes to a scenario do\n\nThe same stack in the same worlds, with the change less without it: success (exact McNemar \
         test), and time on the worlds solved both ways (signed-rank test). p is not corrected. Where a change makes other worlds \
         there is nothing to compare.\n\n{}\n",
        table(&rows, 4, Format::Markdown)
    )
}

/// Mean over all episodes.
fn all_mean(stack: &StackRows, get: fn(&crate::results::Row) -> Option<f64>) -> String {
    let values: Vec<f64> = stack.rows.values().filter_map(get).collect();
    if values.is_empty() { "-".to_owned() } else { format!("{:.2}", values.iter().sum::<f64>() / values.len() as f64) }
}

fn given_an_encounter(stack: &StackRows) -> String {
    let met = || stack.rows.values().filter(|row| row.metrics.encounters.is_some_and(|count| count > 0));
    let (n, k) = (met().count(), met().filter(|row| row.outcome.is_success()).count());
    if n == 0 { "-".to_owned() } else { format!("{:.1} ({k}/{n})", 100.0 * k as f64 / n as f64) }
}

fn causes(manifest: &manifest::Manifest, evidence: &Evidence) -> String {
    let mut text = "## Why drives failed\n\nUp to twenty failures of each stack were driven again, and their last seconds looked at. \
                    The example is an episode: `simrun draw` shows it.\n\n"
        .to_owned();
    let mut rows =
        vec![["folder", "stack", "failures", "looked at", "causes (how many, an episode)"].map(str::to_owned).to_vec()];
    for spec in &manifest.tables {
        let Some(found) = evidence.tables.get(spec.id.as_str()) else { continue };
        for ((_, stack), failures) in found.failures.iter().filter(|(_, failures)| failures.total > 0) {
            let mut causes: Vec<_> = failures.causes.iter().collect();
            causes.sort_by_key(|(cause, count)| (std::cmp::Reverse(**count), **cause));
            let words = causes.iter().map(|(cause, count)| {
                format!(
                    "{} ({count}, episode {})",
                    cause.words(),
                    failures.examples.get(*cause).copied().unwrap_or_default()
                )
            });
            rows.push(vec![
                format!("`{}`", spec.id),
                stack.clone(),
                failures.total.to_string(),
                failures.sampled.to_string(),
                words.collect::<Vec<_>>().join("; "),
            ]);
        }
    }
    text += &table(&rows, 2, Format::Markdown);
    text + "\n"
}

fn bounds(manifest: &manifest::Manifest, evidence: &Evidence) -> String {
    let found = || manifest.tables.iter().filter_map(|spec| Some(&evidence.tables.get(spec.id.as_str())?.bounds));
    let (rows, checks): (u64, u64) = found().fold((0, 0), |(r, c), bounds| (r + bounds.rows, c + bounds.checks));
    let broken: Vec<&String> = found().flat_map(|bounds| &bounds.broken).collect();
    let mut text = format!(
        "## Bounds that no row may break\n\nNo planned path and no drive is shorter than the straight line; exact planners agree on the \
         length; A* expands no more than Dijkstra, Dijkstra no more than there are free cells. {checks} checks on {rows} rows, {} broken.\n\n",
        broken.len()
    );
    for what in broken {
        let _ = writeln!(text, "- **{what}**");
    }
    text
}

fn numbers(published: &[Published], evidence: &Evidence) -> String {
    let mut rows =
        vec![["where", "folder", "stack", "what", "printed", "ours [95 %]", "note"].map(str::to_owned).to_vec()];
    for number in published {
        let against = if number.against.is_empty() { String::new() } else { format!(" against {}", number.against) };
        rows.push(vec![
            number.place.clone(),
            format!("`{}`", number.table),
            number.stack.clone(),
            format!("{} {}{against}, {}", number.metric, number.quantity.name(), number.unit),
            number.value.clone(),
            measured(number, evidence).map_or_else(|| "-".to_owned(), shown),
            cell(&number.note),
        ]);
    }
    format!("## Every published number\n\n{}", table(&rows, 4, Format::Markdown))
}

fn shown(ours: Measured) -> String {
    let interval = ours.interval.map_or_else(String::new, |(low, high)| format!(" [{low:.2}, {high:.2}]"));
    format!("{:.2}{interval}", ours.value)
}

/// Every published number beside ours, as CSV.
pub fn published_csv(paper: &Paper, evidence: &Evidence) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = [
        "where",
        "table",
        "stack",
        "against",
        "metric",
        "quantity",
        "unit",
        "published",
        "measured",
        "low",
        "high",
        "n",
    ];
    // Writing to memory does not fail.
    let _ = writer.write_record(head);
    for number in &paper.published {
        let ours = measured(number, evidence);
        let real = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
        let _ = writer.write_record([
            number.place.clone(),
            number.table.clone(),
            number.stack.clone(),
            number.against.clone(),
            number.metric.clone(),
            number.quantity.name().to_owned(),
            number.unit.clone(),
            number.value.clone(),
            real(ours.map(|ours| ours.value)),
            real(ours.and_then(|ours| ours.interval).map(|interval| interval.0)),
            real(ours.and_then(|ours| ours.interval).map(|interval| interval.1)),
            ours.map_or_else(String::new, |ours| ours.n.to_string()),
        ]);
    }
    String::from_utf8_lossy(&writer.into_inner().unwrap_or_default()).into_owned()
}

/// The verdicts as CSV.
pub fn verdicts_csv(paper: &Paper, evidence: &Evidence) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let _ = writer.write_record(["id", "claim", "verdict", "because"]);
    for claim in &paper.manifest.claims {
        let verdict = judge(&claim.test, evidence, &paper.published);
        let _ = writer.write_record([&claim.id, &claim.says, verdict.ruling.words(), &verdict.why]);
    }
    String::from_utf8_lossy(&writer.into_inner().unwrap_or_default()).into_owned()
}
