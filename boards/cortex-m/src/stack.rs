//! The stack: where its guard is, and how much of it was ever used. The start-up code fills it with a pattern.

use core::ops::Range;
use core::ptr::{addr_of, read_volatile};

use cortex_m_rt::STACK_PAINT_VALUE;
use massline_firmware::board::StackUse;

/// Bytes of the guard at the end of the stack. A function whose locals are larger may step over it. An ARMv8-M needs no
/// guard, because it has a limit of the stack pointer; there these bytes are left unused.
pub const GUARD_BYTES: usize = 256;

unsafe extern "C" {
    // Symbols of the linker script: the lowest word of the stack, and the word after the highest.
    static _stack_end: u32;
    static _stack_start: u32;
}

/// Addresses of the guard, at a multiple of its size. Below it are the statics.
pub fn guard() -> Range<usize> {
    let start = (addr_of!(_stack_end) as usize).next_multiple_of(GUARD_BYTES);
    start..start + GUARD_BYTES
}

/// Addresses of the stack above its guard.
pub fn usable() -> Range<usize> {
    guard().end..addr_of!(_stack_start) as usize
}

/// Counts the words that still hold the pattern.
pub fn measure() -> StackUse {
    let usable = usable();
    let untouched = usable
        .clone()
        .step_by(size_of::<u32>())
        // SAFETY: every word between the two is RAM.
        .take_while(|&word| unsafe { read_volatile(word as *const u32) } == STACK_PAINT_VALUE)
        .count()
        * size_of::<u32>();
    let size = usable.len();
    StackUse { high_water: (size - untouched) as u32, size: size as u32 }
}
