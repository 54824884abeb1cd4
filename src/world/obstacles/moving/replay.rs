//! Movers from a recording: one for each track. They appear and vanish with the data, go straight from sample to
//! sample, and ignore walls and the robot.

use super::recording::Recording;
use super::{Given, Mover, MovingKind, OnStatic, Order, radius_default};
use crate::geometry::Vec2;
use crate::settings::Entry;
use crate::settings::quantity::{NonNegative, Positive};
use crate::world::motion::{Replay, Sample};
use crate::world::obstacles::Drawing;
use crate::world::scene::{Infeasible, SceneError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Registry entry.
pub const ENTRY: Entry = Entry { summary: "movers from a recording, one for each that it holds" };

/// Parameters of a replay.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Params {
    /// CSV file, relative to the scenario, with the columns `time_s` (or `time`, or `frame`), `id` (or `ped_id`), `x_m` (or `x`)
    /// and `y_m` (or `y`); positions in the world frame, m. Other columns are not read.
    pub file: PathBuf,
    /// Frames per second, for a file that counts frames. Default: 25.
    #[serde(default = "frame_rate_default")]
    pub frame_rate_hz: Positive,
    /// Moment of the recording at which the episode begins, s. Default: 0.
    #[serde(default = "from_default")]
    pub from_s: NonNegative,
    /// Only these ids, as they stand in the file. Default: all.
    #[serde(default)]
    pub ids: Option<Vec<u64>>,
    /// Longest time between two rows of one id over which it walks straight on, s; in a longer hole it is not there: it is neither
    /// sensed nor touched until the data goes on. Default: 1.
    #[serde(default = "gap_default")]
    pub gap_max_s: Positive,
    /// Radius of the discs, m. Default: 0.3.
    #[serde(default = "radius_default")]
    pub radius_m: Positive,
    /// Whether they stand where the data ends, instead of vanishing. Default: false.
    #[serde(default)]
    pub stays: bool,
    /// Content of the file, once it has been read.
    #[serde(skip)]
    pub recording: Option<Arc<Recording>>,
}

fn frame_rate_default() -> Positive {
    Positive::new(25.0)
}

fn gap_default() -> Positive {
    Positive::new(1.0)
}

fn from_default() -> NonNegative {
    NonNegative::new(0.0)
}

impl Params {
    /// The tracks that are played, by id; those whose data ends before the episode begins are left out.
    fn tracks(&self) -> impl Iterator<Item = &[Sample]> {
        let wanted = |id: u64| self.ids.as_ref().is_none_or(|ids| ids.contains(&id));
        let ends_in_time = |track: &[Sample]| self.stays || track[track.len() - 1].time_s - self.from_s.get() > 0.0;
        let tracks = self.recording.iter().flat_map(|recording| recording.tracks());
        tracks.filter(move |&(id, track)| wanted(id) && ends_in_time(track)).map(|(_, track)| track)
    }
}

impl MovingKind for Params {
    fn load(&mut self, key: &str, folder: &Path) -> Result<(), SceneError> {
        let recording = Recording::read(&folder.join(&self.file), self.frame_rate_hz.get());
        self.recording = Some(Arc::new(recording.map_err(|message| SceneError::new(format!("{key}.file"), message))?));
        Ok(())
    }

    fn files(&self) -> Vec<PathBuf> {
        vec![self.file.clone()]
    }

    fn check(&self, key: &str, _: &Given<'_>) -> Result<(), SceneError> {
        let Some(recording) = &self.recording else {
            return Err(SceneError::new(format!("{key}.file"), "the recording has not been read"));
        };
        match self.ids.iter().flatten().find(|&&id| recording.tracks().all(|(known, _)| known != id)) {
            Some(id) => Err(SceneError::new(format!("{key}.ids"), format!("the recording has no id {id}"))),
            None => Ok(()),
        }
    }

    fn count(&self) -> usize {
        self.tracks().count()
    }

