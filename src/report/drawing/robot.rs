//! The robot: its plans, its track by speed or in one colour, its footprint at start and end and at round times, goals and contact.

use super::labels::Labels;
use super::legend::Legend;
use super::view::View;
use super::{Drive, LABEL, emblem, outlined, seconds};
use crate::episode::Outcome;
use crate::geometry::outline::{Outline, Shape};
use crate::geometry::{Pose, Rect, Vec2, direction};
use crate::math;
use crate::plan::contract::State;
use crate::report::palette::{CONTACT, Colour, GOAL, INK, PAPER, SPEED, STATES};
use crate::report::picture::{Paint, Picture, Text};
use crate::robot::Robot;
use crate::trace::Trace;

pub(super) fn footprint(robot: &Robot, pose: Pose) -> Outline {
    let shape = match &robot.footprint {
        None => Shape::Disc { radius_m: robot.radius_m },
        Some(polygon) => Shape::Polygon(polygon.clone()),
    };
    Outline::new(shape, pose.theta)
}

/// The footprint with a line from its centre to its front.
fn body(page: &mut Picture, view: &View, robot: &Robot, pose: Pose, paint: Paint, edge: Colour) {
    outlined(page, view, &footprint(robot, pose), pose.position, paint);
    let front = pose.position + direction(pose.theta) * robot.inscribed_radius_m();
    page.line(vec![view.at(pose.position), view.at(front)], Paint::line(edge, 1.4));
}

/// The plans that came into force up to a row: the last one with its key nodes, earlier ones pale.
pub(super) fn plans(
    page: &mut Picture,
    view: &View,
    trace: &Trace,
    until_tick: u32,
    colour: Colour,
    legend: &mut Legend,
) {
    let paint = Paint::line(colour, 1.5).dashed(5.0, 3.5);
    let plans: Vec<_> = trace.paths.iter().take_while(|plan| plan.tick <= until_tick).collect();
    let Some((last, earlier)) = plans.split_last() else { return };
    let pale = Paint::line(colour, 1.2).dashed(2.0, 3.0).faded(0.55);
    if !earlier.is_empty() {
        page.lines(earlier.iter().map(|plan| view.path(&plan.path)).collect(), pale);
    }
    page.line(view.path(&last.path), paint);
    let mut nodes = Vec::new();
    last.path.key_nodes(&mut nodes);
    let node = Paint::fill(PAPER).edged(colour, 1.1);
    nodes.iter().for_each(|node_here| page.circle(view.at(node_here.position), 2.1, node));
    let bar = |page: &mut Picture, at: Vec2, paint: Paint| {
        page.line(vec![at - Vec2::new(10.0, 0.0), at + Vec2::new(10.0, 0.0)], paint);
    };
    legend.add("plan and its key nodes", move |page, at| {
        bar(page, at, paint);
        page.circle(at, 2.1, node);
    });
    if !earlier.is_empty() {
        legend.add("earlier plans", move |page, at| bar(page, at, pale));
    }
}

/// The track up to a row, coloured by speed, with a dark rim so that its bright end can be seen.
pub(super) fn track_by_speed(page: &mut Picture, view: &View, drive: &Drive<'_>, rows: usize) {
    let ticks = &drive.trace().ticks[..rows];
    let track = view.track(ticks.iter().map(|tick| tick.pose.position));
    page.line(track, Paint::line(INK, 4.4));
    let step = |row: usize| {
        let share = math::clamp(ticks[row].twist.v.abs() / drive.robot().speed_max_mps, 0.0, 1.0);
        ((share * SPEED.len() as f64) as usize).min(SPEED.len() - 1)
    };
    let mut row = 1;
    while row < rows {
        let (begin, colour) = (row, step(row));
        while row < rows && step(row) == colour {
            row += 1;
        }
        let points = view.track(ticks[begin - 1..row].iter().map(|tick| tick.pose.position));
        page.line(points, Paint::line(SPEED[colour], 2.8));
    }
}

pub(super) fn speed_legend(robot: &Robot, legend: &mut Legend) {
    const STEP: f64 = 9.0;
    let width = STEP * SPEED.len() as f64;
    // A limit such as 1/6 m/s would be longer than the bar.
    let speed_max_mps = (robot.speed_max_mps * 1000.0).round() / 1000.0;
    let words = format!("speed, 0 to {speed_max_mps} m/s");
    legend.add_wide(width, words, move |page, at| {
        for (index, colour) in SPEED.into_iter().enumerate() {
            let min = at + Vec2::new(STEP * index as f64 - 0.5 * width, -4.0);
            page.rect(Rect { min, max: min + Vec2::new(STEP, 8.0) }, Paint::fill(colour));
        }
    });
}

