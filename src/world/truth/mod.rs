//! The world while it runs: actuation, motion, sensing, and the judgement of contact and clearance.

mod bodies;
mod contact;
mod physics;
#[cfg(test)]
mod tests;
mod tick;

use super::Conditions;
use super::drive::Drivetrain;
use super::motion::{Course, Driver, Span};
use super::obstacles::moving::Mover;
use super::obstacles::unknown_static::UnknownStatic;
use super::scene::Scene;
use super::sense::{Perception, Surroundings};
use super::statics::Statics;
use crate::geometry::outline::SLACK_M;
use crate::geometry::{Pose, Twist, Vec2};
use crate::math;
use crate::observation::{Belief, Scan, SensedObstacle};
use crate::robot::Robot;
use crate::settings::quantity::Fraction;
use contact::{Sample, bound, first_contact, lowest};
use physics::Physics;
use tick::Tick;

use bodies::PerBody;
pub(super) use bodies::{Bodies, Body};

/// The robot counts as standing still while its centre and every point of its outline are slower than this, m/s. The outline of a
/// disc does not move where the disc turns on the spot.
const REST_SPEED_MPS: f64 = 0.02;

/// The smallest clearances of an episode by what the robot came near to, m: lower bounds, up to a millimetre below the truth;
/// infinity where there was nothing of the kind.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// To a mover.
    pub movers_m: f64,
    /// To an unknown static.
    pub unknown_m: f64,
}

impl Default for Closest {
    fn default() -> Self {
        Self { movers_m: f64::INFINITY, unknown_m: f64::INFINITY }
    }
}

/// Result of one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Footprint edge to the nearest obstacle at the end of the tick (or at the contact), m.
    pub clearance_m: f64,
    /// A lower bound of the clearance at every moment of the tick, m: never above the truth, and within a millimetre of
    /// it wherever it is the lowest of the episode so far.
    pub clearance_low_m: f64,
    /// The first contact, which ends the episode.
    pub contact: Option<Contact>,
}

/// A first contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    /// The kind of obstacle that the robot touched.
    pub with: ObstacleKind,
    /// Moment within the tick, s.
    pub time_s: f64,
    /// Whether the robot stood still: its centre below 0.02 m/s, and every point of its outline, wherever it was touched. Turning on
    /// the spot moves the corners of a polygon; the outline of a disc stays where it is.
    pub at_rest: bool,
    /// True pose at the contact, grid frame.
    pub pose: Pose,
}

/// The kind of obstacle that the robot touched.
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

/// The world of one scene: the truth. Its state is in f64, in the grid frame.
pub struct World<'s> {
    scene: &'s Scene,
    robot: &'s Robot,
    conditions: Conditions,
    clock: Clock,
    state: RobotState,
    goal: (Vec2, Option<f64>),
    perception: Perception,
    drivetrain: Drivetrain,
    movers: Movers,
    /// The scene's unknown statics, present or absent by the script.
    unknown: Vec<UnknownStatic>,
    gaps: Gaps,
    physics: Physics,
}

/// Progress of the episode.
#[derive(Clone, Copy, Debug)]
struct Clock {
    tick: u32,
    /// Duration of a tick, s.
    period_s: f64,
    /// Whether this tick's changes have been made.
    has_begun: bool,
    /// Number of events of the script that have happened.
    events: usize,
}

impl Clock {
    /// The time of this tick.
    fn span(&self) -> Span {
        Span { begin_s: f64::from(self.tick) * self.period_s, lasts_s: self.period_s }
    }
}

/// State of the robot: its pose and twists.
#[derive(Clone, Copy, Debug)]
struct RobotState {
    pose: Pose,
    /// Motion over ground during the last tick.
    twist: Twist,
}

/// The movers, one after the other in each list.
#[derive(Debug)]
struct Movers {
    states: Vec<Mover>,
    drivers: Vec<Driver>,
    /// Position of each mover at every moment of this tick.
    courses: Vec<Course>,
}

/// Gaps between the footprint and every body, m.
#[derive(Debug)]
struct Gaps {
    now_m: PerBody<f64>,
    /// Gaps at the beginning of the last tick.
    before_m: PerBody<f64>,
    /// The lowest gap of the episode so far.
    lowest_m: f64,
    /// The lowest gaps of the episode so far to movers and to unknown statics.
    closest: Closest,
}

