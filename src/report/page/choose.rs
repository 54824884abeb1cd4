//! Which episodes a page shows: failures first, then the extremes of the successes, then a spread of them.

use crate::comparison::COMPARED;
use crate::results::{Row, metric_column};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Why an episode is shown; the order of the gallery.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Reason {
    /// It failed.
    Failure,
    /// Another stack failed in the same world.
    SameWorld,
    /// The longest time of its stack.
    Slowest,
    /// The longest drive of its stack.
    Longest,
    /// The smallest clearance of its stack.
    Closest,
    /// One of the rest.
    Spread,
}

impl Reason {
    /// Heading of its episodes in a gallery; failures are headed by their causes.
    pub fn words(self) -> &'static str {
        match self {
            Self::Failure => "failures",
            Self::SameWorld => "in the same worlds",
            Self::Slowest => "the slowest of each stack",
            Self::Longest => "the longest way of each stack",
            Self::Closest => "the closest to an obstacle of each stack",
            Self::Spread => "a spread of successes",
        }
    }
}

/// An episode to be shown.
#[derive(Clone, Debug)]
pub(super) struct Choice {
    /// Why.
    pub reason: Reason,
    /// Its row.
    pub row: Row,
}

/// The rows of one world, all stacks.
type World = Rc<Vec<Row>>;
/// A row of a world.
type Place = (World, usize);

/// Episodes that may be shown, gathered row by row in bounded memory.
#[derive(Debug)]
pub(super) struct Candidates {
    shown: usize,
    /// Names of stacks by first row.
    stacks: Vec<String>,
    /// By ending, then stack: the first worlds, with the place of the row.
    failures: BTreeMap<(String, usize), Vec<Place>>,
    /// By stack and metric: the most extreme worlds, the first one first.
    extremes: BTreeMap<(usize, usize), Vec<(f64, Place)>>,
    /// By stack: worlds at even distances.
    spread: BTreeMap<usize, Spread>,
}

/// Successes of one stack, every `stride`-th.
#[derive(Debug)]
struct Spread {
    stride: u64,
    seen: u64,
    worlds: Vec<Place>,
}

const FAILURES_A_GROUP: usize = 12;
const EXTREMES_A_STACK: usize = 2;
const SPREAD_A_STACK: usize = 8;

/// The metrics whose extremes are shown, with the reason and whether the largest is meant.
const EXTREME: [(&str, Reason, bool); COMPARED.len()] = [
    ("time_s", Reason::Slowest, true),
    ("length_m", Reason::Longest, true),
    ("clearance_min_m", Reason::Closest, false),
];

impl Candidates {
    /// No candidates yet for `shown` episodes.
    pub fn new(shown: usize) -> Self {
        Self {
            shown,
            stacks: Vec::new(),
            failures: BTreeMap::new(),
            extremes: BTreeMap::new(),
            spread: BTreeMap::new(),
        }
    }

    /// Looks at the rows of one world.
    pub fn offer(&mut self, world: &World) {
        if self.shown == 0 {
            return;
        }
        for (place, row) in world.iter().enumerate() {
            let stack = self.stacks.iter().position(|name| *name == row.stack).unwrap_or_else(|| {
                self.stacks.push(row.stack.clone());
                self.stacks.len() - 1
            });
            // Without a trace there is nothing to show.
            if row.trace_digest.is_none() {
                continue;
            }
            if !row.outcome.is_success() {
                let group = self.failures.entry((row.outcome.words(), stack)).or_default();
                if group.len() < FAILURES_A_GROUP {
                    group.push((Rc::clone(world), place));
                }
                continue;
            }
            for (index, (metric, _, largest)) in EXTREME.iter().enumerate() {
                let column = metric_column(metric).expect("a column of the table, as a test asserts");
                let Some(value) = column.number(&row.metrics) else { continue };
                let rank = if *largest { value } else { -value };
                let best = self.extremes.entry((stack, index)).or_default();
                let at = best.iter().position(|(other, _)| rank > *other).unwrap_or(best.len());
                if at < EXTREMES_A_STACK {
                    best.insert(at, (rank, (Rc::clone(world), place)));
                    best.truncate(EXTREMES_A_STACK);
                }
            }
            let spread = self.spread.entry(stack).or_insert(Spread { stride: 1, seen: 0, worlds: Vec::new() });
            if spread.seen.is_multiple_of(spread.stride) {
                spread.worlds.push((Rc::clone(world), place));
                if spread.worlds.len() > SPREAD_A_STACK {
                    let mut kept = (0..).map(|at: usize| at.is_multiple_of(2));
                    spread.worlds.retain(|_| kept.next().unwrap_or(false));
                    spread.stride *= 2;
                }
            }
            spread.seen += 1;
        }
    }