/// A band beneath the track for each stretch in one of the [`marked_states`].
pub(super) fn states(page: &mut Picture, view: &View, trace: &Trace, rows: usize, legend: &mut Legend) {
    let marked = marked_states(trace);
    let band = |colour: Colour| Paint::line(colour, 10.0).faded(0.5);
    let colour_of = |name: &str| {
        let at = marked.iter().position(|state| *state == name)?;
        Some(STATES[at % STATES.len()])
    };
    for run in trace.ticks[..rows].chunk_by(|a, b| a.state.name == b.state.name) {
        let Some(colour) = colour_of(run[0].state.name) else { continue };
        page.line(view.track(run.iter().map(|tick| tick.pose.position)), band(colour));
    }
    for name in &marked {
        let Some(colour) = colour_of(name) else { continue };
        legend.add(*name, move |page, at| {
            page.line(vec![at - Vec2::new(4.0, 0.0), at + Vec2::new(4.0, 0.0)], band(colour));
        });
    }
}

/// The states of the local planner that a picture marks, in the order in which they were entered: its own ones, without the one in which it
/// sets out and drives as usual.
fn marked_states(trace: &Trace) -> Vec<&'static str> {
    let states = || trace.ticks.iter().map(|tick| tick.state);
    // No planner has decided yet at the first tick.
    let usual = states().skip(1).find(|state| ![State::RECOVER, State::ARRIVE].contains(state));
    let mut names: Vec<&'static str> = Vec::new();
    for state in states() {
        let is_own = ![State::TRACK, State::RECOVER, State::ARRIVE].contains(&state) && Some(state) != usual;
        if is_own && !names.contains(&state.name) {
            names.push(state.name);
        }
    }
    names
}

/// The shape of a mark on a track: with several tracks each has its own, so that they can be told apart in grey.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dot {
    Round,
    Square,
    Diamond,
    Triangle,
}

impl Dot {
    pub fn of(index: usize) -> Self {
        [Self::Round, Self::Square, Self::Diamond, Self::Triangle][index % 4]
    }

    pub fn paint(self, page: &mut Picture, at: Vec2, paint: Paint) {
        let corners = |corners: &[(f64, f64)]| corners.iter().map(|(x, y)| at + Vec2::new(*x, *y)).collect();
        match self {
            Self::Round => page.circle(at, 2.6, paint),
            Self::Square => page.area(vec![corners(&[(-2.6, -2.6), (2.6, -2.6), (2.6, 2.6), (-2.6, 2.6)])], paint),
            Self::Diamond => page.area(vec![corners(&[(0.0, -3.8), (3.8, 0.0), (0.0, 3.8), (-3.8, 0.0)])], paint),
            Self::Triangle => page.area(vec![corners(&[(0.0, -3.6), (3.4, 2.6), (-3.4, 2.6)])], paint),
        }
    }
}

/// Footprints and dots at the times of `marks`, and the times beside them.
pub(super) fn times(
    page: &mut Picture,
    view: &View,
    drive: &Drive<'_>,
    (colour, dot): (Colour, Dot),
    marks: &[(usize, String)],
    labels: &mut Labels,
) {
    for (row, _) in marks {
        let pose = drive.trace().ticks[*row].pose;
        outlined(page, view, &footprint(drive.robot(), pose), pose.position, Paint::line(INK, 0.8).faded(0.55));
    }
    let spots: Vec<Vec2> = marks.iter().map(|(row, _)| view.at(drive.trace().ticks[*row].pose.position)).collect();
    for spot in &spots {
        dot.paint(page, *spot, Paint::fill(PAPER).edged(colour, 1.3));
        labels.take(*spot, 3.0);
    }
    for (spot, (_, words)) in spots.into_iter().zip(marks) {
        if let Some((at, anchor)) = labels.place(spot, 6.0, words, LABEL, true) {
            let text = Text::new(at, LABEL, words.as_str()).anchored(anchor).coloured(colour);
            page.text(Text { rimmed: true, bold: true, ..text });
        }
    }
}

/// The goals that were in force before a time, each with when it came into force: the last is the one at that time.
pub(super) fn goals(drive: &Drive<'_>, end_s: f64) -> Vec<(f64, Vec2)> {
    let scene = drive.scene();
    let mut goals = vec![(0.0, scene.goal)];
    for event in scene.script.iter().filter(|event| event.at_s < end_s) {
        if let Some(to) = event.change.goal_moved_to() {
            if event.at_s <= 0.0 {
                goals.clear();
            }
            goals.push((event.at_s, to));
        }
    }
    goals
}

/// A flag on a pole of this height; one that is less than nothing hangs.
fn flag(page: &mut Picture, at: Vec2, high: f64, alpha: f64) {
    page.line(vec![at, at - Vec2::new(0.0, high)], Paint::line(GOAL, 1.6).faded(alpha));
    let cloth = [(0.0, -1.0), (0.65, -0.76), (0.0, -0.52)].map(|(x, y)| at + Vec2::new(x * high.abs(), y * high));
    page.area(vec![cloth.to_vec()], Paint::fill(GOAL).edged(GOAL, 1.0).faded(alpha));
}

