//! Ends a run after a panic or a fault: stores a message in memory that survives a reset, then restarts the
//! chip. [`crate::last_words!`] defines a program's handlers.

use core::fmt;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::addr_of_mut;

use cortex_m_rt::ExceptionFrame;
use static_cell::StaticCell;

use crate::boot::Words;

#[unsafe(link_section = ".uninit.LAST_WORDS")]
static mut LAST_WORDS: MaybeUninit<Words> = MaybeUninit::uninit();

/// The message of the previous run, or "". To be called once, before interrupts are enabled.
pub fn take() -> &'static str {
    static KEPT: StaticCell<heapless::String<{ Words::CAPACITY }>> = StaticCell::new();
    // SAFETY: any bytes are valid `Words`, and nothing else runs yet.
    let words = unsafe { (*addr_of_mut!(LAST_WORDS)).assume_init_mut() };
    words.take().map_or("", |words| KEPT.init(words).as_str())
}

/// Defines the handlers for a panic, a hard fault and an interrupt without a handler. Each stores a message
/// and calls `$restart`, which restarts the chip.
#[macro_export]
macro_rules! last_words {
    ($restart:path) => {
        #[panic_handler]
        fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
            $crate::last_words::panicked(info);
            $restart()
        }

        #[cortex_m_rt::exception]
        unsafe fn HardFault(frame: &cortex_m_rt::ExceptionFrame) -> ! {
            $crate::last_words::hard_fault(frame);
            $restart()
        }

        #[cortex_m_rt::exception]
        unsafe fn DefaultHandler(number: i16) {
            panic!("interrupt {number} has no handler");
        }
    };
}

/// Stores the message of a panic.
pub fn panicked(info: &PanicInfo<'_>) {
    match info.location() {
        Some(place) => {
            let file = place.file().rsplit('/').next().unwrap_or_default();
            keep(format_args!("{file}:{}: {}", place.line(), info.message()));
        }
        None => keep(format_args!("{}", info.message())),
    }
}

/// Stores the message of a hard fault.
pub fn hard_fault(frame: &ExceptionFrame) {
    // SAFETY: reading the fault status has no side effect.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    keep(format_args!(
        "hard fault at {:#010x}, called from {:#010x}, status {status:#010x}",
        frame.pc(),
        frame.lr()
    ));
}

/// Stores the message for the next run. This run has ended, so nothing interrupts it.
pub fn keep(words: fmt::Arguments<'_>) {
    cortex_m::interrupt::disable();
    // SAFETY: nothing else runs any more, and `Words::none` sets every field.
    unsafe { (*addr_of_mut!(LAST_WORDS)).write(Words::none()).write(words) };
}
