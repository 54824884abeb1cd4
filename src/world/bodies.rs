//! The rapier side of the world: bodies that follow our poses.

use super::DT_S;
use super::obstacle::{Mover, Shape};
use super::scene::Scene;
use crate::geometry::{Pose, Vec2};
use crate::math;
use rapier2d::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, BvhOptimizationStrategy, ColliderBuilder, ColliderHandle, PhysicsWorld,
    Pose as RapierPose, RigidBodyBuilder, RigidBodyHandle, Rotation, SharedShape, Vector,
};

/// One collider for the known map, one for each unknown static, a kinematic body for the robot and for each mover.
pub(super) struct Bodies {
    pub(super) physics: PhysicsWorld,
    pub(super) robot: RigidBodyHandle,
    pub(super) movers: Vec<RigidBodyHandle>,
    unknown: Vec<ColliderHandle>,
}

impl Bodies {
    pub(super) fn new(scene: &Scene, robot_radius_m: f64) -> Self {
        // The tree is good enough as it was built: movers come back to where they were, and re-balancing it costs as
        // much as the rest of a step. Which pairs it finds does not depend on it.
        let broad_phase = BroadPhaseBvh::with_optimization_strategy(BvhOptimizationStrategy::None);
        let mut physics = PhysicsWorld { gravity: Vector::ZERO, broad_phase, ..PhysicsWorld::default() };
        physics.integration_parameters.dt = DT_S as f32;
        // Without contact pairs: nobody would read them (they lag by a step), and they cost most of it.
        let inert = |shape: SharedShape| {
            ColliderBuilder::new(shape).density(0.0).active_collision_types(ActiveCollisionTypes::empty())
        };
        physics.insert_collider(inert(scene.map.shape().clone()), None);
        let mut unknown = Vec::with_capacity(scene.unknown_static.len());
        for obstacle in &scene.unknown_static {
            let shape = match obstacle.shape() {
                Shape::Disc { radius_m } => SharedShape::ball(radius_m as f32),
                Shape::Rectangle { half_m } => SharedShape::cuboid(half_m.x as f32, half_m.y as f32),
            };
            let collider = inert(shape).position(rapier_pose(obstacle.pose())).enabled(obstacle.is_present());
            unknown.push(physics.insert_collider(collider, None));
        }
        let mut kinematic = |pose: Pose, radius_m: f64| {
            let body = RigidBodyBuilder::kinematic_position_based().pose(rapier_pose(pose)).can_sleep(false);
            physics.insert(body, inert(SharedShape::ball(radius_m as f32))).0
        };
        let robot = kinematic(scene.start, robot_radius_m);
        let movers = scene.movers.iter().map(|mover| kinematic(mover_pose(mover.position), mover.radius_m)).collect();
        Self { physics, robot, movers, unknown }
    }

    /// An unknown static appears or vanishes.
    pub(super) fn set_presence(&mut self, number: usize, present: bool) {
        self.physics.colliders[self.unknown[number]].set_enabled(present);
    }

    /// Moves every body to where it is at the end of the tick.
    pub(super) fn step(&mut self, robot: Pose, movers: &[Mover]) {
        self.physics.bodies[self.robot].set_next_kinematic_position(rapier_pose(robot));
        for (handle, mover) in self.movers.iter().zip(movers) {
            let body = &mut self.physics.bodies[*handle];
            if body.is_enabled() != mover.present {
                body.set_enabled(mover.present);
            }
            body.set_next_kinematic_position(rapier_pose(mover_pose(mover.position)));
        }
        self.physics.step();
    }
}

fn mover_pose(position: Vec2) -> Pose {
    Pose { position, theta: 0.0 }
}

fn rapier_pose(pose: Pose) -> RapierPose {
    let (sin, cos) = math::sin_cos(pose.theta);
    RapierPose {
        translation: Vector::new(pose.position.x as f32, pose.position.y as f32),
        rotation: Rotation { re: cos as f32, im: sin as f32 },
    }
}