    /// The episodes to show, at most as many as were asked for: failures up to three fifths, taken from every ending and stack in
    /// turn, each with a drive of another stack in the same world (one that succeeded, if there is one); then the extremes of each
    /// stack up to five sixths; then a spread of the rest; then more failures if there is room. The same rows make the same choice.
    pub fn choose(&self) -> Vec<Choice> {
        let mut chosen = Chosen { known: BTreeSet::new(), choices: Vec::new() };
        let (first, then) = (self.shown * 3 / 5, self.shown * 5 / 6);
        self.take_failures(&mut chosen, if self.shown < 4 { self.shown } else { first });
        for rank in 0..EXTREMES_A_STACK {
            for (index, (_, reason, _)) in EXTREME.iter().enumerate() {
                for stack in 0..self.stacks.len() {
                    if let Some((_, (world, place))) =
                        self.extremes.get(&(stack, index)).and_then(|best| best.get(rank))
                    {
                        chosen.take(*reason, &world[*place], then.max(1));
                    }
                }
            }
        }
        for at in 0..=SPREAD_A_STACK {
            for spread in self.spread.values() {
                if let Some((world, place)) = spread.worlds.get(at) {
                    chosen.take(Reason::Spread, &world[*place], self.shown);
                }
            }
        }
        self.take_failures(&mut chosen, self.shown);
        chosen.choices.sort_by_key(|choice| choice.reason);
        chosen.choices
    }

    fn take_failures(&self, chosen: &mut Chosen, most: usize) {
        for at in 0..FAILURES_A_GROUP {
            for group in self.failures.values() {
                let Some((world, place)) = group.get(at) else { continue };
                let row = &world[*place];
                let others = || world.iter().filter(|other| other.stack != row.stack && other.trace_digest.is_some());
                let beside = others().find(|other| other.outcome.is_success()).or_else(|| others().next());
                chosen.take(Reason::Failure, row, most);
                if let Some(other) = beside {
                    let reason = if other.outcome.is_success() { Reason::SameWorld } else { Reason::Failure };
                    chosen.take(reason, other, most);
                }
            }
        }
    }
}

struct Chosen {
    known: BTreeSet<(u32, u64, u64, String)>,
    choices: Vec<Choice>,
}

impl Chosen {
    fn take(&mut self, reason: Reason, row: &Row, most: usize) {
        if self.choices.len() < most && self.known.insert((row.point, row.seed, row.episode, row.stack.clone())) {
            self.choices.push(Choice { reason, row: row.clone() });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::episode::Outcome;
    use crate::metrics::Metrics;
    use crate::results::Digest;
    use crate::world::ObstacleKind;

    fn row(stack: &str, episode: u64, outcome: Outcome) -> Row {
        let time_s = Some(10.0 + episode as f64);
        Row {
            stack: stack.to_owned(),
            episode,
            outcome,
            metrics: Metrics { time_s, length_m: time_s, clearance_min_m: time_s, ..Metrics::default() },
            world_digest: Some(Digest(episode)),
            trace_digest: Some(Digest(episode)),
            ..Row::blank()
        }
    }

    fn candidates(shown: usize) -> Candidates {
        let mut candidates = Candidates::new(shown);
        for episode in 0..40 {
            let a = if episode == 30 { Outcome::Stuck } else { Outcome::Success };
            let b = match episode % 4 {
                0 => Outcome::Collision { with: ObstacleKind::Dynamic, at_rest: false },
                1 => Outcome::Timeout,
                _ => Outcome::Success,
            };
            candidates.offer(&Rc::new(vec![row("a", episode, a), row("b", episode, b)]));
        }
        candidates
    }

    #[test]
    fn failures_come_first_from_every_ending_in_turn_each_beside_another_stack() {
        let chosen = candidates(20).choose();
        assert_eq!(chosen.len(), 20);
        let failures: Vec<(String, u64)> = chosen
            .iter()
            .filter(|choice| choice.reason == Reason::Failure)
            .map(|choice| (choice.row.outcome.words(), choice.row.episode))
            .collect();
        // Twelve of twenty places, each failure with its companion.
        let kinds = ["collision with dynamic", "stuck", "timeout"].map(str::to_owned);
        assert!(kinds.iter().all(|kind| failures.iter().any(|(ending, _)| ending == kind)), "{failures:?}");
        assert_eq!(failures[0], ("collision with dynamic".to_owned(), 0));
        let beside = chosen.iter().filter(|choice| choice.reason == Reason::SameWorld);
        assert!(beside.clone().count() >= 5 && beside.clone().all(|choice| choice.row.outcome.is_success()));
        let slowest = chosen.iter().find(|choice| choice.reason == Reason::Slowest).map(|choice| choice.row.episode);
        assert_eq!(slowest, Some(39));
        assert!(chosen.iter().any(|choice| choice.reason == Reason::Spread));
        assert!(chosen.windows(2).all(|pair| pair[0].reason <= pair[1].reason));
    }

    #[test]
    fn no_more_are_chosen_than_asked_for_and_none_twice() {
        for shown in [0, 1, 2, 3, 5, 60, 1000] {
            let chosen = candidates(shown).choose();
            assert!(chosen.len() <= shown && (shown == 0 || !chosen.is_empty()), "{shown}");
            let keys: BTreeSet<(u64, &str)> =
                chosen.iter().map(|choice| (choice.row.episode, choice.row.stack.as_str())).collect();
            assert_eq!(keys.len(), chosen.len());
        }
    }

    #[test]
    fn a_row_without_a_trace_is_not_shown() {
        let mut candidates = Candidates::new(10);
        let nowhere = Row {
            outcome: Outcome::InfeasibleWorld { message: String::new() },
            trace_digest: None,
            ..row("a", 0, Outcome::Stuck)
        };
        candidates.offer(&Rc::new(vec![nowhere]));
        assert!(candidates.choose().is_empty());
    }
}
