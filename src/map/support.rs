//! Helpers shared by the tests of map kinds.

use super::{MapError, MapKind, MapSpec, OccupancyGrid};
use crate::rng::EpisodeSeed;
use std::path::Path;

/// Episode `episode` of seed 1.
pub(super) const fn episode(episode: u64) -> EpisodeSeed {
    EpisodeSeed { seed: 1, episode }
}

/// The map of an episode of seed 1; every length and count must fit.
pub(super) fn generate(params: &impl MapKind, number: u64) -> OccupancyGrid {
    params.load(Path::new(""), episode(number)).expect("a map")
}

/// The map of episode 0 that a scenario's key `map` asks for.
pub(super) fn load(yaml: &str) -> Result<OccupancyGrid, MapError> {
    serde_yaml::from_str::<MapSpec>(yaml).expect("parameters").load(Path::new(""), episode(0))
}

/// The message that refuses the map; it begins with the name of its kind.
pub(super) fn refusal(yaml: &str) -> String {
    let message = load(yaml).expect_err("refused").to_string();
    let kind = yaml.split(':').next().unwrap_or_default();
    assert!(message.starts_with(&format!("{kind} map: ")), "{message}");
    message
}

/// Checks that the first picture in a module's documentation is what the first scenario there draws.
pub(super) fn assert_picture(kind: &str, source: &str) {
    let fence = |text: &str| text.strip_prefix("//!").map(|text| text.strip_prefix(' ').unwrap_or(text).to_owned());
    let mut lines = source.lines().map_while(fence).collect::<Vec<_>>().into_iter();
    let mut block = |opening: &str| -> Vec<String> {
        assert!(lines.by_ref().any(|line| line == opening), "{kind}: no {opening}");
        lines.by_ref().take_while(|line| line != "```").collect()
    };
    let yaml = block("```yaml").join(" ").replace("map: ", "");
    assert!(yaml.contains(kind), "{kind}: the scenario shows another kind, {yaml}");
    let picture = block("```text").join("\n") + "\n";
    let drawn = load(&yaml).expect("a map").to_string();
    assert_eq!(drawn, picture, "the map is\n{drawn}");
}
