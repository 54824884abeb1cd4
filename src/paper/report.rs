//! The report on a paper, in words for a reader who does not know it.

use super::evidence::{Evidence, Failures, TableEvidence};
use super::findings::{Finding, Findings};
use super::published::{Measured, Published, Quantity, SUCCESS, mean_of, measured, values};
use super::test::{Data, Ruling, Test};
use super::{Paper, manifest};
use crate::analysis::{ErrorRates, minimal_detectable_risk_difference, one_way_random, pairs};
use crate::comparison::{Comparison, Format, Pairing, Section, StackRows, analyse, compare_pairs, table};
use crate::math;
use crate::settings::quantity::counted;
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The whole report in Markdown.
pub fn report(paper: &Paper, evidence: &Evidence, findings: &Findings<'_>) -> String {
    let manifest = &paper.manifest;
    let mut text = format!("# {}\n\n{}\n\n", manifest.title, manifest.citation);
    let _ = write!(
        text,
        "## What the paper says\n\n{}\n\n## What was run\n\n{}\n\n",
        manifest.about.trim(),
        manifest.method.trim()
    );
    text += &ran(paper, evidence);
    text += &rulings(findings);
    text += &choices(paper, evidence);
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
    let under: usize =
        evidence.under.values().flatten().flat_map(|section| &section.stacks).map(|stack| stack.rows.len()).sum();
    let (under, full) = match under {
        0 => (String::new(), ""),
        count => (format!(", and {} under other choices", counted(count as u64, "episode")), " --full"),
    };
    format!(
        "{}\n{total} episodes in all{under}. `simrun reproduce {}{full}` runs them again; the same build writes the same rows.\n\n",
        table(&rows, 4, Format::Markdown),
        paper.name
    )
}

/// The claims of the paper, then the questions of ours.
fn rulings(findings: &Findings<'_>) -> String {
    let tested = findings.claims.iter().filter(|finding| finding.p_holm.is_some()).count();
    let mut text = "## The claims of the paper\n\n".to_owned();
    let _ = writeln!(
        text,
        "{} *Undecided* means that the data fit both the claim and its opposite; *depends* that it holds under one of the choices which \
         the paper leaves open and does not hold under another. The {tested} claims with a statistical test are one family: their \
         p-values are corrected by Holm, and the error rate of 5 % is that of all of them together.\n",
        counts(&findings.claims, "claim")
    );
    text += &ruling_table(&findings.claims);
    if !findings.questions.is_empty() {
        let _ = writeln!(
            text,
            "\n## Questions of ours\n\n{} The paper does not claim these; each is tested by itself, without a correction.\n",
            counts(&findings.questions, "question")
        );
        text += &ruling_table(&findings.questions);
    }
    text + "\n"
}

