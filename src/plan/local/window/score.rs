//! Weighing the admissible rollouts of one cycle: normalised terms, their weighted sum, the choice.

use super::Rollouts;

/// Scores of one cycle's rollouts; keeps its memory.
#[derive(Clone, Debug, Default)]
pub struct Score {
    total: Vec<f64>,
    term: Vec<f64>,
}

impl Score {
    /// Begins a cycle: every score is 0.
    pub fn over<'a>(&'a mut self, rollouts: &'a Rollouts) -> Scoring<'a> {
        self.total.clear();
        self.total.resize(rollouts.len(), 0.0);
        self.term.resize(rollouts.len(), 0.0);
        Scoring { rollouts, total: &mut self.total, term: &mut self.term }
    }
}

/// The scores of one cycle while its terms are being added. Larger is better.
///
/// Each term k is normalised on its own over the admissible rollouts, norm(i) = k(i) / Σ k(j), and 0
/// everywhere where the sum is 0 (qin2026 eq. 17, zhao2025 eq. 13–15, G-A16); weights multiply afterwards (Q-A7).
/// So adding candidates scales every term alike, and a term that hardly varies hardly decides.
#[derive(Debug)]
pub struct Scoring<'a> {
    rollouts: &'a Rollouts,
    total: &'a mut [f64],
    term: &'a mut [f64],
}

impl Scoring<'_> {
    /// Adds `weight` · norm(`term`).
    ///
    /// # Panics
    /// If the term is negative or not finite for an admissible rollout.
    pub fn add(&mut self, weight: f64, term: impl Fn(usize) -> f64) {
        self.add_weighted(|_| weight, term);
    }

    /// Sets the scores as they are.
    ///
    /// # Panics
    /// If a score of an admissible rollout is not finite.
    pub fn set(&mut self, score: impl Fn(usize) -> f64) {
        for i in self.rollouts.admissible() {
            self.total[i] = score(i);
            assert!(self.total[i].is_finite(), "a score is {}", self.total[i]);
        }
    }

    /// Adds `weight(i)` · norm(`term`)(i), for a weight that differs from rollout to rollout (G-A14).
    ///
    /// # Panics
    /// As [`Self::add`].
    pub fn add_weighted(&mut self, weight: impl Fn(usize) -> f64, term: impl Fn(usize) -> f64) {
        self.normalise(term);
        for i in self.rollouts.admissible() {
            self.total[i] += weight(i) * self.term[i];
        }
    }

    /// Multiplies the scores so far by norm(`term`) (Z-A7, multiplicative form).
    ///
    /// # Panics
    /// As [`Self::add`].
    pub fn multiply(&mut self, term: impl Fn(usize) -> f64) {
        self.normalise(term);
        for i in self.rollouts.admissible() {
            self.total[i] *= self.term[i];
        }
    }

    fn normalise(&mut self, term: impl Fn(usize) -> f64) {
        let mut sum = 0.0;
        for i in self.rollouts.admissible() {
            let value = term(i);
            assert!(value.is_finite() && value >= 0.0, "a term of the objective is {value}");
            self.term[i] = value;
            sum += value;
        }
        let scale = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        for i in self.rollouts.admissible() {
            self.term[i] *= scale;
        }
    }

    /// The admissible rollout with the highest score; among equals the one with the larger speed, then the
    /// smaller |yaw rate|, then the lower index. `None` if no rollout is admissible.
    pub fn best(&self) -> Option<usize> {
        self.rollouts.admissible().min_by(|&a, &b| {
            let (p, q) = (self.rollouts.twist(a), self.rollouts.twist(b));
            (self.total[b].total_cmp(&self.total[a]))
                .then(q.v.total_cmp(&p.v))
                .then(p.omega.abs().total_cmp(&q.omega.abs()))
                .then(a.cmp(&b))
        })
    }

    /// The score of a rollout; 0 if it is not admissible.
    pub fn score(&self, index: usize) -> f64 {
        self.total[index]
    }
}
