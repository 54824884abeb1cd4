//! The picture of the fuzzy controller of `fuzzy_dwa` in the documents is drawn here, from its code.
//!
//! `SIMRUN_BLESS=1 cargo test --release --test it fuzzy_sets::` draws it anew.

use super::support::{is_blessing, root};
use simrun::plan::local::fuzzy_dwa::Params;
use simrun::plan::local::fuzzy_dwa::inference::{Peaks, Set};
use std::fmt::Write as _;

/// Colours from 0 to 1: eight steps of a perceptually even ramp.
const RAMP: [&str; 8] = ["#440154", "#46327e", "#365c8d", "#277f8e", "#1fa187", "#4ac16d", "#a0da39", "#fde725"];
const LINES: [&str; 4] = ["#5e81ac", "#277f8e", "#d08770", "#b4538a"];
const INK: &str = "#2e3440";
/// Squares of a surface along either axis.
const SQUARES: u32 = 40;

/// A panel with axes: lower left corner, width and height, px.
struct Panel {
    left: f64,
    bottom: f64,
    width: f64,
    height: f64,
}

impl Panel {
    fn x(&self, share: f64) -> f64 {
        self.left + share * self.width
    }

    fn y(&self, share: f64) -> f64 {
        self.bottom - share * self.height
    }

