//! `simrun check`: everything that can be wrong before the first tick.

use super::scenarios::{AtPoint, Changes};
use super::{Failure, Out};
use crate::results::layout::hanging;
use crate::settings::quantity::counted;
use std::path::PathBuf;

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
    #[command(flatten)]
    changes: Changes,
    #[command(flatten)]
    out: Out,
}

pub(super) fn main(args: &Args) -> Result<(), Failure> {
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
            Err(Failure::Usage(message)) => {
                refused.push(message);
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
                if experiment.repeats(0) {
                    let episodes = counted(episodes, "episode");
                    line(
                        2,
                        &format!(
                            "note: nothing in this scenario is random: its {episodes} are the same; use `episodes: 1`, or make the start, \
                             the goal, obstacles or noise random"
                        ),
                    );
                }
                for note in experiment.map_notes() {
                    line(2, &format!("note: {note}"));
                }
                for difference in experiment.differences(0) {
                    line(2, &format!("note: {difference}"));
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
    if refused.is_empty() { Ok(()) } else { Err(Failure::Usage(refused.join("\n\n"))) }
}
