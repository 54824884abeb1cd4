//! The inputs: `benches/scenes` and, where they are there, the MovingAI benchmarks.

use crate::Settings;
use simrun::map::formats::movingai;
use simrun::map::queries::{self, Query};
use simrun::map::{DistanceField, OccupancyGrid};
use simrun::plan::PlanningGrid;
use simrun::plan::contract::Problem;
use std::path::{Path, PathBuf};

/// The folder of the scenes that come with the benches.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

/// A map with queries.
pub struct GridScene {
    /// Name of the map.
    pub name: String,
    /// The map.
    pub map: OccupancyGrid,
    /// The same for planners, without inflation.
    pub grid: PlanningGrid,
    /// Starts and goals.
    pub queries: Vec<Query>,
}

impl GridScene {
    fn read(map: &Path, scen: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(map).map_err(|error| format!("{}: {error}", map.display()))?;
        let occupancy = movingai::parse(&text).map_err(|error| error.to_string())?;
        let grid = PlanningGrid::new(&occupancy, &DistanceField::new(&occupancy), 0.0);
        let name = map.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, map: occupancy, grid, queries: queries::read(scen)?.list })
    }

    /// Every `step`-th query as problems, so that about `count` remain.
    pub fn problems(&self, count: usize) -> Vec<Problem<'_>> {
        let step = self.queries.len().div_ceil(count).max(1);
        let problem = |query: &Query| Problem {
            grid: &self.grid,
            start: movingai::flip(&self.map, query.start),
            goal: movingai::flip(&self.map, query.goal),
        };
        self.queries.iter().step_by(step).map(problem).collect()
    }
}

/// The scenes that come with the benches: 20 % random obstacles, 100 × 100 and 512 × 512.
pub fn random_grids() -> Result<Vec<GridScene>, String> {
    let read = |name: &str| {
        let file = |ending: &str| folder().join(format!("{name}.{ending}"));
        GridScene::read(&file("map"), &file("scen"))
    };
    ["random100-20", "random512-20"].into_iter().map(read).collect()
}

/// The maps of the MovingAI benchmarks, each with all its queries, by name.
pub fn movingai_grids(settings: &Settings) -> Result<Vec<GridScene>, String> {
    let folder = settings.benchmarks.as_ref().ok_or("it needs --benchmarks FOLDER")?;
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let mut files: Vec<PathBuf> = entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).collect();
    files.sort();
    let ends_with = |file: &Path, ending: &str| file.extension().is_some_and(|extension| extension == ending);
    let mut scenes = Vec::new();
    for map in files.iter().filter(|file| ends_with(file, "map")) {
        let stem = map.file_stem().unwrap_or_default().to_string_lossy();
        let is_of_map = |file: &&PathBuf| {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            ends_with(file, "scen")
                && name.strip_prefix(&*stem).is_some_and(|rest| rest.starts_with('.') || rest.starts_with('-'))
        };
        let mut scene: Option<GridScene> = None;
        for scen in files.iter().filter(is_of_map) {
            match &mut scene {
                None => scene = Some(GridScene::read(map, scen)?),
                Some(scene) => scene.queries.extend(queries::read(scen)?.list),
            }
        }
        scenes.extend(scene);
    }
    if scenes.is_empty() { Err(format!("no .map with a .scen in {}", folder.display())) } else { Ok(scenes) }
}
