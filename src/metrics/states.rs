//! Time that a local planner spent in each of its states, and how often it entered each.

use crate::plan::contract::StateKind;
use crate::trace::Trace;
use serde::{Deserialize, Serialize};

/// The time that a local planner spent in one of its states in one episode: a row of `states.csv`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateTime {
    /// Name of the state.
    pub state: String,
    /// Time in it, s: ticks decided in the state times dt, a last one that a contact ended up to there. Over all states it is the
    /// time of the episode.
    pub seconds: f64,
    /// Number of times that it was entered: maximal runs of ticks.
    pub entries: u32,
}

/// A state that lasted no longer is left out, s: a contact may end a tick with its beginning, and a table that is read again after a
/// kill is tested by its times.
const SHORTEST_S: f64 = 1e-6;

/// The states of an episode in the order in which they were first entered; empty if no tick was driven.
pub fn states(trace: &Trace, dt_s: f64) -> Vec<StateTime> {
    let mut found: Vec<(&str, u32)> = Vec::new();
    let mut before = None;
    // Row 0 is the state before the first decision.
    for tick in trace.ticks.iter().skip(1) {
        let name = tick.state.name;
        let index = found.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
            found.push((name, 0));
            found.len() - 1
        });
        found[index].1 += u32::from(before != Some(name));
        before = Some(name);
    }
    let state = |(name, entries): (&str, u32)| StateTime {
        state: name.to_owned(),
        seconds: trace.time_where_s(dt_s, |tick| tick.state.name == name),
        entries,
    };
    found.into_iter().map(state).filter(|state| state.seconds > SHORTEST_S).collect()
}

/// Time that the local planner spent in states of one kind, s: ticks decided in them times dt, a last one that a contact ended up
/// to there.
pub(super) fn kind_s(trace: &Trace, kind: StateKind, dt_s: f64) -> f64 {
    trace.time_where_s(dt_s, |tick| tick.state.kind == kind)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Twist};
    use crate::plan::contract::State;

    #[test]
    fn ticks_and_runs_of_ticks_are_counted_by_state() {
        let mut ticks = crate::metrics::tests::drive(Pose::new(0.0, 0.0, 0.0), &[Twist::ZERO; 7]);
        // The row before the first tick says nothing: recover, track, track, recover, recover, track, track.
        for (row, mode) in [0, 1, 0, 0, 1, 1, 0, 0].into_iter().enumerate() {
            ticks[row].state = [State::TRACK, State::RECOVER][mode];
        }
        let trace = Trace { ticks, ..Trace::default() };
        let found = states(&trace, 0.1);
        let expected = [("recover", 0.3, 2), ("track", 0.4, 2)];
        assert_eq!(found.iter().map(|s| (s.state.as_str(), s.seconds, s.entries)).collect::<Vec<_>>(), expected);
        // A contact 25 ms after the beginning of the last tick, and one with its beginning.
        let seconds = |contact_s: f64| {
            let trace = Trace { contact_s: Some(contact_s), ..trace.clone() };
            states(&trace, 0.1).iter().map(|state| state.seconds).collect::<Vec<_>>()
        };
        assert_eq!((seconds(0.025), seconds(0.0)), (vec![0.3, 0.325], vec![0.3, 0.3]));
        let kinds = [StateKind::Recovering, StateKind::Tracking, StateKind::Waiting];
        assert_eq!(kinds.map(|kind| kind_s(&trace, kind, 0.1)), [0.3, 0.4, 0.0]);
    }

    #[test]
    fn without_a_tick_there_is_no_state() {
        assert_eq!(states(&Trace::default(), 0.1), []);
        let ticks = crate::metrics::tests::drive(Pose::new(0.0, 0.0, 0.0), &[]);
        assert_eq!(states(&Trace { ticks, ..Trace::default() }, 0.1), []);
        let ticks = crate::metrics::tests::drive(Pose::new(0.0, 0.0, 0.0), &[Twist::ZERO]);
        assert_eq!(states(&Trace { ticks, contact_s: Some(0.0), ..Trace::default() }, 0.1), [], "hit at 0 s");
    }
}
