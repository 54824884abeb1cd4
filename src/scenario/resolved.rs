//! A scenario with every default filled in, and beside each key that has no value of its own what is used in its place.

use super::Scenario;
use super::key_path::KeyPath;
use super::schema::Place;
use crate::map::OccupancyGrid;
use crate::robot::Robot;
use crate::world::{GoalSpec, StartSpec};

impl Scenario {
    /// The scenario as YAML with every default written out, as [`to_yaml`](Self::to_yaml) has it, and with comments: beside each key without a
    /// value the value that is used, or the rule that it follows. Reading it gives an equal scenario. `map` is the fixed map, if there
    /// is one.
    pub fn explained(&self, map: Option<&OccupancyGrid>) -> String {
        let mut text = String::new();
        // The keys above the line, each with the column in which it begins.
        let mut above: Vec<(usize, String)> = Vec::new();
        for line in self.to_yaml().lines() {
            text += line;
            let begins = line.find(|c| c != ' ' && c != '-').unwrap_or(line.len());
            above.retain(|(column, _)| *column < begins);
            if let Some((key, value)) = line[begins..].split_once(':')
                && key.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            {
                above.push((begins, key.to_owned()));
                if value == " null" {
                    let path = above.iter().fold(KeyPath::default(), |path, (_, key)| path.key(key.clone()));
                    if let Some(comment) = self.in_place_of(&path, map) {
                        text += &format!("  # {comment}");
                    }
                }
            }
            text.push('\n');
        }
        text
    }

    /// What is used in place of a key without a value.
    fn in_place_of(&self, path: &KeyPath, map: Option<&OccupancyGrid>) -> Option<String> {
        let robot = Robot::new(&self.robot, &self.limits);
        let used = match path.to_string().as_str() {
            "limits.deceleration_max_mps2" => Some(robot.deceleration_max_mps2),
            "planning.inflation_m" => Some(self.planning.inflation_m(robot.radius_m)),
            "start.random.distance_min_m" | "goal.random.distance_min_m" => map.map(|map| self.distance_min_m(map)),
            "termination.timeout_s" => {
                return Some(format!(
                    "used: {} × (shortest_m / {} m/s + π / {} rad/s), in each world its own",
                    self.termination.timeout_factor.get(),
                    robot.speed_max_mps,
                    robot.yaw_rate_max_radps
                ));
            }
            _ => None,
        };
        let rule = rule(path);
        match used {
            Some(used) => {
                let used = (used * 1e6).round() / 1e6;
                Some(rule.map_or(format!("used: {used}"), |rule| format!("used: {used} ({rule})")))
            }
            None => rule,
        }
    }

    /// Least distance of a random end from the other one, where nothing is said of it, m.
    fn distance_min_m(&self, map: &OccupancyGrid) -> f64 {
        let is_random = [matches!(self.start, StartSpec::Random(_)), matches!(self.goal, GoalSpec::Random(_))];
        map.extent_m().norm() * if is_random == [true; 2] { 0.5 } else { 0.25 }
    }
}

/// What the documentation of a key says of its absence, without the full stop; all of it if no part of it is about that.
fn rule(path: &KeyPath) -> Option<String> {
    let top = Place::top(Scenario::schema());
    let place = path.steps().iter().try_fold(top, |place, step| place.key_or_item_key(step.name()))?;
    let meaning = place.meaning()?;
    let speaks =
        |part: &&str| ["efault", "absent", "ithout", "one by", "eplaces"].iter().any(|word| part.contains(word));
    let parts = meaning.split_inclusive([';', '.']).collect::<Vec<&str>>();
    // A full stop inside of a number parts nothing.
    let mut sentences: Vec<String> = Vec::new();
    for part in parts {
        match sentences.last_mut() {
            Some(last) if !part.starts_with(' ') => last.push_str(part),
            _ => sentences.push(part.to_owned()),
        }
    }
    let first = sentences.iter().position(|sentence| speaks(&sentence.as_str()));
    let said = first.map_or(meaning.clone(), |first| sentences[first..].concat());
    let said = said.trim().trim_end_matches(['.', ';']).trim_start_matches("Default: ").trim_start_matches("default: ");
    Some(said.to_owned()).filter(|said| !said.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::ScenarioFile;

    const TEXT: &str = "map: {empty: {cols: 30, rows: 40}}\nrobot: {radius_m: 0.3}\ngoal: [3, 4]\n\
        stacks:\n  - {global: a_star, path: [b_spline], local: imp_dwa}\n  - {name: last, global: none, local: dwa}\n";

    fn read(text: &str) -> Scenario {
        ScenarioFile::from_text("room.yaml", text).read(&[]).unwrap()
    }

    #[test]
    fn what_is_used_stands_beside_every_key_without_a_value() {
        let scenario = read(TEXT);
        let map = OccupancyGrid::empty(30, 40, 1.0);
        let text = scenario.explained(Some(&map));
        for line in text.lines() {
            assert!(!line.contains(": null") || line.contains("null  # "), "{line}");
        }
        for expected in [
            // A quarter of the diagonal of 30 m by 40 m, for the goal is given.
            "    distance_min_m: null  # used: 12.5 (half the map's diagonal, or a quarter where the other end is given)",
            "  deceleration_max_mps2: null  # used: 0.5 (the acceleration where absent)",
            "  inflation_m: null  # used: 0.35 (",
            "  timeout_s: null  # used: 10 × (shortest_m / 1 m/s + π / 1 rad/s), in each world its own",
            "va_clip_m: null  # `d_cap_m` where absent",
        ] {
            assert!(text.contains(expected), "{expected}\n{text}");
        }
    }

    #[test]
    fn reading_it_gives_the_same_scenario() {
        let scenario = read(TEXT);
        let text = scenario.explained(None);
        assert!(text.contains("  # ") && text != scenario.to_yaml());
        assert_eq!(read(&text), scenario);
        assert_eq!(read(&text).to_yaml(), scenario.to_yaml());
    }
}
