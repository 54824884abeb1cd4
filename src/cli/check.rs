//! `simrun check`: everything that can be wrong before the first tick.

use super::json::{self, TextOrJson};
use super::scenarios::{AtPoint, Changes};
use super::{Failure, Out};
use crate::experiment::Experiment;
use crate::results::Field;
use crate::results::layout::hanging;
use crate::settings::quantity::counted;
use serde_json::{Value as Json, json};
use std::path::{Path, PathBuf};

#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// Scenario files.
    #[arg(required = true, value_name = "SCENARIO")]
    scenarios: Vec<PathBuf>,
    /// Print each scenario with every default filled in; comments tell what is used where a key has no value of its own.
    #[arg(long)]
    resolved: bool,
    /// Print the scenario at this point of its sweep, with every default filled in.
    #[arg(long, value_name = "N")]
    point: Option<u32>,
    /// How to print it.
    #[arg(long, value_enum, default_value_t)]
    format: TextOrJson,
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    out: Out,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
    if args.format == TextOrJson::Json {
        return json::answer("check", &args.out, |document| {
            let (mut checked, mut refused) = (Vec::new(), Vec::new());
            for file in &args.scenarios {
                match as_json(args, file) {
                    Ok(found) => checked.push(found),
                    Err(failure) => refused.push(failure),
                }
            }
            document.insert("scenarios".to_owned(), checked.into());
            Failure::all(refused)
        });
    }
    let mut text = String::new();
    let result = check(args, &mut text);
    // What was found before a fault is said as well.
    args.out.write(&text)?;
    result
}

fn check(args: &Args, text: &mut String) -> Result<(), Failure> {
    let mut refused = Vec::new();
    for file in &args.scenarios {
        let experiment = match args.changes.load(file) {
            Err(failure @ (Failure::Usage(_) | Failure::Scenario(_))) => {
                refused.push(failure);
                continue;
            }
            other => other?,
        };
        let episodes = u64::from(experiment.scenario().episodes.get());
        match (args.resolved, args.point) {
            (true, None) => *text += &experiment.scenario().explained(experiment.fixed_map(0)),
            (_, Some(point)) => {
                let point = AtPoint { point }.of(&experiment)?;
                *text += &experiment.scenario_at(point).explained(experiment.fixed_map(point));
            }
            (false, None) => {
                let order = experiment.order().map_err(Failure::usage)?;
                let is_swept = !experiment.swept().is_empty();
                let count = if is_swept {
                    counted(u64::from(experiment.points()), "point")
                } else {
                    counted(order.points()[0].len() as u64, "stack")
                };
                let mut line = |indent: usize, words: &str| {
                    *text += &hanging(&" ".repeat(indent), indent + 2, words, args.out.width())
                };
                line(0, &format!("{}: valid, {count}, {} each", file.display(), counted(episodes, "episode")));
                for note in notes(&experiment) {
                    line(2, &format!("note: {note}"));
                }
                for point in (0..experiment.points()).filter(|_| is_swept) {
                    let values = experiment.swept().iter().zip(experiment.values(point));
                    let values: Vec<String> = values.map(|(key, value)| format!("{key} = {value}")).collect();
                    let stacks: Vec<&str> = experiment.stacks(point).map(|stack| stack.name.as_str()).collect();
                    let stacks = if stacks.is_empty() { "nothing new".to_owned() } else { stacks.join(", ") };
                    line(2, &format!("{point}: {}: {stacks}", values.join(", ")));
                }
            }
        }
    }
    Failure::all(refused)
}

/// What is worth knowing about a scenario that is not wrong.
fn notes(experiment: &Experiment) -> Vec<String> {
    let episodes = counted(u64::from(experiment.scenario().episodes.get()), "episode");
    let repeats = experiment.repeats(0).then(|| {
        format!(
            "nothing in this scenario is random: its {episodes} are the same; use `episodes: 1`, or make the start, the goal, obstacles or \
             noise random"
        )
    });
    repeats.into_iter().chain(experiment.map_notes()).chain(experiment.differences(0)).collect()
}

fn as_json(args: &Args, file: &Path) -> Result<Json, Failure> {
    let experiment = args.changes.load(file)?;
    let scenario = experiment.scenario();
    let order = experiment.order().map_err(Failure::usage)?;
    let points = (0..experiment.points()).zip(order.points()).map(|(point, stacks)| {
        let values = experiment.swept().iter().zip(experiment.values(point));
        let values: json::Object =
            values.map(|(key, value)| (key.clone(), Field::Setting(value.to_string()).json())).collect();
        let stacks: Vec<&str> = stacks.iter().map(|stack| stack.name.as_str()).collect();
        json!({ "point": point, "values": values, "stacks": stacks })
    });
    let points: Vec<Json> = points.collect();
    let resolved = match (args.resolved, args.point) {
        (true, None) => Some(json!(scenario)),
        (false, None) => None,
        (_, Some(point)) => Some(json!(experiment.scenario_at(AtPoint { point }.of(&experiment)?))),
    };
    let mut object = json!({
        "file": file.display().to_string(),
        "scenario": scenario.name.as_str(),
        "seed": scenario.seed,
        "episodes": scenario.episodes.get(),
        "stacks": experiment.stack_names(),
        "points": points,
        "notes": notes(&experiment),
    });
    if let (Some(resolved), Some(object)) = (resolved, object.as_object_mut()) {
        object.insert("resolved".to_owned(), resolved);
    }
    Ok(object)
}
