//! The time driver of embassy: TIMER0 is the clock, TIMER1 the alarm.

use core::cell::{Cell, RefCell};
use core::task::Waker;

use critical_section::{CriticalSection, Mutex};
use embassy_time_driver::{Driver, TICK_HZ};
use embassy_time_queue_utils::Queue;

use super::registers::{Interrupt, TIMER0, TIMER1};

const CYCLES_PER_TICK: u64 = 25_000_000 / TICK_HZ;
const _: () = assert!(CYCLES_PER_TICK * TICK_HZ == 25_000_000);

struct Timers {
    /// Wraps of TIMER0, of 2³² cycles each.
    laps: Mutex<Cell<u32>>,
    queue: Mutex<RefCell<Queue>>,
}

embassy_time_driver::time_driver_impl!(static TIMERS: Timers = Timers {
    laps: Mutex::new(Cell::new(0)),
    queue: Mutex::new(RefCell::new(Queue::new())),
});

/// Starts the clock, which reads zero before that.
pub fn start() {
    TIMER0.start(u32::MAX);
    // SAFETY: the interrupts' handlers are in the vector table.
    unsafe {
        cortex_m::peripheral::NVIC::unmask(Interrupt::Timer0);
        cortex_m::peripheral::NVIC::unmask(Interrupt::Timer1);
    }
}

/// TIMER0 has wrapped.
pub fn on_lap() {
    critical_section::with(|cs| {
        if TIMER0.raised() {
            TIMER0.clear();
            let laps = TIMERS.laps.borrow(cs);
            laps.set(laps.get().wrapping_add(1));
        }
    });
}

/// TIMER1 has reached zero.
pub fn on_alarm() {
    critical_section::with(|cs| {
        TIMER1.stop();
        TIMER1.clear();
        TIMERS.wake_and_set_alarm(cs);
    });
}

impl Timers {
    fn now_in(&self, cs: CriticalSection<'_>) -> u64 {
        let mut laps = self.laps.borrow(cs).get();
        let mut value = TIMER0.value();
        if TIMER0.raised() {
            // The timer has wrapped, but the wrap was not counted yet.
            laps = laps.wrapping_add(1);
            value = TIMER0.value();
        }
        ((u64::from(laps) << 32) | u64::from(u32::MAX - value)) / CYCLES_PER_TICK
    }

    fn wake_and_set_alarm(&self, cs: CriticalSection<'_>) {
        let mut queue = self.queue.borrow(cs).borrow_mut();
        loop {
            let now = self.now_in(cs);
            let next = queue.next_expiration(now);
            if next == u64::MAX {
                TIMER1.stop();
                return;
            }
            if next > now {
                // An alarm beyond the timer's range fires early and is set again.
                let cycles = (next - now).saturating_mul(CYCLES_PER_TICK);
                TIMER1.start(u32::try_from(cycles).unwrap_or(u32::MAX));
                return;
            }
        }
    }
}

impl Driver for Timers {
    fn now(&self) -> u64 {
        critical_section::with(|cs| self.now_in(cs))
    }

    fn schedule_wake(&self, at: u64, waker: &Waker) {
        critical_section::with(|cs| {
            let changed = self.queue.borrow(cs).borrow_mut().schedule_wake(at, waker);
            if changed {
                self.wake_and_set_alarm(cs);
            }
        });
    }
}
