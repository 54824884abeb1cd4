//! Episodes as pictures: one drive, several drives of different stacks through one world, a world without a drive, or a moment of a drive.
//!
//! A picture shows a [`Crop`] of the map with axes in metres of the map's frame; what each mark means is beneath it. Tracks of the robot and
//! of movers have dots at the same round times, so that one sees who was where when.

mod axes;
mod borders;
mod film;
mod labels;
mod legend;
mod map;
mod movers;
mod robot;
mod view;

pub(super) use map::stays;

pub use film::{Film, film, shown_cs};
pub use view::Crop;

use super::palette::{FAINT_INK, INK, PAPER, PLAN, ROBOT, series};
use super::picture::{Anchor, Paint, Picture, Text, font};
use crate::episode::Recording;
use crate::geometry::outline::{Outline, Shape};
use crate::geometry::{Rect, Vec2};
use crate::math;
use crate::robot::Robot;
use crate::trace::Trace;
use crate::world::Scene;
use axes::Axes;
use labels::Labels;
use legend::Legend;
use movers::Look;
use robot::Dot;
use view::View;

/// The words above a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Caption {
    /// Large text: scenario, stack, episode. Empty for a picture without words above it.
    pub title: String,
    /// Small text: the outcome.
    pub subtitle: String,
}

/// How a picture is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Style {
    /// Width of the page, pixels of 1/96 inch; texts keep their size.
    pub width: f64,
    /// The part of the world that is shown.
    pub crop: Crop,
    /// Seconds between two dots of a track; 0 for none, `None` for a round number that suits the drive.
    pub marks_s: Option<f64>,
}

impl Default for Style {
    fn default() -> Self {
        Self { width: 800.0, crop: Crop::Auto, marks_s: None }
    }
}

/// Size of the times beside tracks.
const LABEL: f64 = 9.5;
const MARGIN: f64 = 14.0;
/// Height of a map at most, as a share of the width of the page.
const TALL: f64 = 0.95;
/// A page is never narrower, however tall its map, as a share of what was asked for.
const NARROW: f64 = 0.62;

/// A drive as the layers of a picture take it.
#[derive(Clone, Copy)]
struct Drive<'a> {
    recording: &'a Recording,
}

impl<'a> Drive<'a> {
    fn trace(&self) -> &'a Trace {
        &self.recording.trace
    }

    fn scene(&self) -> &'a Scene {
        &self.recording.scene
    }

    fn robot(&self) -> &'a Robot {
        &self.recording.robot
    }

    fn rows(&self) -> usize {
        self.trace().ticks.len()
    }

    fn end_s(&self) -> f64 {
        self.rows().checked_sub(1).map_or(0.0, |row| self.trace().row_time_s(row, self.recording.dt_s))
    }

    /// What the robot touched: start, goals, plans and track.
    fn touched(&self) -> Rect {
        let (start, radius) = (self.scene().start.position, self.robot().radius_m);
        let goals = robot::goals(self, self.end_s()).into_iter().map(|(_, goal)| goal);
        let plans = self.trace().paths.iter().flat_map(|plan| plan.path.vertices());
        let track = self.trace().ticks.iter().map(|tick| tick.pose.position);
        let all = goals.chain(plans).chain(track).chain([start]);
        let Rect { min, max } = view::bounds(all).unwrap_or(Rect { min: start, max: start });
        let reach = Vec2::new(radius, radius);
        Rect { min: min - reach, max: max + reach }
    }

    /// Rows at multiples of `step_s`, without the first and the last second, with their times in words.
    fn marks(&self, step_s: f64) -> Vec<(usize, String)> {
        if step_s <= 0.0 || self.rows() == 0 {
            return Vec::new();
        }
        let dt_s = self.recording.dt_s;
        let times = axes::multiples(step_s, self.end_s() - 0.3 * step_s, step_s);
        let row = |time_s: f64| (time_s / dt_s).round() as usize;
        times.map(|time_s| (row(time_s), axes::signed(time_s))).filter(|(row, _)| *row < self.rows()).collect()
    }
}

