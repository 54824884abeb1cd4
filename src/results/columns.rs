//! The one table of columns: header, README table, reader, writer and summary all come from it.

use super::csv_rows::ending;
use super::field::Field;
use super::row::Row;
use super::value::Value;
use crate::analysis::Better;
use crate::episode::Outcome;
use crate::metrics::Metrics;
use crate::settings::choice::NameError;
use std::fmt::Write;

/// One column of `episodes.csv`.
#[derive(Debug)]
pub struct Column {
    /// Its name, the unit last.
    pub name: &'static str,
    /// Its unit; empty for names and counts.
    pub unit: &'static str,
    /// Its meaning or formula.
    pub formula: &'static str,
    /// Source of the definition.
    pub source: &'static str,
    /// Its value when the episode failed.
    pub on_failure: &'static str,
    /// Direction in which the value is better; `None` if neither direction is.
    pub better: Option<Better>,
    /// Moment from which its value is known.
    pub known: Known,
    /// Number of the first header of `episodes.csv` with this column, from 1. In tables of older headers it is read as empty.
    pub since: u32,
    pub(super) access: Access,
}

/// Moment from which the value of a column is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// Before the first tick: it depends on the world and the first plan alone, so a failed drive has it like any other.
    Before,
    /// After the drive: a failed drive has its value up to its end.
    After,
}

/// Access of a column to its value in a row.
#[derive(Debug)]
pub(super) enum Access {
    /// A field of the row.
    Field { get: fn(&Row) -> &dyn Value, get_mut: fn(&mut Row) -> &mut dyn Value },
    /// A part of the outcome, which is put together again from all such columns.
    Ending(fn(&Outcome) -> String),
    /// A field of the metrics, which summaries describe.
    Metric { get: fn(&Metrics) -> &dyn Value, get_mut: fn(&mut Metrics) -> &mut dyn Value },
}

impl Column {
    /// Whether summaries describe this column.
    pub fn is_metric(&self) -> bool {
        matches!(self.access, Access::Metric { .. })
    }

    /// Its value in a row.
    pub fn field(&self, row: &Row) -> Field {
        match self.access {
            Access::Field { get, .. } => get(row).field(),
            Access::Ending(part) => {
                let text = part(&row.outcome);
                // 0 or 1; the rest are words.
                if ["success", "at_rest"].contains(&self.name) { Field::Setting(text) } else { Field::Text(text) }
            }
            Access::Metric { get, .. } => get(&row.metrics).field(),
        }
    }

    /// Its value as a number; `None` if it is undefined or the column is no metric.
    pub fn number(&self, metrics: &Metrics) -> Option<f64> {
        match self.access {
            Access::Metric { get, .. } => get(metrics).number(),
            Access::Field { .. } | Access::Ending(_) => None,
        }
    }
}

/// The column of that name that summaries describe.
///
/// # Errors
/// If no metric column has that name; the error lists the known names.
pub fn metric_column(name: &str) -> Result<&'static Column, NameError> {
    metric_columns().find(|column| column.name == name).ok_or_else(|| {
        let known: Vec<&str> = metric_columns().map(|column| column.name).collect();
        NameError::unknown("metric", name, &known)
    })
}

/// The columns that summaries describe, in order.
pub fn metric_columns() -> impl Iterator<Item = &'static Column> {
    COLUMNS.iter().filter(|column| column.is_metric())
}

/// The names of all columns for a sweep over `swept`, in order.
pub fn header(swept: &[String]) -> impl Iterator<Item = &str> {
    COLUMNS.iter().map(|column| column.name).chain(swept.iter().map(String::as_str))
}

/// The table of columns in Markdown, for the README.
pub fn columns() -> String {
    let mut table = String::from(
        "| column | unit | meaning | better | known | source | when the episode failed |\n|---|---|---|---|---|---|---|\n",
    );
    for Column { name, unit, formula, source, on_failure, better, known, .. } in &COLUMNS {
        let better = match better {
            Some(Better::Higher) => "more",
            Some(Better::Lower) => "less",
            None => "",
        };
        let known = match known {
            Known::Before => "before the drive",
            Known::After => "after it",
        };
        // A bar inside a formula would end the table's field.
        let formula = formula.replace('|', "\\|");
        writeln!(table, "| `{name}` | {unit} | {formula} | {better} | {known} | {source} | {on_failure} |")
            .expect("writing to a string cannot fail");
    }
    table.push_str("| one per swept key | | the key's value at this point, as written in the sweep; empty where the key does not touch the stack | | before the drive | | as is |\n");
    table
}

