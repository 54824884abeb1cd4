//! A ranking of stacks into groups that the data can tell apart.

/// All pairs (i, j) with i < j of `count` things: (0, 1), (0, 2), …, (1, 2), …
pub fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)))
}

/// Direction in which scores are better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// Higher is better, as for a success rate.
    Higher,
    /// Lower is better, as for a travel time.
    Lower,
}

/// Stacks from best to worst, and the groups within which no difference was shown.
///
/// A compact letter display: two stacks share a group if and only if the test of their pair did
/// *not* tell them apart. Sharing a group is no proof of equality, and it is not transitive: a
/// and b may share one, b and c another, while a and c differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ranking {
    /// Numbers of the stacks, best score first; equal scores in their given order.
    pub order: Vec<usize>,
    /// The groups, each the numbers of its stacks in the order of `order`. Every stack is in one.
    pub groups: Vec<Vec<usize>>,
}

impl Ranking {
    /// Ranks stacks by `scores` and groups those that differ by no adjusted p-value up to `alpha`.
    ///
    /// `p_adjusted` has one value per pair in the order of [`pairs`], adjusted for the whole family
    /// ([`holm`](super::holm)). Groups are cliques of the graph "not told apart" that cover all its
    /// edges. The fewest possible are NP-hard to find; these come from clique growing: the first
    /// pair in the order of the ranking that shares no group yet starts one, which takes in each
    /// further stack, best first, that differs from none of its members. Then, last first, a group
    /// is dropped if each of its pairs also shares another. Sorted by best member. Deterministic,
    /// O(k⁴) for k stacks in the worst case, at most k²/2 groups (insert-and-absorb may need
    /// exponentially many steps). J. Gramm, J. Guo, F. Hüffner, R. Niedermeier, H.-P. Piepho and
    /// R. Schmid, *Algorithms for compact letter displays: comparison and evaluation*,
    /// Computational Statistics & Data Analysis 52, 2007; the display itself: H.-P. Piepho, *An
    /// algorithm for a letter-based representation of all-pairwise comparisons*, Journal of
    /// Computational and Graphical Statistics 13, 2004.
    ///
    /// # Panics
    /// If a score is not a number, a p-value is outside [0, 1] or there is not one per pair.
    pub fn new(scores: &[f64], better: Better, p_adjusted: &[f64], alpha: f64) -> Self {
        let count = scores.len();
        assert!(scores.iter().all(|score| !score.is_nan()), "a score is not a number: {scores:?}");
        assert_eq!(p_adjusted.len(), pairs(count).count(), "one p-value per pair of {count} stacks");
        assert!(p_adjusted.iter().all(|p| (0.0..=1.0).contains(p)), "p-values lie between 0 and 1: {p_adjusted:?}");

        let mut order: Vec<usize> = (0..count).collect();
        // partial_cmp, not total_cmp: −0.0 and 0.0 are equal scores. The sort keeps equals in order.
        let ascending = |a: usize, b: usize| scores[a].partial_cmp(&scores[b]).unwrap_or(std::cmp::Ordering::Equal);
        order.sort_by(|&a, &b| match better {
            Better::Higher => ascending(b, a),
            Better::Lower => ascending(a, b),
        });

        let mut rank = vec![0; count];
        for (position, &stack) in order.iter().enumerate() {
            rank[stack] = position;
        }
        let mut alike = Relation::empty(count);
        for ((i, j), &p) in pairs(count).zip(p_adjusted) {
            alike.set(rank[i], rank[j], p > alpha);
        }
        let groups = cover_by_cliques(&alike);
        let groups = groups.into_iter().map(|group| group.into_iter().map(|position| order[position]).collect());
        Self { groups: groups.collect(), order }
    }

