//! The end of a run: the words go into memory that a reset leaves alone, then the chip starts again.

use core::fmt;
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::addr_of_mut;

use cortex_m_rt::ExceptionFrame;
use static_cell::StaticCell;

use crate::boot::Words;

#[unsafe(link_section = ".uninit.LAST_WORDS")]
static mut LAST_WORDS: MaybeUninit<Words> = MaybeUninit::uninit();

/// The words of the run before, or "". To be called once, before interrupts are enabled.
pub fn take() -> &'static str {
    static KEPT: StaticCell<heapless::String<{ Words::CAPACITY }>> = StaticCell::new();
    // SAFETY: any bytes are `Words`, and nothing else runs yet.
    let words = unsafe { (*addr_of_mut!(LAST_WORDS)).assume_init_mut() };
    words.take().map_or("", |words| KEPT.init(words).as_str())
}

/// The panic of a board.
pub fn panicked(info: &PanicInfo<'_>) -> ! {
    match info.location() {
        Some(place) => {
            let file = place.file().rsplit('/').next().unwrap_or_default();
            end(format_args!("{file}:{}: {}", place.line(), info.message()))
        }
        None => end(format_args!("{}", info.message())),
    }
}

/// The hard fault of a board.
pub fn hard_fault(frame: &ExceptionFrame) -> ! {
    // SAFETY: reading the fault status has no side effect.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    end(format_args!(
        "hard fault at {:#010x}, called from {:#010x}, status {status:#010x}",
        frame.pc(),
        frame.lr()
    ))
}

/// Keeps the words and starts the chip again.
pub fn end(words: fmt::Arguments<'_>) -> ! {
    cortex_m::interrupt::disable();
    // SAFETY: nothing else runs any more, and `say` sets every field.
    unsafe { (*addr_of_mut!(LAST_WORDS)).write(Words::none()).say(words) };
    cortex_m::peripheral::SCB::sys_reset()
}
