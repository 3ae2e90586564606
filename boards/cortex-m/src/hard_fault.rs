//! What a hard fault was.

use core::fmt;

use super::stack;

/// Memory that the MPU guards was accessed: the only such region is the guard of the stack.
const DATA_ACCESS: u32 = 1 << 1;
/// The same while the registers were put on the stack.
const STACKING: u32 = 1 << 4 | 1 << 5;
/// The stack pointer has passed its limit, on an ARMv8-M.
const BEYOND_LIMIT: u32 = 1 << 20;
/// Words that the core puts on the stack, and the places of the caller and of the instruction among them.
const FRAME_WORDS: usize = 8;
const CALLER: usize = 5;
const INSTRUCTION: usize = 6;

/// Defines the entry of a hard fault. It abandons the stack, which may have overflowed, and calls `__hard_fault` with
/// the stack pointer at the time of the fault; that function must not return.
#[macro_export]
macro_rules! hard_fault_entry {
    () => {
        core::arch::global_asm!(
            ".section .HardFaultTrampoline, \"ax\"",
            ".global HardFault",
            ".type HardFault,%function",
            ".thumb_func",
            "HardFault:",
            "mrs r0, MSP",
            "movw r1, #:lower16:_stack_start",
            "movt r1, #:upper16:_stack_start",
            "msr MSP, r1",
            "b __hard_fault",
            ".size HardFault, . - HardFault",
        );
    };
}

/// A hard fault.
#[derive(Clone, Copy, Debug)]
pub struct HardFault {
    /// The configurable fault status register.
    status: u32,
    /// Addresses of the instruction and of its caller; `None` when they could not be put on the stack.
    at: Option<(u32, u32)>,
}

impl HardFault {
    /// What the core reports, with the stack pointer at the time of the fault. To be called by the handler only.
    pub fn read(stack_pointer: usize) -> Self {
        // SAFETY: reading the fault status has no side effect.
        let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
        let stack = stack::addresses();
        let frame = stack_pointer..stack_pointer.saturating_add(FRAME_WORDS * size_of::<u32>());
        let is_whole = stack.start <= frame.start && frame.end <= stack.end;
        let word = |index: usize| {
            // SAFETY: the frame lies in the stack, and everything that used the stack has ended.
            unsafe { (stack_pointer as *const u32).add(index).read_volatile() }
        };
        let at = is_whole.then(|| (word(INSTRUCTION), word(CALLER)));
        Self { status, at }
    }
}

impl fmt::Display for HardFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.status & (DATA_ACCESS | STACKING | BEYOND_LIMIT) != 0 {
            return f.write_str("the stack has overflowed");
        }
        let (instruction, caller) = self.at.unwrap_or_default();
        let status = self.status;
        write!(
            f,
            "hard fault at {instruction:#010x}, called from {caller:#010x}, status {status:#010x}"
        )
    }
}
