//! Checks of the fixed parts of a specification, which drawing again cannot help: given places and ranges.

use super::super::statics::{StaticMap, Statics};
use crate::geometry::outline::{Body, SLACK_M};
use crate::geometry::{Pose, Vec2};
use crate::robot::Robot;

/// A fixed part of the specification is impossible; drawing again cannot help.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key}: {message}")]
pub struct SceneError {
    /// The key relative to the scenario's root, such as `start` or `obstacles.moving[2].fixed.position`.
    pub key: String,
    /// The fault, with cell, position and the obstacle in the way.
    pub message: String,
}

impl SceneError {
    pub(in crate::world) fn new(key: impl Into<String>, message: impl Into<String>) -> Self {
        Self { key: key.into(), message: message.into() }
    }
}

/// Checks that a range [lowest, highest] is in order.
pub(in crate::world) fn check_range(key: &str, [low, high]: [f64; 2]) -> Result<(), SceneError> {
    if low <= high {
        return Ok(());
    }
    Err(SceneError::new(key, format!("expected [lowest, highest], found [{low}, {high}]")))
}

/// Checks that `p` (grid frame) lies on the map.
pub(in crate::world) fn check_inside(key: &str, p: Vec2, map: &StaticMap) -> Result<(), SceneError> {
    if map.edge_distance_m(p) >= 0.0 {
        return Ok(());
    }
    let (cols, rows) = (map.grid.cols(), map.grid.rows());
    Err(SceneError::new(key, at(p, map, &format!("lies outside the map of {cols} by {rows} cells"))))
}

/// Checks that the footprint fits at `p` (grid frame) with the heading `theta`, or with any heading if none is given.
pub(in crate::world) fn check_fits(
    key: &str,
    p: Vec2,
    theta: Option<f64>,
    robot: &Robot,
    statics: &Statics<'_>,
) -> Result<(), SceneError> {
    let map = statics.map;
    check_inside(key, p, map)?;
    let body = match theta {
        Some(theta) => robot.body(Pose { position: p, theta }),
        None => Body { position: p, radius_m: robot.inscribed_radius_m(), corners: None },
    };
    let unknown = statics.unknown.iter().enumerate();
    let unknown = unknown.map(|(index, obstacle)| {
        (format!("unknown static number {index} given in the scenario"), obstacle.gap_m(&body), obstacle.distance_m(p))
    });
    let known = ("a known obstacle".to_owned(), map.obstacle_gap_m(&body), map.obstacle_distance_m(p, f64::INFINITY));
    let edge = ("the map's edge".to_owned(), map.edge_gap_m(&body), map.edge_distance_m(p));
    match [known, edge].into_iter().chain(unknown).find(|&(_, gap_m, _)| gap_m < -SLACK_M) {
        None => Ok(()),
        Some((what, _, distance_m)) if distance_m <= 0.0 => {
            Err(SceneError::new(key, at(p, map, &format!("lies inside {what}"))))
        }
        Some((what, gap_m, distance_m)) => {
            let room = match body.corners {
                None => format!("(radius {} m): {distance_m:.3} m to {what}", body.radius_m),
                Some(_) => format!("with that heading: its footprint overlaps {what} by {:.3} m", -gap_m),
            };
            Err(SceneError::new(key, at(p, map, &format!("leaves no room for the robot {room}"))))
        }
    }
}

/// What the message says of a place inside an obstacle of the known map.
pub const INSIDE_KNOWN: &str = "lies inside a known obstacle";

/// The place `p` (grid frame) in words, followed by `what`.
pub(in crate::world) fn at(p: Vec2, map: &StaticMap, what: &str) -> String {
    let cell = map.grid.cell_at(p);
    let world = map.grid.frame().point_to_world(p);
    format!("at [{:.3}, {:.3}], in cell [{}, {}], {what}", world.x, world.y, cell.col, cell.row)
}
