//! Fingerprints: of maps, motions, events and whole scenes.

use super::Scene;
use crate::geometry::Vec2;
use crate::geometry::outline::Shape;
use crate::world::obstacles::moving::{OnRobot, OnStatic};

pub(in crate::world) use crate::digest::Fnv1a as Digest;

impl Scene {
    /// The scene's fingerprint: two scenes have the same one exactly if all bits of map, start, goal and obstacles are equal
    /// (but for a chance of 2⁻⁶⁴).
    pub fn digest(&self) -> u64 {
        let mut digest = Digest::default();
        digest.word(self.map.digest());
        digest.point(self.start.position);
        digest.real(self.start.theta);
        digest.point(self.goal);
        // A goal without a heading adds nothing, so that such scenes keep their fingerprint.
        if let Some(heading_rad) = self.goal_heading_rad {
            digest.words([u64::MAX, heading_rad.to_bits()]);
        }
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
                OnStatic::TurnBack => 3,
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
}

fn digest_of_corners(corners: &[Vec2], digest: &mut Digest) {
    digest.word(2);
    digest.word(corners.len() as u64);
    corners.iter().for_each(|&corner| digest.point(corner));
}
