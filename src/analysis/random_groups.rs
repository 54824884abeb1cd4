//! Groups drawn at random, say maps: how much of the spread lies between them, and what a mean over them is worth.

use super::student_quantile;
use crate::math;

/// A one-way model of random effects: number = mean + effect of its group + error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomGroups {
    /// Mean of the means of the groups.
    pub mean: f64,
    /// Variance within a group.
    pub within: f64,
    /// Variance between the true means of groups; 0 where the estimate is negative.
    pub between: f64,
    /// Intraclass correlation: share of the variance that lies between groups, 0 to 1; `None` if nothing varies.
    pub intraclass: Option<f64>,
    /// 95 % interval of the mean over all groups that there might be: Student's t of the means, groups − 1 degrees of freedom.
    pub interval: (f64, f64),
}

/// Fits [`RandomGroups`]. `None` below two groups, with an empty group, or if no group has two numbers.
///
/// A mean over many worlds of few maps is known as well as its *maps* allow: worlds of one map resemble each other, and an interval
/// over all worlds is too short. The variances come from the analysis of variance: within = mean square within, between = (mean
/// square between − within) / n₀ with n₀ = (N − Σ nᵢ² / N) / (k − 1), the size of the groups where it is equal. With
/// equal sizes they are those of restricted maximum likelihood wherever the estimate is not negative. S. R. Searle, G. Casella and
/// C. E. McCulloch, *Variance Components*, 1992, sections 3.5 and 3.6.
///
/// # Panics
/// If a number is not finite.
pub fn one_way_random(groups: &[Vec<f64>]) -> Option<RandomGroups> {
    assert!(groups.iter().flatten().all(|x| x.is_finite()), "only finite numbers have variances");
    let k = groups.len();
    let sizes: Vec<f64> = groups.iter().map(|group| group.len() as f64).collect();
    let all: f64 = sizes.iter().sum();
    if k < 2 || sizes.contains(&0.0) || all <= k as f64 {
        return None;
    }
    let means: Vec<f64> = groups.iter().zip(&sizes).map(|(group, size)| group.iter().sum::<f64>() / size).collect();
    let squares = |values: &[f64], centre: f64| values.iter().map(|x| (x - centre) * (x - centre)).sum::<f64>();
    let inside: f64 = groups.iter().zip(&means).map(|(group, &mean)| squares(group, mean)).sum();
    let within = inside / (all - k as f64);

    let weighted = means.iter().zip(&sizes).map(|(mean, size)| mean * size).sum::<f64>() / all;
    let apart = means.iter().zip(&sizes).map(|(mean, size)| size * (mean - weighted) * (mean - weighted)).sum::<f64>();
    let size = (all - sizes.iter().map(|size| size * size).sum::<f64>() / all) / (k - 1) as f64;
    let between = math::max((apart / (k - 1) as f64 - within) / size, 0.0);

    let mean = means.iter().sum::<f64>() / k as f64;
    let error = (squares(&means, mean) / (k - 1) as f64 / k as f64).sqrt();
    let reach = -student_quantile(0.025, k as u64 - 1) * error;
    Some(RandomGroups {
        mean,
        within,
        between,
        intraclass: (between + within > 0.0).then(|| between / (between + within)),
        interval: (mean - reach, mean + reach),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_groups_worked_by_hand() {
        // Means 2 and 6, squares within 2 + 2 over 4 − 2 = 2; between: 2 (4 + 4) / 1 = 16, (16 − 2) / 2 = 7.
        let found = one_way_random(&[vec![1.0, 3.0], vec![5.0, 7.0]]).unwrap();
        assert_eq!((found.mean, found.within, found.between, found.intraclass), (4.0, 2.0, 7.0, Some(7.0 / 9.0)));
        // t of one degree of freedom at 97.5 %: tan(0.475 π) = 12.7062; the means have a standard error of √(8 / 2) = 2.
        assert!((found.interval.1 - (4.0 + 2.0 * 12.706_204_736)).abs() < 1e-6, "{:?}", found.interval);
    }

    #[test]
    fn groups_that_do_not_differ_and_those_that_cannot_be_told() {
        let alike = one_way_random(&[vec![1.0, 5.0], vec![5.0, 1.0], vec![2.0, 4.0]]).unwrap();
        assert_eq!((alike.between, alike.intraclass), (0.0, Some(0.0)));
        assert_eq!(one_way_random(&[vec![3.0; 2], vec![3.0; 2]]).unwrap().intraclass, None);
        for groups in [vec![], vec![vec![1.0, 2.0]], vec![vec![1.0], vec![2.0]], vec![vec![1.0, 2.0], vec![]]] {
            assert_eq!(one_way_random(&groups), None, "{groups:?}");
        }
    }
}
