//! Answers that take simulated time: asked at one tick, in force at a later one.

/// Whole ticks that `cost_s` seconds of planning take, rounded up.
pub(super) fn ticks_of(cost_s: f64, dt_s: f64) -> u32 {
    // A cost that is a whole number of ticks but for rounding is that number.
    (cost_s / dt_s - 1e-9).ceil().clamp(0.0, f64::from(u32::MAX)) as u32
}

/// An answer on its way.
#[derive(Clone, Debug)]
pub(super) struct Pending<T> {
    pub(super) ready_tick: u32,
    pub(super) answer: T,
}

impl<T> Pending<T> {
    /// Takes the answer out of its slot if it is due at `tick`.
    pub(super) fn take(slot: &mut Option<Self>, tick: u32) -> Option<T> {
        slot.take_if(|pending| pending.ready_tick <= tick).map(|pending| pending.answer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cost_is_rounded_up_to_ticks_and_rounding_errors_are_none() {
        assert_eq!([0.0, 1e-12, 0.05, 0.1, 0.3, 0.31].map(|cost_s| ticks_of(cost_s, 0.1)), [0, 0, 1, 1, 3, 4]);
        assert_eq!((ticks_of(1e30, 0.1), ticks_of(0.1, 0.05)), (u32::MAX, 2));
    }

    #[test]
    fn an_answer_is_taken_once_and_not_before_its_time() {
        let mut slot = Some(Pending { ready_tick: 5, answer: 'a' });
        assert_eq!([4, 5, 6].map(|tick| Pending::take(&mut slot, tick)), [None, Some('a'), None]);
    }
}
