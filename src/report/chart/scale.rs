//! Scales from values to pixels, and round ticks.

use crate::math;

/// A tick of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// The value.
    pub value: f64,
    /// What is written beside it.
    pub label: String,
}

/// A linear scale: values from `low` to `high` become pixels from `from_px` to `to_px`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// The value at `from_px`.
    pub low: f64,
    /// The value at `to_px`; above `low`.
    pub high: f64,
    /// Pixel of `low`.
    pub from_px: f64,
    /// Pixel of `high`; below `from_px` for an axis that points up.
    pub to_px: f64,
}

impl Scale {
    /// The scale whose ends are round and hold all `values`; 0 to 1 without a finite one. About `about` ticks fit on it.
    pub fn covering(values: impl IntoIterator<Item = f64>, about: usize, (from_px, to_px): (f64, f64)) -> Self {
        let finite = values.into_iter().filter(|value| value.is_finite());
        let (mut low, mut high) =
            finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (math::min(low, x), math::max(high, x)));
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        // A single value stands in the middle of a stretch that shows its last digits.
        if high - low <= 1e-9 * math::max(math::max(high.abs(), low.abs()), 1e-9) {
            let half = if low == 0.0 { 0.5 } else { low.abs() / 2.0 };
            (low, high) = (low - half, high + half);
        }
        let (step, _) = nice_step(high - low, about);
        // What lies within a thousandth of a step beyond a tick is the tick, up to rounding.
        let (first, last) = ((low / step + 1e-3).floor(), (high / step - 1e-3).ceil());
        Self { low: first * step, high: last * step, from_px, to_px }
    }

    /// The same, from 0 where all values are on one side of it and not far away.
    pub fn covering_near_zero(values: impl IntoIterator<Item = f64>, about: usize, pixels: (f64, f64)) -> Self {
        let values: Vec<f64> = values.into_iter().filter(|value| value.is_finite()).collect();
        let (low, high) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (math::min(low, x), math::max(high, x)));
        let is_near = low > 0.0 && low < 0.5 * high;
        Self::covering(values.into_iter().chain(is_near.then_some(0.0)), about, pixels)
    }

    /// The pixel of a value, also of one beyond the ends.
    pub fn at(&self, value: f64) -> f64 {
        self.from_px + (value - self.low) / (self.high - self.low) * (self.to_px - self.from_px)
    }

    /// About `about` round ticks from end to end.
    pub fn ticks(&self, about: usize) -> Vec<Tick> {
        let (step, decimals) = nice_step(self.high - self.low, about);
        let first = (self.low / step - 1e-6).ceil();
        let count = ((self.high / step + 1e-6).floor() - first) as usize;
        let tick = |k: usize| {
            let value = math::canonical((first + k as f64) * step);
            Tick { value, label: number(value, decimals) }
        };
        (0..=count).map(tick).collect()
    }
}