impl Gaps {
    fn new(bodies: Bodies) -> Self {
        let gaps_m = PerBody::new(bodies, 0.0);
        Self { now_m: gaps_m.clone(), before_m: gaps_m, lowest_m: f64::INFINITY, closest: Closest::default() }
    }

    /// Makes the gaps at the end of the last tick those at the beginning of this one.
    fn advance(&mut self) {
        core::mem::swap(&mut self.now_m, &mut self.before_m);
    }
}

/// The number of `closest` that is about a body of this kind; the known map has none.
fn closest_to(closest: &mut Closest, body: Body) -> Option<&mut f64> {
    match body {
        Body::Map => None,
        Body::Unknown(_) => Some(&mut closest.unknown_m),
        Body::Mover(_) => Some(&mut closest.movers_m),
    }
}

fn smallest(gaps_m: &PerBody<f64>) -> f64 {
    gaps_m.iter().fold(f64::INFINITY, |best, (_, &gap)| math::min(best, gap))
}

impl core::fmt::Debug for World<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("World")
            .field("pose", &self.state.pose)
            .field("twist", &self.state.twist)
            .field("movers", &self.movers.states)
            .finish_non_exhaustive()
    }
}

impl<'s> World<'s> {
    /// The world of `scene` before the first tick.
    pub fn new(scene: &'s Scene, robot: &'s Robot, conditions: &Conditions) -> Self {
        let bodies = Bodies { unknown: scene.unknown_static.len(), movers: scene.movers.len() };
        let mut world = Self {
            scene,
            robot,
            conditions: conditions.clone(),
            clock: Clock { tick: 0, period_s: conditions.control_period_s.get(), has_begun: false, events: 0 },
            state: RobotState { pose: scene.start, twist: Twist::ZERO },
            goal: (scene.goal, scene.goal_heading_rad),
            perception: Perception::new(conditions, bodies, scene.start),
            drivetrain: Drivetrain::new(&conditions.actuation, conditions.seed),
            movers: Movers {
                states: scene.movers.clone(),
                drivers: scene.movers.iter().map(Driver::new).collect(),
                courses: scene.movers.iter().map(|mover| Course::standing(mover.position)).collect(),
            },
            unknown: scene.unknown_static.clone(),
            gaps: Gaps::new(bodies),
            physics: Physics::new(scene, robot),
        };
        world.begin_tick();
        let tick = Tick {
            statics: Statics { map: &scene.map, unknown: &world.unknown },
            movers: &world.movers.states,
            courses: &world.movers.courses,
            begin: world.state.pose,
            twist: Twist::ZERO,
            robot,
        };
        tick.measure(0.0, &mut world.gaps.now_m);
        world.gaps.lowest_m = smallest(&world.gaps.now_m);
        for (body, &gap_m) in world.gaps.now_m.iter() {
            if let Some(closest_m) = closest_to(&mut world.gaps.closest, body) {
                *closest_m = math::min(*closest_m, gap_m);
            }
        }
        world
    }

    /// Resets the world to its state before the first tick.
    pub fn reset(&mut self) {
        *self = Self::new(self.scene, self.robot, &self.conditions);
    }

    /// True pose of the robot, grid frame.
    pub fn pose(&self) -> Pose {
        self.state.pose
    }

    /// Pose that the robot believes to have at the beginning of this tick, grid frame.
    pub fn believed_pose(&self) -> Pose {
        self.perception.believed
    }

    /// True twist of the robot during the last tick: its motion over ground.
    pub fn twist(&self) -> Twist {
        self.state.twist
    }

    /// Twist of the robot's wheels during the last tick, which is its believed twist.
    pub fn odometry(&self) -> Twist {
        self.drivetrain.wheels
    }

    /// The goal in force, grid frame.
    pub fn goal(&self) -> Vec2 {
        self.goal.0
    }

    /// Heading that the robot is to have at the goal in force where it has to stand there, grid frame, rad.
    pub fn goal_heading_rad(&self) -> Option<f64> {
        self.goal.1
    }

