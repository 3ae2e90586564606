//! The executor: sleeps with WFI, because QEMU treats the WFE of embassy's own as nothing.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::{Spawner, raw};
use static_cell::StaticCell;

static WOKEN: AtomicBool = AtomicBool::new(false);

// embassy calls this by name when a task is to be polled.
#[unsafe(export_name = "__pender")]
fn pend(_context: *mut ()) {
    WOKEN.store(true, Ordering::Release);
}

/// Runs what `start` spawns, for ever.
pub fn run(start: impl FnOnce(Spawner)) -> ! {
    static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();
    let executor: &'static raw::Executor = EXECUTOR.init(raw::Executor::new(core::ptr::null_mut()));
    start(executor.spawner());
    loop {
        // SAFETY: polled here only, and `__pender` does not poll.
        unsafe { executor.poll() };
        sleep_until_woken();
    }
}

/// An interrupt that comes between the look and the sleep stays pending, and so ends the sleep.
fn sleep_until_woken() {
    cortex_m::interrupt::disable();
    if !WOKEN.swap(false, Ordering::AcqRel) {
        cortex_m::asm::wfi();
    }
    // SAFETY: the one critical section that ends here began in this function.
    unsafe { cortex_m::interrupt::enable() };
}
