//! The time of the virtual rig: the embassy-time driver of the host process, and the executor that
//! fires its timers.
//!
//! Each rig runs on a thread of its own and has a clock of its own, found through the thread:
//!
//! ```text
//! now = wall clock since the process first asked + what this thread has skipped
//! ```
//! In real time nothing is skipped. In simulated time the sampler skips to the end of each block that it
//! hands out ([`advance_to`]), so a simulated campaign takes only as long as its computation. While no
//! scans are handed out, time follows the wall clock, so that a timeout of the link does not expire
//! before a host in another thread can answer.
//!
//! Guarantees:
//! - Time on one thread never goes backwards and is never slower than the wall clock.
//! - Skips of one rig do not affect another. Times of different threads cannot be compared.
//! - A timer under [`Executor::run`] wakes its task at its time or as soon as the thread runs after
//!   it, never before; a skip over it wakes it too.
//! - On any other thread a timer wakes its task at once, and the task polls until the time has come:
//!   correct, but busy waiting.

use std::cell::{Cell, RefCell};
use std::pin::Pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::task::{Context, Poll, Wake, Waker};
use std::thread::{self, Thread};
use std::time::{Duration, Instant as WallInstant};

use embassy_time::{Instant, TICK_HZ};
use embassy_time_driver::Driver;
use embassy_time_queue_utils::queue_generic::ConstGenericQueue;

/// Number of timers that one rig can wait for; a further one only wakes a task early.
const TIMERS: usize = 64;

struct HostDriver;

// The macro exports two functions under the names that embassy-time links to.
#[allow(unsafe_code)]
mod driver {
    use super::HostDriver;
    embassy_time_driver::time_driver_impl!(static DRIVER: HostDriver = HostDriver);
}

impl Driver for HostDriver {
    fn now(&self) -> u64 {
        wall_ticks() + SKIPPED.with(Cell::get)
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        let queued = QUEUE.with_borrow_mut(|queue| match queue {
            Some(queue) => {
                queue.schedule_wake(at, waker);
                true
            }
            None => false,
        });
        if !queued {
            waker.wake_by_ref();
        }
    }
}

thread_local! {
    static SKIPPED: Cell<u64> = const { Cell::new(0) };
    /// The timers of this thread while an executor runs on it.
    static QUEUE: RefCell<Option<ConstGenericQueue<TIMERS>>> = const { RefCell::new(None) };
}

fn wall_ticks() -> u64 {
    static START: OnceLock<WallInstant> = OnceLock::new();
    let elapsed = START.get_or_init(WallInstant::now).elapsed();
    // 1 MHz ticks overflow after half a million years.
    (elapsed.as_nanos() * u128::from(TICK_HZ) / 1_000_000_000) as u64
}

/// Advances the time of this thread to `at` at once. Does nothing when `at` has already passed.
pub fn advance_to(at: Instant) {
    let behind = at.as_ticks().saturating_sub(Instant::now().as_ticks());
    SKIPPED.with(|skipped| skipped.set(skipped.get() + behind));
}

/// Runs one future on one thread: sleeps while there is nothing to do, fires the timers, and can be
/// stopped from any thread.
#[derive(Clone, Default)]
pub struct Executor {
    signal: Arc<Signal>,
}

#[derive(Default)]
struct Signal {
    thread: OnceLock<Thread>,
    woken: AtomicBool,
    stopped: AtomicBool,
}

impl Wake for Signal {
    fn wake(self: Arc<Self>) {
        self.wake_by_ref();
    }

    fn wake_by_ref(self: &Arc<Self>) {
        self.woken.store(true, Ordering::Release);
        if let Some(thread) = self.thread.get() {
            thread.unpark();
        }
    }
}

impl Executor {
    /// Stops [`run`](Self::run), now or as soon as it starts: the future is not polled again.
    pub fn stop(&self) {
        self.signal.stopped.store(true, Ordering::Release);
        self.signal.wake_by_ref();
    }

    /// Runs `future` on the calling thread; `None` when it was stopped. An executor serves one thread:
    /// run it once, and not inside another executor.
    pub fn run<T>(&self, future: impl Future<Output = T>) -> Option<T> {
        let _timers = TimersOfThread::open();
        let _ = self.signal.thread.set(thread::current());
        let waker = Waker::from(self.signal.clone());
        // On the heap: the application's future is large.
        let mut future: Pin<Box<dyn Future<Output = T> + '_>> = Box::pin(future);
        loop {
            // A stop comes after this and stays a wake, or its flag is seen below.
            self.signal.woken.swap(false, Ordering::AcqRel);
            if self.signal.stopped.load(Ordering::Acquire) {
                return None;
            }
            if let Poll::Ready(value) = future.as_mut().poll(&mut Context::from_waker(&waker)) {
                return Some(value);
            }
            self.sleep();
        }
    }

    /// Sleeps until the task is woken, by a timer or by anything else.
    fn sleep(&self) {
        loop {
            let now = Instant::now().as_ticks();
            let next = QUEUE.with_borrow_mut(|queue| {
                queue.as_mut().map_or(u64::MAX, |queue| queue.next_expiration(now))
            });
            if self.signal.woken.load(Ordering::Acquire) {
                return;
            }
            if next == u64::MAX {
                thread::park();
            } else {
                // Rounded up, so that the thread does not wake just before the time.
                let micros = ((next - now) as u128 * 1_000_000).div_ceil(u128::from(TICK_HZ));
                thread::park_timeout(Duration::from_micros(micros as u64));
            }
        }
    }
}

