//! The summary as a table for the terminal.

use super::layout::{broken, hanging};
use super::summary::{Rate, Statistics, SummaryRow};

/// Largest width of the table, characters.
const WIDTH: usize = 120;

/// Room that names get where columns can make it, characters; longer ones stand on lines of their own.
const NAME_WIDTH: usize = 24;

/// Columns that are left out where there is no room for all, the least telling first; those in which nothing but 0 stands go before them.
const DISPENSABLE: [usize; 9] = [10, 9, 7, 8, 1, 6, 5, 4, 3];
/// Columns that count endings: left out first where they hold nothing but 0, which is said.
const ENDINGS: [usize; 4] = [6, 5, 4, 3];

/// Heading of each column, two lines.
const HEADING: [[&str; 2]; 11] = [
    ["", "stack"],
    ["", "n"],
    ["success %", "[95 % interval]"],
    ["collision", "(at rest)"],
    ["", "timeout"],
    ["", "stuck"],
    ["", "other"],
    ["length", "m"],
    ["time", "s"],
    ["clearance", "min m"],
    ["turning", "points"],
];

/// Name of each column in sentences.
const NAMES: [&str; 11] = [
    "stack",
    "n",
    "success",
    "collision",
    "timeout",
    "stuck",
    "other",
    "length",
    "time",
    "clearance",
    "turning points",
];

/// The summary as aligned text of at most 120 columns, or `width` if that is less, one block per sweep point.
///
/// Lengths, times, clearances and turning points are means over the successes; `other` counts `no_path`,
/// `planner_error`, `internal_error`, `gave_up` and `infeasible_world`. A stack's name that is too long for its column stands on a line of its own
/// (which may be wider than 120). Columns for which there is no room are left out and named.
pub fn table(summary: &[SummaryRow], width: usize) -> String {
    let most = width.min(WIDTH);
    let cells: Vec<[String; 11]> = summary.iter().map(cells).collect();
    let mut widths = HEADING.map(|lines| lines.map(|line| line.chars().count()).into_iter().fold(0, usize::max));
    for row in &cells {
        for (width, cell) in widths.iter_mut().zip(row).skip(1) {
            *width = (*width).max(cell.chars().count());
        }
    }
    let longest = cells.iter().map(|row| row[0].chars().count()).fold(widths[0], usize::max);
    let mut shown: Vec<usize> = (0..HEADING.len()).collect();
    let rest = |shown: &[usize]| shown[1..].iter().map(|&column| widths[column] + 2).sum::<usize>();
    let is_none = |column: &usize| cells.iter().all(|row| row[*column] == "0");
    let (mut none, mut left_out) = (Vec::new(), Vec::new());
    for column in ENDINGS.into_iter().filter(is_none).chain(DISPENSABLE.into_iter().filter(|column| !is_none(column))) {
        // Columns are narrower than the names alone make the table: then nothing has to go.
        if most == WIDTH || longest.min(NAME_WIDTH) + rest(&shown) <= most {
            break;
        }
        shown.retain(|&kept| kept != column);
        if is_none(&column) { &mut none } else { &mut left_out }.push(column);
    }
    let room = most.saturating_sub(rest(&shown));
    let fitting = cells.iter().map(|row| row[0].chars().count()).filter(|&length| length <= room);
    widths[0] = fitting.fold(widths[0], usize::max);

    let mut text = String::new();
    for heading in 0..2 {
        push_line(&mut text, &HEADING.map(|lines| lines[heading]), &widths, &shown);
    }
    let mut point = None;
    for (index, mut cells) in cells.into_iter().enumerate() {
        let row = &summary[index];
        if point.replace(row.point) != Some(row.point) && !row.swept.is_empty() {
            let rows = summary[index..].iter().take_while(|other| other.point == row.point);
            text += &hanging("", 2, &format!("{}:", title(rows.map(|row| row.swept.as_slice()))), width);
        }
        if cells[0].chars().count() > widths[0] {
            text += &broken(&cells[0], width).join("\n");
            text.push('\n');
            cells[0].clear();
        }
        push_line(&mut text, &cells.each_ref().map(String::as_str), &widths, &shown);
    }
    let names = |mut columns: Vec<usize>| {
        columns.sort_unstable();
        columns.iter().map(|&column| NAMES[column]).collect::<Vec<&str>>().join(", ")
    };
    if !none.is_empty() {
        text += &hanging("", 2, &format!("none: {}", names(none)), width);
    }
    if !left_out.is_empty() {
        text += &hanging("", 2, &format!("no room for: {} (summary.csv has them)", names(left_out)), width);
    }
    text
}

