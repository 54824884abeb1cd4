//! Paired measurements: A B A B, in time of the process, so that a busy neighbour disturbs both sides alike.

use rustix::time::{ClockId, clock_gettime};
use std::hint::black_box;

/// Least time of one measurement, s: shorter work is repeated until it takes that long.
const LEAST_S: f64 = 0.02;

/// Median and extremes.
#[derive(Clone, Copy, Debug)]
pub struct Spread {
    pub median: f64,
    pub min: f64,
    pub max: f64,
}

impl Spread {
    /// # Panics
    /// If there are no values.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let middle = values.len() / 2;
        let median = if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) };
        Self { median, min: values[0], max: values[values.len() - 1] }
    }
}

/// Times of a pair of commands, in seconds per call, and the ratio first / second pair by pair.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    pub first: Spread,
    pub second: Spread,
    pub ratio: Spread,
}

/// Times `first` and `second` in turn, `pairs` times each after a warm-up.
pub fn pair<A, B>(pairs: usize, mut first: impl FnMut() -> A, mut second: impl FnMut() -> B) -> Pair {
    let (first_calls, second_calls) = (calls(&mut first), calls(&mut second));
    let (mut firsts, mut seconds) = (Vec::new(), Vec::new());
    for _ in 0..pairs {
        firsts.push(seconds_per_call(first_calls, &mut first));
        seconds.push(seconds_per_call(second_calls, &mut second));
    }
    let ratio = Spread::of(firsts.iter().zip(&seconds).map(|(first, second)| first / second).collect());
    Pair { first: Spread::of(firsts), second: Spread::of(seconds), ratio }
}

/// Times `work` alone, in seconds per call.
pub fn alone<T>(times: usize, mut work: impl FnMut() -> T) -> Spread {
    let calls = calls(&mut work);
    Spread::of((0..times).map(|_| seconds_per_call(calls, &mut work)).collect())
}

/// Number of calls that take long enough to be timed; finding it is also the warm-up.
fn calls<T>(work: &mut impl FnMut() -> T) -> u32 {
    let mut calls = 1;
    while f64::from(calls) * seconds_per_call(calls, work) < LEAST_S {
        calls *= 2;
    }
    calls
}

fn seconds_per_call<T>(calls: u32, work: &mut impl FnMut() -> T) -> f64 {
    let begin_s = process_time_s();
    for _ in 0..calls {
        black_box(work());
    }
    (process_time_s() - begin_s) / f64::from(calls)
}

/// Processor time of this process so far, s.
pub fn process_time_s() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}