/// The thread's timers exist as long as this value.
struct TimersOfThread;

impl TimersOfThread {
    fn open() -> Self {
        QUEUE.set(Some(ConstGenericQueue::new()));
        Self
    }
}

impl Drop for TimersOfThread {
    fn drop(&mut self) {
        QUEUE.set(None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embassy_futures::join::{join, join4};
    use embassy_futures::select::{Either, select};
    use embassy_time::{Duration, Timer};
    use std::future::{pending, poll_fn};

    #[test]
    fn timers_fire_in_order_and_never_early() {
        let hour = Duration::from_secs(3600);
        let begin = Instant::now();
        let fired = RefCell::new(Vec::new());
        let timer = async |hours: u32| {
            Timer::at(begin + hours * hour).await;
            assert!(Instant::now() >= begin + hours * hour);
            fired.borrow_mut().push(hours);
        };
        let skipping = async {
            for hours in 1..=3 {
                embassy_futures::yield_now().await;
                advance_to(begin + hours * hour);
            }
        };
        Executor::default().run(join4(timer(3), timer(1), timer(2), skipping)).unwrap();
        assert_eq!(*fired.borrow(), [1, 2, 3]);
    }

    #[test]
    fn a_timer_fires_while_nobody_skips() {
        let (begin, wall) = (Instant::now(), WallInstant::now());
        Executor::default().run(Timer::after_millis(3)).unwrap();
        assert!(begin.elapsed() >= Duration::from_millis(3));
        // The rig's clock counts whole microseconds.
        assert!(wall.elapsed() >= std::time::Duration::from_micros(2999));
    }

    #[test]
    fn a_skip_fires_the_timers_that_it_passes() {
        let hour = Duration::from_secs(3600);
        let wall = WallInstant::now();
        let skipping = async {
            for _ in 0..10 {
                advance_to(Instant::now() + hour / 10);
                embassy_futures::yield_now().await;
            }
        };
        let begin = Instant::now();
        Executor::default().run(join(Timer::after(hour), skipping)).unwrap();
        assert!(begin.elapsed() >= hour);
        assert!(wall.elapsed() < std::time::Duration::from_secs(3000));
    }

    #[test]
    fn a_skip_backwards_changes_nothing() {
        let before = Instant::now();
        advance_to(Instant::from_ticks(0));
        assert!(Instant::now() >= before);
    }

    #[test]
    fn another_thread_does_not_see_the_skips_of_this_one() {
        advance_to(Instant::now() + Duration::from_secs(1_000_000));
        let other_now = thread::spawn(Instant::now).join().unwrap();
        assert!(other_now < Instant::now() - Duration::from_secs(500_000));
    }

    #[test]
    fn a_timer_fires_under_a_foreign_executor() {
        let at = Instant::now() + Duration::from_millis(2);
        embassy_futures::block_on(Timer::at(at));
        assert!(Instant::now() >= at);
    }

    #[test]
    fn a_wake_from_another_thread_arrives() {
        let flag = Arc::new(AtomicBool::new(false));
        let mut started = false;
        let future = poll_fn(|cx| {
            if !started {
                started = true;
                let (flag, waker) = (flag.clone(), cx.waker().clone());
                thread::spawn(move || {
                    flag.store(true, Ordering::Release);
                    waker.wake();
                });
            }
            if flag.load(Ordering::Acquire) { Poll::Ready(7) } else { Poll::Pending }
        });
        assert_eq!(Executor::default().run(future), Some(7));
    }

    #[test]
    fn a_stop_ends_a_future_that_waits_for_ever() {
        let executor = Executor::default();
        let handle = executor.clone();
        let runs = thread::spawn(move || executor.run(pending::<()>()));
        handle.stop();
        assert_eq!(runs.join().unwrap(), None);
    }

    #[test]
    fn a_stop_between_two_polls_is_heard() {
        for _ in 0..2000 {
            let (executor, busy) = (Executor::default(), Arc::new(AtomicBool::new(false)));
            let (handle, works) = (executor.clone(), busy.clone());
            let mut polls = 0;
            // Runs in circles until it is told to be quiet, immediately before the stop.
            let future = poll_fn(move |cx| {
                polls += 1;
                if polls == 1 {
                    works.store(true, Ordering::Release);
                }
                if works.load(Ordering::Acquire) {
                    cx.waker().wake_by_ref();
                }
                Poll::<()>::Pending
            });
            let runs = thread::spawn(move || executor.run(future));
            while !busy.load(Ordering::Acquire) {
                std::hint::spin_loop();
            }
            busy.store(false, Ordering::Release);
            handle.stop();
            assert_eq!(runs.join().unwrap(), None);
        }
    }

    #[test]
    fn the_earlier_of_two_waits_wins_although_the_later_was_asked_first() {
        let either = Executor::default()
            .run(select(Timer::after_secs(3600), Timer::after_millis(1)))
            .unwrap();
        assert!(matches!(either, Either::Second(())));
    }
}
