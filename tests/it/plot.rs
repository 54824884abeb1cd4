//! `simrun plot`: values stand where the axes say, the same table makes the same bytes, names are checked.

use super::support::{Simrun, simrun};
use simrun::episode::Outcome;
use simrun::metrics::Metrics;
use simrun::results::{Row, header_line, write_row};
use std::fs;
use std::path::Path;

/// A table of a sweep over `robot.radius_m`: stack, point, episode, time in s (none for a time-out), value of the key.
type Drive<'a> = (&'a str, u32, u64, Option<f64>, &'a str);

fn write(folder: &Path, drives: &[Drive<'_>]) {
    let header = header_line(&["robot.radius_m".to_owned()]);
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(header);
    for &(stack, point, episode, time_s, value) in drives {
        let row = Row {
            scenario: "made_up".to_owned(),
            point,
            stack: stack.to_owned(),
            global: String::new(),
            path: String::new(),
            local: "dwa".to_owned(),
            episode,
            seed: 7,
            outcome: if time_s.is_some() { Outcome::Success } else { Outcome::Timeout },
            metrics: Metrics { time_s: time_s.or(Some(500.0)), ..Metrics::default() },
            world_digest: None,
            trace_digest: None,
            swept: vec![value.to_owned()],
        };
        write_row(&mut writer, &row).unwrap();
    }
    fs::write(folder.join("episodes.csv"), writer.into_inner().unwrap()).unwrap();
}

fn plot(folder: &Path, arguments: &[&str]) -> String {
    call(folder, arguments).ends_with(0).stdout
}

fn call(folder: &Path, arguments: &[&str]) -> Simrun {
    let mut call = simrun(folder);
    call.arg("plot").args(arguments).args(["-o", "-"]);
    call
}

fn attribute(line: &str, name: &str) -> f64 {
    let from = line.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
    line[from..].split('"').next().unwrap().parse().unwrap()
}

/// Where a label stands: x and y.
#[track_caller]
fn label(svg: &str, words: &str) -> (f64, f64) {
    let line = svg.lines().find(|line| line.contains(&format!(">{words}</text>")));
    let line = line.unwrap_or_else(|| panic!("no label {words}: {svg}"));
    (attribute(line, "x"), attribute(line, "y"))
}

/// The middles of the discs, the marks of the first series.
fn discs(svg: &str) -> Vec<(f64, f64)> {
    let marks = svg.lines().filter(|line| line.starts_with("<circle"));
    marks.map(|line| (attribute(line, "cx"), attribute(line, "cy"))).collect()
}

const DRIVES: [Drive<'static>; 7] = [
    ("a", 0, 0, Some(19.0), "0.2"),
    ("a", 0, 1, Some(20.0), "0.2"),
    ("a", 0, 2, Some(21.0), "0.2"),
    ("a", 1, 0, Some(38.0), "0.4"),
    ("a", 1, 1, Some(40.0), "0.4"),
    ("a", 1, 2, Some(42.0), "0.4"),
    ("a", 1, 3, None, "0.4"),
];

#[test]
fn means_stand_where_the_axes_say() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &DRIVES);
    let svg = plot(folder.path(), &[".", "--x", "robot.radius_m", "--y", "time_s"]);
    // Labels of y stand as far below their ticks everywhere, those of x in the middle of theirs. Means: 20 s at 0.2 m, 40 s at 0.4 m; the
    // time-out counts for neither.
    let places = discs(&svg);
    assert_eq!(places.len(), 2, "{svg}");
    for ((x, y), (at, mean)) in places.into_iter().zip([("0.2", 20.0), ("0.4", 40.0)]) {
        assert!((x - label(&svg, at).0).abs() < 0.11, "{x} at {at}");
        // Two ticks of the y axis span the scale.
        let (zero, forty) = (label(&svg, "0").1, label(&svg, "40").1);
        let below = forty - tick_line(&svg, forty);
        let expected = zero + mean / 40.0 * (forty - zero) - below;
        assert!((y - expected).abs() < 0.25, "{y} for {mean} s: {expected}");
    }
    assert!(svg.contains(">Time (s)<") && svg.contains(">Radius (m)<") && svg.contains("width=\"88mm\""), "{svg}");
    assert_eq!(svg, plot(folder.path(), &[".", "--x", "robot.radius_m", "--y", "time_s"]));
}