/// A row of the table: `kind name: "unit", better, known, "formula", "source", "value on failure"`. `better` is `higher`, `lower`
/// or `none`; `known` is `before` or `after` the drive. `, since N` at the end names the first header that
/// has the column where that is not the first of all; a column that was released keeps its place.
///
/// `field` and `metric` take the struct's field of the same name, so that the two cannot differ.
macro_rules! table {
    ($($kind:ident $name:ident: $unit:literal, $better:ident, $known:ident, $formula:literal, $source:literal, $on_failure:literal $(, since $since:literal)?;)*) => {
        /// Every column of `episodes.csv` before those of the swept keys, in order.
        pub static COLUMNS: [Column; [$(stringify!($name)),*].len()] = [$(Column {
            name: stringify!($name),
            unit: $unit,
            formula: $formula,
            source: $source,
            on_failure: $on_failure,
            better: table!(@better $better),
            known: table!(@known $known),
            since: table!(@since $($since)?),
            access: table!(@$kind $name),
        }),*];
    };
    (@better higher) => { Some(Better::Higher) };
    (@better lower) => { Some(Better::Lower) };
    (@better none) => { None };
    (@known before) => { Known::Before };
    (@known after) => { Known::After };
    (@since) => { 1 };
    (@since $since:literal) => { $since };
    (@field $name:ident) => { Access::Field { get: |row| &row.$name, get_mut: |row| &mut row.$name } };
    (@metric $name:ident) => { Access::Metric { get: |metrics| &metrics.$name, get_mut: |metrics| &mut metrics.$name } };
    (@ending $name:ident) => { Access::Ending(ending::$name) };
}

