//! Mamdani inference over piecewise linear fuzzy sets, in closed form.
//!
//! A rule holds to the degree min(μ_A(x), μ_B(y)) of its two inputs; a set of the output is cut at the largest degree of the
//! rules that name it; the cut sets are joined by their maximum; the answer is the centroid of that figure:
//!
//! ```text
//! answer = ∫ u μ(u) du / ∫ μ(u) du        μ(u) = max over the sets k of min(level_k, μ_k(u)),  u from 0 to 1
//! ```
//!
//! The figure is piecewise linear, so both integrals are sums over its corners: nothing is sampled.
//!
//! Source: E. H. Mamdani, S. Assilian, "An experiment in linguistic synthesis with a fuzzy logic controller", International
//! Journal of Man-Machine Studies 7(1), 1975.

use crate::math;
use crate::settings::quantity::Finite;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Deserializer, Serialize, de};
use std::borrow::Cow;

/// Number of sets of each input and of each output.
pub const SETS: usize = 4;

/// Peaks of the sets of one number, in shares of its universe: ascending, each from 0 to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Peaks([f64; SETS]);

impl Peaks {
    const EXPECTED: &'static str = "four ascending numbers from 0 to 1";

    /// 0, 1/3, 2/3 and 1.
    pub const EVEN: Self = Self([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]);

    /// The peaks.
    pub fn get(self) -> [f64; SETS] {
        self.0
    }
}

impl TryFrom<[f64; SETS]> for Peaks {
    type Error = String;
    fn try_from(peaks: [f64; SETS]) -> Result<Self, String> {
        let fits = peaks.iter().all(|peak| (0.0..=1.0).contains(peak)) && peaks.windows(2).all(|two| two[0] < two[1]);
        if fits { Ok(Self(peaks)) } else { Err(format!("expected {}, found {peaks:?}", Self::EXPECTED)) }
    }
}

impl<'de> Deserialize<'de> for Peaks {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let numbers: Vec<f64> = Vec::<Finite>::deserialize(deserializer)?.into_iter().map(Finite::get).collect();
        let found = format!("expected {}, found {numbers:?}", Self::EXPECTED);
        let peaks = <[f64; SETS]>::try_from(numbers).map_err(|_| de::Error::custom(found))?;
        Self::try_from(peaks).map_err(de::Error::custom)
    }
}

impl JsonSchema for Peaks {
    fn schema_name() -> Cow<'static, str> {
        "Peaks".into()
    }
    fn inline_schema() -> bool {
        true
    }
    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "type": "array", "minItems": SETS, "maxItems": SETS,
            "items": {"type": "number", "minimum": 0, "maximum": 1},
            "examples": [[0.0, 0.2, 0.5, 1.0]],
        })
    }
}

/// Shape of a membership function.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// 1 at its own peak alone, 0 from the peaks beside it on.
    #[default]
    Triangle,
    /// 1 up to a quarter of the way to the peaks beside it, 0 from three quarters on.
    Trapezoid,
}

/// A fuzzy set of [0, 1]: a trapezoid that rises from `foot` to `shoulder` and falls between the other two. The first and the last
/// set of a universe reach to its ends at full height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Set {
    /// Where it begins to rise, has risen, begins to fall, has fallen.
    corners: [f64; 4],
}

impl Set {
    /// The sets with these peaks. Two neighbours add up to 1 everywhere between their peaks.
    pub fn family(peaks: Peaks, shape: Shape) -> [Self; SETS] {
        let peaks = peaks.get();
        // Shares of the way to the next peak at which the slope between two sets begins and ends.
        let (begin, end) = match shape {
            Shape::Triangle => (0.0, 1.0),
            Shape::Trapezoid => (0.25, 0.75),
        };
        core::array::from_fn(|k| {
            let (foot, shoulder) = match k {
                0 => (0.0, 0.0),
                _ => {
                    let gap = peaks[k] - peaks[k - 1];
                    (peaks[k] - end * gap, peaks[k] - begin * gap)
                }
            };
            let (far_shoulder, far_foot) = match peaks.get(k + 1) {
                None => (1.0, 1.0),
                Some(next) => (peaks[k] + begin * (next - peaks[k]), peaks[k] + end * (next - peaks[k])),
            };
            Self { corners: [foot, shoulder, far_shoulder, far_foot] }
        })
    }

