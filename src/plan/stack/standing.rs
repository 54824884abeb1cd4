//! Movers that stand, on the map on which paths are planned.
//!
//! A mover stands if it has come no farther than `standing_mps` · `standing_after_s` within `standing_after_s`. Its place counts and
//! not its velocity: with a noisy sensor the place, smoothed over a quarter of that time, says more. It stands until it has gone
//! farther than that, or its place is seen to be free.
//!
//! The cells that it touches are occupied in a copy of the belief that only global planners, path stages and the look-ahead of the
//! sub-goal see. The belief itself stays as it is: local planners sense the mover and go by its exact outline, for which a
//! coarse map has no room.

use super::PlanningSpec;
use crate::geometry::Vec2;
use crate::observation::{Belief, SensedObstacle};
use crate::plan::contract::Situation;

/// Share of `standing_after_s` over which places are smoothed.
const SMOOTHED_SHARE: f64 = 0.25;

/// The movers that stand, as far as the robot has seen.
#[derive(Debug, Default)]
pub(super) struct Standing {
    tracks: Vec<Track>,
    /// The belief with the marks; a buffer that is used again.
    belief: Option<Belief>,
    /// Counts the changes of the marks.
    pub(super) revision: u64,
}

/// What is known of one mover.
#[derive(Debug)]
struct Track {
    id: u32,
    /// Its smoothed place, and the tick at which it was seen last.
    place: Vec2,
    seen_tick: u32,
    /// Place and tick from which its way is measured.
    since: (Vec2, u32),
    /// How it stands, if it does.
    mark: Option<SensedObstacle>,
}

