//! A stack that overflows, by calls whose locals are as large as the largest of the firmware's.

use core::hint::black_box;
use core::sync::atomic::{AtomicU32, Ordering};

/// A static that an overflow must not change.
static CANARY: [AtomicU32; 16] = [const { AtomicU32::new(0) }; 16];

/// Calls itself for ever; panics when a static has changed.
pub fn overflow() -> ! {
    panic!("{} calls and no end", deeper(0))
}

#[allow(unconditional_recursion, reason = "it is to overflow the stack")]
fn deeper(calls: u32) -> u32 {
    // 4 KiB, in use until the call returns.
    let locals = black_box([calls + 1; 1024]);
    assert!(CANARY.iter().all(|word| word.load(Ordering::Relaxed) == 0), "a static has changed");
    let deepest = deeper(calls + 1);
    black_box(locals).iter().fold(deepest, |sum, local| sum.wrapping_add(*local))
}
