//! Seeds and named random streams.
//!
//! A world is a pure function of (seed, episode). Every purpose (the map, the start and goal,
//! each mover, …) draws from a ChaCha8 stream of its own, so that adding a consumer, or a planner
//! that draws more, moves nothing else. The key is seed (u64 little-endian) | episode (u64
//! little-endian) | 16 zero bytes; the stream number is the purpose in the high 16 bits and the
//! entity (mover 0, mover 1, …) in the low 48. Draws that belong to a moment are addressed by
//! tick ([`Stream::at_tick`]), not by how many were taken before.

use crate::math;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// Purpose of a random stream. The numbers are part of the results contract: never renumber.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u16)]
pub enum Purpose {
    /// Generated maps.
    Map = 1,
    /// Start and goal poses.
    StartGoal = 2,
    /// The perturbed costs of the reference route.
    ReferenceRoute = 3,
    /// Unknown static obstacles.
    UnknownStatic = 4,
    /// Initial state of moving obstacles.
    Dynamic = 5,
    /// Changes of motion while moving (irregular movers).
    Motion = 6,
    /// Sensor noise.
    Sensor = 7,
    /// Localisation noise.
    Localisation = 8,
    /// Actuation noise.
    Actuation = 9,
    /// A planner's own randomness.
    Planner = 10,
    /// Resampling when results are analysed (the bootstrap).
    Resampling = 11,
    /// Points of a sweep.
    Sweep = 12,
}

/// Words of the stream that one tick may draw from ([`Stream::at_tick`]).
const WORDS_PER_TICK: u128 = 1 << 12;

/// The source of all randomness of one episode's world.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct EpisodeSeed {
    /// The scenario's seed.
    pub seed: u64,
    /// The episode's number, counted from 0.
    pub episode: u64,
}

impl EpisodeSeed {
    /// The stream for one purpose and entity, at its beginning.
    pub fn stream(self, purpose: Purpose, entity: u64) -> Stream {
        assert!(entity < 1 << 48, "entity numbers have 48 bits");
        let mut key = [0u8; 32];
        key[..8].copy_from_slice(&self.seed.to_le_bytes());
        key[8..16].copy_from_slice(&self.episode.to_le_bytes());
        let mut rng = ChaCha8Rng::from_seed(key);
        rng.set_stream((purpose as u64) << 48 | entity);
        Stream(rng)
    }
}

/// A stream of random numbers with its own, fixed distributions.
#[derive(Clone, Debug, PartialEq)]
pub struct Stream(ChaCha8Rng);

impl Stream {
    /// The same stream, placed where the draws of `tick` begin: what was drawn before is forgotten.
    pub fn at_tick(&mut self, tick: u32) -> &mut Self {
        self.0.set_word_pos(u128::from(tick) * WORDS_PER_TICK);
        self
    }

    /// A uniform number in [0, 1): 53 random bits times 2⁻⁵³.
    pub fn uniform(&mut self) -> f64 {
        const SCALE: f64 = 1.0 / (1u64 << 53) as f64;
        (self.0.next_u64() >> 11) as f64 * SCALE
    }

    /// A uniform number in [low, high).
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.uniform()
    }

    /// A uniform index in 0..count. The bias is below count · 2⁻⁵³.
    ///
    /// # Panics
    /// If `count` is 0.
    pub fn index(&mut self, count: usize) -> usize {
        assert!(count > 0, "an index needs at least one choice");
        let index = (self.uniform() * count as f64) as usize;
        index.min(count - 1)
    }

    /// A normal number with mean 0 and standard deviation 1 (Box and Muller, 1958): two uniform draws, always.
    pub fn normal(&mut self) -> f64 {
        // 1 − u is in (0, 1], so its logarithm is finite.
        let radius = (-2.0 * math::ln(1.0 - self.uniform())).sqrt();
        radius * math::cos(math::TAU * self.uniform())
    }

    /// 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0.next_u64()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEED: EpisodeSeed = EpisodeSeed { seed: 7, episode: 3 };

    #[test]
    fn streams_are_repeatable_and_apart() {
        let a: Vec<u64> = (0..4)
            .map({
                let mut s = SEED.stream(Purpose::Map, 0);
                move |_| s.bits()
            })
            .collect();
        let b: Vec<u64> = (0..4)
            .map({
                let mut s = SEED.stream(Purpose::Map, 0);
                move |_| s.bits()
            })
            .collect();
        assert_eq!(a, b);
        for other in [
            SEED.stream(Purpose::Map, 1).bits(),
            SEED.stream(Purpose::Dynamic, 0).bits(),
            EpisodeSeed { episode: 4, ..SEED }.stream(Purpose::Map, 0).bits(),
            EpisodeSeed { seed: 8, ..SEED }.stream(Purpose::Map, 0).bits(),
        ] {
            assert_ne!(a[0], other);
        }
    }

    #[test]
    fn draws_are_addressed_by_tick() {
        let mut once = SEED.stream(Purpose::Sensor, 0);
        let mut often = SEED.stream(Purpose::Sensor, 0);
        for _ in 0..17 {
            often.at_tick(5).uniform();
        }
        assert_eq!(once.at_tick(9).bits(), often.at_tick(9).bits());
    }

    #[test]
    fn uniform_has_mean_one_half_and_stays_inside() {
        let mut stream = SEED.stream(Purpose::Planner, 0);
        let draws: Vec<f64> = (0..100_000).map(|_| stream.uniform()).collect();
        assert!(draws.iter().all(|u| (0.0..1.0).contains(u)));
        let mean = draws.iter().sum::<f64>() / draws.len() as f64;
        // Standard error of the mean: 0.2887 / sqrt(1e5) = 0.0009.
        assert!((mean - 0.5).abs() < 0.005, "mean {mean}");
    }

    #[test]
    fn normal_draws_have_the_distribution_function_of_the_normal() {
        let mut stream = SEED.stream(Purpose::Sensor, 1);
        let mut draws: Vec<f64> = (0..100_000).map(|_| stream.normal()).collect();
        draws.sort_unstable_by(f64::total_cmp);
        // Kolmogorov and Smirnov: above 1.95 / √n in one of a thousand samples of the stated distribution.
        let count = draws.len() as f64;
        let distance = draws.iter().enumerate().fold(0.0, |worst, (k, &x)| {
            let below = 0.5 * math::erfc(-x / math::SQRT_2);
            math::max(worst, math::max((below - k as f64 / count).abs(), ((k + 1) as f64 / count - below).abs()))
        });
        assert!(distance < 1.95 / count.sqrt(), "{distance}");
    }
}