    fn refuses(&self, _: Order) -> Option<&'static str> {
        Some("replays a recording and does nothing else")
    }

    fn draw(&self, drawing: &Drawing<'_>) -> Result<Vec<Mover>, Infeasible> {
        let frame = drawing.scene.map.grid.frame();
        let mover = |track: &[Sample]| {
            let samples: Arc<[Sample]> = track
                .iter()
                .map(|sample| Sample {
                    time_s: sample.time_s - self.from_s.get(),
                    position: frame.point_to_grid(sample.position),
                })
                .collect();
            let first = samples[0].position;
            Mover {
                on_static: OnStatic::Pass,
                motion: Replay { samples, stays: self.stays, gap_max_s: self.gap_max_s.get() }.into(),
                present: false,
                ..Mover::new(first, Vec2::zeros(), self.radius_m.get())
            }
        };
        Ok(self.tracks().map(mover).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Twist;
    use crate::map::OccupancyGrid;
    use crate::robot::Robot;
    use crate::world::obstacles::moving::MovingChoice;
    use crate::world::scene::tests::{seed, spec, states};
    use crate::world::scene::{Scene, SceneSpec};
    use crate::world::statics::StaticMap;
    use crate::world::{Conditions, World};

    /// Sets the recording of the one mover of a specification.
    fn set_recording(spec: &mut SceneSpec, recording: Arc<Recording>) {
        let [MovingChoice::replay(params)] = spec.obstacles.moving.as_mut_slice() else { panic!("{spec:?}") };
        params.recording = Some(recording);
    }

    #[test]
    fn a_recorded_mover_is_at_the_recorded_place_and_gone_outside_of_its_time() {
        let csv =
            b"time_s,id,x_m,y_m\n1.0,4,10,10\n1.4,4,10.4,10\n1.85,4,10.4,10.9\n2.85,4,10.4,12.9\n3.0,4,10.4,13.2\n";
        let recording = Arc::new(Recording::parse(csv, 25.0).unwrap());
        let obstacles = "moving: [replay: {file: unused.csv, from_s: 0.5}]";
        let mut spec = spec("[1, 1]", "[38, 28]", obstacles);
        set_recording(&mut spec, recording);
        let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
        let scene = Scene::generate(&spec, &map, &Robot::default(), seed(0)).unwrap();
        let states = states(&scene, 40);
        for (tick, state) in states.iter().enumerate() {
            let t = tick as f64 * 0.1 + 0.5;
            // The row of a tick shows the end of the tick: the first one driven begins at 1.0 s, the last one ends at 3.0 s.
            assert_eq!(state[0].present, t > 1.05 && t < 3.05, "at {t}");
            if state[0].present {
                let expected =
                    if t < 1.4 { Vec2::new(10.0 + (t - 1.0), 10.0) } else { Vec2::new(10.4, 10.0 + 2.0 * (t - 1.4)) };
                assert!((state[0].position - expected).norm() < 1e-6, "at {t}: {:?} {expected:?}", state[0].position);
            }
        }
    }

    #[test]
    fn a_mover_that_appears_upon_the_robot_is_a_collision_at_that_moment() {
        let csv = b"time_s,id,x_m,y_m\n1.0,4,1.2,1\n9.0,4,1.2,1\n";
        let mut spec = spec("[1, 1]", "[38, 28]", "moving: [replay: {file: unused.csv, gap_max_s: 8}]");
        set_recording(&mut spec, Arc::new(Recording::parse(csv, 25.0).unwrap()));
        let map = Arc::new(StaticMap::new(OccupancyGrid::empty(40, 30, 1.0)));
        let scene = Scene::generate(&spec, &map, &Robot::default(), seed(0)).unwrap();
        let robot = Robot::default();
        let mut world = World::new(&scene, &robot, &Conditions::default());
        let hit = (0..20).find_map(|tick| world.step(Twist::ZERO).contact.map(|contact| (tick, contact.time_s)));
        assert_eq!(hit, Some((10, 0.0)));
    }
}
