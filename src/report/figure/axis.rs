//! An axis of a figure, linear or logarithmic, with its ticks.

use crate::math;
use crate::report::chart::{Scale, Tick, number};

/// A scale with its ticks.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    scale: Scale,
    is_log: bool,
    pub ticks: Vec<Tick>,
}

/// What an axis is to show.
#[derive(Clone, Debug, Default)]
pub(super) struct Extent {
    /// Values that it must hold.
    pub values: Vec<f64>,
    /// Its ends where they are known, such as 0 and 100 per cent.
    pub ends: Option<(f64, f64)>,
    /// Its ticks, where they are given: the places of a key, or words.
    pub places: Vec<Tick>,
    /// Whether it is logarithmic; values that are not above 0 are not on it.
    pub is_log: bool,
}

impl Extent {
    /// A scale that holds the values with a little room at its ends; from 0 where they are all above it and not far away. No end is moved to a
    /// round number, so that no room is lost.
    fn scale(&self, (from_px, to_px): (f64, f64)) -> Scale {
        let known = self.ends.into_iter().flat_map(|(low, high)| [low, high]);
        let values = self.values.iter().copied().filter(|value| value.is_finite()).chain(known);
        let (mut low, mut high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (math::min(low, x), math::max(high, x)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // A single value stands in the middle.
        if high - low <= 1e-9 * math::max(math::max(high.abs(), low.abs()), 1e-9) {
            let half = if low == 0.0 { 0.5 } else { low.abs() / 2.0 };
            (low, high) = (low - half, high + half);
        }
        let from_zero = low > 0.0 && low < 0.5 * high;
        if from_zero {
            low = 0.0;
        }
        let room = 0.04 * (high - low);
        let is_low_end = from_zero || self.ends.is_some_and(|(end, _)| end == low);
        let is_high_end = self.ends.is_some_and(|(_, end)| end == high);
        Scale {
            low: if is_low_end { low } else { low - room },
            high: if is_high_end { high } else { high + room },
            from_px,
            to_px,
        }
    }
}

fn log10(value: f64) -> f64 {
    math::ln(value) / core::f64::consts::LN_10
}

impl Axis {
    /// An axis over `pixels`, from low to high, with about `about` ticks where none are given.
    pub fn new(extent: &Extent, about: usize, pixels: (f64, f64)) -> Self {
        let is_log = extent.is_log && extent.values.iter().any(|value| *value > 0.0);
        if is_log {
            return Self::log(extent, pixels);
        }
        if extent.places.is_empty() {
            let scale = extent.scale(pixels);
            // Two ticks are too few to read values by.
            let choices = (about.max(2)..about.max(2) + 4).map(|about| scale.ticks(about));
            let ticks = choices.max_by_key(|ticks| (ticks.len().min(3), std::cmp::Reverse(ticks.len())));
            return Self { ticks: ticks.unwrap_or_default(), scale, is_log };
        }
        // Half a place of room at both ends.
        let values = || extent.places.iter().map(|tick| tick.value).chain(extent.values.iter().copied());
        let (low, high) = (values().fold(f64::INFINITY, math::min), values().fold(f64::NEG_INFINITY, math::max));
        let count = extent.places.len() as f64;
        let room = if high > low {
            (high - low) / math::max(2.0 * (count - 1.0), 2.0)
        } else {
            math::max(low.abs(), 1.0) * 0.5
        };
        let scale = Scale { low: low - room, high: high + room, from_px: pixels.0, to_px: pixels.1 };
        Self { ticks: extent.places.clone(), scale, is_log }
    }

    fn log(extent: &Extent, (from_px, to_px): (f64, f64)) -> Self {
        let logs: Vec<f64> = extent
            .values
            .iter()
            .filter(|value| **value > 0.0 && value.is_finite())
            .map(|value| log10(*value))
            .collect();
        let (low, high) = (
            logs.iter().copied().fold(f64::INFINITY, math::min),
            logs.iter().copied().fold(f64::NEG_INFINITY, math::max),
        );
        let room = 0.04 * math::max(high - low, 0.2);
        let scale = Scale { low: low - room, high: high + room, from_px, to_px };
        let mut ticks = extent.places.clone();
        if ticks.is_empty() {
            // 1, 2 and 5 where there is room for them, else powers of ten.
            let factors: &[f64] = if high - low < 2.5 { &[1.0, 2.0, 5.0] } else { &[1.0] };
            for exponent in (scale.low.floor() as i32)..=(scale.high.ceil() as i32) {
                for factor in factors {
                    let value = factor
                        * (0..exponent.abs())
                            .fold(1.0, |power, _| if exponent < 0 { power / 10.0 } else { power * 10.0 });
                    let decimals = usize::try_from(-exponent).unwrap_or(0);
                    ticks.push(Tick { value, label: number(value, decimals) });
                }
            }
        }
        let mut axis = Self { scale, is_log: true, ticks };
        axis.ticks = axis.ticks.iter().filter(|tick| axis.holds(tick.value)).cloned().collect();
        axis
    }

    /// The pixel of a value; `None` for one that is not on the axis.
    pub fn at(&self, value: f64) -> Option<f64> {
        let value = if self.is_log { (value > 0.0).then(|| log10(value))? } else { value };
        value.is_finite().then(|| self.scale.at(value))
    }

    fn holds(&self, value: f64) -> bool {
        self.at(value).is_some_and(|px| {
            let (low, high) =
                (math::min(self.scale.from_px, self.scale.to_px), math::max(self.scale.from_px, self.scale.to_px));
            (low - 0.01..=high + 0.01).contains(&px)
        })
    }

    /// The pixel of a value, or of the end beyond which it lies.
    pub fn within(&self, value: f64) -> f64 {
        let (low, high) =
            (math::min(self.scale.from_px, self.scale.to_px), math::max(self.scale.from_px, self.scale.to_px));
        // A logarithmic axis has no 0: what is not above it lies beyond the low end.
        math::clamp(self.at(value).unwrap_or(self.scale.from_px), low, high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decade_is_as_long_as_every_other() {
        let axis = Axis::new(
            &Extent { values: vec![1.0, 10.0, 100.0, 0.0], is_log: true, ..Extent::default() },
            5,
            (0.0, 100.0),
        );
        let [a, b, c] = [1.0, 10.0, 100.0].map(|value| axis.at(value).unwrap());
        assert!((b - a - (c - b)).abs() < 1e-9 && axis.at(0.0).is_none());
        let labels: Vec<&str> = axis.ticks.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels, ["1", "2", "5", "10", "20", "50", "100"]);
        let small =
            Axis::new(&Extent { values: vec![0.002, 0.02], is_log: true, ..Extent::default() }, 5, (0.0, 100.0));
        let labels: Vec<&str> = small.ticks.iter().map(|tick| tick.label.as_str()).collect();
        assert_eq!(labels, ["0.002", "0.005", "0.01", "0.02"]);
    }

    #[test]
    fn ends_are_where_the_data_end_and_ticks_are_round() {
        let axis = |values: &[f64], ends| {
            Axis::new(&Extent { values: values.to_vec(), ends, ..Extent::default() }, 4, (0.0, 100.0))
        };
        let labels = |axis: &Axis| axis.ticks.iter().map(|tick| tick.label.clone()).collect::<Vec<String>>();
        // From 0, and a twenty-sixth of the room above the highest.
        let near = axis(&[12.0, 38.0], None);
        assert!(near.at(0.0) == Some(0.0) && (near.at(38.0).unwrap() - 100.0 / 1.04).abs() < 1e-9);
        let rate = axis(&[70.0, 100.0], Some((0.0, 100.0)));
        assert_eq!((rate.at(0.0), rate.at(100.0)), (Some(0.0), Some(100.0)));
        // Ticks at −0.2, 0 and 0.2 alone would be one, for the ends are nearer.
        assert!(labels(&axis(&[-0.15, 0.17], None)).len() >= 3);
    }

    #[test]
    fn places_are_ticks_with_room_at_both_ends() {
        let places = [0.2, 0.3, 0.5].map(|value| Tick { value, label: value.to_string() });
        let extent = Extent { places: places.to_vec(), ..Extent::default() };
        let axis = Axis::new(&extent, 5, (0.0, 90.0));
        assert_eq!(axis.ticks.len(), 3);
        assert!(axis.at(0.2).unwrap() > 5.0 && axis.at(0.5).unwrap() < 85.0);
        let one = Axis::new(&Extent { places: places[..1].to_vec(), ..extent }, 5, (0.0, 90.0));
        assert!((one.at(0.2).unwrap() - 45.0).abs() < 1e-9);
    }
}
