//! Counts how often a gate alarms though nothing got worse.
//!
//! ```sh
//! simrun scenarios/sweeps/gate_alarms.yaml --episodes 100000
//! cargo run --release --example gate_alarms -- results/gate_alarms 100 0.94 0.9
//! ```
//!
//! The rows of three settings in the same worlds (as they are, changed in the last digits, changed visibly) are cut into gates of so many worlds.
//! The visible change gives rows that move but are neither better nor worse: for every world a coin decides which of the two rows is the
//! baseline's and which is the new one.

#![expect(clippy::print_stdout, reason = "an example shows its result")]

use simrun::analysis::{Z_95, wilson};
use simrun::comparison::{Gate, Section, StackRows, compare_baseline, read_table};
use simrun::rng::{EpisodeSeed, Purpose};
use std::error::Error;
use std::path::PathBuf;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, size, required @ ..] = &arguments[..] else {
        return Err("the results, worlds per gate, the success rates that are required".into());
    };
    let size: usize = size.parse()?;
    let required = required.iter().map(|rate| rate.parse()).collect::<Result<Vec<f64>, _>>()?;
    let table = read_table(&PathBuf::from(folder))?;
    let [plain, tiny, changed] = [0, 1, 2].map(|point| whole(&table.sections[point]));
    let rate = plain.success_rate();
    println!("{} worlds, success {:.2} %", plain.rows.len(), 100.0 * rate);

    let (dealt_old, dealt_new) = deal(&plain, &changed);
    let margins = ["success=0", "length_m=0", "time_s=0", "clearance_min_m=0"].map(str::to_owned);
    let wide = ["success=2", "length_m=2%", "time_s=2%", "clearance_min_m=5%"].map(str::to_owned);
    let gates =
        [("no margin", Gate::new(&[], &margins)?), ("as is", Gate::default()), ("wide", Gate::new(&[], &wide)?)];
    for (title, old, new) in [
        ("unchanged", &plain, &plain),
        ("0.1 µm more look-ahead", &plain, &tiny),
        ("rows dealt at random", &dealt_old, &dealt_new),
    ] {
        for (margin, gate) in &gates {
            let alarms = cut(old, size)
                .zip(cut(new, size))
                .map(|(old, new)| Ok(!compare_baseline(&[old], &[new], gate)?.regressions.is_empty()));
            say(&format!("--baseline, {title}, margins {margin}"), alarms.collect::<Result<_, Box<dyn Error>>>()?);
        }
    }
    let gates: Vec<StackRows> = cut(&plain, size).map(|mut section| section.stacks.remove(0)).collect();
    for required in required {
        let below = gates.iter().map(|gate| gate.success_rate() < required);
        say(&format!("--require-success {required}"), below.collect());
        let low = |gate: &StackRows| wilson(gate.successes(), gate.rows.len() as u64, Z_95).map_or(0.0, |ends| ends.0);
        let lows = gates.iter().map(|gate| low(gate) < required);
        say(&format!("--require-success {required} --require-interval"), lows.collect());
    }
    Ok(())
}

/// The one stack of a point, without the values that tell it from those of the other points.
fn whole(section: &Section) -> StackRows {
    StackRows { values: Vec::new(), ..section.stacks[0].clone() }
}

/// The rows of two settings dealt at random between an old and a new run, world by world.
fn deal(first: &StackRows, second: &StackRows) -> (StackRows, StackRows) {
    let (mut old, mut new) = (first.clone(), second.clone());
    let mut coin = EpisodeSeed { seed: 0, episode: 0 }.stream(Purpose::Resampling, 1);
    for (world, row) in &first.rows {
        if coin.uniform() < 0.5
            && let Some(other) = second.rows.get(world)
        {
            old.rows.insert(*world, other.clone());
            new.rows.insert(*world, row.clone());
        }
    }
    (old, new)
}

/// Gates of so many worlds; those left over are no gate.
fn cut(stack: &StackRows, size: usize) -> impl Iterator<Item = Section> {
    let worlds: Vec<_> = stack.rows.iter().collect();
    (0..worlds.len() / size).map(move |gate| {
        let rows = worlds[gate * size..][..size].iter().map(|&(world, row)| (*world, row.clone()));
        Section {
            title: format!("gate {gate}"),
            scenario: String::new(),
            point: 0,
            swept: Vec::new(),
            stacks: vec![StackRows { name: stack.name.clone(), values: Vec::new(), rows: rows.collect() }],
        }
    })
}

fn say(title: &str, alarms: Vec<bool>) {
    let (count, alarmed) = (alarms.len() as u64, alarms.iter().filter(|&&alarm| alarm).count() as u64);
    let (low, high) = wilson(alarmed, count, Z_95).unwrap_or_default();
    println!(
        "{title}: {alarmed} of {count} gates alarm, {:.1} % [{:.1}, {:.1}]",
        100.0 * alarmed as f64 / count as f64,
        100.0 * low,
        100.0 * high
    );
}
