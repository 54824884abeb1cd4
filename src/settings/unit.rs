//! Units of keys: the last word of a name says its unit (`speed_max_mps`), and with it where physics ends.
//!
//! A number outside of its unit's range is a slip of the pen: nothing on wheels is that fast, and the work of a tick or the
//! memory of a map grows with it. The widest figures that are accepted stand here, for scenarios, headers of maps and recordings.

use std::fmt;

/// A unit, as the last word of a name says it.
struct Unit {
    word: &'static str,
    written: &'static str,
    /// Smallest figure above 0.
    least: f64,
    /// Largest figure, by its amount.
    most: f64,
}

const fn unit(word: &'static str, written: &'static str, least: f64, most: f64) -> Unit {
    Unit { word, written, least, most }
}

/// The last words that are units, how the units are written, and the range of their figures.
const UNITS: [Unit; 14] = [
    unit("m", "m", 1e-6, 1e5),
    unit("mps", "m/s", 1e-6, 1e3),
    unit("mps2", "m/s²", 1e-6, 1e6),
    unit("mps3", "m/s³", 1e-6, 1e9),
    unit("1pm", "1/m", 1e-6, 1e6),
    unit("rad", "rad", 1e-9, 1e4),
    unit("radps", "rad/s", 1e-6, 1e4),
    unit("radps2", "rad/s²", 1e-6, 1e6),
    unit("deg", "°", 1e-6, 1e6),
    unit("s", "s", 1e-9, 1e7),
    unit("hz", "Hz", 1e-6, 1e6),
    unit("px", "px", 1e-6, 1e6),
    unit("ticks", "ticks", 0.0, 1e9),
    unit("cells", "cells", 1e-6, 1e6),
];

/// The side of a cell.
const RESOLUTION: &str = "resolution_m";
/// Sides of a cell that maps may have, m: beyond them distances in cells leave the range of whole numbers, and no robot drives there.
pub const RESOLUTION_M: core::ops::RangeInclusive<f64> = 1e-4..=1e4;

/// Largest amount of a coordinate, m: that of a map in a frame of the whole earth.
pub const COORDINATE_M_MAX: f64 = 1e8;
/// Largest share: a hundred times the whole.
const SHARE_MAX: f64 = 100.0;
/// Largest amount of a number without a unit, such as a weight.
const PLAIN_MAX: f64 = 1e9;

/// Counts whose work or memory grows with them: the end of the name, and the largest figure.
const COUNTS: [(&str, u64); 3] = [("count", 100_000), ("ants", 10_000), ("iterations", 100_000)];

/// The unit of the number called `name`; `None` for one without a unit, such as a count or a share.
pub fn unit_of(name: &str) -> Option<&'static str> {
    find(name).map(|unit| unit.written)
}

fn find(name: &str) -> Option<&'static Unit> {
    let (_, last) = name.rsplit_once('_')?;
    UNITS.iter().find(|unit| unit.word == last)
}

/// What was expected instead of a figure outside of its range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OutOfRange {
    /// At most so much, with the unit.
    Above(f64, &'static str),
    /// 0 or at least so much, with the unit.
    Below(f64, &'static str),
    /// Between the two, with the unit.
    Outside(f64, f64, &'static str),
}

impl fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let unit = match *self {
            Self::Above(most, unit) => {
                write!(f, "at most {most}")?;
                unit
            }
            Self::Below(least, unit) => {
                write!(f, "0 or at least {least}")?;
                unit
            }
            Self::Outside(least, most, unit) => {
                write!(f, "{least} to {most}")?;
                unit
            }
        };
        let gap = if unit.is_empty() || unit == "°" { "" } else { " " };
        write!(f, "{gap}{unit}")
    }
}

/// Checks the number called `name`. One that stands in a list, as `is_listed` says, may be arbitrarily small, for coordinates and
/// components of vectors are; without a unit it is a coordinate.
///
/// # Errors
/// What was expected.
pub fn check_range(name: &str, value: f64, is_listed: bool) -> Result<(), OutOfRange> {
    if name == RESOLUTION {
        let is_inside = RESOLUTION_M.contains(&value);
        return if is_inside {
            Ok(())
        } else {
            Err(OutOfRange::Outside(*RESOLUTION_M.start(), *RESOLUTION_M.end(), "m"))
        };
    }
    let amount = value.abs();
    let (least, most, unit) = match find(name) {
        Some(unit) => (if is_listed { 0.0 } else { unit.least }, unit.most, unit.written),
        None if is_listed => (0.0, COORDINATE_M_MAX, "m"),
        None if name.ends_with("_share") => (0.0, SHARE_MAX, ""),
        None => (0.0, PLAIN_MAX, ""),
    };
    if amount > most {
        Err(OutOfRange::Above(most, unit))
    } else if amount > 0.0 && amount < least {
        Err(OutOfRange::Below(least, unit))
    } else {
        Ok(())
    }
}

/// Checks the count called `name`.
///
/// # Errors
/// What was expected.
pub fn check_count(name: &str, value: u64) -> Result<(), OutOfRange> {
    match COUNTS.iter().find(|(word, _)| *word == name) {
        Some(&(_, most)) if value > most => Err(OutOfRange::Above(most as f64, "")),
        _ => Ok(()),
    }
}

/// A number as messages show it: those that would fill a line with zeros by their power of ten.
pub fn shown(value: f64) -> String {
    if value == 0.0 || (1e-7..1e16).contains(&value.abs()) { format!("{value}") } else { format!("{value:e}") }
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

    #[test]
    fn what_lies_beyond_physics_is_refused_with_the_widest_figure() {
        let said = |name: &str, value: f64, is_listed: bool| {
            check_range(name, value, is_listed).err().map(|range| range.to_string())
        };
        for (name, value, expected) in [
            ("speed_max_mps", 1000.0, None),
            ("speed_max_mps", 1000.1, Some("at most 1000 m/s")),
            ("heading_rad", -1e300, Some("at most 10000 rad")),
            ("radius_m", 1e-300, Some("0 or at least 0.000001 m")),
            ("radius_m", 0.0, None),
            ("resolution_m", 1e-5, Some("0.0001 to 10000 m")),
            ("speed_noise_share", 1e30, Some("at most 100")),
            ("brake_angle_max_deg", 1e9, Some("at most 1000000°")),
            ("heading_weight", 1e30, Some("at most 1000000000")),
        ] {
            assert_eq!(said(name, value, false).as_deref(), expected, "{name} {value}");
        }
        // A component that rounding has left is no fault.
        assert_eq!(said("velocity_mps", 6e-17, true), None);
        assert_eq!(said("goal", -1e9, true).unwrap(), "at most 100000000 m");
        assert_eq!(check_count("count", 1_000_000_000).unwrap_err().to_string(), "at most 100000");
        assert_eq!((check_count("count", 100_000), check_count("seed", u64::MAX)), (Ok(()), Ok(())));
    }

    #[test]
    fn no_message_is_a_line_of_zeros() {
        assert_eq!([1e300, 0.25, -1e-300, 0.0].map(shown), ["1e300", "0.25", "-1e-300", "0"]);
    }
}
