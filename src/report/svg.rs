//! One episode as an SVG: the map, the unknown obstacles, movers with their tracks, the planned
//! path with its key nodes, the driven trajectory coloured by speed, the contact if there was one,
//! and a scale bar. A browser is enough to view it.

use crate::episode::{Outcome, Recording};
use crate::geometry::outline::{Outline, Shape};
use crate::geometry::{Path, Piece, Pose, Vec2};
use crate::map::OccupancyGrid;
use crate::math;
use crate::plan::contract::State;
use crate::robot::Robot;
use crate::trace::{Tick, Trace};
use crate::world::Scene;
use std::fmt::{self, Write as _};

/// Width of the map in the picture, px.
const MAP_WIDTH_PX: f64 = 1100.0;
/// Height that a tall map is reduced to, px.
const MAP_HEIGHT_MAX_PX: f64 = 1100.0;
const MARGIN_PX: f64 = 24.0;
const HEADER_PX: f64 = 58.0;
const FOOTER_PX: f64 = 66.0;

/// Colours from standing (dark) to full speed (bright): eight steps of a perceptually even ramp.
const SPEED_COLOURS: [&str; 8] =
    ["#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725"];
const OBSTACLE: &str = "#3b4252";
const FLOOR: &str = "#fbfbf8";
const UNKNOWN: &str = "#d08770";
const MOVER: &str = "#b4538a";
const PLAN: &str = "#5e81ac";
/// Bands beneath the track for a planner's own states, in the order in which it enters them.
const STATE_COLOURS: [&str; 4] = ["#f2a65a", "#d1495b", "#7b5ea7", "#8d99ae"];
const CONTACT: &str = "#c4001a";
const INK: &str = "#2e3440";

/// The words of a picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Caption {
    /// Large text: scenario, stack, episode.
    pub title: String,
    /// Small text: the outcome.
    pub subtitle: String,
}

/// Draws one episode; see the module's documentation.
pub fn draw(recording: &Recording, caption: &Caption) -> String {
    let Recording { scene, robot, trace, outcome, .. } = recording;
    let canvas = Canvas::new(&scene.map.grid);
    let mut svg = canvas.open(caption);
    canvas.map(&mut svg, &scene.map.grid);
    canvas.unknown_statics(&mut svg, scene);
    canvas.paths(&mut svg, trace);
    canvas.movers(&mut svg, scene, trace);
    canvas.states(&mut svg, trace);
    canvas.trajectory(&mut svg, robot, trace);
    canvas.ends(&mut svg, scene, robot, trace, outcome);
    canvas.legend(&mut svg, scene, robot, trace, outcome);
    svg.push_str("</svg>\n");
    svg
}

/// From metres of the grid frame to pixels, y down.
struct Canvas {
    scale: f64,
    width_px: f64,
    height_px: f64,
}

impl Canvas {
    fn new(grid: &OccupancyGrid) -> Self {
        let extent = grid.extent_m();
        let scale = math::min(MAP_WIDTH_PX / extent.x, MAP_HEIGHT_MAX_PX / extent.y);
        Self { scale, width_px: extent.x * scale, height_px: extent.y * scale }
    }

    fn x(&self, p: Vec2) -> f64 {
        MARGIN_PX + p.x * self.scale
    }

    fn y(&self, p: Vec2) -> f64 {
        HEADER_PX + self.height_px - p.y * self.scale
    }

    fn px(&self, metres: f64) -> f64 {
        metres * self.scale
    }