/// A flag at each goal and the circle that counts as arrived about it; those that have moved on are pale and say when they held.
pub(super) fn flags(
    page: &mut Picture,
    view: &View,
    drive: &Drive<'_>,
    end_s: f64,
    labels: &mut Labels,
    legend: &mut Legend,
) {
    let goals = goals(drive, end_s);
    let radius = drive.recording.goal_tolerance_m * view.scale;
    let last = goals.len() - 1;
    for (index, (from_s, goal)) in goals.iter().enumerate() {
        let (at, is_last) = (view.at(*goal), index == last);
        let alpha = if is_last { 1.0 } else { 0.45 };
        page.circle(at, math::max(radius, 2.0), Paint::line(GOAL, 1.2).faded(alpha));
        let high = if at.y - 19.0 < view.plot.min.y { -17.0 } else { 17.0 };
        flag(page, at, high, alpha);
        labels.take(at - Vec2::new(-4.0, 0.65 * high), 8.0);
        let words = match (is_last, last) {
            (true, 0) => "goal".to_owned(),
            (true, _) => format!("goal from {}", seconds(*from_s)),
            (false, _) => format!("goal until {}", seconds(goals[index + 1].0)),
        };
        if let Some((spot, anchor)) = labels.place(at, math::max(radius, 4.0) + 4.0, &words, 11.0, false) {
            page.text(Text { rimmed: true, ..Text::new(spot, 11.0, words).anchored(anchor) });
        }
    }
    let words = format!("goal, arrived within {} m", drive.recording.goal_tolerance_m);
    legend.add(words, move |page, at| {
        page.circle(at + Vec2::new(-2.0, 3.5), 4.0, Paint::line(GOAL, 1.2));
        flag(page, at + Vec2::new(-2.0, 3.5), 10.0, 1.0);
    });
    if last > 0 {
        legend.add("earlier goal", move |page, at| flag(page, at + Vec2::new(-2.0, 5.0), 10.0, 0.45));
    }
}

/// The footprint at the start.
pub(super) fn start(page: &mut Picture, view: &View, drive: &Drive<'_>, labels: &mut Labels, legend: &mut Legend) {
    let (robot, start) = (drive.robot(), drive.scene().start);
    let paint = Paint::fill(PAPER).edged(INK, 1.4);
    body(page, view, robot, start, paint, INK);
    let reach = math::max(robot.radius_m * view.scale, 3.0);
    labels.take(view.at(start.position), reach);
    if let Some((at, anchor)) = labels.place(view.at(start.position), reach + 4.0, "start", 11.0, false) {
        page.text(Text { rimmed: true, ..Text::new(at, 11.0, "start").anchored(anchor) });
    }
    let shape = footprint(robot, start).shape().clone();
    legend.add("robot at the start", move |page, at| {
        emblem(page, at, &shape, paint);
        page.line(vec![at, at + Vec2::new(4.0, 0.0)], Paint::line(INK, 1.4));
    });
}

/// The footprint at the end of the drive, and a cross if it touched something.
pub(super) fn end(page: &mut Picture, view: &View, drive: &Drive<'_>, colour: Colour) -> Option<Ended> {
    let pose = drive.trace().ticks.last()?.pose;
    let touched = matches!(drive.recording.outcome, Outcome::Collision { .. });
    let edge = if touched { CONTACT } else { INK };
    body(page, view, drive.robot(), pose, Paint::fill(colour).faded(0.55).edged(edge, 1.8), edge);
    if touched {
        cross(page, view.at(pose.position), 8.0);
    }
    Some(Ended { touched })
}

/// How a drive ended, for the legend.
pub(super) struct Ended {
    pub touched: bool,
}

pub(super) fn end_legend(robot: &Robot, touched: bool, colour: Colour, legend: &mut Legend) {
    let edge = if touched { CONTACT } else { INK };
    let shape = footprint(robot, Pose::new(0.0, 0.0, 0.0)).shape().clone();
    legend.add("at the end", move |page, at| {
        emblem(page, at, &shape, Paint::fill(colour).faded(0.55).edged(edge, 1.8));
        page.line(vec![at, at + Vec2::new(4.0, 0.0)], Paint::line(edge, 1.4));
    });
    if touched {
        legend.add("contact", |page, at| cross(page, at, 5.0));
    }
}

fn cross(page: &mut Picture, at: Vec2, half: f64) {
    let bars = [(1.0, 1.0), (1.0, -1.0)].map(|(x, y)| {
        let arm = Vec2::new(x, y) * half;
        vec![at - arm, at + arm]
    });
    page.lines(bars.to_vec(), Paint::line(PAPER, 5.0));
    page.lines(bars.to_vec(), Paint::line(CONTACT, 2.6));
}

/// The robot as it is at a row.
pub(super) fn now(page: &mut Picture, view: &View, drive: &Drive<'_>, row: usize, fill: Colour) {
    let is_end = row + 1 == drive.rows();
    let touched = is_end && matches!(drive.recording.outcome, Outcome::Collision { .. });
    let edge = if touched { CONTACT } else { INK };
    let pose = drive.trace().ticks[row].pose;
    body(page, view, drive.robot(), pose, Paint::fill(fill).edged(edge, 1.6), edge);
    if touched {
        cross(page, view.at(pose.position), 8.0);
    }
}