fn counts(findings: &[Finding<'_>], what: &str) -> String {
    let count = |ruling: Ruling| findings.iter().filter(|finding| finding.ruling() == ruling).count();
    let counts = Ruling::ALL.into_iter().filter(|&ruling| count(ruling) > 0);
    let counts: Vec<String> = counts.map(|ruling| format!("{} {}", count(ruling), ruling.words())).collect();
    format!("{}: {}.", counted(findings.len() as u64, what), counts.join(", "))
}

fn ruling_table(findings: &[Finding<'_>]) -> String {
    // A sentence that ends with its own mark needs no other.
    let joined = |parts: [&str; 2], before: &str| {
        let [first, second] = parts.map(str::trim);
        let end = if first.is_empty() || first.ends_with('?') { "" } else { "." };
        cell(&if second.is_empty() { first.to_owned() } else { format!("{first}{end} {before}{second}") })
    };
    let is_corrected = findings.iter().any(|finding| finding.p_holm.is_some());
    let has_choices = findings.iter().any(|finding| !finding.under.is_empty());
    let mut head = vec!["", "claim", "verdict", "because"];
    if is_corrected {
        head.push("p, Holm");
    }
    if has_choices {
        head.extend(["kindest reading", "other choices that decide otherwise"]);
    }
    let mut rows = vec![head.into_iter().map(str::to_owned).collect::<Vec<_>>()];
    for finding in findings {
        let Finding { claim, verdict, p_holm, under } = finding;
        let mut row = vec![
            claim.id.clone(),
            joined([&claim.says, &claim.doubt], "*Doubt:* "),
            format!("**{}**", finding.ruling().words()),
            joined([&verdict.why, &claim.remark], ""),
        ];
        if is_corrected {
            row.push(p_holm.map_or_else(|| "-".to_owned(), p_value));
        }
        if has_choices {
            let kindest = under.iter().find(|(choice, _)| choice.kindest);
            row.push(kindest.map_or("-", |(_, ruling)| ruling.words()).to_owned());
            let others = finding.turned_by().filter(|(choice, _)| !choice.kindest);
            let others: Vec<String> =
                others.map(|(choice, ruling)| format!("`{}`: {}", choice.id, ruling.words())).collect();
            row.push(match (others.is_empty(), under.len()) {
                (_, 0) => "-".to_owned(),
                (true, count) => format!("none of {count}"),
                (false, _) => others.join("; "),
            });
        }
        rows.push(row);
    }
    table(&rows, rows[0].len(), Format::Markdown)
}

fn p_value(p: f64) -> String {
    if p < 0.0005 { "<0.001".to_owned() } else { format!("{p:.3}") }
}

/// The choices that the paper leaves open, and what each does to the stacks whose published rate is asked for.
fn choices(paper: &Paper, evidence: &Evidence) -> String {
    let manifest = &paper.manifest;
    let ran = |choice: &&manifest::Choice| evidence.under.keys().any(|(id, _)| id == choice.id.as_str());
    let choices: Vec<&manifest::Choice> = manifest.ablate.iter().filter(ran).collect();
    if choices.is_empty() {
        return String::new();
    }
    let mut text = "## What the paper leaves open\n\nEach choice is taken another way in turn, on the same seeds; every claim above is judged \
                    again under it.\n\n"
        .to_owned();
    let mut rows = vec![["choice", "about", "taken this way", "settings", "tables"].map(str::to_owned).to_vec()];
    for choice in &choices {
        let about = match choice.of {
            manifest::Subject::Planner => "the planner",
            manifest::Subject::World => "the world",
            manifest::Subject::Both => "both",
        };
        let kindest = if choice.kindest { " (the kindest reading)" } else { "" };
        rows.push(vec![
            format!("`{}`{kindest}", choice.id),
            about.to_owned(),
            cell(choice.says.trim()),
            cell(&format!("`{}`", choice.set.join("`, `"))),
            choice.tables.join(", "),
        ]);
    }
    text += &table(&rows, 5, Format::Markdown);

    let head = ["stack", "table", "choice", "n", "success % [95 %]", "length m", "time s", "speed m/s", "movers met"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for claim in manifest.statements() {
        let Test::reach(reach) = &claim.test else { continue };
        let place = &reach.of;
        for choice in std::iter::once(None).chain(choices.iter().map(|choice| Some(choice.id.as_str()))) {
            let tables = [Some(&place.table), reach.larger.as_ref()];
            let changes = |id: &str| {
                tables.into_iter().flatten().any(|table| evidence.under.contains_key(&(id.to_owned(), table.clone())))
            };
            if choice.is_some_and(|id| !changes(id)) {
                continue;
            }
            let Ok(stack) =
                reach.rows(&Data { evidence, published: &paper.published, tables: &manifest.tables, choice })
            else {
                continue;
            };
            let of = |metric: &str| {
                mean_of(stack, metric).map_or_else(|| "-".to_owned(), |mean| format!("{:.2}", mean.value))
            };
            rows.push(vec![
                place.stack.clone(),
                format!("`{}`", place.table),
                choice.map_or_else(|| "as it is".to_owned(), |id| format!("`{id}`")),
                stack.rows.len().to_string(),
                success(stack),
                of("length_m"),
                of("time_s"),
                of("speed_mean_mps"),
                all_mean(stack, |row| row.metrics.encounters_movers.map(f64::from)),
            ]);
        }
    }
    if rows.len() > 1 {
        text += "\nThe stacks whose published rate is asked for, under each choice:\n\n";
        text += &table(&rows, 3, Format::Markdown);
    }
    text + "\n"
}

/// The success rate with its interval.
fn success(stack: &StackRows) -> String {
    mean_of(stack, "success").map_or_else(
        || "-".to_owned(),
        |mean| {
            let (low, high) = mean.interval.unwrap_or((mean.value, mean.value));
            format!("{:.1} [{low:.1}, {high:.1}]", mean.value)
        },
    )
}

/// A text as the cell of a Markdown table.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('\n', " ")
}

fn of_table(spec: &manifest::Table, found: &TableEvidence, published: &[Published]) -> String {
    let mut text = format!("## {}\n\n", spec.title);
    if let Some(maps) = between_maps(&found.sections) {
        return text + &maps;
    }
    for section in &found.sections {
        if !section.swept.is_empty() {
            let point: Vec<String> = section.swept.iter().map(|(key, value)| format!("`{key}` = {value}")).collect();
            let _ = writeln!(text, "{}:\n", point.join(", "));
        }
        text += &stacks(spec.id.as_str(), section, published);
    }
    text
}

/// What a mean over maps is worth where a sweep drives many worlds on each of several maps; `None` unless the keys are the map's alone.
fn between_maps(sections: &[Section]) -> Option<String> {
    let is_of_map = |section: &Section| section.swept.iter().all(|(key, _)| key.starts_with("map."));
    let first = sections.first().filter(|_| sections.len() > 1 && sections.iter().all(is_of_map))?;
    let head =
        ["stack", "metric", "maps", "mean [95 %, maps at random]", "sd between maps", "sd within a map", "intraclass"];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (stack, metric) in first.stacks.iter().flat_map(|stack| [(stack, SUCCESS), (stack, "time_s")]) {
        let same =
            |section: &Section| section.stacks.iter().find(|other| other.name == stack.name).map(|s| values(s, metric));
        let groups: Vec<Vec<f64>> = sections.iter().filter_map(same).filter(|group| !group.is_empty()).collect();
        let Some(found) = one_way_random(&groups) else { continue };
        let (low, high) = found.interval;
        rows.push(vec![
            stack.name.clone(),
            metric.to_owned(),
            groups.len().to_string(),
            format!("{:.2} [{low:.2}, {high:.2}]", found.mean),
            format!("{:.2}", found.between.sqrt()),
            format!("{:.2}", found.within.sqrt()),
            found.intraclass.map_or_else(|| "-".to_owned(), |share| format!("{share:.3}")),
        ]);
    }
    Some(format!(
        "Maps as a random effect: an interval for maps that were not driven, and how much of the spread lies between maps (`success` in \
         percentage points).\n\n{}\n",
        table(&rows, 2, Format::Markdown)
    ))
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
        "to movers m",
        "to unknown m",
        "movers met",
        "unknown met",
        "success of those that met a mover %",
        "replans",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    for (index, stack) in section.stacks.iter().enumerate() {
        let of = |metric: &str, decimals: usize| {
            let ours =
                mean_of(stack, metric).map_or_else(|| "-".to_owned(), |mean| format!("{:.decimals$}", mean.value));
            ours + &printed(&stack.name, metric)
        };
        rows.push(vec![
            stack.name.clone(),
            stack.rows.len().to_string(),
            success(stack) + &printed(&stack.name, "success"),
            letters.get(index).cloned().unwrap_or_default(),
            of("length_m", 2),
            of("time_s", 2),
            of("planned_length_m", 2),
            of("expanded", 0),
            of("clearance_min_m", 2),
            of("clearance_movers_min_m", 2),
            of("clearance_unknown_min_m", 2),
            all_mean(stack, |row| row.metrics.encounters_movers.map(f64::from)),
            all_mean(stack, |row| Some(f64::from(row.metrics.encounters? - row.metrics.encounters_movers?))),
            given_a_mover(stack),
            all_mean(stack, |row| row.metrics.replans.map(f64::from)),
        ]);
    }
    format!(
        "{}\nIn brackets behind a number: what the paper prints in this place. Lengths, times and clearances are means over the successes; \
         stacks that share a letter are not told apart by success.{}\n\n",
        table(&rows, 1, Format::Markdown),
        shown_differences(section)
    )
}

/// What difference in success the worlds of a section can show between two of its stacks.
fn shown_differences(section: &Section) -> String {
    let differences = pairs(section.stacks.len()).filter_map(|(first, second)| {
        let shared = || section.stacks[first].shared(&section.stacks[second]);
        let discordant = shared().filter(|(a, b)| a.outcome.is_success() != b.outcome.is_success()).count();
        let n = shared().count();
        let share = discordant as f64 / n as f64;
        (discordant > 0).then(|| minimal_detectable_risk_difference(n, share, ErrorRates::default()))?
    });
    let points: Vec<f64> = differences.map(|rate| 100.0 * rate).collect();
    let (low, high) =
        (points.iter().copied().fold(f64::INFINITY, math::min), points.iter().copied().fold(0.0, math::max));
    if points.is_empty() {
        return String::new();
    }
    let (low, high) = (format!("{low:.1}"), format!("{high:.1}"));
    let range = if low == high { high } else { format!("{low} to {high}") };
    format!(
        " Two stacks must differ by {range} points for one test on these worlds to show it with a power of 80 %: *not told apart* is \
         not *equal*."
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
                [test.n.to_string(), difference, p_value(test.p)]
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

fn given_a_mover(stack: &StackRows) -> String {
    let met = || stack.rows.values().filter(|row| row.metrics.encounters_movers.is_some_and(|count| count > 0));
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
        let mut by_stack: BTreeMap<&str, Failures> = BTreeMap::new();
        for ((_, stack), failures) in &found.failures {
            by_stack.entry(stack).or_default().join(failures);
        }
        for (stack, failures) in by_stack.iter().filter(|(_, failures)| failures.total > 0) {
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
                (*stack).to_owned(),
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
pub fn verdicts_csv(findings: &Findings<'_>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let head = ["id", "asked_by", "claim", "verdict", "ours", "because", "p", "p_holm", "kindest", "depends_on"];
    let _ = writer.write_record(head);
    let mut of = |asked_by: &str, findings: &[Finding<'_>]| {
        for finding in findings {
            let real = |value: Option<f64>| value.map_or_else(String::new, |value| value.to_string());
            let kindest = finding.under.iter().find(|(choice, _)| choice.kindest);
            let turned: Vec<&str> = finding.turned_by().map(|(choice, _)| choice.id.as_str()).collect();
            let _ = writer.write_record([
                finding.claim.id.as_str(),
                asked_by,
                finding.claim.says.as_str(),
                finding.ruling().words(),
                finding.verdict.ruling.words(),
                finding.verdict.why.as_str(),
                real(finding.verdict.p).as_str(),
                real(finding.p_holm).as_str(),
                kindest.map_or("", |(_, ruling)| ruling.words()),
                turned.join(" ").as_str(),
            ]);
        }
    };
    of("paper", &findings.claims);
    of("simrun", &findings.questions);
    String::from_utf8_lossy(&writer.into_inner().unwrap_or_default()).into_owned()
}