/// The summary as rows of cells for papers: the head, then a row for each stack, after one of a single cell at each sweep point. Lengths, times,
/// clearances and turning points are means ± standard deviations over the successes.
pub fn summary_rows(summary: &[SummaryRow]) -> Vec<Vec<String>> {
    let head = [
        "stack",
        "n",
        "success % [95 %]",
        "collision",
        "at rest",
        "timeout",
        "stuck",
        "other",
        "length_m",
        "time_s",
        "clearance_min_m",
        "turning_points",
    ];
    let mut rows = vec![head.map(str::to_owned).to_vec()];
    let mut point = None;
    for (index, row) in summary.iter().enumerate() {
        if point.replace(row.point) != Some(row.point) && !row.swept.is_empty() {
            let of_point = summary[index..].iter().take_while(|other| other.point == row.point);
            rows.push(vec![title(of_point.map(|row| row.swept.as_slice()))]);
        }
        let spread = |name: &str, decimals: usize| match row.metric(name) {
            Statistics { mean: Some(mean), sd: Some(sd), .. } => format!("{mean:.decimals$} ± {sd:.decimals$}"),
            Statistics { mean: Some(mean), .. } => format!("{mean:.decimals$}"),
            _ => "-".to_owned(),
        };
        let success = row.success.map_or_else(
            || "-".to_owned(),
            |Rate { rate, low, high }| format!("{:.1} [{:.1}, {:.1}]", rate * 100.0, low * 100.0, high * 100.0),
        );
        rows.push(vec![
            row.stack.clone(),
            row.n.to_string(),
            success,
            row.count("collision").to_string(),
            row.collision_at_rest.to_string(),
            row.count("timeout").to_string(),
            row.count("stuck").to_string(),
            (row.count("no_path") + row.count("planner_error") + row.count("infeasible_world")).to_string(),
            spread("length_m", 2),
            spread("time_s", 1),
            spread("clearance_min_m", 2),
            spread("turning_points", 1),
        ]);
    }
    rows
}

/// The swept keys and values of a sweep point, taken from the rows of its stacks; a key that concerns none of them is left out.
pub(crate) fn title<'a>(rows: impl Iterator<Item = &'a [(String, String)]> + Clone) -> String {
    let keys = rows.clone().next().unwrap_or_default().iter().enumerate();
    let values = keys.filter_map(|(index, (key, _))| {
        let value = rows.clone().map(|row| row[index].1.as_str()).find(|value| !value.is_empty())?;
        Some(format!("{key} = {value}"))
    });
    values.collect::<Vec<String>>().join(", ")
}

/// One line: the first column to the left, the others to the right, two spaces between.
fn push_line(text: &mut String, cells: &[&str; 11], widths: &[usize; 11], shown: &[usize]) {
    let mut line = format!("{:<width$}", cells[0], width = widths[0]);
    for &column in &shown[1..] {
        line.push_str(&format!("  {:>width$}", cells[column], width = widths[column]));
    }
    text.push_str(line.trim_end());
    text.push('\n');
}