    fn open(&self, caption: &Caption) -> String {
        let width = math::max(self.width_px + 2.0 * MARGIN_PX, 800.0);
        let height = self.height_px + HEADER_PX + FOOTER_PX;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" \
             font-family=\"system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif\" fill=\"{INK}\">\n\
             <rect width=\"{width:.0}\" height=\"{height:.0}\" fill=\"#ffffff\"/>\n"
        );
        line(
            &mut svg,
            format_args!(
                "<text x=\"{MARGIN_PX}\" y=\"25\" font-size=\"17\" font-weight=\"600\">{}</text>",
                escape(&caption.title)
            ),
        );
        line(
            &mut svg,
            format_args!("<text x=\"{MARGIN_PX}\" y=\"45\" font-size=\"13\">{}</text>", escape(&caption.subtitle)),
        );
        svg
    }

    fn map(&self, svg: &mut String, grid: &OccupancyGrid) {
        line(
            svg,
            format_args!(
                "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"{:.2}\" height=\"{:.2}\" fill=\"{FLOOR}\" stroke=\"{OBSTACLE}\" stroke-width=\"2\"/>",
                MARGIN_PX, HEADER_PX, self.width_px, self.height_px
            ),
        );
        // One path of runs: occupied cells of a row that touch become one rectangle.
        svg.push_str("<path d=\"");
        let side = grid.resolution_m();
        for row in 0..grid.rows() {
            let mut col = 0;
            while col < grid.cols() {
                let run =
                    (col..grid.cols()).take_while(|&col| !grid.is_free(crate::map::Cell { col, row })).count() as i32;
                if run > 0 {
                    let top_left = Vec2::new(f64::from(col) * side, f64::from(row + 1) * side);
                    let (w, h) = (self.px(f64::from(run) * side), self.px(side));
                    let _ = write!(svg, "M{:.2} {:.2}h{w:.2}v{h:.2}h-{w:.2}z", self.x(top_left), self.y(top_left));
                }
                col += run + 1;
            }
        }
        // The same colour as a thin stroke hides the seams between rows.
        line(svg, format_args!("\" fill=\"{OBSTACLE}\" stroke=\"{OBSTACLE}\" stroke-width=\"0.3\"/>"));
    }

    fn unknown_statics(&self, svg: &mut String, scene: &Scene) {
        for obstacle in &scene.unknown_static {
            self.outline(svg, obstacle.outline(), obstacle.pose().position, format_args!("fill=\"{UNKNOWN}\""));
        }
    }

    /// An outline about `centre`, never smaller than a few pixels.
    fn outline(&self, svg: &mut String, outline: &Outline, centre: Vec2, style: fmt::Arguments<'_>) {
        match outline.corners(centre) {
            Some(corners) => {
                line(svg, format_args!("<polygon points=\"{}\" {style}/>", self.points(&corners)));
            }
            None => {
                let (x, y) = (self.x(centre), self.y(centre));
                let r = math::max(self.px(outline.circumradius_m()), 2.0);
                line(svg, format_args!("<circle cx=\"{x:.2}\" cy=\"{y:.2}\" r=\"{r:.2}\" {style}/>"));
            }
        }
    }

    fn paths(&self, svg: &mut String, trace: &Trace) {
        let last = trace.paths.len().saturating_sub(1);
        for (index, planned) in trace.paths.iter().enumerate() {
            // Earlier plans stay visible but pale.
            let opacity = if index == last { 1.0 } else { 0.35 };
            line(
                svg,
                format_args!(
                    "<path d=\"{}\" fill=\"none\" stroke=\"{PLAN}\" stroke-width=\"1.6\" stroke-dasharray=\"6 4\" opacity=\"{opacity}\"/>",
                    self.path_data(&planned.path)
                ),
            );
            let mut nodes = Vec::new();
            planned.path.key_nodes(&mut nodes);
            for node in nodes.iter().map(|node| node.position) {
                line(
                    svg,
                    format_args!(
                        "<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"2.6\" fill=\"#ffffff\" stroke=\"{PLAN}\" stroke-width=\"1.3\" opacity=\"{opacity}\"/>",
                        self.x(node),
                        self.y(node)
                    ),
                );
            }
        }
    }

    fn path_data(&self, path: &Path) -> String {
        let mut data = format!("M{:.2} {:.2}", self.x(path.start()), self.y(path.start()));
        for (from, piece) in path.segments() {
            let (x, y) = (self.x(piece.end()), self.y(piece.end()));
            let _ = match *piece {
                Piece::Line { .. } => write!(data, "L{x:.2} {y:.2}"),
                Piece::Arc { centre, sweep, .. } => {
                    let r = self.px((from - centre).norm());
                    let (large, clockwise) = (u8::from(sweep.abs() > math::PI), u8::from(sweep < 0.0));
                    write!(data, "A{r:.2} {r:.2} 0 {large} {clockwise} {x:.2} {y:.2}")
                }
                Piece::Curve(_) => {
                    let chords = piece.chord_count(from, 0.25 / self.scale, 1e3);
                    (1..=chords).try_for_each(|k| {
                        let p = piece.chord_point(from, k, chords);
                        write!(data, "L{:.2} {:.2}", self.x(p), self.y(p))
                    })
                }
            };
        }
        data
    }

    fn movers(&self, svg: &mut String, scene: &Scene, trace: &Trace) {
        let rows = trace.ticks.len();
        for (index, mover) in scene.movers.iter().enumerate() {
            let at = |row: usize| trace.movers_at(row)[index].position;
            let there = |row: &usize| trace.movers_at(*row)[index].present;
            let (Some(begin), Some(end)) = ((0..rows).find(there), (0..rows).rev().find(there)) else { continue };
            let track: Vec<Vec2> = (begin..=end).step_by(2).chain([end]).filter(there).map(at).collect();
            line(
                svg,
                format_args!(
                    "<polyline points=\"{}\" fill=\"none\" stroke=\"{MOVER}\" stroke-width=\"1.1\" opacity=\"0.55\"/>",
                    self.points(&track)
                ),
            );
            let (first, last) = (at(begin), at(end));
            let hollow = format_args!("fill=\"none\" stroke=\"{MOVER}\" stroke-width=\"1.1\" opacity=\"0.55\"");
            self.outline(svg, &mover.outline, first, hollow);
            self.outline(svg, &mover.outline, last, format_args!("fill=\"{MOVER}\""));
            let velocity = trace.movers_at(end)[index].velocity;
            let ahead = last + velocity;
            line(
                svg,
                format_args!(
                    "<line x1=\"{:.2}\" y1=\"{:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" stroke=\"{MOVER}\" stroke-width=\"1.6\"/>",
                    self.x(last),
                    self.y(last),
                    self.x(ahead),
                    self.y(ahead)
                ),
            );
        }
    }

    fn points(&self, points: &[Vec2]) -> String {
        let mut text = String::with_capacity(points.len() * 14);
        for p in points {
            let _ = write!(text, "{:.2},{:.2} ", self.x(*p), self.y(*p));
        }
        text
    }

    /// A band beneath the track for each stretch in one of the [`marked_states`].
    fn states(&self, svg: &mut String, trace: &Trace) {
        let marked = marked_states(trace);
        for run in trace.ticks.chunk_by(|a, b| a.state.name == b.state.name) {
            let Some(colour) = state_colour(&marked, run[0].state.name) else { continue };
            let points: Vec<Vec2> = run.iter().map(|tick| tick.pose.position).collect();
            line(
                svg,
                format_args!(
                    "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"10\" stroke-linecap=\"round\" stroke-linejoin=\"round\" opacity=\"0.6\"/>",
                    self.points(&points)
                ),
            );
        }
    }

    fn trajectory(&self, svg: &mut String, robot: &Robot, trace: &Trace) {
        let colour = |tick: &Tick| {
            let share = math::clamp(tick.twist.v.abs() / robot.speed_max_mps, 0.0, 1.0);
            ((share * SPEED_COLOURS.len() as f64) as usize).min(SPEED_COLOURS.len() - 1)
        };
        let mut row = 1;
        while row < trace.ticks.len() {
            let bin = colour(&trace.ticks[row]);
            let mut points = vec![trace.ticks[row - 1].pose.position];
            while row < trace.ticks.len() && colour(&trace.ticks[row]) == bin {
                points.push(trace.ticks[row].pose.position);
                row += 1;
            }
            line(
                svg,
                format_args!(
                    "<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"3.2\" stroke-linecap=\"round\" stroke-linejoin=\"round\"/>",
                    self.points(&points),
                    SPEED_COLOURS[bin]
                ),
            );
        }
    }

    fn ends(&self, svg: &mut String, scene: &Scene, robot: &Robot, trace: &Trace, outcome: &Outcome) {
        let start = scene.start;
        let footprint = match &robot.footprint {
            None => Shape::Disc { radius_m: robot.radius_m },
            Some(polygon) => Shape::Polygon(polygon.clone()),
        };
        let footprint = |pose: Pose| Outline::new(footprint.clone(), pose.theta);
        let paper = format_args!("fill=\"#ffffff\" stroke=\"{INK}\" stroke-width=\"1.6\"");
        self.outline(svg, &footprint(start), start.position, paper);
        self.label(svg, start.position, "start");
        let (gx, gy) = (self.x(scene.goal), self.y(scene.goal));
        line(
            svg,
            format_args!(
                "<path d=\"M{gx:.2} {gy:.2}v-18l12 4.5l-12 4.5\" fill=\"#2e7d32\" stroke=\"#2e7d32\" stroke-width=\"1.8\" stroke-linejoin=\"round\"/>"
            ),
        );
        self.label(svg, scene.goal, "goal");
        let Some(last) = trace.ticks.last() else { return };
        let (x, y) = (self.x(last.pose.position), self.y(last.pose.position));
        let nose = last.pose.position + crate::geometry::direction(last.pose.theta) * robot.inscribed_radius_m();
        let collided = matches!(outcome, Outcome::Collision { .. });
        let edge = if collided { CONTACT } else { INK };
        let glass = format_args!("fill=\"#ffffff\" fill-opacity=\"0.75\" stroke=\"{edge}\" stroke-width=\"1.8\"");
        self.outline(svg, &footprint(last.pose), last.pose.position, glass);
        line(
            svg,
            format_args!(
                "<line x1=\"{x:.2}\" y1=\"{y:.2}\" x2=\"{:.2}\" y2=\"{:.2}\" stroke=\"{edge}\" stroke-width=\"1.8\"/>",
                self.x(nose),
                self.y(nose)
            ),
        );
        if collided {
            line(
                svg,
                format_args!(
                    "<path d=\"M{:.2} {:.2}l22 22m0 -22l-22 22\" stroke=\"{CONTACT}\" stroke-width=\"3\" stroke-linecap=\"round\"/>",
                    x - 11.0,
                    y - 11.0
                ),
            );
        }
    }

    fn label(&self, svg: &mut String, p: Vec2, text: &str) {
        line(
            svg,
            format_args!(
                "<text x=\"{:.2}\" y=\"{:.2}\" font-size=\"11\" paint-order=\"stroke\" stroke=\"#ffffff\" stroke-width=\"3\">{text}</text>",
                self.x(p) + 8.0,
                self.y(p) + 14.0
            ),
        );
    }

    fn legend(&self, svg: &mut String, scene: &Scene, robot: &Robot, trace: &Trace, outcome: &Outcome) {
        let y = HEADER_PX + self.height_px + 24.0;
        // Scale bar: the roundest length of at most a fifth of the width.
        let wanted_m = self.width_px / self.scale / 5.0;
        let bar_m = [100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0, 0.5, 0.2, 0.1]
            .into_iter()
            .find(|&length| length <= wanted_m)
            .unwrap_or(0.05);
        let x = MARGIN_PX;
        line(
            svg,
            format_args!(
                "<path d=\"M{x} {y}v6h{w:.2}v-6\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"1.6\"/>\
             <text x=\"{:.2}\" y=\"{:.2}\" font-size=\"12\">{bar_m} m</text>",
                x + self.px(bar_m) + 6.0,
                y + 6.0,
                w = self.px(bar_m)
            ),
        );
        let y = y + 28.0;
        let mut x = MARGIN_PX;
        for (index, colour) in SPEED_COLOURS.iter().enumerate() {
            line(
                svg,
                format_args!(
                    "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"14\" height=\"8\" fill=\"{colour}\"/>",
                    x + 14.0 * index as f64,
                    y - 8.0
                ),
            );
        }
        x += 14.0 * SPEED_COLOURS.len() as f64 + 6.0;
        line(
            svg,
            format_args!("<text x=\"{x:.2}\" y=\"{y}\" font-size=\"12\">0 to {} m/s</text>", robot.speed_max_mps),
        );
        x += 92.0;
        let mut item = |mark: &dyn Fn(f64) -> String, text: &str| {
            line(svg, format_args!("{}<text x=\"{:.2}\" y=\"{y}\" font-size=\"12\">{text}</text>", mark(x), x + 24.0));
            x += 40.0 + 6.4 * text.chars().count() as f64;
        };
        if !trace.paths.is_empty() {
            item(
                &|x| {
                    format!(
                        "<line x1=\"{x:.2}\" y1=\"{0:.2}\" x2=\"{1:.2}\" y2=\"{0:.2}\" stroke=\"{PLAN}\" stroke-width=\"1.6\" stroke-dasharray=\"6 4\"/>",
                        y - 4.0,
                        x + 18.0
                    )
                },
                "planned path, key nodes",
            );
        }
        if !scene.unknown_static.is_empty() {
            item(
                &|x| {
                    format!(
                        "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"14\" height=\"9\" fill=\"{UNKNOWN}\"/>",
                        x + 2.0,
                        y - 9.0
                    )
                },
                "not on the map",
            );
        }
        if trace.mover_count > 0 {
            item(
                &|x| format!("<circle cx=\"{:.2}\" cy=\"{:.2}\" r=\"5\" fill=\"{MOVER}\"/>", x + 9.0, y - 4.0),
                "mover, its track and 1 s ahead",
            );
        }
        let marked = marked_states(trace);
        for name in &marked {
            let colour = state_colour(&marked, name).unwrap_or(INK);
            item(
                &|x| {
                    format!(
                        "<rect x=\"{:.2}\" y=\"{:.2}\" width=\"16\" height=\"9\" rx=\"4\" fill=\"{colour}\" opacity=\"0.6\"/>",
                        x + 2.0,
                        y - 9.0
                    )
                },
                name,
            );
        }
        if matches!(outcome, Outcome::Collision { .. }) {
            item(
                &|x| {
                    format!(
                        "<path d=\"M{:.2} {:.2}l10 10m0 -10l-10 10\" stroke=\"{CONTACT}\" stroke-width=\"2.4\"/>",
                        x + 4.0,
                        y - 9.0
                    )
                },
                "contact",
            );
        }
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

fn state_colour(marked: &[&'static str], name: &str) -> Option<&'static str> {
    let at = marked.iter().position(|state| *state == name)?;
    Some(STATE_COLOURS[at % STATE_COLOURS.len()])
}

fn line(svg: &mut String, text: fmt::Arguments<'_>) {
    let _ = svg.write_fmt(text);
    svg.push('\n');
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