/// The height of the line of the grid nearest to a label.
fn tick_line(svg: &str, label_y: f64) -> f64 {
    let lines = svg.lines().filter(|line| line.starts_with("<path d=\"M") && line.contains("#e3e5e8"));
    let heights = lines.map(|line| {
        let data = line.trim_start_matches("<path d=\"M").split(['H', 'L']).next().unwrap();
        data.split_once(' ').unwrap().1.parse::<f64>().unwrap()
    });
    heights.min_by(|a, b| (a - label_y).abs().total_cmp(&(b - label_y).abs())).unwrap()
}

#[test]
fn a_sweep_shows_success_and_time_and_a_curve_for_each_stack() {
    let folder = tempfile::tempdir().unwrap();
    let mut drives = DRIVES.to_vec();
    // The key does not touch this stack: its rows hold at every place.
    drives.insert(2, ("bfs", 0, 0, Some(25.0), ""));
    write(folder.path(), &drives);
    let svg = plot(folder.path(), &["sweep", ".", "--width-mm", "180"]);
    assert!(svg.contains(">Success (%)<") && svg.contains(">Time (s)<") && svg.contains(">bfs<"), "{svg}");
    assert!(svg.contains("#0072b2") && svg.contains("#d55e00") && svg.contains("width=\"180mm\""));
    // One in the legend, two places in each of two panels.
    assert_eq!(discs(&svg).len(), 5);
}

#[test]
fn stacks_and_pairs_have_a_row_for_each_stack() {
    let folder = tempfile::tempdir().unwrap();
    let worlds = (0..6).flat_map(|k| {
        let time = 20.0 + f64::from(k as u32);
        [("a", 0, k, Some(time), ""), ("b", 0, k, Some(time + 10.0), "")]
    });
    write(folder.path(), &worlds.collect::<Vec<Drive<'_>>>());
    let stacks = plot(folder.path(), &["stacks", ".", "--metrics", "success,time_s"]);
    assert_eq!((stacks.matches(">a<").count(), stacks.matches(">b<").count()), (2, 2));
    let pairs = plot(folder.path(), &["pairs", ".", "--metrics", "time_s", "--reference", "b"]);
    assert!(pairs.contains("Δ Time (s), less is better") && pairs.contains(">a<") && !pairs.contains(">b<"), "{pairs}");
    // a is 10 s quicker in every world.
    let discs = discs(&pairs);
    assert_eq!(discs.len(), 1);
    assert!((discs[0].0 - label(&pairs, "\u{2212}10").0).abs() < 0.11, "{discs:?} {pairs}");
}

#[test]
fn what_is_not_there_is_refused_with_what_is() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), &DRIVES);
    for (arguments, expected) in [
        (&[".", "--x", "robot.radius", "--y", "time_s"][..], "did you mean `robot.radius_m`?"),
        (&[".", "--x", "episode", "--y", "tim_s"], "did you mean `time_s`?"),
        (&[".", "--x", "episode", "--y", "outcome"], "is no number"),
        (&["stacks", "."], "2 points of a sweep"),
        (&["stacks", ".", "--point", "0", "--stack", "aa"], "unknown stack `aa`"),
        (&["pairs", ".", "--point", "0"], "nothing to compare"),
        (&["sweep", ".", "--x", "time_s"], "unknown swept key `time_s`"),
        (&["stacks", "nowhere"], "nowhere"),
    ] {
        let said = call(folder.path(), arguments).ends_with(2).stderr;
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "nothing was written");
}
