//! Inputs and answers of planners as bytes: for planners in other processes, other languages, and files.
//!
//! The format is that of postcard; floats are kept bit for bit. A value read back equals the value written, and a planner
//! gives the same answer to both.

use super::contract::{
    Arrival, Budget, Decision, Entry, Guidance, Notes, Randomness, Request, Situation, State, StateKind,
};
use crate::geometry::{KeyNode, Path, Pose, Twist, Vec2};
use crate::observation::{Belief, Scan, SensedObstacle};
use crate::robot::Robot;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// Reason why bytes cannot be read as a value.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BytesError {
    /// The bytes do not encode a value of the expected type.
    #[error("the bytes cannot be read: {0}")]
    Unreadable(String),
    /// A decision in a state that the planner does not declare.
    #[error("the planner declares no state `{0}`")]
    UnknownState(String),
}

/// A value as bytes.
///
/// # Panics
/// If the value cannot be written, which does not happen for the types of this crate.
pub fn to_bytes<T: Serialize>(value: &T) -> Vec<u8> {
    postcard::to_stdvec(value).expect("plain values can be written")
}

/// A value from its bytes.
///
/// # Errors
/// If the bytes do not encode a value of this type, or some bytes are left over.
pub fn from_bytes<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, BytesError> {
    let unreadable = |what: String| BytesError::Unreadable(what);
    match postcard::take_from_bytes(bytes).map_err(|error| unreadable(error.to_string()))? {
        (value, []) => Ok(value),
        (_, rest) => Err(unreadable(format!("{} bytes are left over", rest.len()))),
    }
}

/// A [`Situation`] that owns its data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SituationSnapshot {
    tick: u32,
    dt_s: f64,
    pose: Pose,
    twist: Twist,
    robot: Robot,
    belief: Belief,
    obstacles: Vec<SensedObstacle>,
    remembered: Vec<SensedObstacle>,
    /// Bearing of the first ray, step between two, ranges.
    scan: Option<(f64, f64, Vec<f64>)>,
    goal: Vec2,
    arrival: Arrival,
    random: Randomness,
    budget: Budget,
}

impl From<&Situation<'_>> for SituationSnapshot {
    fn from(situation: &Situation<'_>) -> Self {
        let Situation {
            tick,
            dt_s,
            pose,
            twist,
            robot,
            belief,
            obstacles,
            remembered,
            scan,
            goal,
            arrival,
            random,
            budget,
        } = *situation;
        Self {
            tick,
            dt_s,
            pose,
            twist,
            robot: robot.clone(),
            belief: belief.clone(),
            obstacles: obstacles.to_vec(),
            remembered: remembered.to_vec(),
            scan: scan.map(|scan| (scan.bearing_first_rad, scan.bearing_step_rad, scan.ranges_m.to_vec())),
            goal,
            arrival,
            random,
            budget,
        }
    }
}

impl SituationSnapshot {
    /// The situation, borrowed from this one.
    pub fn situation(&self) -> Situation<'_> {
        let Self { tick, dt_s, pose, twist, robot, belief, obstacles, remembered, scan, goal, arrival, random, budget } =
            self;
        let scan = scan.as_ref().map(|(bearing_first_rad, bearing_step_rad, ranges_m)| Scan {
            bearing_first_rad: *bearing_first_rad,
            bearing_step_rad: *bearing_step_rad,
            ranges_m,
        });
        Situation {
            tick: *tick,
            dt_s: *dt_s,
            pose: *pose,
            twist: *twist,
            robot,
            belief,
            obstacles,
            remembered,
            scan,
            goal: *goal,
            arrival: *arrival,
            random: *random,
            budget: *budget,
        }
    }
}

/// A [`Guidance`] that owns its data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct GuidanceSnapshot {
    path: Path,
    progress_m: f64,
    previous_node: Vec2,
    sub_goal: Vec2,
    is_last: bool,
    path_revision: u32,
    key_nodes: Vec<KeyNode>,
    next_key_node: usize,
}

impl From<&Guidance<'_>> for GuidanceSnapshot {
    fn from(guidance: &Guidance<'_>) -> Self {
        let Guidance { path, progress_m, previous_node, sub_goal, is_last, path_revision, key_nodes, next_key_node } =
            *guidance;
        let (path, key_nodes) = (path.clone(), key_nodes.to_vec());
        Self { path, progress_m, previous_node, sub_goal, is_last, path_revision, key_nodes, next_key_node }
    }
}