/// A number with so many decimals, with a true minus sign, thin spaces between thousands from 10 000 on, and no −0.
pub fn number(value: f64, decimals: usize) -> String {
    let text = format!("{:.decimals$}", value.abs());
    let (whole, fraction) = text.split_once('.').map_or((text.as_str(), ""), |(whole, fraction)| (whole, fraction));
    let mut out = String::new();
    if value < 0.0 && text.bytes().any(|byte| (b'1'..=b'9').contains(&byte)) {
        out.push('\u{2212}');
    }
    for (at, digit) in whole.chars().enumerate() {
        if at > 0 && whole.len() > 4 && (whole.len() - at).is_multiple_of(3) {
            out.push('\u{2009}');
        }
        out.push(digit);
    }
    if !fraction.is_empty() {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

/// The round step, 1, 2 or 5 times a power of ten, that splits `span` into at most `about` parts (at least one); and the number of
/// decimals that its multiples need.
///
/// # Panics
/// If `span` is not a positive number.
pub fn nice_step(span: f64, about: usize) -> (f64, usize) {
    assert!(span.is_finite() && span > 0.0, "a scale has two ends");
    let wanted = span / about.max(1) as f64 * (1.0 - 1e-9);
    // Powers of ten by division and multiplication of exact ones, so that the step is the number that a reader would write.
    let (mut power, mut exponent) = (1.0, 0_i32);
    while power > wanted {
        exponent -= 1;
        power = power_of_ten(exponent);
    }
    while power * 10.0 <= wanted {
        exponent += 1;
        power = power_of_ten(exponent);
    }
    for (factor, carry) in [(1.0, 0), (2.0, 0), (5.0, 0), (10.0, 1)] {
        if factor * power >= wanted {
            let step = if exponent < 0 { factor / power_of_ten(-exponent) } else { factor * power };
            return (step, usize::try_from(-(exponent + carry)).unwrap_or(0));
        }
    }
    (10.0 * power, usize::try_from(-(exponent + 1)).unwrap_or(0))
}

fn power_of_ten(exponent: i32) -> f64 {
    let power = (0..exponent.unsigned_abs().min(300)).fold(1.0, |power, _| power * 10.0);
    if exponent < 0 { 1.0 / power } else { power }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_round() {
        for (span, about, expected) in [
            (1.0, 5, (0.2, 1)),
            (100.0, 5, (20.0, 0)),
            (7.3, 5, (2.0, 0)),
            (0.04, 5, (0.01, 2)),
            (0.05, 5, (0.01, 2)),
            (3e-4, 3, (1e-4, 4)),
            (9.0, 1, (10.0, 0)),
            (2.6e6, 5, (1e6, 0)),
        ] {
            assert_eq!(nice_step(span, about), expected, "{span} in {about}");
        }
    }

    #[test]
    fn a_scale_covers_its_values_with_round_ends() {
        let scale = Scale::covering([12.4, 38.9, f64::NAN], 5, (0.0, 100.0));
        assert_eq!((scale.low, scale.high), (10.0, 40.0));
        assert_eq!(scale.at(25.0), 50.0);
        let labels: Vec<String> = scale.ticks(5).into_iter().map(|tick| tick.label).collect();
        assert_eq!(labels, ["10", "20", "30", "40"]);
        let near = Scale::covering_near_zero([12.4, 38.9], 5, (0.0, 1.0));
        assert_eq!((near.low, near.high), (0.0, 40.0));
        let far = Scale::covering_near_zero([32.4, 38.9], 5, (0.0, 1.0));
        assert_eq!((far.low, far.high), (32.0, 40.0));
    }

    #[test]
    fn nothing_and_one_value_have_a_scale_too() {
        let none = Scale::covering([], 4, (0.0, 1.0));
        assert_eq!((none.low, none.high), (0.0, 1.0));
        let one = Scale::covering([3.0, 3.0], 4, (0.0, 100.0));
        assert!(one.low < 3.0 && one.high > 3.0 && (one.at(3.0) - 50.0).abs() < 17.0);
        let zero = Scale::covering([0.0], 4, (0.0, 1.0));
        assert!(zero.low < 0.0 && zero.high > 0.0);
    }

    #[test]
    fn numbers_are_written_as_a_reader_expects() {
        assert_eq!(number(-0.3, 0), "0", "no minus before nothing");
        assert_eq!(number(-0.3, 1), "\u{2212}0.3");
        assert_eq!(number(1234.0, 0), "1234");
        assert_eq!(number(12_345.5, 1), "12\u{2009}345.5");
        let scale = Scale { low: -0.2, high: 0.2, from_px: 0.0, to_px: 1.0 };
        let labels: Vec<String> = scale.ticks(4).into_iter().map(|tick| tick.label).collect();
        assert_eq!(labels, ["\u{2212}0.2", "\u{2212}0.1", "0.0", "0.1", "0.2"]);
    }
}