fn cells(row: &SummaryRow) -> [String; 11] {
    let mean = |name: &str, decimals: usize| {
        row.metric(name).mean.map_or_else(|| "-".to_owned(), |mean| format!("{mean:.decimals$}"))
    };
    let success = row.success.map_or_else(
        || "-".to_owned(),
        |Rate { rate, low, high }| format!("{:.1} [{:.0}, {:.0}]", rate * 100.0, low * 100.0, high * 100.0),
    );
    let collision = match (row.count("collision"), row.collision_at_rest) {
        (all, 0) => all.to_string(),
        (all, at_rest) => format!("{all} ({at_rest})"),
    };
    let others = ["no_path", "planner_error", "internal_error", "gave_up", "infeasible_world"];
    let other: u64 = others.iter().map(|outcome| row.count(outcome)).sum();
    [
        row.stack.clone(),
        row.n.to_string(),
        success,
        collision,
        row.count("timeout").to_string(),
        row.count("stuck").to_string(),
        other.to_string(),
        mean("length_m", 2),
        mean("time_s", 1),
        mean("clearance_min_m", 2),
        mean("turning_points", 1),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episode::Outcome;
    use crate::results::layout::WIDE;
    use crate::results::metric_columns;

    fn row(stack: &str, point: u32) -> SummaryRow {
        let mean = |name: &str| match name {
            "length_m" => Some(43.267),
            "time_s" => Some(87.12),
            "clearance_min_m" => Some(0.254),
            "turning_points" => Some(6.25),
            _ => None,
        };
        SummaryRow {
            scenario: "warehouse".to_owned(),
            point,
            stack: stack.to_owned(),
            n: 121,
            rated: 120,
            outcomes: [116, 2, 1, 1, 0, 0, 0, 0, 1],
            collision_at_rest: 1,
            success: Some(Rate { rate: 116.0 / 120.0, low: 0.9174, high: 0.987 }),
            spl: None,
            metrics: metric_columns().map(|c| Statistics { mean: mean(c.name), ..Statistics::default() }).collect(),
            swept: Vec::new(),
        }
    }

    #[test]
    fn columns_are_aligned() {
        let mut none = row("dijkstra+pure_pursuit", 0);
        none.outcomes = [0; Outcome::NAMES.len()];
        (none.success, none.collision_at_rest, none.n) = (None, 0, 0);
        none.metrics = metric_columns().map(|_| Statistics::default()).collect();
        let expected = [
            "                                  success %  collision                         length  time  clearance  turning",
            "stack                    n  [95 % interval]  (at rest)  timeout  stuck  other       m     s      min m   points",
            "a_star+dwa             121    96.7 [92, 99]      2 (1)        1      1      1   43.27  87.1       0.25      6.2",
            "dijkstra+pure_pursuit    0                -          0        0      0      0       -     -          -        -",
        ];
        assert_eq!(table(&[row("a_star+dwa", 0), none], WIDE).lines().collect::<Vec<_>>(), expected);
    }

    #[test]
    fn long_names_stand_alone_and_points_have_titles() {
        let long = "improved_dijkstra+line_of_sight+b_spline+follow_dwa";
        let mut rows = [row("a_star+dwa", 0), row(long, 0), row("a_star+dwa", 1)];
        for row in &mut rows {
            row.swept = vec![("robot.radius_m".to_owned(), format!("0.{}", row.point + 2))];
        }
        let text = table(&rows, WIDE);
        assert!(text.lines().all(|line| line.chars().count() <= WIDTH), "{text}");
        let titles: Vec<&str> = text.lines().filter(|line| line.ends_with(':')).collect();
        assert_eq!(titles, ["robot.radius_m = 0.2:", "robot.radius_m = 0.3:"]);
        let name = text.lines().position(|line| line == long).expect("the name is on its own line");
        assert!(text.lines().nth(name + 1).unwrap().trim_start().starts_with("121"));
    }

    #[test]
    fn a_narrow_table_says_what_it_leaves_out() {
        let mut calm = row("a_star+dwa", 0);
        calm.outcomes = [119, 2, 0, 0, 0, 0, 0, 0, 0];
        let expected = [
            "                                  success %  collision  length  time",
            "stack                    n  [95 % interval]  (at rest)       m     s",
            "a_star+dwa             121    96.7 [92, 99]      2 (1)   43.27  87.1",
            "dijkstra+pure_pursuit  121    96.7 [92, 99]      2 (1)   43.27  87.1",
            "none: timeout, stuck, other",
            "no room for: clearance, turning points (summary.csv has them)",
        ];
        let mut other = calm.clone();
        other.stack = "dijkstra+pure_pursuit".to_owned();
        assert_eq!(table(&[calm, other], 72).lines().collect::<Vec<_>>(), expected);
        for width in [40, 60, 80, 100, 119] {
            let text =
                table(&[row("a_star+dwa", 0), row("improved_dijkstra+line_of_sight+b_spline+follow_dwa", 0)], width);
            assert!(text.lines().all(|line| line.chars().count() <= width), "{width}:\n{text}");
            assert!(text.contains("success %") && text.contains("96.7 [92, 99]"), "{width}:\n{text}");
        }
    }
}
