//! Statistics: plain functions of numbers, used by summaries and by paired comparisons.
//!
//! Which function answers which question, for two stacks that drove the same worlds (pairs):
//!
//! | question | test | size of the effect |
//! |---|---|---|
//! | Who succeeds more often? | [`mcnemar_exact`], [`mcnemar_mid_p`] | [`risk_difference`], [`tango_interval`], [`discordant_odds_ratio`] |
//! | Who is faster, shorter, …? | [`signed_rank`] of [`paired_differences`] | [`hodges_lehmann`] and its [interval](hodges_lehmann_interval), [`rank_biserial`] |
//! | By how much in the mean, or as a share? | | [`bootstrap_interval`], [`cohen_d_z`], [`bootstrap_ratio`] |
//! | Are both as good, up to a margin? | [`equivalence_of_rates`], [`equivalence_of_means`] | their intervals |
//! | Of many pairs of stacks, which differ? | [`holm`] over all their p-values | [`Ranking`] |
//! | Were there worlds enough? | [`informative_pairs_min`] | [`minimal_detectable_mean`], [`minimal_detectable_risk_difference`] |
//! | How many worlds would tell them apart? | | [`pairs_needed_mean`], [`pairs_needed_risk_difference`] |
//! | Do two numbers rise together? | [`spearman`], [`kendall_tau_b`] | their coefficients |
//! | What of it is due to the map? | | [`one_way_random`] |
//!
//! Samples that are not paired (a published rate, other worlds) are compared by [`fisher_exact`]
//! and [`rank_sum`] with [`hodges_lehmann_shift`]. All p-values of differences are two-sided. Metrics of drives exist only where both stacks
//! drove to the end: a comparison of times is one *among the worlds that both solved*, and says so.
//!
//! Every function is deterministic to the last bit: portable transcendentals, sums in a fixed
//! order, one fixed stream of random numbers.

mod bootstrap;
mod contingency;
mod correlation;
mod effect;
mod equivalence;
mod groups;
mod hodges_lehmann;
mod holm;
mod interval;
mod normal;
mod paired;
mod quantile;
mod random_groups;
mod rank;
mod sample_size;
mod student;

pub use bootstrap::{Location, RESAMPLES, Ratio, bootstrap_interval, bootstrap_ratio};
pub use contingency::fisher_exact;
pub use correlation::{RankCorrelation, kendall_tau_b, spearman};
pub use effect::{cohen_d_z, discordant_odds_ratio, rank_biserial, risk_difference};
pub use equivalence::{Equivalence, equivalence_of_means, equivalence_of_rates, tango_interval};
pub use groups::{Better, Ranking, pairs};
pub use hodges_lehmann::{
    hodges_lehmann, hodges_lehmann_interval, hodges_lehmann_shift, hodges_lehmann_shift_interval,
};
pub use holm::holm;
pub use interval::{Z_95, wilson};
pub use normal::{normal_quantile, normal_upper_tail};
pub use paired::{PairedOutcomes, mcnemar_exact, mcnemar_mid_p, paired_differences};
pub use quantile::quantile;
pub use random_groups::{RandomGroups, one_way_random};
pub use rank::{EXACT_MAX, NullDistribution, RankSum, SignedRank, rank_sum, signed_rank};
pub use sample_size::{
    ErrorRates, informative_pairs_min, minimal_detectable_mean, minimal_detectable_risk_difference, pairs_needed_mean,
    pairs_needed_risk_difference,
};
pub use student::{student_quantile, student_upper_tail};
