//! Statistics: plain functions of numbers, used by summaries and by paired comparisons.
//!
//! Which function answers which question, for two stacks that drove the same worlds (pairs):
//!
//! | question | test | size of the effect |
//! |---|---|---|
//! | Who succeeds more often? | [`mcnemar_exact`], [`mcnemar_mid_p`] | [`risk_difference`], [`discordant_odds_ratio`] |
//! | Who is faster, shorter, …? | [`signed_rank`] of [`paired_differences`] | [`rank_biserial`], [`cohen_d_z`], [`bootstrap_interval`] |
//! | Of many pairs of stacks, which differ? | [`holm`] over all their p-values | [`Ranking`] |
//! | Were there worlds enough? | [`informative_pairs_min`] | [`minimal_detectable_mean`], [`minimal_detectable_risk_difference`] |
//!
//! Samples that are not paired (a published rate, other worlds) are compared by [`fisher_exact`]
//! and [`rank_sum`]. All p-values are two-sided. Metrics of drives exist only where both stacks
//! drove to the end: a comparison of times is one *among the worlds that both solved*, and says so.
//!
//! Every function is deterministic to the last bit: portable transcendentals, sums in a fixed
//! order, one fixed stream of random numbers.

mod bootstrap;
mod contingency;
mod effect;
mod groups;
mod holm;
mod interval;
mod normal;
mod paired;
mod quantile;
mod rank;
mod sample_size;

pub use bootstrap::{Location, RESAMPLES, bootstrap_interval};
pub use contingency::fisher_exact;
pub use effect::{cohen_d_z, discordant_odds_ratio, rank_biserial, risk_difference};
pub use groups::{Better, Ranking, pairs};
pub use holm::holm;
pub use interval::{Z_95, wilson};
pub use normal::{normal_quantile, normal_upper_tail};
pub use paired::{PairedOutcomes, mcnemar_exact, mcnemar_mid_p, paired_differences};
pub use quantile::quantile;
pub use rank::{EXACT_MAX, NullDistribution, RankSum, SignedRank, rank_sum, signed_rank};
pub use sample_size::{ErrorRates, informative_pairs_min, minimal_detectable_mean, minimal_detectable_risk_difference};
