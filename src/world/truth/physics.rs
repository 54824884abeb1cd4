//! The rapier side of the world: bodies that follow our poses.

use crate::geometry::outline::{Outline, Shape};
use crate::geometry::{Pose, Vec2, direction};
use crate::robot::Robot;
use crate::world::obstacles::moving::Mover;
use crate::world::scene::Scene;
use rapier2d::prelude::{
    ActiveCollisionTypes, BroadPhaseBvh, BvhOptimizationStrategy, ColliderBuilder, ColliderHandle, PhysicsWorld,
    Pose as RapierPose, RigidBodyBuilder, RigidBodyHandle, Rotation, SharedShape, Vector,
};

/// One collider for the known map, one for each unknown static, a kinematic body for the robot and for each mover.
pub(super) struct Physics {
    pub(super) world: PhysicsWorld,
    pub(super) robot: RigidBodyHandle,
    pub(super) movers: Vec<RigidBodyHandle>,
    unknown: Vec<ColliderHandle>,
}

impl Physics {
    pub(super) fn new(scene: &Scene, robot: &Robot) -> Self {
        // The tree is good enough as it was built: movers come back to where they were, and re-balancing it costs as
        // much as the rest of a step. Which pairs it finds does not depend on it.
        let broad_phase = BroadPhaseBvh::with_optimization_strategy(BvhOptimizationStrategy::None);
        let mut physics = PhysicsWorld { gravity: Vector::ZERO, broad_phase, ..PhysicsWorld::default() };
        // Without contact pairs: nobody would read them (they lag by a step), and they cost most of it.
        let inert = |shape: SharedShape| {
            ColliderBuilder::new(shape).density(0.0).active_collision_types(ActiveCollisionTypes::empty())
        };
        physics.insert_collider(inert(scene.map.shape().clone()), None);
        let mut unknown = Vec::with_capacity(scene.unknown_static.len());
        for obstacle in &scene.unknown_static {
            let collider = inert(rapier_shape(obstacle.shape()))
                .position(rapier_pose(obstacle.pose()))
                .enabled(obstacle.is_present());
            unknown.push(physics.insert_collider(collider, None));
        }
        let mut kinematic = |pose: RapierPose, shape: &Shape| {
            let body = RigidBodyBuilder::kinematic_position_based().pose(pose).can_sleep(false);
            physics.insert(body, inert(rapier_shape(shape))).0
        };
        let footprint = match &robot.footprint {
            None => Shape::Disc { radius_m: robot.radius_m },
            Some(polygon) => Shape::Polygon(polygon.clone()),
        };
        let robot = kinematic(rapier_pose(scene.start), &footprint);
        let mover = |mover: &Mover| kinematic(mover_pose(mover.position, &mover.outline), mover.outline.shape());
        let movers = scene.movers.iter().map(mover).collect();
        Self { world: physics, robot, movers, unknown }
    }

    /// Makes an unknown static appear or vanish.
    pub(super) fn set_presence(&mut self, number: usize, present: bool) {
        self.world.colliders[self.unknown[number]].set_enabled(present);
    }

    /// Moves every body to where it is at the end of the tick, and brings rapier's collision detection up to date.
    ///
    /// Its dynamics are left out: bodies that follow our poses have no forces to solve for, and looking for some takes
    /// as long as all the rest.
    pub(super) fn step(&mut self, robot: Pose, movers: &[Mover]) {
        self.world.bodies[self.robot].set_position(rapier_pose(robot), false);
        for (handle, mover) in self.movers.iter().zip(movers) {
            let body = &mut self.world.bodies[*handle];
            if body.is_enabled() != mover.present {
                body.set_enabled(mover.present);
            }
            body.set_position(mover_pose(mover.position, &mover.outline), false);
        }
        self.world.detect_collisions(&(), &());
    }
}

fn rapier_shape(shape: &Shape) -> SharedShape {
    match shape {
        Shape::Disc { radius_m } => SharedShape::ball(*radius_m as f32),
        Shape::Rectangle { half_m } => SharedShape::cuboid(half_m.x as f32, half_m.y as f32),
        Shape::Polygon(polygon) => {
            let corners: Vec<Vector> = polygon.corners().iter().map(|c| Vector::new(c.x as f32, c.y as f32)).collect();
            // A sliver that single precision takes for a line: the disc around it.
            SharedShape::convex_hull(&corners).unwrap_or_else(|| SharedShape::ball(polygon.circumradius_m() as f32))
        }
    }
}

fn mover_pose(position: Vec2, outline: &Outline) -> RapierPose {
    placed(position, outline.axis())
}

fn rapier_pose(pose: Pose) -> RapierPose {
    placed(pose.position, direction(pose.theta))
}

fn placed(position: Vec2, axis: Vec2) -> RapierPose {
    RapierPose {
        translation: Vector::new(position.x as f32, position.y as f32),
        rotation: Rotation { re: axis.x as f32, im: axis.y as f32 },
    }
}