    /// The scan at the beginning of this tick, after [`Self::sense`].
    pub fn scan(&self) -> Option<Scan<'_>> {
        self.perception.scan()
    }

    /// The movers that the robot sensed before and not the last time, where it sensed them last; each until it sees that it is no longer
    /// there.
    pub fn remembered(&self) -> &[SensedObstacle] {
        self.perception.remembered()
    }

    /// The movers as they are now, in the scene's order.
    pub fn movers(&self) -> &[Mover] {
        &self.movers.states
    }

    /// Footprint edge to the nearest obstacle now, m, exact.
    pub fn clearance_m(&self) -> f64 {
        smallest(&self.gaps.now_m)
    }

    /// How near the robot has come to movers and to unknown statics in the episode so far.
    pub fn closest(&self) -> Closest {
        self.gaps.closest
    }

    /// Whether the robot touches something now: at the beginning of an episode, by the script's doing.
    pub fn is_in_contact(&self) -> bool {
        self.clearance_m() < -SLACK_M
    }

    /// Number of unknown statics that the robot knows of by now.
    pub fn seen_statics(&self) -> u32 {
        self.perception.seen_statics()
    }

    /// Makes the changes with which this tick begins, once: the script's events, movers that turn, appear or
    /// vanish, the robot's believed pose.
    fn begin_tick(&mut self) {
        if core::mem::replace(&mut self.clock.has_begun, true) {
            return;
        }
        let (scene, span) = (self.scene, self.clock.span());
        while let Some(event) = scene.script.get(self.clock.events).filter(|event| event.is_due(span.begin_s)) {
            self.clock.events += 1;
            event.change.apply(self);
        }
        for number in 0..self.movers.states.len() {
            let mover = &mut self.movers.states[number];
            let was_present = mover.present;
            self.movers.drivers[number].begin(mover, span);
            if mover.present != was_present {
                self.note_presence(number);
            }
        }
        self.perception.believe(self.state.pose, self.clock.tick);
    }

    /// Makes an unknown static appear or vanish.
    pub(super) fn set_obstacle_presence(&mut self, number: usize, present: bool) {
        let obstacle = &mut self.unknown[number];
        obstacle.set_presence(present);
        self.physics.set_presence(number, present);
        self.gaps.now_m[Body::Unknown(number)] = obstacle.gap_m(&self.robot.body(self.state.pose));
    }

    /// Makes a mover appear or vanish.
    pub(super) fn set_mover_presence(&mut self, number: usize, present: bool) {
        self.movers.states[number].present = present;
        self.note_presence(number);
    }

    /// Updates the gaps after a mover has appeared or vanished.
    fn note_presence(&mut self, number: usize) {
        let mover = &self.movers.states[number];
        self.movers.courses[number] = Course::standing(mover.position);
        let footprint = self.robot.body(self.state.pose);
        let gap_m = if mover.present { mover.gap_m(mover.position, &footprint) } else { f64::INFINITY };
        self.gaps.now_m[Body::Mover(number)] = gap_m;
    }

    /// Stops a mover or lets it go on.
    pub(super) fn halt_mover(&mut self, number: usize, halted: bool) {
        self.movers.drivers[number].halted = halted;
    }

    /// Gives a mover another velocity, m/s, grid frame.
    pub(super) fn set_mover_velocity(&mut self, number: usize, velocity: Vec2) {
        self.movers.drivers[number].set_velocity(&mut self.movers.states[number], velocity);
    }

    /// Moves the goal, grid frame, m, and gives it a heading or none.
    pub(super) fn set_goal(&mut self, goal: Vec2, heading_rad: Option<f64>) {
        self.goal = (goal, heading_rad);
    }

    /// Sets the range of the sensor for obstacles, m.
    pub(super) fn set_sensor_range_m(&mut self, range_m: f64) {
        self.perception.set_range_m(range_m);
    }

    /// Sets the slip of the wheels.
    pub(super) fn set_wheel_slip(&mut self, left: [Fraction; 2], right: [Fraction; 2]) {
        self.drivetrain.set_slip(left, right);
    }

    /// Senses: writes the movers in range to `sensed` (the scene's order) and changes of the unknown statics to
    /// `belief`: it adds every cell touched by one at its perceived place, and frees the cells of one that is seen to be gone.
    ///
    /// [`SensingSpec`](super::SensingSpec) says which obstacles are perceived, and with what errors.
    pub fn sense(&mut self, belief: &mut Belief, sensed: &mut Vec<SensedObstacle>) {
        self.begin_tick();
        let statics = Statics { map: &self.scene.map, unknown: &self.unknown };
        let surroundings = Surroundings { statics, movers: &self.movers.states };
        self.perception.sense(&surroundings, self.state.pose, self.clock.tick, belief, sensed);
    }

    /// Drives one tick and judges it.
    ///
    /// # Panics
    /// If the command is not finite.
    pub fn step(&mut self, command: Twist) -> Step {
        assert!(command.v.is_finite() && command.omega.is_finite(), "the command is not finite: {command:?}");
        self.begin_tick();
        let span = self.clock.span();
        self.state.twist = self.drivetrain.drive(self.robot, command, self.clock.tick, span.lasts_s);
        let statics = Statics { map: &self.scene.map, unknown: &self.unknown };
        let Movers { states, drivers, courses } = &mut self.movers;
        for (number, ((mover, driver), course)) in states.iter().zip(drivers).zip(&mut *courses).enumerate() {
            let robot = (self.state.pose.position, self.gaps.now_m[Body::Mover(number)]);
            *course = driver.course(mover, &statics, robot, span);
        }
        let tick = Tick {
            statics,
            movers: states,
            courses,
            begin: self.state.pose,
            twist: self.state.twist,
            robot: self.robot,
        };
        self.gaps.advance();
        tick.measure(span.lasts_s, &mut self.gaps.now_m);
        let (end_s, touched) = self.gaps.first_contact(&tick, span.lasts_s);
        if touched.is_some() {
            tick.measure(end_s, &mut self.gaps.now_m);
        }
        let clearance_m = smallest(&self.gaps.now_m);
        let clearance_low_m = self.gaps.lowest(&tick, end_s);

        let pose = tick.pose(end_s);
        let contact = touched.map(|body| Contact {
            with: tick.kind(body, end_s),
            time_s: end_s,
            at_rest: tick.twist.v.abs() < REST_SPEED_MPS && tick.turning_mps() < REST_SPEED_MPS,
            pose,
        });
        self.state.pose = pose;
        for (mover, course) in states.iter_mut().zip(courses) {
            (mover.position, mover.velocity) = course.at(end_s);
        }
        self.physics.step(pose, states);
        self.clock.tick += 1;
        self.clock.has_begun = false;
        Step { clearance_m, clearance_low_m, contact }
    }

    /// Lets one tick pass as if the robot were not there: the script goes on, movers go their ways.
    pub fn pass(&mut self) {
        self.begin_tick();
        let span = self.clock.span();
        let statics = Statics { map: &self.scene.map, unknown: &self.unknown };
        let Movers { states, drivers, courses } = &mut self.movers;
        for ((mover, driver), course) in states.iter_mut().zip(drivers).zip(courses) {
            *course = driver.course(mover, &statics, (self.state.pose.position, f64::INFINITY), span);
            (mover.position, mover.velocity) = course.at(span.lasts_s);
        }
        self.clock.tick += 1;
        self.clock.has_begun = false;
    }
}

