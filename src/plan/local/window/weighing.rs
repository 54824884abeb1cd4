//! What every planner over the window keeps and does at a tick: it rolls, weighs and commands.

use super::objective::Objective;
use super::{Aim, DynamicWindow, Rollouts, Score, Scoring, Settings};
use crate::geometry::Vec2;
use crate::plan::contract::{Decision, Guidance, Situation};

/// The window, the objective on fixed scales and the scores; their memory is used again.
#[derive(Clone, Debug)]
pub(crate) struct Weighing {
    window: DynamicWindow,
    objective: Objective,
    score: Score,
}

impl Weighing {
    /// One that has seen nothing yet.
    pub(crate) fn new(settings: Settings) -> Self {
        Self { window: DynamicWindow::new(settings), objective: Objective::default(), score: Score::default() }
    }

    /// Forgets the map: to be called before each episode.
    pub(crate) fn reset(&mut self) {
        self.window.reset();
    }

    /// The rollouts of this tick for the objective on fixed scales, no faster than `cap_mps`.
    pub(crate) fn roll(&mut self, situation: &Situation<'_>, guidance: &Guidance<'_>, cap_mps: f64) -> &Rollouts {
        let aim = Aim { cap_mps, ..self.objective.aim(situation, guidance, &mut self.window) };
        self.window.roll(situation, &aim)
    }

    /// The best of the rollouts of [`Self::roll`] by `score`; `None` if no rollout is admissible.
    pub(crate) fn best(
        &mut self,
        situation: &Situation<'_>,
        score: impl Fn(&Objective, &Rollouts, usize) -> f64,
    ) -> Option<usize> {
        let objective = &self.objective;
        objective.best(&mut self.window, situation, &mut self.score, |rollouts, i| score(objective, rollouts, i))
    }

    /// Rolls no faster than `cap_mps` and takes the best by a sum of normalised terms, which `add` adds up; `None` if no rollout is
    /// admissible.
    pub(crate) fn best_by_sums(
        &mut self,
        situation: &Situation<'_>,
        cap_mps: f64,
        add: impl FnOnce(&Rollouts, &mut Scoring<'_>),
    ) -> Option<usize> {
        let rollouts = self.window.roll(situation, &Aim { cap_mps, ..Aim::ON });
        let mut scoring = self.score.over(rollouts);
        add(rollouts, &mut scoring);
        scoring.best()
    }

    /// The decision for rollout `best`, or the recovery towards `target` where there is none.
    pub(crate) fn decide(&mut self, best: Option<usize>, situation: &Situation<'_>, target: Vec2) -> Decision {
        self.window.decide(best, situation, target)
    }
}
