//! Start and goal, given or drawn, and the free space in which they must be connected.

use super::free_space::FreeSpace;
use super::place::{GoalSpec, RandomPlace, StartSpec};
use super::spec::SceneSpec;
use super::{Infeasible, TRIES};
use crate::geometry::Vec2;
use crate::geometry::outline::SLACK_M;
use crate::math;
use crate::rng::{EpisodeSeed, Purpose, Stream};
use crate::robot::Robot;
use crate::settings::quantity::NonNegative;
use crate::world::obstacles::unknown_static::UnknownStatic;
use crate::world::statics::StaticMap;

/// Margin of the way from start to goal beyond the robot's radius, m.
const MARGIN_M: f64 = 0.05;

/// The cells on which a disc of the clearance fits, on the map with the given unknown statics.
///
/// The clearance is the robot's radius and [`MARGIN_M`]; if a given start or goal lies in a cell where that does not fit, or
/// no way as wide leads from a given start to a given goal, the footprint alone. A robot that starts and ends where it is told needs no room to turn there: its footprint then counts by
/// the inscribed radius. The cell of a given end counts as free even if only the given point, not its centre, is clear.
pub(super) fn free_space<'a>(
    spec: &SceneSpec,
    map: &'a StaticMap,
    statics: &[UnknownStatic],
    robot: &Robot,
) -> FreeSpace<'a> {
    let grid = &map.grid;
    let with_statics = |clearance_m: f64| {
        let mut space = FreeSpace::new(map, clearance_m);
        for obstacle in statics {
            let touched = space.touched(obstacle);
            space.add(&touched);
        }
        space
    };
    let given = [spec.start.given(grid).map(|(position, _)| position), spec.goal.given(grid)];
    let mut space = with_statics(robot.radius_m + MARGIN_M);
    let both = given.iter().all(Option::is_some);
    let cells = given.iter().flatten().map(|&p| grid.index(grid.cell_at(p)));
    let fits = cells.clone().all(|cell| space.passable()[cell]);
    let is_way = || {
        let parts = space.components();
        let mut labels = cells.clone().map(|cell| parts.labels()[cell]);
        labels.next().is_none_or(|first| labels.all(|label| label == first))
    };
    if !fits || both && !is_way() {
        space = with_statics(if both { robot.inscribed_radius_m() } else { robot.radius_m });
    }
    for p in given.into_iter().flatten() {
        space.admit(grid.cell_at(p));
    }
    space
}

/// Start and goal: given as they are, random ones uniform over the passable cell centres that are far enough from the
/// other end and connected with it.
pub(super) fn draw(spec: &SceneSpec, space: &FreeSpace<'_>, seed: EpisodeSeed) -> Result<(Vec2, Vec2), Infeasible> {
    let grid = space.grid();
    let (start, goal) = (spec.start.given(grid).map(|(position, _)| position), spec.goal.given(grid));
    let parts = space.components();
    let part = |p: Vec2| parts.labels()[grid.index(grid.cell_at(p))];
    let diagonal = grid.extent_m().norm();
    let distance_min =
        |place: &RandomPlace, share: f64| place.distance_min_m.map_or(share * diagonal, NonNegative::get);
    // Labels are 0 where nothing fits.
    let candidates = || parts.labels().iter().enumerate().filter(|&(_, &label)| label != 0).map(|(index, _)| index);
    // Each end has a stream of its own, so that giving one leaves the draws of the other.
    let mut start_stream = seed.stream(Purpose::StartGoal, 0);
    let mut goal_stream = seed.stream(Purpose::StartGoal, 1);
    let far_from = |other: Vec2, distance: f64, stream: &mut Stream| {
        let connected = part(other);
        let far = || {
            candidates().filter(|&index| {
                parts.labels()[index] == connected
                    && (grid.centre(grid.cell(index)) - other).norm() >= distance - SLACK_M
            })
        };
        drawn(far, stream).map(|index| grid.centre(grid.cell(index)))
    };
    match (start, goal, &spec.start, &spec.goal) {
        (Some(start), Some(goal), ..) => {
            if part(start) == 0 || part(start) != part(goal) {
                return Err(Infeasible::new("start and goal are not connected for the robot"));
            }
            Ok((start, goal))
        }
        (Some(start), None, _, GoalSpec::Random(place)) => far_from(start, distance_min(place, 0.25), &mut goal_stream)
            .map(|goal| (start, goal))
            .ok_or_else(|| Infeasible::new("no free cell is connected with the start and far enough from it")),
        (None, Some(goal), StartSpec::Random(place), _) => far_from(goal, distance_min(place, 0.25), &mut start_stream)
            .map(|start| (start, goal))
            .ok_or_else(|| Infeasible::new("no free cell is connected with the goal and far enough from it")),
        (None, None, StartSpec::Random(from), GoalSpec::Random(to)) if !parts.sizes().is_empty() => {
            let distance = math::max(distance_min(from, 0.5), distance_min(to, 0.5));
            for _ in 0..TRIES {
                let start = drawn(candidates, &mut start_stream).expect("there is one");
                let start = grid.centre(grid.cell(start));
                if let Some(goal) = far_from(start, distance, &mut goal_stream) {
                    return Ok((start, goal));
                }
            }
            Err(Infeasible::new(format!("no connected start and goal at least {distance:.3} m apart in {TRIES} draws")))
        }
        _ => Err(Infeasible::new("no free cell for start and goal")),
    }
}

/// One of the items, each with the same probability; `None` without items.
fn drawn<I: Iterator<Item = usize>>(items: impl Fn() -> I, stream: &mut Stream) -> Option<usize> {
    let count = items().count();
    if count > 0 { items().nth(stream.index(count)) } else { None }
}
