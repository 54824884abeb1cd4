//! `simrun draw`: what a picture shows, and that each ending is written as what it says.

use super::support::{Simrun, root, simrun};
use std::fs;
use std::path::Path;

fn draw(folder: &Path, name: &str, arguments: &[&str]) -> Simrun {
    let mut command = simrun(folder);
    command.arg("draw").arg(root().join(format!("scenarios/{name}.yaml"))).args(arguments);
    command
}

/// The texts of a picture, in the order in which they are painted.
fn texts(svg: &str) -> Vec<&str> {
    svg.lines().filter(|line| line.starts_with("<text")).filter_map(|line| line.split(['>', '<']).nth(2)).collect()
}

fn svg_of(name: &str, arguments: &[&str]) -> String {
    let scratch = tempfile::tempdir().unwrap();
    draw(scratch.path(), name, arguments).args(["-o", "-"]).ends_with(0).stdout
}

#[test]
fn a_picture_has_axes_in_metres_and_a_legend_of_what_is_on_it() {
    let svg = svg_of("04_unknown_pallet", &[]);
    assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
    let texts = texts(&svg);
    for words in
        ["x (m)", "y (m)", "start", "goal", "obstacle not on the map", "plan and its key nodes", "robot at the start"]
    {
        assert!(texts.contains(&words), "{words}: {texts:?}");
    }
    assert!(!texts.iter().any(|words| words.contains("mover") || words.contains("unknown cells")), "{texts:?}");
    assert!(texts.iter().any(|words| words.starts_with("goal, arrived within 0.25 m")), "{texts:?}");
}

#[test]
fn axes_are_those_of_the_window_that_was_asked_for() {
    let svg = svg_of("02_wall", &["--crop", "3,2,9,6", "--marks", "0", "--width", "400"]);
    let numbers: Vec<&str> = texts(&svg).into_iter().filter(|words| words.parse::<f64>().is_ok()).collect();
    // Across from 3 to 9, then up from 2 to 6.
    assert_eq!(numbers, ["3", "4", "5", "6", "7", "8", "9", "2", "3", "4", "5", "6"]);
}

#[test]
fn every_goal_of_a_goal_that_moved_is_shown() {
    let svg = svg_of("13_blocked_aisle", &["--stack", "replans"]);
    let goals: Vec<&str> = texts(&svg).into_iter().filter(|words| words.starts_with("goal ")).collect();
    assert_eq!(goals.len(), 2, "{goals:?}");
    assert!(goals[0].starts_with("goal until") && goals[1].starts_with("goal from"), "{goals:?}");
}

#[test]
fn stacks_drive_through_one_world_in_colours_of_their_own() {
    let svg = svg_of("warehouse", &["--overlay", "theta_star+dwa,a_star+dwa"]);
    let texts = texts(&svg);
    let place = |name: &str| texts.iter().position(|words| words.starts_with(name)).unwrap();
    assert!(place("theta_star+dwa: success") < place("a_star+dwa: success"));
    for colour in ["#0072b2", "#d55e00"] {
        assert!(svg.contains(&format!("stroke=\"{colour}\" stroke-width=\"2.6\"")), "{colour}");
    }
    let scratch = tempfile::tempdir().unwrap();
    let refused = draw(scratch.path(), "warehouse", &["--overlay", "theta_star+dwa,a_sta+dwa"]).answer();
    assert_eq!(refused.code, 2);
    assert!(refused.stderr.contains("did you mean `a_star+dwa`"), "{refused:?}");
}

#[test]
fn a_world_is_shown_without_a_drive() {
    let svg = svg_of("05_crossing", &["--world"]);
    let texts = texts(&svg);
    for words in ["start", "goal", "mover at first", "its track"] {
        assert!(texts.contains(&words), "{words}: {texts:?}");
    }
    assert!(!texts.iter().any(|words| words.starts_with("speed") || words.contains("plan")), "{texts:?}");
}

#[test]
fn the_ending_says_what_is_written() {
    let scratch = tempfile::tempdir().unwrap();
    for (file, begins) in
        [("a.svg", &b"<svg"[..]), ("a.PNG", b"\x89PNG\r\n"), ("a.pdf", b"%PDF-1."), ("film.gif", b"GIF89a")]
    {
        draw(scratch.path(), "01_empty", &["--width", "300", "-o", file]).ends_with(0);
        let bytes = fs::read(scratch.path().join(file)).unwrap();
        assert!(bytes.starts_with(begins), "{file}: {:?}", &bytes[..8]);
    }
    let answer = draw(scratch.path(), "01_empty", &["-o", "a.jpg"]).answer();
    assert_eq!(answer.code, 2);
    assert!(answer.stderr.contains(".svg, .png, .pdf or .gif"), "{answer:?}");
    assert!(!scratch.path().join("a.jpg").exists());
}

#[test]
fn an_image_has_the_size_that_was_asked_for() {
    let scratch = tempfile::tempdir().unwrap();
    draw(scratch.path(), "01_empty", &["--width", "400", "--scale", "3", "-o", "a.png"]).ends_with(0);
    let image = image::open(scratch.path().join("a.png")).unwrap();
    assert_eq!(image.width(), 1200);
}

#[test]
fn frames_are_numbered_and_of_one_size() {
    let scratch = tempfile::tempdir().unwrap();
    draw(scratch.path(), "05_crossing", &["--frames", "film", "--every", "1", "--width", "300"]).ends_with(0);
    let mut names: Vec<_> =
        fs::read_dir(scratch.path().join("film")).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    assert!(names.len() > 3 && names[0].ends_with("000000.png") && names[1].ends_with("000001.png"), "{names:?}");
    let size = |file: &Path| image::image_dimensions(file).unwrap();
    assert!(names.iter().all(|file| size(file) == size(&names[0])));
    assert!(!scratch.path().join("episode.svg").exists());
}
