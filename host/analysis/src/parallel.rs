//! Divides long computations into numbered pieces that run on several threads.

use std::cell::Cell;
use std::num::NonZeroUsize;
use std::panic::resume_unwind;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{Builder, available_parallelism, scope};

/// Asked before each piece: whether the user wants no more of them.
pub type Interrupted<'a> = &'a (dyn Fn() -> bool + Sync);

thread_local! {
    /// Whether this thread computes pieces beside others: what it divides further has no more cores.
    static IS_WORKER: Cell<bool> = const { Cell::new(false) };
}

/// Calls `act` for each number below `count` and returns the results in the order of the numbers, however many threads
/// there are: one for each core where `threads` does not say, and none but its own within a computation that is divided
/// already. `act` may overwrite the memory that it gets, which `memory` allocates.
///
/// Pieces are started in the order of their numbers. Once `is_interrupted` no further piece is started, and the
/// results of the first ones are returned: a computation that was interrupted can be repeated with a
/// smaller `count`. `progress` is called after each piece with the number of pieces done.
pub fn pieces<M, T: Send>(
    count: u64,
    threads: Option<NonZeroUsize>,
    is_interrupted: Interrupted<'_>,
    progress: impl FnMut(u64) + Send,
    memory: impl Fn() -> M + Sync,
    act: impl Fn(&mut M, u64) -> T + Sync,
) -> Vec<T> {
    let done = Mutex::new((0, progress));
    let next = AtomicU64::new(0);
    let work = || {
        let mut memory = memory();
        let mut results = Vec::new();
        while !is_interrupted() {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                break;
            }
            results.push((number, act(&mut memory, number)));
            let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
            let (count, progress) = &mut *done;
            *count += 1;
            progress(*count);
        }
        results
    };
    let cores = || available_parallelism().map_or(1, NonZeroUsize::get);
    let most = threads.map_or_else(cores, NonZeroUsize::get);
    let workers = usize::try_from(count).map_or(most, |count| count.min(most));
    // A single piece may be divided further, unless the number of threads is stated.
    let mut results = if IS_WORKER.get() || (count < 2 && threads.is_none()) {
        work()
    } else {
        scope(|scope| {
            let worker = || {
                IS_WORKER.set(true);
                work()
            };
            // Where the system starts no more threads, those that it has started do the work, or else this one.
            let workers: Vec<_> = (0..workers)
                .map_while(|_| Builder::new().spawn_scoped(scope, worker).ok())
                .collect();
            if workers.is_empty() {
                return work();
            }
            let results = workers.into_iter().map(|worker| worker.join());
            results.flat_map(|result| result.unwrap_or_else(|panic| resume_unwind(panic))).collect()
        })
    };
    results.sort_unstable_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Calls `act` for each item on all cores and returns the results in the order of the items.
pub fn each<I: Sync, M, T: Send>(
    items: &[I],
    memory: impl Fn() -> M + Sync,
    act: impl Fn(&mut M, &I) -> T + Sync,
) -> Vec<T> {
    let one = |memory: &mut M, number: u64| act(memory, &items[number as usize]);
    pieces(items.len() as u64, None, &|| false, |_| (), memory, one)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;
    use std::thread;

    use super::*;

    const FOUR: Option<NonZeroUsize> = NonZeroUsize::new(4);

    #[test]
    fn the_order_is_that_of_the_numbers_and_progress_counts_every_piece() {
        let mut heard = Vec::new();
        let progress = |done| heard.push(done);
        let squares = pieces(1000, FOUR, &|| false, progress, || (), |(), number| number * number);
        assert_eq!(squares, (0..1000).map(|number| number * number).collect::<Vec<_>>());
        assert_eq!(heard, (1..=1000).collect::<Vec<_>>());
        assert!(each(&[0_u8; 0], || (), |(), item| *item).is_empty());
    }

    #[test]
    fn after_an_interruption_no_piece_is_begun() {
        let pressed = AtomicBool::new(false);
        let press = |done| {
            if done == 10 {
                pressed.store(true, Ordering::SeqCst);
            }
        };
        let is_pressed = || pressed.load(Ordering::SeqCst);
        let numbers = pieces(u64::MAX, FOUR, &is_pressed, press, || (), |(), number| number);
        // Each of the other three threads may have started one more piece.
        assert!((10..=13).contains(&numbers.len()), "{numbers:?}");
        assert!(numbers.is_sorted());
    }

    #[test]
    fn a_piece_that_is_divided_further_stays_on_its_thread() {
        let strangers = |(): &mut (), _| {
            let own = thread::current().id();
            let threads = each(&[(); 8], || (), |(), ()| thread::current().id());
            threads.iter().filter(|thread| **thread != own).count()
        };
        for threads in [NonZeroUsize::new(1), FOUR] {
            assert_eq!(pieces(8, threads, &|| false, |_| (), || (), strangers), [0; 8]);
        }
    }

    #[test]
    #[should_panic(expected = "the seventh")]
    fn a_panic_in_a_piece_is_one_of_the_caller() {
        pieces(8, FOUR, &|| false, |_| (), || (), |(), number| assert!(number != 6, "the seventh"));
    }
}