    /// The letters of each stack (by its number): one per group it is in, in alphabetical order.
    ///
    /// Groups are a, b, …, z, aa, ab, …; beyond 26 of them a stack's letters are joined by dots.
    pub fn letters(&self) -> Vec<String> {
        let separator = if self.groups.len() > 26 { "." } else { "" };
        let of_stack = |stack| {
            let member_of = self.groups.iter().enumerate().filter(|(_, group)| group.contains(&stack));
            member_of.map(|(index, _)| group_name(index)).collect::<Vec<_>>().join(separator)
        };
        (0..self.order.len()).map(of_stack).collect()
    }
}

/// a, b, …, z, aa, ab, …
fn group_name(index: usize) -> String {
    let last = char::from(b'a' + (index % 26) as u8);
    let before = if index < 26 { String::new() } else { group_name(index / 26 - 1) };
    format!("{before}{last}")
}

/// A symmetric relation between numbers below `count`.
struct Relation {
    count: usize,
    holds: Vec<bool>,
}

impl Relation {
    fn empty(count: usize) -> Self {
        Self { count, holds: vec![false; count * count] }
    }

    fn get(&self, i: usize, j: usize) -> bool {
        self.holds[i * self.count + j]
    }

    fn set(&mut self, i: usize, j: usize, holds: bool) {
        self.holds[i * self.count + j] = holds;
        self.holds[j * self.count + i] = holds;
    }
}

