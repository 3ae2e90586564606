//! Ends a run after a panic or a fault: stores a message in memory that survives a reset, then restarts the
//! chip. [`crate::last_words!`] defines a program's handlers.

use core::fmt;
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};

use static_cell::StaticCell;

use crate::boot::{Words, kept_number, number_kept};
use crate::hard_fault::HardFault;
use crate::kept::RetainedWords;

#[unsafe(link_section = ".uninit.LAST_WORDS")]
static LAST_WORDS: RetainedWords<{ Words::SIZE }> = RetainedWords::new();
#[unsafe(link_section = ".uninit.FAILURES")]
static FAILURES: RetainedWords<2> = RetainedWords::new();

/// The message of the previous run, or "". To be called once, before interrupts are enabled.
pub fn take() -> &'static str {
    static TEXT: StaticCell<heapless::String<{ Words::CAPACITY }>> = StaticCell::new();
    let words = Words::read(&LAST_WORDS.read());
    LAST_WORDS.write([0; Words::SIZE]);
    words.map_or("", |words| TEXT.init(words).as_str())
}

/// Number of starts of this firmware in a row that had failed before this one; 0 after the power was off.
pub fn failures() -> u32 {
    number_kept(FAILURES.read(), mark())
}

/// Notes this number for the next start.
pub fn note_failures(failures: u32) {
    FAILURES.write(kept_number(failures, mark()));
}

/// Marks the firmware of this commit: what older firmware has failed at says nothing about it.
fn mark() -> u32 {
    massline_protocol::crc32(env!("MASSLINE_GIT_HASH").as_bytes())
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

        $crate::hard_fault_entry!();

        #[unsafe(no_mangle)]
        extern "C" fn __hard_fault(stack_pointer: usize) -> ! {
            $crate::last_words::hard_fault(stack_pointer);
            $restart()
        }

        #[cortex_m_rt::exception]
        unsafe fn DefaultHandler(number: i16) {
            panic!("interrupt {number} has no handler");
        }
    };
}

/// Stores the message of a panic; of one while another is reported, that the report has failed.
pub fn panicked(info: &PanicInfo<'_>) {
    static REPORTED: AtomicBool = AtomicBool::new(false);
    cortex_m::interrupt::disable();
    if REPORTED.swap(true, Ordering::Relaxed) {
        return keep(format_args!("the report of a panic has failed"));
    }
    match info.location() {
        Some(place) => {
            let file = place.file().rsplit('/').next().unwrap_or_default();
            keep(format_args!("{file}:{}: {}", place.line(), info.message()));
        }
        None => keep(format_args!("{}", info.message())),
    }
}

/// Stores the message of a hard fault.
pub fn hard_fault(stack_pointer: usize) {
    keep(format_args!("{}", HardFault::read(stack_pointer)));
}

/// Stores the message for the next run. This run has ended, so nothing interrupts it.
pub fn keep(words: fmt::Arguments<'_>) {
    cortex_m::interrupt::disable();
    LAST_WORDS.write(Words::of(words).encode());
}
