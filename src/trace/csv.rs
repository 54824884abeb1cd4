//! Traces as CSV.

use super::{Trace, time_s};
use crate::geometry::Vec2;
use crate::map::Frame;
use crate::math;
use crate::plan::contract::Notes;
use std::fmt::{self, Write as _};
use std::io;

/// The columns of a trace file before those of the movers.
const COLUMNS: [&str; 19] = [
    "tick",
    "time_s",
    "x_m",
    "y_m",
    "theta_rad",
    "believed_x_m",
    "believed_y_m",
    "believed_theta_rad",
    "v_mps",
    "omega_radps",
    "command_v_mps",
    "command_omega_radps",
    "mode",
    "sub_goal_x_m",
    "sub_goal_y_m",
    "clearance_m",
    "sensed_movers",
    "seen_statics",
    "path_deviation_m",
];

/// Writes the scans: one row per scan, `tick,time_s,range0_m,…`; `inf` for a ray without an echo.
///
/// # Errors
/// If `out` cannot be written.
pub fn write_scans(trace: &Trace, dt_s: f64, out: &mut impl io::Write) -> io::Result<()> {
    let mut record = CsvRow { writer: csv::Writer::from_writer(out), text: String::new() };
    let rays = (0..trace.ray_count).map(|ray| format!("range{ray}_m"));
    record.writer.write_record(["tick", "time_s"].map(str::to_owned).into_iter().chain(rays))?;
    for (tick, ranges_m) in trace.ranges_m.chunks(trace.ray_count.max(1)).enumerate() {
        record.field(tick)?;
        record.real(time_s(tick as u32, dt_s))?;
        for &range_m in ranges_m {
            if range_m.is_finite() { record.real(range_m)? } else { record.field("inf")? }
        }
        record.writer.write_record(None::<&[u8]>)?;
    }
    record.writer.flush()
}

/// Writes a trace as CSV: a header, then one row per row of [`Trace::ticks`], lines ended by `\n`.
///
/// Columns are `tick`, `time_s`, the true and the believed pose, the true twist and the commanded one, `mode`,
/// the sub-goal, `clearance_m`, `sensed_movers`, `seen_statics`, `path_deviation_m`, the numbers that the local planner publishes, if any, then `mover{i}_x_m` and `mover{i}_y_m` for each
/// mover in the scene's order, empty while it is not there. Poses and points are in the world frame, into which `frame` takes them. Numbers print as
/// the shortest text that reads back the same; what is undefined is empty.
///
/// # Errors
/// If `out` cannot be written.
///
/// # Panics
/// If the trace holds a number that is not finite.
pub fn write_csv(trace: &Trace, frame: &Frame, dt_s: f64, out: &mut impl io::Write) -> io::Result<()> {
    let movers = (0..trace.mover_count).flat_map(|i| [format!("mover{i}_x_m"), format!("mover{i}_y_m")]);
    let mut record = CsvRow { writer: csv::Writer::from_writer(out), text: String::new() };
    let notes = trace.note_names.iter().map(|&name| name.to_owned());
    record.writer.write_record(COLUMNS.map(str::to_owned).into_iter().chain(notes).chain(movers))?;
    for (row, tick) in trace.ticks.iter().enumerate() {
        record.field(tick.tick)?;
        record.real(trace.row_time_s(row, dt_s))?;
        for pose in [tick.pose, tick.believed].map(|pose| frame.to_world(pose)) {
            record.point(pose.position)?;
            record.real(pose.theta)?;
        }
        for twist in [tick.twist, tick.command] {
            record.real(twist.v)?;
            record.real(twist.omega)?;
        }
        record.field(tick.state.name)?;
        record.point(frame.point_to_world(tick.sub_goal))?;
        record.real(tick.clearance_m)?;
        record.field(tick.sensed_movers)?;
        record.field(tick.seen_statics)?;
        match tick.path_deviation_m {
            Some(deviation_m) => record.real(deviation_m)?,
            None => record.field("")?,
        }
        let notes = trace.notes.get(row).map_or(&[][..], Notes::values);
        for at in 0..trace.note_names.len() {
            match notes.get(at) {
                Some(&note) => record.real(note)?,
                None => record.field("")?,
            }
        }
        for mover in trace.movers_at(row) {
            if mover.present {
                record.point(frame.point_to_world(mover.position))?;
            } else {
                record.field("")?;
                record.field("")?;
            }
        }
        record.writer.write_record(None::<&[u8]>)?;
    }
    record.writer.flush()
}

