//! The executor. It sleeps with WFI, because QEMU ignores the WFE that embassy's own executor uses.

use core::sync::atomic::{AtomicBool, Ordering};

use embassy_executor::{Spawner, raw};
use static_cell::StaticCell;

static WOKEN: AtomicBool = AtomicBool::new(false);

// embassy calls this function by name when a task is to be polled.
#[unsafe(export_name = "__pender")]
fn pend(_context: *mut ()) {
    WOKEN.store(true, Ordering::Release);
}

/// Runs the tasks that `start` spawns; never returns.
pub fn run(start: impl FnOnce(Spawner)) -> ! {
    static EXECUTOR: StaticCell<raw::Executor> = StaticCell::new();
    let executor: &'static raw::Executor = EXECUTOR.init(raw::Executor::new(core::ptr::null_mut()));
    start(executor.spawner());
    loop {
        // SAFETY: the executor is polled here only, and `__pender` does not poll.
        unsafe { executor.poll() };
        sleep_until_woken();
    }
}

/// Sleeps if no task is to be polled. An interrupt between the check and the sleep stays pending and ends
/// the sleep.
fn sleep_until_woken() {
    cortex_m::interrupt::disable();
    if !WOKEN.swap(false, Ordering::AcqRel) {
        cortex_m::asm::wfi();
    }
    // SAFETY: the critical section that ends here began in this function.
    unsafe { cortex_m::interrupt::enable() };
}