impl Standing {
    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.tracks.clear();
        self.revision = 0;
    }

    /// Takes in what is sensed at this tick.
    pub(super) fn observe(&mut self, situation: &Situation<'_>, planning: &PlanningSpec) {
        let (speed_mps, after_s) = (planning.standing_mps.get(), planning.standing_after_s.get());
        if speed_mps == 0.0 {
            return;
        }
        let radius_m = speed_mps * after_s;
        for seen in situation.obstacles {
            let index = self.tracks.iter().position(|track| track.id == seen.id).unwrap_or_else(|| {
                let since = (seen.position, situation.tick);
                let (id, place, seen_tick) = (seen.id, seen.position, situation.tick);
                self.tracks.push(Track { id, place, seen_tick, since, mark: None });
                self.tracks.len() - 1
            });
            let track = &mut self.tracks[index];
            let unseen_s = situation.time_since_s(track.seen_tick);
            let share = unseen_s / (SMOOTHED_SHARE * after_s + unseen_s);
            // After a time out of sight what was known before says nothing.
            track.place =
                if unseen_s > after_s { seen.position } else { track.place + share * (seen.position - track.place) };
            track.seen_tick = situation.tick;
            if (track.place - track.since.0).norm() > radius_m {
                track.since = (track.place, situation.tick);
                self.revision += u64::from(track.mark.take().is_some());
            } else if situation.time_since_s(track.since.1) >= after_s - 1e-9 {
                track.since = (track.place, situation.tick);
                // A mark is not moved by the noise of its mover's place.
                if track.mark.as_ref().is_none_or(|mark| (mark.position - track.place).norm() > 0.5 * radius_m) {
                    track.mark = Some(SensedObstacle { position: track.place, ..seen.clone() });
                    self.revision += 1;
                }
            }
        }
        let is_known = |id: u32| situation.obstacles.iter().chain(situation.remembered).any(|seen| seen.id == id);
        let revision = &mut self.revision;
        self.tracks.retain(|track| {
            let stays = is_known(track.id);
            *revision += u64::from(!stays && track.mark.is_some());
            stays
        });
    }

    /// Whether any mover stands.
    pub(super) fn is_any(&self) -> bool {
        self.tracks.iter().any(|track| track.mark.is_some())
    }

    /// The map on which to plan. The cells of the robot and of the goal stay as they are believed: the robot is where it is, and
    /// whether there is room at the goal is seen there.
    pub(super) fn belief<'a>(&'a mut self, situation: &Situation<'a>) -> &'a Belief {
        if !self.is_any() {
            return situation.belief;
        }
        let belief = self.belief.get_or_insert_with(|| situation.belief.clone());
        belief.copy_from(situation.belief);
        let ends = [situation.pose.position, situation.goal];
        for mark in self.tracks.iter().filter_map(|track| track.mark.as_ref()) {
            let bounds = mark.outline.bounds(mark.position);
            belief.add(bounds, |square| {
                mark.outline.touches(mark.position, square) && !ends.iter().any(|&end| square.contains(end))
            });
        }
        belief
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Pose;
    use crate::map::{Cell, DistanceField, OccupancyGrid};
    use crate::rng::{EpisodeSeed, Purpose};
    use crate::robot::Robot;
    use crate::settings::quantity::NonNegative;

    /// Whether a mover of radius 0.4 m stands, tick by tick; `place` is where it is sensed, `None` where it is not.
    fn stands(place: impl Fn(u32) -> Option<Vec2>, ticks: u32, planning: &PlanningSpec) -> Vec<bool> {
        let (robot, belief) = (Robot::default(), Belief::from(&OccupancyGrid::empty(20, 10, 1.0)));
        let mut standing = Standing::default();
        let mut seen = None;
        let tick = |tick: u32| {
            let obstacles: Vec<_> =
                place(tick).map(|place| SensedObstacle::disc(7, place, Vec2::zeros(), 0.4)).into_iter().collect();
            seen = obstacles.first().cloned().or_else(|| seen.take());
            let remembered: Vec<_> = if obstacles.is_empty() { seen.clone() } else { None }.into_iter().collect();
            let start = Situation::new(&robot, &belief, Pose::new(1.5, 5.5, 0.0), Vec2::new(18.5, 5.5));
            let situation = Situation { tick, obstacles: &obstacles, remembered: &remembered, ..start };
            standing.observe(&situation, planning);
            standing.is_any()
        };
        (0..ticks).map(tick).collect()
    }

    fn first(stands: &[bool], wanted: bool, from: usize) -> Option<usize> {
        stands[from..].iter().position(|&is| is == wanted).map(|at| from + at)
    }

    #[test]
    fn a_mover_stands_after_two_seconds_and_until_it_goes() {
        let planning = PlanningSpec::default();
        // It comes at 1 m/s, stands from tick 30 on, and leaves at tick 100.
        let x = |tick: u32| 3.0 + 0.1 * f64::from(tick.min(30)) + 0.1 * f64::from(tick.max(100) - 100);
        let found = stands(|tick| Some(Vec2::new(x(tick), 5.0)), 160, &planning);
        let begins = first(&found, true, 0).unwrap();
        assert!((50..=75).contains(&begins), "{begins}");
        let ends = first(&found, false, begins).unwrap();
        assert!((101..=106).contains(&ends) && first(&found, true, ends).is_none(), "{ends}");
        // One that creeps at 0.04 m/s stands, one at 0.06 m/s does not.
        let creeps =
            |speed: f64| stands(|tick| Some(Vec2::new(3.0 + 0.1 * speed * f64::from(tick), 5.0)), 200, &planning);
        assert!(creeps(0.04)[25..].iter().all(|&is| is));
        assert!(creeps(0.06)[40..].iter().all(|&is| !is));
        let never = PlanningSpec { standing_mps: NonNegative::new(0.0), ..planning };
        assert!(stands(|_| Some(Vec2::new(3.0, 5.0)), 100, &never).iter().all(|&is| !is));
    }

    #[test]
    fn noise_of_the_sensor_neither_hides_a_stand_nor_makes_one() {
        let mut stream = EpisodeSeed { seed: 4, episode: 0 }.stream(Purpose::Sensor, 0);
        let noise: Vec<Vec2> = (0..600).map(|_| 0.05 * Vec2::new(stream.normal(), stream.normal())).collect();
        let planning = PlanningSpec::default();
        let still = stands(|tick| Some(Vec2::new(5.0, 5.0) + noise[tick as usize]), 600, &planning);
        assert!(still[100..].iter().all(|&is| is), "{:?}", first(&still, false, 100));
        let walks = stands(|tick| Some(Vec2::new(0.03 * f64::from(tick), 5.0) + noise[tick as usize]), 600, &planning);
        assert!(walks.iter().all(|&is| !is));
    }

    #[test]
    fn out_of_sight_it_is_remembered_and_seen_to_be_gone_it_is_forgotten() {
        let (robot, known) = (Robot::default(), Belief::from(&OccupancyGrid::empty(20, 10, 1.0)));
        let mover = [SensedObstacle::disc(7, Vec2::new(5.5, 5.5), Vec2::zeros(), 0.4)];
        let planning = PlanningSpec::default();
        let mut standing = Standing::default();
        let at = |tick: u32, obstacles, remembered| Situation {
            tick,
            obstacles,
            remembered,
            ..Situation::new(&robot, &known, Pose::new(1.5, 5.5, 0.0), Vec2::new(18.5, 5.5))
        };
        (0..=20).for_each(|tick| standing.observe(&at(tick, &mover, &[]), &planning));
        standing.observe(&at(40, &[], &mover), &planning);
        assert_eq!((standing.is_any(), standing.revision), (true, 1));
        standing.observe(&at(41, &[], &[]), &planning);
        assert_eq!((standing.is_any(), standing.revision), (false, 2));
    }

    #[test]
    fn marks_are_cells_of_the_planned_map_alone_and_spare_both_ends_and_every_static() {
        let mut map = OccupancyGrid::empty(20, 10, 1.0);
        map.set_occupied(Cell { col: 5, row: 5 });
        let (robot, mut known) = (Robot::default(), Belief::from(&map));
        known.add(map.square(Cell { col: 7, row: 5 }), |square| square.contains(Vec2::new(7.5, 5.5)));
        // It touches four cells: the wall, the goal's, the robot's, and one more.
        let mover = [SensedObstacle::disc(7, Vec2::new(6.0, 6.0), Vec2::zeros(), 0.4)];
        let planning = PlanningSpec::default();
        let mut standing = Standing::default();
        let (robot_at, goal) = (Pose::new(6.7, 5.3, 0.0), Vec2::new(5.2, 6.9));
        let at = |tick: u32| Situation { tick, obstacles: &mover, ..Situation::new(&robot, &known, robot_at, goal) };
        for tick in 0..=20 {
            standing.observe(&at(tick), &planning);
        }
        let occupied = |belief: &Belief| {
            let grid = belief.grid();
            assert_eq!(*belief.field(), DistanceField::new(grid), "the field is exact");
            (0..grid.occupied().len()).filter(|&index| grid.occupied()[index]).map(|index| grid.cell(index)).collect()
        };
        let cells: Vec<Cell> = occupied(standing.belief(&at(21)));
        assert_eq!(cells, [(5, 5), (7, 5), (6, 6)].map(|(col, row)| Cell { col, row }));
        standing.observe(&Situation { obstacles: &[], ..at(22) }, &planning);
        let cells: Vec<Cell> = occupied(standing.belief(&at(23)));
        assert_eq!(cells, [(5, 5), (7, 5)].map(|(col, row)| Cell { col, row }));
    }
}