/// Writes the fields of a CSV row one after another.
struct CsvRow<W: io::Write> {
    writer: csv::Writer<W>,
    /// The field being written; kept for its memory.
    text: String,
}

impl<W: io::Write> CsvRow<W> {
    fn field(&mut self, value: impl fmt::Display) -> csv::Result<()> {
        self.text.clear();
        write!(self.text, "{value}").expect("writing to a string cannot fail");
        self.writer.write_field(&self.text)
    }

    fn real(&mut self, x: f64) -> csv::Result<()> {
        self.field(math::canonical(x))
    }

    fn point(&mut self, p: Vec2) -> csv::Result<()> {
        self.real(p.x)?;
        self.real(p.y)
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::trace;
    use super::*;
    use crate::geometry::Pose;

    #[test]
    fn csv_is_in_the_world_frame_with_empty_undefined_fields() {
        let mut bytes = Vec::new();
        let frame = Frame { origin: Pose::new(10.0, -3.0, 0.0) };
        write_csv(&trace(), &frame, 0.1, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(
            lines[0],
            "tick,time_s,x_m,y_m,theta_rad,believed_x_m,believed_y_m,believed_theta_rad,v_mps,omega_radps,command_v_mps,\
             command_omega_radps,mode,sub_goal_x_m,sub_goal_y_m,clearance_m,sensed_movers,seen_statics,path_deviation_m,\
             mover0_x_m,mover0_y_m,mover1_x_m,mover1_y_m"
        );
        assert_eq!(lines[1], "0,0,11,-1,0.5,11.125,-1,0.5,0,0,0.1,-0.25,track,14,-1,0.75,1,0,,10,2,17,2");
        assert_eq!(
            lines[2],
            "3,0.3,11,-1,0.5,11.125,-1,0.5,0,0,0.1,-0.25,recover,14,-1,0.75,1,0,0.0000001,10.1,2,17.1,2"
        );
        assert_eq!(lines.len(), 3);

        let mut bytes = Vec::new();
        let turned = Frame { origin: Pose::new(0.0, 0.0, math::FRAC_PI_2) };
        write_csv(&trace(), &turned, 0.1, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let field = |index: usize| text.lines().nth(1).unwrap().split(',').nth(index).unwrap().parse::<f64>().unwrap();
        // (1, 2, 0.5) a quarter turn on: (−2, 1, 0.5 + π/2).
        assert!((field(2) + 2.0).abs() < 1e-12 && (field(3) - 1.0).abs() < 1e-12);
        assert!((field(4) - 0.5 - math::FRAC_PI_2).abs() < 1e-12);
    }

    #[test]
    fn numbers_of_a_planner_become_columns() {
        let mut with_notes = trace();
        with_notes.note_names = &["heading", "weight"];
        with_notes.notes = vec![Notes::NONE, Notes::new(&[0.25, -3.0])];
        let mut bytes = Vec::new();
        write_csv(&with_notes, &Frame { origin: Pose::new(0.0, 0.0, 0.0) }, 0.1, &mut bytes).unwrap();
        let text = String::from_utf8(bytes).unwrap();
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        assert_eq!(rows[0][19..23], ["heading", "weight", "mover0_x_m", "mover0_y_m"]);
        assert_eq!((&rows[1][19..21], &rows[2][19..21]), (&["", ""][..], &["0.25", "-3"][..]));
    }
}