impl Gaps {
    /// Time and body of the robot's first contact in a tick of `lasts_s` seconds; the end of the tick and `None` without a
    /// contact. Ties go to the first body.
    fn first_contact(&self, tick: &Tick<'_>, lasts_s: f64) -> (f64, Option<Body>) {
        let (mut end_s, mut touched) = (lasts_s, None);
        for ((body, &before_m), (_, &now_m)) in self.before_m.iter().zip(self.now_m.iter()) {
            let from = Sample { time_s: 0.0, gap_m: before_m };
            let to = Sample { time_s: lasts_s, gap_m: now_m };
            if bound(tick.rate(body), from, to) >= 0.0 {
                continue;
            }
            if let Some(time_s) = first_contact(|time_s| tick.gap_m(body, time_s), tick.rate(body), end_s)
                && (touched.is_none() || time_s < end_s)
            {
                (end_s, touched) = (time_s, Some(body));
            }
        }
        (end_s, touched)
    }

    /// A lower bound of the clearance from the beginning of the tick to `end_s`, m; also updates the lowest ones of the episode.
    fn lowest(&mut self, tick: &Tick<'_>, end_s: f64) -> f64 {
        let mut low = smallest(&self.now_m);
        let mut seen = math::min(smallest(&self.before_m), low);
        for ((body, &before_m), (_, &now_m)) in self.before_m.iter().zip(self.now_m.iter()) {
            let from = Sample { time_s: 0.0, gap_m: before_m };
            let to = Sample { time_s: end_s, gap_m: now_m };
            let gap = |time_s| tick.gap_m(body, time_s);
            low = math::min(low, lowest(&gap, tick.rate(body), from, to, self.lowest_m, &mut seen));
            if let Some(closest_m) = closest_to(&mut self.closest, body) {
                let mut seen = math::min(before_m, now_m);
                let low = lowest(&gap, tick.rate(body), from, to, *closest_m, &mut seen);
                *closest_m = math::min(*closest_m, low);
            }
        }
        self.lowest_m = math::min(self.lowest_m, low);
        low
    }
}
