//! Movers from a recording: one for each that it holds. They appear and vanish with the data, go straight from sample to
//! sample, and mind neither walls nor the robot, as recordings do.

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

/// What the registry says of it.
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
    /// Radius of the discs, m. Default: 0.3.
    #[serde(default = "radius_default")]
    pub radius_m: Positive,
    /// Whether they stand where the data ends, instead of vanishing. Default: false.
    #[serde(default)]
    pub stays: bool,
    /// What the file holds, once it has been read.
    #[serde(skip)]
    pub recording: Option<Arc<Recording>>,
}

fn frame_rate_default() -> Positive {
    Positive::new(25.0)
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
                motion: Replay { samples, stays: self.stays }.into(),
                present: false,
                ..Mover::new(first, Vec2::zeros(), self.radius_m.get())
            }
        };
        Ok(self.tracks().map(mover).collect())
    }
}