/// Cliques that cover every edge and every vertex, as [`Ranking::new`] describes them.
fn cover_by_cliques(alike: &Relation) -> Vec<Vec<usize>> {
    let count = alike.count;
    let mut covered = Relation::empty(count);
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for i in 0..count {
        for j in i + 1..count {
            if alike.get(i, j) && !covered.get(i, j) {
                let mut group = vec![i, j];
                for k in 0..count {
                    // No stack is its own neighbour, so a member never joins twice.
                    if group.iter().all(|&member| alike.get(k, member)) {
                        group.push(k);
                    }
                }
                group.sort_unstable();
                for (a, b) in pairs(group.len()) {
                    covered.set(group[a], group[b], true);
                }
                groups.push(group);
            }
        }
        if !(0..count).any(|j| alike.get(i, j)) {
            groups.push(vec![i]);
        }
    }
    for index in (0..groups.len()).rev() {
        let group = &groups[index];
        let is_elsewhere = |&(a, b): &(usize, usize)| {
            let holds_both = |other: &Vec<usize>| other.contains(&group[a]) && other.contains(&group[b]);
            groups.iter().enumerate().any(|(i, other)| i != index && holds_both(other))
        };
        if group.len() > 1 && pairs(group.len()).all(|pair| is_elsewhere(&pair)) {
            groups.remove(index);
        }
    }
    groups.sort();
    groups
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::{EpisodeSeed, Purpose};

    /// p-values of 0.01 for the pairs told apart, 0.5 for the others.
    fn p_values(count: usize, apart: &[(usize, usize)]) -> Vec<f64> {
        pairs(count).map(|pair| if apart.contains(&pair) { 0.01 } else { 0.5 }).collect()
    }

    #[test]
    fn pairs_come_in_reading_order() {
        assert_eq!(pairs(4).collect::<Vec<_>>(), [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)]);
        assert_eq!(pairs(0).count() + pairs(1).count(), 0);
    }

    #[test]
    fn neighbours_in_the_ranking_overlap() {
        // Times 1, 2, 3, 4 s given as stacks 3, 1, 0, 2; only the best and the two worst differ.
        let ranking = Ranking::new(&[3.0, 2.0, 4.0, 1.0], Better::Lower, &p_values(4, &[(0, 3), (2, 3)]), 0.05);
        assert_eq!(ranking.order, [3, 1, 0, 2]);
        assert_eq!(ranking.groups, [vec![3, 1], vec![1, 0, 2]]);
        assert_eq!(ranking.letters(), ["b", "ab", "b", "a"]);
        let reversed = Ranking::new(&[3.0, 2.0, 4.0, 1.0], Better::Higher, &p_values(4, &[(0, 3), (2, 3)]), 0.05);
        assert_eq!(reversed.order, [2, 0, 1, 3]);
        assert_eq!(reversed.letters(), ["a", "ab", "a", "b"]);
    }

    #[test]
    fn the_eight_treatments_of_piepho_2004() {
        // Example 3 of the paper: T1 T7, T1 T8, T2 T4, T2 T5 and T3 T5 are told apart. Told-apart pairs
        // form a star 7-1-8, a path 4-2-5-3 and T6 alone. Each group takes {1} or {7, 8}, and {4, 5}, {3, 4}
        // or {2, 3}, and 6: six are possible (insert-and-absorb gives them all), five cover all pairs, for
        // {1} and {7, 8} each need {4, 5} and {2, 3}, and the pair 3 4 needs one more.
        let apart = [(0, 6), (0, 7), (1, 3), (1, 4), (2, 4)];
        let scores: Vec<f64> = (1..=8).map(f64::from).collect();
        let ranking = Ranking::new(&scores, Better::Lower, &p_values(8, &apart), 0.05);
        assert_eq!(ranking.letters(), ["abc", "ad", "abd", "bce", "ce", "abcde", "de", "de"]);
    }

    #[test]
    fn all_alike_all_apart_one_and_none() {
        assert_eq!(Ranking::new(&[1.0, 1.0, 2.0], Better::Higher, &[1.0; 3], 0.05).letters(), ["a", "a", "a"]);
        let apart = Ranking::new(&[1.0, 1.0, 2.0], Better::Higher, &[0.05; 3], 0.05);
        assert_eq!((apart.letters(), &apart.order[..]), (vec!["b".into(), "c".into(), "a".into()], &[2, 0, 1][..]));
        assert_eq!(Ranking::new(&[0.5], Better::Higher, &[], 0.05).letters(), ["a"]);
        assert_eq!(Ranking::new(&[], Better::Higher, &[], 0.05).letters(), [""; 0]);
    }

    #[test]
    fn two_stacks_share_a_group_exactly_if_not_told_apart() {
        let mut stream = EpisodeSeed { seed: 2, episode: 0 }.stream(Purpose::Resampling, 2);
        for _ in 0..3000 {
            let count = stream.index(11);
            let share = stream.uniform();
            let scores: Vec<f64> = (0..count).map(|_| stream.index(6) as f64).collect();
            let p: Vec<f64> = pairs(count).map(|_| if stream.uniform() < share { 0.01 } else { 0.5 }).collect();
            let ranking = Ranking::new(&scores, Better::Higher, &p, 0.05);
            let share_one = |groups: &[Vec<usize>], i, j| groups.iter().any(|g| g.contains(&i) && g.contains(&j));
            for ((i, j), &p) in pairs(count).zip(&p) {
                assert_eq!(share_one(&ranking.groups, i, j), p > 0.05, "{i} {j}");
            }
            assert!(ranking.letters().iter().all(|letters| !letters.is_empty()));
            assert!(ranking.order.is_sorted_by(|&a, &b| scores[a] > scores[b] || (scores[a] == scores[b] && a < b)));
            // No group is superfluous: without it some pair, or some stack, is in none.
            for index in 0..ranking.groups.len() {
                let mut others = ranking.groups.clone();
                let group = others.remove(index);
                let is_needed = pairs(group.len()).any(|(a, b)| !share_one(&others, group[a], group[b]));
                assert!(is_needed || group.len() == 1);
            }
        }
    }

    #[test]
    fn groups_beyond_the_alphabet_have_names() {
        assert_eq!([0, 25, 26, 51, 52, 701, 702].map(group_name), ["a", "z", "aa", "az", "ba", "zz", "aaa"]);
        let apart = Ranking::new(&[0.0; 28], Better::Lower, &[0.0; 28 * 27 / 2], 0.05);
        assert_eq!(apart.letters()[27], "ab");
    }
}