table! {
    field scenario: "", none, before, "name of the scenario", "", "as is";
    field point: "", none, before, "number of the sweep point, from 0", "", "as is";
    field stack: "", none, before, "unique name of the stack", "", "as is";
    field global: "", none, before, "global planner; empty without one", "", "as is";
    field path: "", none, before, "path stages joined by `+`; empty without any", "", "as is";
    field local: "", none, before, "local planner", "", "as is";
    field episode: "", none, before, "number of the episode, from 0; with the seed it fixes the world", "", "as is";
    field seed: "", none, before, "seed of the scenario", "", "as is";
    ending outcome: "", none, after, "`success`, `collision`, `timeout`, `stuck`, `no_path`, `planner_error`, `internal_error`, `gave_up` or `infeasible_world`", "", "as is";
    ending message: "", none, after, "what went wrong, in words", "", "may be empty";
    ending success: "", higher, after, "1 if the goal was reached within its tolerance, before the time-out and without contact, else 0", "Arena-Rosnav, BARN", "0";
    ending collided_with: "", none, after, "`known_static`, `unknown_static`, `dynamic` or `boundary`", "", "empty without collision";
    ending at_rest: "", none, after, "1 if the robot stood still when it was hit (no point of its outline moved at 0.02 m/s), else 0", "", "empty without collision";
    metric time_s: "s", lower, after, "simulated time from the first tick until the episode ended: ticks · dt, the last one up to a contact", "Arena-Rosnav", "until the end";
    metric length_m: "m", lower, after, "length of the driven path: Σ |v| dt, up to a contact", "all peers", "until the end";
    metric shortest_m: "m", none, before, "lower bound of every collision-free drive: any-angle optimum of a point on the true static map, cells blocked only where the whole square lies within the inscribed radius of an obstacle; empty where it is not computed", "Anderson et al. 2018", "as is";
    metric spl: "", higher, after, "success · shortest_m / max(length_m, shortest_m)", "Anderson et al. 2018", "0; empty where shortest_m is";
    metric planned_length_m: "m", lower, before, "length of the first planned path", "Bench-MR", "empty without a path";
    metric planned_turns: "", lower, before, "interior vertices of the first planned path with a change of direction above 1e-6 rad", "Bench-MR", "empty without a path";
    metric turning_points: "", lower, after, "maximal runs of ticks with one sign of yaw rate, |ω| ≥ 0.05 rad/s, that turn the heading by at least 5°", "Bench-MR, thresholds our own", "until the end";
    metric turning_angle_deg: "deg", lower, after, "Σ |Δθ| of the driven trajectory", "HuNavSim", "until the end";
    metric goal_error_m: "m", lower, after, "distance of the robot's centre to the goal at the end", "", "at the end";
    metric clearance_min_m: "m", higher, after, "smallest distance at any moment from the footprint's edge to any obstacle, a lower bound up to 1 mm below the truth; negative only after a contact", "Bench-MR", "until the end";
    metric clearance_mean_m: "m", higher, after, "mean of that distance at the ends of the ticks", "Bench-MR", "until the end";
    metric near_miss_s: "s", lower, after, "time with a clearance below `metrics.near_miss_m`, judged at the end of each tick", "MRPB", "until the end";
    metric ttc_min_s: "s", higher, after, "smallest time to collision with a mover, constant twist and velocity, looked 10 s ahead; empty if none", "Hayward 1972", "until the end";
    metric encounters: "", none, after, "movers and unknown statics whose surface came within `metrics.encounter_m`", "", "until the end";
    metric speed_mean_mps: "m/s", higher, after, "length_m / time_s; empty if no time passed", "", "until the end";
    metric stopped_s: "s", lower, after, "time with |v| < 0.01 m/s and |ω| < 0.02 rad/s", "HuNavSim", "until the end";
    metric curvature_max_1pm: "1/m", lower, after, "largest |ω / v| over the ticks with |v| ≥ 0.05 m/s; empty if there is none", "Bench-MR, of exact arcs", "until the end";
    metric jerk_rms_mps3: "m/s³", lower, after, "root mean square of the second difference of the true speed by dt²; empty below two ticks", "Navigation2 #3239", "until the end";
    metric path_deviation_mean_m: "m", lower, after, "mean distance to the path in force, over the ticks that had one", "", "until the end; empty without a path";
    metric expanded: "", lower, before, "nodes expanded by the global planner, all searches, re-expansions included", "Bench-MR, PathBench", "until the end";
    metric generated: "", lower, before, "nodes generated by the global planner, all searches", "", "until the end";
    metric replans: "", lower, after, "searches after the first", "", "until the end";
    metric rollouts: "", lower, after, "trajectories simulated by the local planner", "", "until the end";
    metric recoveries: "", lower, after, "ticks on which the local planner found no admissible command", "", "until the end";
    metric path_nodes: "", lower, before, "vertices of the first planned path, start and goal included", "Qin et al. 2026", "empty without a path";
    metric risky_nodes: "", lower, before, "vertices of the first planned path beside a segment with a clearance below half a cell", "Qin et al. 2026", "empty without a path";
    metric turning_steps: "", lower, after, "ticks with |Δθ| > 0.5°", "Zhu et al. 2025", "until the end";
    metric ticks: "", lower, after, "ticks driven", "", "until the end";
    metric clearance_movers_min_m: "m", higher, after, "smallest distance at any moment from the footprint's edge to a mover, as `clearance_min_m`", "", "until the end; empty without movers", since 2;
    metric clearance_unknown_min_m: "m", higher, after, "the same to an unknown static, known map and its edge left out", "", "until the end; empty without unknown statics", since 2;
    metric encounters_movers: "", none, after, "movers whose surface came within `metrics.encounter_m`", "", "until the end", since 2;
    metric contacts: "", lower, after, "contacts, each from the first touch until the robot is free again; not measured yet", "", "until the end", since 2;
    metric contact_time_s: "s", lower, after, "time in contact; not measured yet", "", "until the end", since 2;
    metric contact_speed_mps: "m/s", lower, after, "largest speed of approach at a first touch; empty without contact; not measured yet", "", "until the end", since 2;
    metric contact_impulse_ns: "N·s", lower, after, "largest impulse of a contact; empty without contact; not measured yet", "", "until the end", since 2;
    metric contact_energy_j: "J", lower, after, "largest kinetic energy lost in a contact; empty without contact; not measured yet", "", "until the end", since 2;
    metric waiting_s: "s", lower, after, "time in states of the local planner that wait: ticks decided in them times dt", "", "until the end", since 2;
    metric retreating_s: "s", lower, after, "time in states of the local planner that retreat: ticks decided in them times dt", "", "until the end", since 2;
    metric recovering_s: "s", lower, after, "time in states of the local planner that recover: ticks decided in them times dt", "", "until the end", since 2;
    metric path_score: "", lower, before, "J of the first planned path over its vertices, points in cells: w1 Σ |P_{i+1} − P_i| + w2 Σ 1 / max(d(P_i), 0.1) + w3 Σ (φ_i − φ_{i−1})², d the distance to the nearest known obstacle or the map's edge, φ the directions of the segments, differences wrapped; weights are `metrics.path_score`", "Qin et al. 2026, eq. 4 to 8", "empty without a path", since 2;
    metric path_score_resampled: "", lower, before, "the same over points of equal spacing along the path, at most `metrics.path_score.step_max_cells` apart", "our own, after Qin et al. 2026", "empty without a path", since 2;
    metric path_fallbacks: "", lower, before, "places of the first planned path where its method fell back to something simpler: spans of a `b_spline` that would have come too near to an obstacle, segments of the first curve of `minimum_snap` that did", "Zhu et al. 2025, Hu et al. 2024", "empty without a path", since 2;
    metric planned_turning_deg: "deg", lower, before, "Σ |change of direction| along the first planned path: at its vertices and along its curves", "Zhao et al. 2025", "empty without a path", since 2;
    metric planned_clearance_min_m: "m", higher, before, "smallest distance from the first planned path, a line, to a known obstacle or the map's edge, at most 5; 0 where it touches; below the robot's radius a robot that follows it exactly collides", "Bench-MR", "empty without a path", since 2;
    field world_digest: "", none, before, "digest of the world before the first tick, equal for all stacks", "", "empty without a world";
    field trace_digest: "", none, after, "digest of everything that happened", "", "empty without a trace";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_columns_are_those_of_the_contract_in_its_order() {
        // Written down a second time on purpose: this is the contract of episodes.csv.
        let contract = "scenario, point, stack, global, path, local, episode, seed, outcome, message, success, collided_with, \
            at_rest, time_s, length_m, shortest_m, spl, planned_length_m, planned_turns, turning_points, turning_angle_deg, \
            goal_error_m, clearance_min_m, clearance_mean_m, near_miss_s, ttc_min_s, encounters, speed_mean_mps, stopped_s, \
            curvature_max_1pm, jerk_rms_mps3, path_deviation_mean_m, expanded, generated, replans, rollouts, recoveries, \
            path_nodes, risky_nodes, turning_steps, ticks, clearance_movers_min_m, clearance_unknown_min_m, encounters_movers, contacts, contact_time_s, \
            contact_speed_mps, contact_impulse_ns, contact_energy_j, waiting_s, retreating_s, recovering_s, path_score, path_score_resampled, path_fallbacks, planned_turning_deg, planned_clearance_min_m, world_digest, trace_digest, \
            robot.radius_m, planner";
        let swept = ["robot.radius_m".to_owned(), "planner".to_owned()];
        assert_eq!(header(&swept).collect::<Vec<_>>().join(", "), contract);
    }

    #[test]
    fn the_readme_table_has_one_row_of_seven_fields_per_column() {
        let table = columns();
        let rows: Vec<&str> = table.lines().collect();
        assert_eq!(rows.len(), 2 + COLUMNS.len() + 1);
        for row in rows {
            assert_eq!(row.replace("\\|", "").matches('|').count(), 8, "{row}");
        }
    }

    #[test]
    fn every_column_says_what_it_means_and_a_unit_in_its_name_is_stated() {
        for column in &COLUMNS {
            assert!(!column.formula.is_empty() && !column.on_failure.is_empty(), "{}", column.name);
            let unit = column.name.rsplit('_').next().unwrap_or_default();
            let stated = match unit {
                "s" | "m" | "deg" => unit,
                "mps" => "m/s",
                "1pm" => "1/m",
                "mps3" => "m/s³",
                "ns" => "N·s",
                "j" => "J",
                _ => "",
            };
            assert_eq!(column.unit, stated, "{}", column.name);
        }
    }
}
