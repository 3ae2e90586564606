//! Divides long computations into numbered pieces that run on the threads of rayon.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

/// Asked before each piece: whether the user wants no more of them.
pub type Interrupted<'a> = &'a (dyn Fn() -> bool + Sync);

/// Calls `act` for each number below `count` and returns the results in the order of the numbers, however
/// many threads there are. `act` may overwrite the memory that it gets, which `memory` allocates.
///
/// Pieces are started in the order of their numbers. Once `is_interrupted` no further piece is started, and the
/// results of the first ones are returned: a computation that was interrupted can be repeated with a
/// smaller `count`. `progress` is called after each piece with the number of pieces done.
pub fn pieces<M, T: Send>(
    count: u64,
    is_interrupted: Interrupted<'_>,
    progress: impl FnMut(u64) + Send,
    memory: impl Fn() -> M + Sync + Send,
    act: impl Fn(&mut M, u64) -> T + Sync + Send,
) -> Vec<T> {
    let done = Mutex::new((0, progress));
    let next = AtomicU64::new(0);
    let piece = |memory: &mut M, _| {
        let number = next.fetch_add(1, Ordering::Relaxed);
        let result = act(memory, number);
        let mut done = done.lock().unwrap_or_else(PoisonError::into_inner);
        let (count, progress) = &mut *done;
        *count += 1;
        progress(*count);
        (number, result)
    };
    let turns = (0..count).into_par_iter().take_any_while(|_| !is_interrupted());
    let mut results: Vec<_> = turns.map_init(memory, piece).collect();
    results.sort_unstable_by_key(|(number, _)| *number);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Calls `act` for each number below `count` and returns the results in the order of the numbers. Within a computation
/// that is divided already, it runs on its own thread: there is no other work for one that waits.
pub fn each<M, T: Send>(
    count: u32,
    progress: impl FnMut(u32, u32) + Send,
    memory: impl Fn() -> M + Sync + Send,
    act: impl Fn(&mut M, u32) -> T + Sync + Send,
) -> Vec<T> {
    let progress = Mutex::new((0, progress));
    let one = |memory: &mut M, number: u32| {
        let result = act(memory, number);
        let mut done = progress.lock().unwrap_or_else(PoisonError::into_inner);
        let (finished, progress) = &mut *done;
        *finished += 1;
        progress(*finished, count);
        result
    };
    if rayon::current_thread_index().is_some() {
        let mut memory = memory();
        return (0..count).map(|number| one(&mut memory, number)).collect();
    }
    (0..count).into_par_iter().map_init(memory, one).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::AtomicBool;

    use super::*;

    #[test]
    fn the_order_is_that_of_the_numbers_and_progress_counts_every_piece() {
        let mut heard = Vec::new();
        let progress = |done| heard.push(done);
        let squares = pieces(1000, &|| false, progress, || (), |(), number| number * number);
        assert_eq!(squares, (0..1000).map(|number| number * number).collect::<Vec<_>>());
        assert_eq!(heard, (1..=1000).collect::<Vec<_>>());
    }

    #[test]
    fn after_an_interruption_no_piece_is_begun() {
        let pressed = AtomicBool::new(false);
        let threads = rayon::ThreadPoolBuilder::new().num_threads(4).build().unwrap();
        let numbers = threads.install(|| {
            let press = |done| {
                if done == 10 {
                    pressed.store(true, Ordering::SeqCst);
                }
            };
            pieces(u64::MAX, &|| pressed.load(Ordering::SeqCst), press, || (), |(), number| number)
        });
        // Each of the other three threads may have started one more piece.
        assert!((10..=13).contains(&numbers.len()), "{numbers:?}");
        assert!(numbers.is_sorted());
    }
}