impl GuidanceSnapshot {
    /// The guidance, borrowed from this one.
    pub fn guidance(&self) -> Guidance<'_> {
        let Self { path, progress_m, previous_node, sub_goal, is_last, path_revision, key_nodes, next_key_node } = self;
        Guidance {
            path,
            progress_m: *progress_m,
            previous_node: *previous_node,
            sub_goal: *sub_goal,
            is_last: *is_last,
            path_revision: *path_revision,
            key_nodes,
            next_key_node: *next_key_node,
        }
    }
}

/// A [`Decision`] in a form that can be read back: its state by name.
#[derive(Serialize, Deserialize)]
struct DecisionBytes {
    command: Twist,
    state: String,
    kind: StateKind,
    rollouts: u64,
    rollout_points: u64,
    notes: Vec<f64>,
    request: Option<Request>,
}

impl Decision {
    /// The decision as bytes.
    pub fn to_bytes(&self) -> Vec<u8> {
        let Self { command, state: State { name, kind }, rollouts, rollout_points, notes, request } = *self;
        let (state, notes) = (name.to_owned(), notes.values().to_vec());
        to_bytes(&DecisionBytes { command, state, kind, rollouts, rollout_points, notes, request })
    }

    /// A decision of a planner with this `entry` from its bytes.
    ///
    /// # Errors
    /// If the bytes are not those of a decision, or its state is not declared.
    pub fn from_bytes(bytes: &[u8], entry: &Entry) -> Result<Self, BytesError> {
        let DecisionBytes { command, state, kind, rollouts, rollout_points, notes, request } = from_bytes(bytes)?;
        if notes.len() > Notes::COUNT_MAX {
            return Err(BytesError::Unreadable(format!("{} notes are too many", notes.len())));
        }
        let known = entry.states.iter().find(|known| known.name == state && known.kind == kind);
        let state = *known.ok_or(BytesError::UnknownState(state))?;
        Ok(Self { command, state, rollouts, rollout_points, notes: Notes::new(&notes), request })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::curve::Curve;
    use crate::geometry::outline::{Outline, Shape};
    use crate::geometry::{Piece, Rect};
    use crate::map::{Frame, OccupancyGrid};
    use crate::plan::grid::tests::{random_cell, random_map, stream};
    use crate::plan::local::LocalChoice;

    fn v(x: f64, y: f64) -> Vec2 {
        Vec2::new(x, y)
    }

    fn path() -> Path {
        let curve = Curve::bezier([v(3.0, 1.0), v(3.0, 2.0), v(4.0, 3.0), v(5.0, 3.0)]);
        let arc = Piece::Arc { to: v(3.0, 1.0), centre: v(2.0, 1.0), sweep: crate::math::FRAC_PI_2 };
        Path::new(v(0.1, -0.0), vec![Piece::Line { to: v(2.0, 0.0) }, arc, Piece::Curve(Box::new(curve))])
            .with_times(vec![0.1, 0.2, 1.0 / 3.0])
            .with_key_nodes(&[v(0.1, 0.0), v(2.7, 0.4), v(5.0, 3.0)])
    }

    /// A belief that has learnt and unlearnt obstacles.
    fn belief() -> Belief {
        let mut stream = stream(51);
        let map = random_map(&mut stream, 40, 0.2).with_frame(Frame { origin: Pose::new(3.0, -2.0, 0.3) });
        let mut belief = Belief::from(&map);
        for _ in 0..4 {
            let square = map.square(random_cell(&mut stream, &map));
            let bounds = Rect { min: square.min - v(1.5, 1.5), max: square.max + v(1.5, 1.5) };
            belief.add(bounds, |_| true);
            if stream.uniform() < 0.5 {
                belief.remove(square, |_| true, |_| false);
            }
        }
        belief
    }

    #[test]
    fn a_path_comes_back_bit_for_bit() {
        let read: Path = from_bytes(&to_bytes(&path())).unwrap();
        assert_eq!(read, path());
        assert_eq!(read.start().y.to_bits(), (-0.0f64).to_bits());
    }

    #[test]
    fn a_belief_comes_back_with_the_same_field() {
        let belief = belief();
        assert!(belief.revision() > 0 && !belief.added().is_empty());
        let read: Belief = from_bytes(&to_bytes(&belief)).unwrap();
        assert_eq!(read, belief);
        assert_eq!(read.field().squares(), belief.field().squares());
        assert_eq!(read.grid().frame(), belief.grid().frame());
        let untouched = Belief::from(&OccupancyGrid::empty(7, 3, 0.5));
        assert_eq!(from_bytes::<Belief>(&to_bytes(&untouched)).unwrap(), untouched);
    }

    #[test]
    fn a_situation_comes_back_and_gets_the_same_answers() {
        let (belief, path) = (belief(), path());
        let corners = [v(0.5, 0.3), v(-0.4, 0.3), v(-0.4, -0.3), v(0.5, -0.3)];
        let footprint = crate::geometry::convex::Polygon::new(&corners).unwrap();
        let obstacles = [
            SensedObstacle::disc(4, v(3.0, 1.0), v(-0.1, 0.3), 0.25),
            SensedObstacle {
                outline: Outline::new(Shape::Polygon(footprint.clone()), 0.7),
                ..SensedObstacle::disc(9, v(1.0, 4.0), v(0.0, 0.0), 1.0)
            },
        ];
        let robot = Robot { footprint: Some(footprint), radius_m: 0.6, ..Robot::default() };
        let ranges_m = [1.5, f64::INFINITY, 0.25];
        let situation = Situation {
            tick: 17,
            twist: Twist { v: 0.4, omega: -0.2 },
            obstacles: &obstacles,
            remembered: &obstacles[1..],
            scan: Some(Scan { bearing_first_rad: -1.0, bearing_step_rad: 1.0, ranges_m: &ranges_m }),
            random: Randomness::new(crate::rng::EpisodeSeed { seed: 3, episode: 8 }, 17),
            budget: Budget { expansions: 5, rollout_points: u64::MAX },
            ..Situation::new(&robot, &belief, Pose::new(1.0, 1.0, 0.3), v(5.0, 3.0))
        };
        let written = SituationSnapshot::from(&situation);
        let read: SituationSnapshot = from_bytes(&to_bytes(&written)).unwrap();
        assert_eq!(read, written);

        let mut key_nodes = Vec::new();
        path.key_nodes(&mut key_nodes);
        let guidance = Guidance {
            path: &path,
            progress_m: 0.5,
            previous_node: v(0.1, 0.0),
            sub_goal: v(3.0, 1.0),
            is_last: false,
            path_revision: 2,
            key_nodes: &key_nodes,
            next_key_node: 1,
        };
        let read_guidance: GuidanceSnapshot = from_bytes(&to_bytes(&GuidanceSnapshot::from(&guidance))).unwrap();
        for &name in LocalChoice::NAMES {
            let planner = || LocalChoice::by_name(name).unwrap().build();
            let answer = planner().decide(&situation, &guidance).unwrap();
            assert_eq!(planner().decide(&read.situation(), &read_guidance.guidance()).unwrap(), answer, "{name}");
            assert_eq!(Decision::from_bytes(&answer.to_bytes(), planner().entry()).unwrap(), answer);
        }
        assert_eq!(read.situation().random.stream(), situation.random.stream());
    }

    #[test]
    fn a_decision_comes_back_if_its_state_is_declared() {
        const HOLD: State = State { name: "hold", kind: StateKind::Waiting };
        let entry = Entry { states: &[State::TRACK, HOLD], ..Entry::PLAIN };
        let decision = Decision {
            state: HOLD,
            rollouts: 3,
            rollout_points: 90,
            notes: Notes::new(&[1.5, -0.0]),
            request: Some(Request::GoBack { to_m: 4.5 }),
            ..Decision::track(Twist { v: 0.1, omega: 2.0 / 3.0 })
        };
        assert_eq!(Decision::from_bytes(&decision.to_bytes(), &entry), Ok(decision));
        let unknown = Decision::from_bytes(&decision.to_bytes(), &Entry { states: &[State::TRACK], ..entry });
        assert_eq!(unknown, Err(BytesError::UnknownState("hold".to_owned())));
    }

    #[test]
    fn damaged_bytes_are_refused() {
        let bytes = to_bytes(&path());
        assert!((0..bytes.len()).all(|end| from_bytes::<Path>(&bytes[..end]).is_err()));
        let mut longer = bytes;
        longer.push(0);
        assert!(
            matches!(from_bytes::<Path>(&longer), Err(BytesError::Unreadable(what)) if what.contains("1 bytes are left"))
        );
    }
}
