//! Perception: the believed pose, sensed obstacles and scanner ranges, with their noise and occlusion.

mod lidar;
mod localisation;
mod ray;
mod sensor;

use super::Conditions;
use super::obstacles::unknown_static::UnknownStatic;
use super::truth::{Bodies, Body};
use crate::geometry::convex::turned;
use crate::geometry::{Pose, Vec2, direction, wrap_angle};
use crate::observation::{Belief, Scan, SensedObstacle};
use lidar::Lidar;
use localisation::Localisation;
use sensor::Sensor;

pub use lidar::LidarSpec;
pub use localisation::LocalisationSpec;
pub use sensor::SensingSpec;
pub(super) use sensor::Surroundings;

/// Perception of the robot in one episode.
#[derive(Debug)]
pub(super) struct Perception {
    sensor: Sensor,
    lidar: Option<Lidar>,
    localisation: Localisation,
    /// Believed pose at the beginning of this tick.
    pub(super) believed: Pose,
    /// Each unknown static as the robot believes it, if it knows of it, and how many it knows.
    known: Vec<Option<UnknownStatic>>,
    known_count: u32,
    /// Each mover as it was sensed last, unless its place has been seen to be free since.
    last_seen: Vec<Option<LastSeen>>,
    remembered: Vec<SensedObstacle>,
}

/// A mover as it was sensed last.
#[derive(Clone, Debug)]
struct LastSeen {
    /// Where it was in truth, to look there again.
    position: Vec2,
    /// As the robot perceived it.
    perceived: SensedObstacle,
}

/// Map from the true place of an obstacle to the place where a robot with a wrong believed pose puts it.
#[derive(Clone, Copy)]
struct Placing {
    eye: Pose,
    believed: Pose,
    turn: f64,
    axis: Vec2,
}

impl Placing {
    fn new(eye: Pose, believed: Pose) -> Self {
        let turn = wrap_angle(believed.theta - eye.theta);
        Self { eye, believed, turn, axis: direction(turn) }
    }

    fn is_lost(&self) -> bool {
        self.believed != self.eye
    }

    fn direction(&self, d: Vec2) -> Vec2 {
        if self.is_lost() { turned(d, self.axis) } else { d }
    }

    fn point(&self, p: Vec2) -> Vec2 {
        if self.is_lost() { self.believed.position + self.direction(p - self.eye.position) } else { p }
    }
}

impl Perception {
    pub(super) fn new(conditions: &Conditions, bodies: Bodies, start: Pose) -> Self {
        let Conditions { seed, control_period_s, sensing, localisation, .. } = conditions;
        Self {
            sensor: Sensor::new(sensing, *seed, bodies),
            lidar: sensing.lidar.as_ref().map(|spec| Lidar::new(spec, *seed)),
            localisation: Localisation::new(localisation, *seed, control_period_s.get()),
            believed: start,
            known: vec![None; bodies.unknown],
            known_count: 0,
            last_seen: vec![None; bodies.movers],
            remembered: Vec::with_capacity(bodies.movers),
        }
    }

    pub(super) fn set_range_m(&mut self, range_m: f64) {
        self.sensor.set_range_m(range_m);
    }

    /// Updates the believed pose at `tick`, given the true pose. Must be called once a tick, in order.
    pub(super) fn believe(&mut self, pose: Pose, tick: u32) {
        self.believed = self.localisation.believe(pose, tick);
    }

    /// Number of unknown statics that the robot knows of by now.
    pub(super) fn seen_statics(&self) -> u32 {
        self.known_count
    }

    /// The movers that were sensed before and not the last time, where they were sensed last.
    pub(super) fn remembered(&self) -> &[SensedObstacle] {
        &self.remembered
    }

    /// The scan of the last time that the robot sensed.
    pub(super) fn scan(&self) -> Option<Scan<'_>> {
        self.lidar.as_ref().map(|lidar| {
            let (bearing_first_rad, bearing_step_rad) = lidar.bearings_rad();
            Scan { bearing_first_rad, bearing_step_rad, ranges_m: &lidar.ranges_m }
        })
    }

    /// Senses from the true pose `eye`; see [`World::sense`](super::World::sense).
    pub(super) fn sense(
        &mut self,
        scene: &Surroundings<'_>,
        eye: Pose,
        tick: u32,
        belief: &mut Belief,
        sensed: &mut Vec<SensedObstacle>,
    ) {
        let placing = Placing::new(eye, self.believed);
        self.sense_movers(scene, placing, tick, sensed);
        for number in 0..scene.statics.unknown.len() {
            self.sense_static(scene, placing, tick, number, belief);
        }
        if let Some(lidar) = &mut self.lidar {
            lidar.scan(scene, eye, tick);
        }
    }

    fn sense_movers(
        &mut self,
        scene: &Surroundings<'_>,
        placing: Placing,
        tick: u32,
        sensed: &mut Vec<SensedObstacle>,
    ) {
        let eye = placing.eye;
        sensed.clear();
        self.remembered.clear();
        for (number, mover) in scene.movers.iter().enumerate() {
            let mut look = |at: Vec2| {
                let gap_m = mover.outline.distance_m(at, eye.position);
                let nearest = || mover.outline.nearest_point(at, eye.position);
                self.sensor.look(scene, eye, tick, Body::Mover(number), gap_m, nearest)
            };
            let last_seen = &mut self.last_seen[number];
            if let Some(sighting) = mover.present.then(|| look(mover.position)).flatten() {
                let perceived = SensedObstacle {
                    id: number as u32,
                    position: placing.point(mover.position + sighting.offset),
                    velocity: placing.direction(mover.velocity + sighting.velocity_error),
                    outline: mover.outline.clone().with_axis(placing.direction(mover.outline.axis())),
                };
                *last_seen = Some(LastSeen { position: mover.position, perceived: perceived.clone() });
                sensed.push(perceived);
            } else if let Some(last) = last_seen {
                // Where it was, it would be seen now.
                if look(last.position).is_some() {
                    *last_seen = None;
                } else {
                    self.remembered.push(last.perceived.clone());
                }
            }
        }
    }

    /// Senses unknown static `number`: whether it is where the robot believes it to be, or gone.
    fn sense_static(
        &mut self,
        scene: &Surroundings<'_>,
        placing: Placing,
        tick: u32,
        number: usize,
        belief: &mut Belief,
    ) {
        let (eye, obstacle) = (placing.eye, &scene.statics.unknown[number]);
        if obstacle.is_present() == self.known[number].is_some() {
            return;
        }
        // One that is gone is looked for where it was.
        let there = obstacle.clone().with_presence(true);
        let gap_m = there.distance_m(eye.position);
        let nearest = || there.nearest_point(eye.position);
        let Some(sighting) = self.sensor.look(scene, eye, tick, Body::Unknown(number), gap_m, nearest) else { return };
        if let Some(gone) = self.known[number].take() {
            self.known_count -= 1;
            let others = &self.known;
            belief.remove(
                gone.bounds(),
                |square| gone.touches(square),
                |square| others.iter().flatten().any(|other| other.touches(square)),
            );
            return;
        }
        let perceived = if placing.is_lost() || sighting.offset != Vec2::zeros() {
            let position = placing.point(obstacle.pose().position + sighting.offset);
            let pose = Pose { position, theta: wrap_angle(obstacle.pose().theta + placing.turn) };
            UnknownStatic::new(pose, obstacle.shape().clone())
        } else {
            obstacle.clone()
        };
        belief.add(perceived.bounds(), |square| perceived.touches(square));
        self.known[number] = Some(perceived);
        self.known_count += 1;
    }
}
