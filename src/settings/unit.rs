//! Units of keys: the last word of a name says its unit (`speed_max_mps`).

/// The last words that are units, and how the units are written.
const UNITS: [(&str, &str); 14] = [
    ("m", "m"),
    ("mps", "m/s"),
    ("mps2", "m/s²"),
    ("mps3", "m/s³"),
    ("1pm", "1/m"),
    ("rad", "rad"),
    ("radps", "rad/s"),
    ("radps2", "rad/s²"),
    ("deg", "°"),
    ("s", "s"),
    ("hz", "Hz"),
    ("px", "px"),
    ("ticks", "ticks"),
    ("cells", "cells"),
];

/// The unit of the number called `name`; `None` for one without a unit, such as a count or a share.
pub fn unit_of(name: &str) -> Option<&'static str> {
    let (_, last) = name.rsplit_once('_')?;
    UNITS.iter().find(|(word, _)| *word == last).map(|(_, unit)| *unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_word_is_the_unit() {
        let names = [
            "speed_max_mps",
            "yaw_acceleration_max_radps2",
            "curvature_max_1pm",
            "timeout_s",
            "missing",
            "s",
            "extra_doors",
        ];
        let units = [Some("m/s"), Some("rad/s²"), Some("1/m"), Some("s"), None, None, None];
        assert_eq!(names.map(unit_of), units);
    }
}