/// Seconds between two dots: a round number for at most ten of them, and for a distance at which their labels have room.
fn suitable_step_s(view: &View, drives: &[Drive<'_>]) -> f64 {
    let longest = |of: &dyn Fn(&Drive<'_>) -> f64| drives.iter().map(of).fold(0.0, math::max);
    let end_s = longest(&|drive| drive.end_s());
    let driven = longest(&|drive| {
        let ticks = &drive.trace().ticks;
        ticks.windows(2).map(|two| (two[1].pose.position - two[0].pose.position).norm()).sum::<f64>() * view.scale
    });
    let most = math::clamp(driven / 45.0, 1.0, 10.0);
    axes::round_step(math::max(end_s / most, 1.0))
}

fn seconds(time_s: f64) -> String {
    format!("{} s", math::canonical((time_s * 10.0).round() / 10.0))
}

/// An outline about `centre`, a disc never smaller than a few pixels.
fn outlined(page: &mut Picture, view: &View, outline: &Outline, centre: Vec2, paint: Paint) {
    match view.corners(outline, centre) {
        Some(corners) => page.area(vec![corners], paint),
        None => page.circle(view.at(centre), math::max(outline.circumradius_m() * view.scale, 2.0), paint),
    }
}

/// A shape as a legend shows it, as large as a letter.
fn emblem(page: &mut Picture, at: Vec2, shape: &Shape, paint: Paint) {
    let scale = 6.5 / shape.circumradius_m();
    match Outline::new(shape.clone(), 0.0).corners(Vec2::zeros()) {
        Some(corners) => {
            page.area(vec![corners.iter().map(|p| at + Vec2::new(p.x, -p.y) * scale).collect()], paint);
        }
        None => page.circle(at, 5.0, paint),
    }
}

/// A page with its header, a map and, in the end, its legend.
struct Sheet {
    page: Picture,
    view: View,
    axes: Axes,
    labels: Labels,
    legend: Legend,
}

impl Sheet {
    fn new(scene: &Scene, touched: Rect, caption: &Caption, style: &Style) -> Self {
        let grid = &scene.map.grid;
        let window = style.crop.window(grid, touched);
        let room = math::max(style.width - axes::LEFT - MARGIN, 80.0);
        let narrow = View::new(window, Vec2::zeros(), room, TALL * style.width);
        let map_width = narrow.plot.max.x - narrow.plot.min.x;
        let width = math::max(map_width + axes::LEFT + MARGIN, NARROW * style.width).ceil();

        let mut page = Picture::new(width, 0.0);
        let mut y = MARGIN;
        let words = [(&caption.title, 14.0, true, INK), (&caption.subtitle, 11.5, false, FAINT_INK)];
        for (words, size, bold, colour) in words {
            for line in font::wrapped(words, size, bold, width - 2.0 * MARGIN) {
                y += 1.32 * size;
                let text = Text::new(Vec2::new(MARGIN, y - 0.3 * size), size, line).coloured(colour);
                page.text(Text { bold, ..text });
            }
        }
        if y > MARGIN {
            y += 12.0;
        }
        let view = View::new(window, Vec2::new(axes::LEFT, y), room, TALL * style.width);
        let axes = Axes::new(&view, grid.frame());
        let labels = Labels::new(view.plot);
        Self { page, view, axes, labels, legend: Legend::default() }
    }

    /// Paints inside the map alone.
    fn inside(&mut self, paint: impl FnOnce(&mut Picture, &View, &mut Labels, &mut Legend)) {
        let Self { page, view, labels, legend, .. } = self;
        page.clipped(view.plot, |page| paint(page, view, labels, legend));
    }

    /// Floor, grid lines and obstacles on the map.
    fn map(&mut self, scene: &Scene) {
        let Self { page, view, axes, legend, .. } = self;
        page.clipped(view.plot, |page| {
            map::ground(page, view, &scene.map.grid, legend);
            axes.grid(page, view);
            map::obstacles(page, view, &scene.map.grid, legend);
        });
    }

    /// The frame, the legend beside a slender map or beneath a wide one, and the page as high as it needs to be.
    fn finish(mut self) -> Picture {
        let Rect { min, max } = self.view.plot;
        self.axes.frame(&mut self.page, &self.view);
        let beside = Vec2::new(max.x + 16.0, min.y);
        let width = self.page.width - 2.0 * MARGIN;
        let room = MARGIN + width - beside.x;
        let beneath = max.y + axes::BELOW;
        let low = if self.legend.width() <= room {
            math::max(beneath, beside.y + self.legend.paint(&mut self.page, beside, 0.0))
        } else {
            let corner = Vec2::new(MARGIN, beneath + 2.0);
            corner.y + self.legend.paint(&mut self.page, corner, width)
        };
        self.page.height = (low + 8.0).ceil();
        self.page
    }
}

/// One drive.
pub fn draw(recording: &Recording, caption: &Caption, style: &Style) -> Picture {
    let drive = Drive { recording };
    let mut sheet = Sheet::new(&recording.scene, drive.touched(), caption, style);
    let step_s = style.marks_s.unwrap_or_else(|| suitable_step_s(&sheet.view, &[drive]));
    let marks = drive.marks(step_s);
    let (rows, end_s) = (drive.rows(), drive.end_s());
    let last_tick = recording.trace.ticks.last().map_or(0, |tick| tick.tick);
    sheet.map(&recording.scene);
    sheet.inside(|page, view, labels, legend| {
        labels.avoid(recording.trace.ticks.iter().step_by(3).map(|tick| view.at(tick.pose.position)));
        if let Some(last) = recording.trace.ticks.last() {
            labels.take(view.at(last.pose.position), drive.robot().radius_m * view.scale);
        }
        movers::keep_clear(view, &drive, labels);
        map::unknown_statics(page, view, &recording.scene, (0.0, end_s), labels, legend);
        movers::tracks(page, view, &drive, Look::USUAL);
        robot::plans(page, view, &recording.trace, last_tick, PLAN, legend);
        robot::states(page, view, &recording.trace, rows, legend);
        robot::start(page, view, &drive, labels, legend);
        robot::track_by_speed(page, view, &drive, rows);
        robot::speed_legend(drive.robot(), legend);
        let ended = robot::end(page, view, &drive, ROBOT);
        robot::end_legend(drive.robot(), ended.is_some_and(|ended| ended.touched), ROBOT, legend);
        robot::flags(page, view, &drive, end_s, labels, legend);
        movers::bodies(page, view, &drive, Look::USUAL, legend);
        robot::times(page, view, &drive, (INK, Dot::Round), &marks, labels);
        movers::times(page, view, &drive, Look::USUAL, &marks, labels);
        marks_legend(&marks, step_s, legend);
    });
    sheet.finish()
}

fn marks_legend(marks: &[(usize, String)], step_s: f64, legend: &mut Legend) {
    if marks.is_empty() {
        return;
    }
    legend.add(format!("every {}, and the time", seconds(step_s)), |page, at| {
        page.line(vec![at - Vec2::new(10.0, 0.0), at + Vec2::new(10.0, 0.0)], Paint::line(FAINT_INK, 1.2));
        Dot::Round.paint(page, at, Paint::fill(PAPER).edged(INK, 1.3));
    });
}

/// The drives of several stacks, each with a name, through one world: a colour and a shape of dots each.
///
/// Movers are shown as those of the first drive met them; what they do may depend on the robot.
pub fn overlay(drives: &[(String, &Recording)], caption: &Caption, style: &Style) -> Picture {
    let all: Vec<Drive<'_>> = drives.iter().map(|(_, recording)| Drive { recording }).collect();
    let Some(first) = all.first().copied() else { return Picture::new(style.width, 1.0) };
    let touched = all.iter().map(Drive::touched).fold(first.touched(), view::united);
    let scene = first.scene();
    let mut sheet = Sheet::new(scene, touched, caption, style);
    let step_s = style.marks_s.unwrap_or_else(|| suitable_step_s(&sheet.view, &all));
    let end_s = all.iter().map(Drive::end_s).fold(0.0, math::max);
    sheet.map(scene);
    sheet.inside(|page, view, labels, legend| {
        for drive in &all {
            labels.avoid(drive.trace().ticks.iter().step_by(3).map(|tick| view.at(tick.pose.position)));
        }
        movers::keep_clear(view, &first, labels);
        map::unknown_statics(page, view, scene, (0.0, end_s), labels, legend);
        movers::tracks(page, view, &first, Look::PLAIN);
        let mut touched = false;
        for (index, (name, drive)) in drives.iter().map(|(name, _)| name).zip(&all).enumerate() {
            let (colour, dot) = (series(index), Dot::of(index));
            let plan = drive.trace().paths.last().map(|plan| view.path(&plan.path));
            page.line(plan.unwrap_or_default(), Paint::line(colour, 1.1).dashed(4.0, 3.0).faded(0.6));
            let track = view.track(drive.trace().ticks.iter().map(|tick| tick.pose.position));
            page.line(track, Paint::line(colour, 2.6));
            legend.add(name.as_str(), move |page, at| {
                page.line(vec![at - Vec2::new(10.0, 0.0), at + Vec2::new(10.0, 0.0)], Paint::line(colour, 2.6));
                dot.paint(page, at, Paint::fill(PAPER).edged(colour, 1.3));
            });
            touched |= robot::end(page, view, drive, colour).is_some_and(|ended| ended.touched);
        }
        legend.add("plan", |page, at| {
            let paint = Paint::line(FAINT_INK, 1.1).dashed(4.0, 3.0);
            page.line(vec![at - Vec2::new(10.0, 0.0), at + Vec2::new(10.0, 0.0)], paint);
        });
        robot::start(page, view, &first, labels, legend);
        robot::end_legend(first.robot(), touched, FAINT_INK, legend);
        robot::flags(page, view, &first, end_s, labels, legend);
        movers::bodies(page, view, &first, Look::PLAIN, legend);
        for (index, drive) in all.iter().enumerate() {
            robot::times(page, view, drive, (series(index), Dot::of(index)), &drive.marks(step_s), labels);
        }
        let marks = first.marks(step_s);
        movers::times(page, view, &first, Look::PLAIN, &marks, labels);
        marks_legend(&marks, step_s, legend);
    });
    sheet.finish()
}

/// A world without a drive: map, obstacles, start, goals, and the ways of the movers as if no robot were there, as
/// [`crate::experiment::Experiment::watch_one`] records them.
pub fn world(recording: &Recording, caption: &Caption, style: &Style) -> Picture {
    let drive = Drive { recording };
    let whole = Rect { min: Vec2::zeros(), max: recording.scene.map.grid.extent_m() };
    let mut sheet = Sheet::new(&recording.scene, whole, caption, style);
    let end_s = drive.end_s();
    let step_s = style.marks_s.unwrap_or_else(|| axes::round_step(math::max(end_s / 6.0, 1.0)));
    let marks = drive.marks(step_s);
    sheet.map(&recording.scene);
    sheet.inside(|page, view, labels, legend| {
        movers::keep_clear(view, &drive, labels);
        map::unknown_statics(page, view, &recording.scene, (0.0, f64::INFINITY), labels, legend);
        movers::tracks(page, view, &drive, Look::USUAL);
        robot::start(page, view, &drive, labels, legend);
        robot::flags(page, view, &drive, f64::INFINITY, labels, legend);
        movers::bodies(page, view, &drive, Look::USUAL, legend);
        movers::times(page, view, &drive, Look::USUAL, &marks, labels);
        if recording.trace.mover_count > 0 {
            marks_legend(&marks, step_s, legend);
        }
    });
    sheet.finish()
}

/// A text at the right end of the header.
fn clock(page: &mut Picture, view: &View, words: &str) {
    let at = Vec2::new(view.plot.max.x, view.plot.min.y - 7.0);
    page.text(Text { bold: true, ..Text::new(at, 14.0, words).anchored(Anchor::End) });
}