    /// Title, frame, ticks at both axes and their labels.
    fn axes(&self, svg: &mut String, title: &str, x: (&str, f64), y: (&str, f64)) {
        let (middle, top) = (self.x(0.5), self.y(1.0));
        let text = |svg: &mut String, x: f64, y: f64, anchor: &str, text: &str| {
            writeln!(svg, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="{anchor}">{text}</text>"#).unwrap();
        };
        text(svg, middle, top - 20.0, "middle", &format!("<tspan font-weight=\"bold\">{title}</tspan>"));
        for k in 0..=2 {
            let share = f64::from(k) / 2.0;
            let (at, up) = (self.x(share), self.y(share));
            let (low, left) = (self.bottom, self.left);
            writeln!(svg, r#"<path d="M{at:.1} {low:.1}v4M{left:.1} {up:.1}h-4" stroke="{INK}"/>"#).unwrap();
            text(svg, at, self.bottom + 16.0, "middle", &format!("{}", x.1 * share));
            text(svg, self.left - 7.0, up + 4.0, "end", &format!("{}", y.1 * share));
        }
        text(svg, middle, self.bottom + 32.0, "middle", x.0);
        let (across, up) = (self.left - 34.0, self.y(0.5));
        writeln!(
            svg,
            r#"<text transform="translate({across:.1} {up:.1}) rotate(-90)" text-anchor="middle">{}</text>"#,
            y.0
        )
        .unwrap();
        let (left, width, height) = (self.left, self.width, self.height);
        writeln!(
            svg,
            r#"<rect x="{left:.1}" y="{top:.1}" width="{width:.1}" height="{height:.1}" fill="none" stroke="{INK}"/>"#
        )
        .unwrap();
    }

    /// The membership functions of a family, and their names above their peaks.
    fn sets(&self, svg: &mut String, sets: &[Set; 4], peaks: Peaks, letter: char) {
        for (number, (set, peak)) in sets.iter().zip(peaks.get()).enumerate() {
            let mut line = String::new();
            // Twelfths meet every corner of even sets.
            for k in 0..=12 {
                let u = f64::from(k) / 12.0;
                write!(line, "{:.1},{:.1} ", self.x(u), self.y(set.membership(u))).unwrap();
            }
            let colour = LINES[number];
            writeln!(svg, r#"<polyline points="{}" fill="none" stroke="{colour}" stroke-width="2"/>"#, line.trim_end())
                .unwrap();
            let (x, y) = (self.x(peak), self.y(1.0) - 5.0);
            let name = number + 1;
            writeln!(svg, r#"<text x="{x:.1}" y="{y:.1}" text-anchor="middle" fill="{colour}">{letter}{name}</text>"#)
                .unwrap();
        }
    }
}

fn picture() -> String {
    let params = Params::default();
    let controller = params.controller();
    let (obstacle_m, goal_m) = (params.obstacle_range_m.get(), params.goal_range_m.get());
    let mut svg = String::from(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1000\" height=\"520\" viewBox=\"0 0 1000 520\" \
         font-family=\"sans-serif\" font-size=\"12\" fill=\"#2e3440\">\n\
         <rect width=\"1000\" height=\"520\" fill=\"white\"/>\n",
    );
    let families = [
        ("distance to the nearest obstacle", "D_obs, m", obstacle_m, params.input_sets, 'N'),
        ("distance to the target", "D_goal, m", goal_m, params.input_sets, 'N'),
        ("weights", "weight", 1.0, params.output_sets, 'M'),
    ];
    for (number, (title, label, top, peaks, letter)) in families.into_iter().enumerate() {
        let panel = Panel { left: 70.0 + 320.0 * number as f64, bottom: 200.0, width: 250.0, height: 150.0 };
        panel.sets(&mut svg, &Set::family(peaks, params.shape), peaks, letter);
        panel.axes(&mut svg, title, (label, top), ("membership", 1.0));
    }
    for (number, title) in ["α, heading", "β, distance", "γ, velocity", "λ, pull"].into_iter().enumerate() {
        let panel = Panel { left: 70.0 + 225.0 * number as f64, bottom: 470.0, width: 160.0, height: 160.0 };
        let (width, height) = (panel.width / f64::from(SQUARES), panel.height / f64::from(SQUARES));
        for row in 0..SQUARES {
            let share = |k: u32| (f64::from(k) + 0.5) / f64::from(SQUARES);
            let step_at = |col: u32| step(controller.weights(share(col) * obstacle_m, share(row) * goal_m)[number]);
            // Squares of one colour beside each other are one rectangle.
            let mut col = 0;
            while col < SQUARES {
                let end = (col..SQUARES).find(|&next| step_at(next) != step_at(col)).unwrap_or(SQUARES);
                let (x, y) = (panel.left + f64::from(col) * width, panel.bottom - f64::from(row + 1) * height);
                let (run, colour) = (f64::from(end - col) * width, RAMP[step_at(col)]);
                writeln!(svg, r#"<path d="M{x:.1} {y:.1}h{run:.1}v{height:.1}h-{run:.1}z" fill="{colour}"/>"#).unwrap();
                col = end;
            }
        }
        panel.axes(&mut svg, title, ("D_obs, m", obstacle_m), ("D_goal, m", goal_m));
    }
    let steps = RAMP.len() as f64;
    for (number, colour) in RAMP.iter().enumerate() {
        let y = 470.0 - 20.0 * (number as f64 + 1.0);
        let (from, to) = (number as f64 / steps, (number as f64 + 1.0) / steps);
        writeln!(svg, r#"<rect x="925" y="{y:.1}" width="14" height="20" fill="{colour}"/>"#).unwrap();
        writeln!(svg, r#"<text x="944" y="{:.1}" font-size="9">{from:.2}–{to:.2}</text>"#, y + 13.0).unwrap();
    }
    svg + "</svg>\n"
}

/// The step of the ramp for a weight.
fn step(weight: f64) -> usize {
    ((weight * RAMP.len() as f64) as usize).min(RAMP.len() - 1)
}

#[test]
fn the_picture_of_the_fuzzy_controller_is_that_of_the_code() {
    let path = root().join("docs/book/src/papers/zhu2025_sets.svg");
    let picture = picture();
    if is_blessing() {
        std::fs::write(path, picture).unwrap();
    } else {
        let shown = std::fs::read_to_string(path).unwrap();
        assert!(shown == picture, "SIMRUN_BLESS=1 cargo test --release --test it fuzzy_sets:: draws it anew");
    }
}
