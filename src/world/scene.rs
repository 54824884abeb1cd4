//! A scene: everything about one episode's world before the first tick. Equal for all stacks.

use super::obstacle::{Mover, Shape, UnknownStatic};
use super::script::{Change, Event};
use super::spec::moving::{OnRobot, OnStatic};
use super::statics::{Digest, StaticMap, Statics};
use crate::geometry::{Path, Pose, Vec2};
use std::sync::Arc;

/// One episode's world before the first tick.
///
/// [`Scene::generate`](Self::generate) draws one from a specification; code may also put one together by hand.
#[derive(Clone, Debug)]
pub struct Scene {
    /// The known map.
    pub map: Arc<StaticMap>,
    /// Where the robot starts, grid frame.
    pub start: Pose,
    /// Where it is to go, grid frame.
    pub goal: Vec2,
    /// A way from start to goal on the known map that no planner has shaped; obstacles "on the route" are placed on it.
    /// None where nothing is placed by it.
    pub reference_route: Option<Path>,
    /// Obstacles that stand still and are not on the map.
    pub unknown_static: Vec<UnknownStatic>,
    /// Moving obstacles.
    pub movers: Vec<Mover>,
    /// What happens when, by tick.
    pub script: Vec<Event>,
}

impl Scene {
    /// A scene with nothing but a map, a start and a goal.
    pub fn new(map: &Arc<StaticMap>, start: Pose, goal: Vec2) -> Self {
        let (unknown_static, movers, script) = (Vec::new(), Vec::new(), Vec::new());
        Self { map: Arc::clone(map), start, goal, reference_route: None, unknown_static, movers, script }
    }

    /// Where the robot is to go during `tick`.
    pub fn goal_during(&self, tick: u32) -> Vec2 {
        let moved = self.script.iter().take_while(|event| event.tick <= tick).filter_map(|event| match event.change {
            Change::Goal(goal) => Some(goal),
            _ => None,
        });
        moved.last().unwrap_or(self.goal)
    }

    /// Whether goal and statics stay as they are, so that the shortest way is one for the whole episode.
    pub fn has_a_fixed_task(&self) -> bool {
        !self.script.iter().any(|event| event.change.moves_the_task())
    }

    /// The scene's fingerprint: equal exactly where all bits of map, start, goal and obstacles are
    /// (but for a chance of 2⁻⁶⁴).
    pub fn digest(&self) -> u64 {
        let mut digest = Digest::default();
        digest.word(self.map.digest());
        digest.point(self.start.position);
        digest.real(self.start.theta);
        digest.point(self.goal);
        digest.word(self.unknown_static.len() as u64);
        for obstacle in &self.unknown_static {
            digest.point(obstacle.pose().position);
            digest.real(obstacle.pose().theta);
            match obstacle.shape() {
                Shape::Disc { radius_m } => {
                    digest.word(0);
                    digest.real(*radius_m);
                }
                Shape::Rectangle { half_m } => {
                    digest.word(1);
                    digest.point(*half_m);
                }
                Shape::Polygon(polygon) => digest_of_corners(polygon.corners(), &mut digest),
            }
        }
        digest.word(self.movers.len() as u64);
        for mover in &self.movers {
            digest.point(mover.position);
            digest.point(mover.velocity);
            digest.real(mover.radius_m());
            if let Some(corners) = mover.outline.corners(Vec2::zeros()) {
                digest_of_corners(&corners, &mut digest);
            }
            digest.word(match mover.on_static {
                OnStatic::Reflect => 0,
                OnStatic::Pass => 1,
                OnStatic::Stop => 2,
            });
            digest.word(match mover.on_robot {
                OnRobot::Ignore => 0,
                OnRobot::Yield => 1,
            });
            digest.real(mover.yield_distance_m);
            mover.motion.digest(&mut digest);
        }
        for event in &self.script {
            event.digest(&mut digest);
        }
        digest.value()
    }

    /// Everything that stands still.
    pub(super) fn statics(&self) -> Statics<'_> {
        Statics { map: &self.map, unknown: &self.unknown_static }
    }
}

fn digest_of_corners(corners: &[Vec2], digest: &mut Digest) {
    digest.word(2);
    digest.word(corners.len() as u64);
    corners.iter().for_each(|&corner| digest.point(corner));
}

/// What the robot touched.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ObstacleKind {
    /// A cell of the known map.
    KnownStatic,
    /// An obstacle that stands still and is not on the map.
    UnknownStatic,
    /// A mover.
    Dynamic,
    /// The edge of the map.
    Boundary,
}

impl ObstacleKind {
    /// The name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::KnownStatic => "known_static",
            Self::UnknownStatic => "unknown_static",
            Self::Dynamic => "dynamic",
            Self::Boundary => "boundary",
        }
    }
}