    /// Membership of `u`, which is taken as the end of [0, 1] that it lies beyond.
    pub fn membership(&self, u: f64) -> f64 {
        let ([a, b, c, d], u) = (self.corners, math::clamp(u, 0.0, 1.0));
        if u >= b && u <= c {
            1.0
        } else if u > a && u < b {
            (u - a) / (b - a)
        } else if u > c && u < d {
            (d - u) / (d - c)
        } else {
            0.0
        }
    }

    /// The corners of the set cut at `level`.
    fn cut(&self, level: f64) -> [f64; 4] {
        let [a, b, c, d] = self.corners;
        [a, a + level * (b - a), d - level * (d - c), d]
    }
}

/// Centroid of the sets of [0, 1], each cut at its level and joined by their maximum. At least one level is above 0.
pub fn centroid(sets: &[Set; SETS], levels: &[f64; SETS]) -> f64 {
    let height = |k: usize, u: f64| math::min(levels[k], sets[k].membership(u));
    let top = |u: f64| (0..SETS).fold(0.0, |top, k| math::max(top, height(k, u)));
    // Between two of these places every cut set is a straight line.
    let mut places = [0.0; 4 * SETS + 2];
    for (k, set) in sets.iter().enumerate() {
        places[4 * k..4 * k + 4].copy_from_slice(&set.cut(levels[k]));
    }
    places[4 * SETS + 1] = 1.0;
    places.sort_unstable_by(f64::total_cmp);
    let (mut area, mut moment) = (0.0, 0.0);
    // Adds the part of the figure between two places between which it is a straight line.
    let mut add = |from: f64, to: f64| {
        let (left, right, width) = (top(from), top(to), to - from);
        area += 0.5 * width * (left + right);
        moment += width / 6.0 * (from * (2.0 * left + right) + to * (left + 2.0 * right));
    };
    for pair in places.windows(2) {
        let (from, to) = (pair[0], pair[1]);
        if to <= from {
            continue;
        }
        // Where two of the lines cross, the figure has a corner as well.
        let mut crossings = [to; SETS * (SETS - 1) / 2 + 1];
        let mut count = 0;
        for i in 0..SETS {
            for k in i + 1..SETS {
                let (begin, end) = (height(i, from) - height(k, from), height(i, to) - height(k, to));
                if begin * end < 0.0 {
                    crossings[count] = from + (to - from) * (begin / (begin - end));
                    count += 1;
                }
            }
        }
        crossings[..count].sort_unstable_by(f64::total_cmp);
        let mut before = from;
        for &place in &crossings[..=count] {
            add(before, place);
            before = place;
        }
    }
    moment / area
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even() -> [Set; SETS] {
        Set::family(Peaks::EVEN, Shape::Triangle)
    }

    #[test]
    fn neighbouring_sets_add_up_to_one() {
        let uneven = Peaks::try_from([0.1, 0.2, 0.6, 0.95]).unwrap();
        for shape in [Shape::Triangle, Shape::Trapezoid] {
            for sets in [Set::family(Peaks::EVEN, shape), Set::family(uneven, shape)] {
                for k in -10..=110 {
                    let u = f64::from(k) / 100.0;
                    let sum: f64 = sets.iter().map(|set| set.membership(u)).sum();
                    assert!((sum - 1.0).abs() < 1e-12, "{shape:?} {u}: {sum}");
                }
            }
        }
    }

    #[test]
    fn memberships_are_those_worked_by_hand() {
        let [first, second, _, last] = even();
        assert_eq!((first.membership(0.0), first.membership(-1.0), last.membership(7.0)), (1.0, 1.0, 1.0));
        assert!((first.membership(0.1) - 0.7).abs() < 1e-12 && (second.membership(0.1) - 0.3).abs() < 1e-12);
        assert!((second.membership(0.5) - 0.5).abs() < 1e-12 && second.membership(2.0 / 3.0) < 1e-12);
        // A trapezoid: full to 1/12 of a third, half in the middle between two peaks, nothing from 1/4 on.
        let [first, ..] = Set::family(Peaks::EVEN, Shape::Trapezoid);
        assert_eq!((first.membership(0.08), first.membership(0.26)), (1.0, 0.0));
        assert!((first.membership(1.0 / 6.0) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn centroids_are_those_worked_by_hand() {
        let sets = even();
        let of = |levels| centroid(&sets, &levels);
        // Triangles: half of one at either end (a third of 1/3 from its peak), a whole one in the middle.
        assert!((of([1.0, 0.0, 0.0, 0.0]) - 1.0 / 9.0).abs() < 1e-12);
        assert!((of([0.0, 0.0, 0.0, 1.0]) - 8.0 / 9.0).abs() < 1e-12);
        assert!((of([0.0, 1.0, 0.0, 0.0]) - 1.0 / 3.0).abs() < 1e-12);
        // What is symmetric about the middle.
        assert!((of([0.3, 0.6, 0.6, 0.3]) - 0.5).abs() < 1e-12);
        // The first set cut at 1/2: 1/2 to 1/6, then down to 0 at 1/3.
        // Area 1/12 + 1/24 = 1/8; moment 1/12 · 1/12 + 1/24 · (1/6 + 1/18) = 1/144 + 1/108 = 7/432; centroid 7/54.
        assert!((of([0.5, 0.0, 0.0, 0.0]) - 7.0 / 54.0).abs() < 1e-12);
        // The first two at full height cross at (1/6, 1/2): symmetric about 1/6 up to 1/3, area 1/4; from there down to 0 at 2/3, area
        // 1/6 about 4/9. (1/24 + 2/27) / (5/12) = 5/18.
        assert!((of([1.0, 1.0, 0.0, 0.0]) - 5.0 / 18.0).abs() < 1e-12);
        // Below 1/2 neighbours leave no gap: level all over.
        assert!((of([0.2, 0.2, 0.2, 0.2]) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn the_centroid_is_that_of_dense_sampling() {
        const SAMPLES: i32 = 20_000;
        let mut stream = crate::plan::grid::tests::stream(77);
        for _ in 0..200 {
            let mut peaks = [0.0; SETS].map(|_| stream.uniform());
            peaks.sort_unstable_by(f64::total_cmp);
            let Ok(peaks) = Peaks::try_from(peaks) else { continue };
            let shape = if stream.uniform() < 0.5 { Shape::Triangle } else { Shape::Trapezoid };
            let sets = Set::family(peaks, shape);
            let levels = [0.0; SETS].map(|_| stream.uniform());
            let (mut area, mut moment) = (0.0, 0.0);
            for k in 0..SAMPLES {
                let u = (f64::from(k) + 0.5) / f64::from(SAMPLES);
                let top = (0..SETS).map(|k| math::min(levels[k], sets[k].membership(u))).fold(0.0, math::max);
                area += top;
                moment += u * top;
            }
            let answer = centroid(&sets, &levels);
            assert!((answer - moment / area).abs() < 1e-6, "{peaks:?} {levels:?}: {answer} {}", moment / area);
        }
    }

    #[test]
    fn peaks_ascend_within_the_universe() {
        let read = |yaml: &str| serde_yaml::from_str::<Peaks>(yaml);
        assert_eq!(read("[0, 0.25, 0.5, 1]").unwrap().get(), [0.0, 0.25, 0.5, 1.0]);
        for wrong in ["[0, 0.5, 0.5, 1]", "[0, 0.5, 1]", "[0, 0.5, 0.7, 1.1]", "[-0.1, 0.1, 0.2, 0.3]"] {
            let message = read(wrong).unwrap_err().to_string();
            assert!(message.contains("four ascending numbers from 0 to 1"), "{message}");
        }
    }
}
