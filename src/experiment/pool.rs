//! The one pool of threads: the same work on several of them, or numbered pieces of it.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Number of processors; 1 if it is unknown.
pub fn threads_available() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// The answers of `work`, run on `threads` threads at once, the caller's own included, whose answer comes first; on fewer where
/// the system has no room for so many.
///
/// # Panics
/// If `work` does, after the other threads have ended.
pub fn on_threads<T: Send>(threads: usize, work: impl Fn() -> T + Sync) -> Vec<T> {
    std::thread::scope(|scope| {
        let start = |_| std::thread::Builder::new().spawn_scoped(scope, &work).ok();
        let others: Vec<_> = (1..threads).map_while(start).collect();
        let mut answers = vec![work()];
        answers.extend(
            others.into_iter().map(|other| other.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))),
        );
        answers
    })
}

/// The answers of `work` to 0, 1, … `count` − 1, in that order, whichever of `threads` threads finds them.
pub fn in_order<T: Send>(count: usize, threads: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let next = AtomicUsize::new(0);
    let found = on_threads(threads.min(count), || {
        let take = || Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&index| index < count);
        std::iter::from_fn(take).map(|index| (index, work(index))).collect::<Vec<(usize, T)>>()
    });
    let mut answers: Vec<(usize, T)> = found.into_iter().flatten().collect();
    answers.sort_by_key(|(index, _)| *index);
    answers.into_iter().map(|(_, answer)| answer).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_piece_is_done_once_and_answers_come_in_order() {
        for (count, threads) in [(0, 4), (1, 4), (7, 1), (100, 3)] {
            let done = AtomicUsize::new(0);
            let answers = in_order(count, threads, |index| {
                done.fetch_add(1, Ordering::Relaxed);
                // Early pieces take longest.
                (0..count - index).for_each(|_| std::thread::yield_now());
                index * index
            });
            assert_eq!(answers, (0..count).map(|index| index * index).collect::<Vec<_>>());
            assert_eq!(done.into_inner(), count);
        }
    }

    #[test]
    fn as_many_threads_answer_as_were_asked_for() {
        assert_eq!((on_threads(3, || 1).len(), on_threads(1, || 1).len(), on_threads(0, || 1).len()), (3, 1, 1));
    }
}
