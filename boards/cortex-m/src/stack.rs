//! The stack: where it is, and how much of it was ever used. It lies at the start of RAM, below the statics. The
//! start-up code fills it with a pattern.

use core::ops::Range;
use core::ptr::{addr_of, read_volatile};

use cortex_m_rt::STACK_PAINT_VALUE;
use massline_firmware::board::StackUse;

unsafe extern "C" {
    // Symbols of the linker script: the lowest word of the stack, and the word after the highest.
    static _stack_end: u32;
    static _stack_start: u32;
}

/// Addresses of the stack.
pub fn addresses() -> Range<usize> {
    addr_of!(_stack_end) as usize..addr_of!(_stack_start) as usize
}

/// Counts the words that still hold the pattern.
pub fn measure() -> StackUse {
    let stack = addresses();
    let untouched = stack
        .clone()
        .step_by(size_of::<u32>())
        // SAFETY: every word between the two is RAM.
        .take_while(|&word| unsafe { read_volatile(word as *const u32) } == STACK_PAINT_VALUE)
        .count()
        * size_of::<u32>();
    let size = stack.len();
    StackUse { high_water: (size - untouched) as u32, size: size as u32 }
}
