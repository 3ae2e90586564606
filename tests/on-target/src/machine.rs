//! Console, exit, instruction counter and stack of the emulated machine.

use core::arch::asm;
use core::fmt::{self, Write};
use core::panic::PanicInfo;
use core::ptr::{read_volatile, write_volatile};

use cortex_m_rt::{ExceptionFrame, STACK_PAINT_VALUE, exception};
use cortex_m_semihosting::debug::{self, EXIT_FAILURE, EXIT_SUCCESS};
use cortex_m_semihosting::hio;

/// Prints a line.
pub fn print(line: fmt::Arguments<'_>) {
    if let Ok(mut out) = hio::hstdout() {
        // Without a console the output is discarded.
        let _ = writeln!(out, "{line}");
    }
}

/// Ends the emulator, with exit code 0 or 1.
pub fn end(good: bool) -> ! {
    debug::exit(if good { EXIT_SUCCESS } else { EXIT_FAILURE });
    unreachable!("semihosting ends the emulator")
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    print(format_args!("{info}"));
    debug::exit(EXIT_FAILURE);
    cortex_m::asm::udf()
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    panic!("hard fault at {:#010x}", frame.pc());
}

/// Cost of a piece of work.
#[derive(Clone, Copy, Debug, Default)]
pub struct Cost {
    /// Instructions executed.
    pub instructions: u32,
    /// Peak stack use, bytes.
    pub stack: u32,
}

/// Runs `work` and measures it. The result includes the overhead of the measurement, below 50
/// instructions.
///
/// # Panics
/// When the counter does not count instructions: QEMU runs without `-icount shift=6,sleep=off`.
pub fn measure(work: impl FnOnce()) -> Cost {
    const CHECK: u32 = 1_000_000;
    let check = instructions(|| spin(CHECK / 2));
    assert!(
        check.abs_diff(CHECK) < CHECK / 1000,
        "{CHECK} instructions were counted as {check}; QEMU needs -icount shift=6,sleep=off"
    );
    let top = stack_pointer();
    paint_stack(top);
    let instructions = instructions(work);
    Cost { instructions, stack: used_stack(top) }
}

/// Cost of work that is done in steps.
#[derive(Clone, Copy, Debug, Default)]
pub struct StepCosts {
    /// Instructions of all steps.
    pub whole: u64,
    /// Instructions of the longest step.
    pub longest: u32,
    /// Peak stack use, bytes.
    pub stack: u32,
    /// Number of steps.
    pub steps: u32,
}

/// Runs steps until `step` returns false, and measures them.
///
/// # Panics
/// As [`measure`].
pub fn measure_steps(mut step: impl FnMut() -> bool) -> StepCosts {
    let mut costs = StepCosts::default();
    let whole = measure(|| {
        let mut going = true;
        while going {
            let instructions = instructions(|| going = step());
            costs.whole += u64::from(instructions);
            costs.longest = costs.longest.max(instructions);
            costs.steps += 1;
        }
    });
    StepCosts { stack: whole.stack, ..costs }
}

/// The counter counts the machine's time at 25 MHz; an instruction takes 64 ns of it.
#[inline(never)]
fn instructions(work: impl FnOnce()) -> u32 {
    const COUNTER: *const u32 = 0x4002_8018 as *const u32;
    // SAFETY: this register of the machine can be read at any time.
    let now = || unsafe { read_volatile(COUNTER) };
    let start = now();
    work();
    let ticks = now().wrapping_sub(start);
    // 40 ns per tick, 64 ns per instruction.
    (u64::from(ticks) * 40 / 64) as u32
}

/// Spins with two instructions per turn.
fn spin(turns: u32) {
    // SAFETY: only counts a register down.
    unsafe {
        asm!("2: subs {n}, {n}, #1", "bne 2b", n = inout(reg) turns => _, options(nomem, nostack));
    }
}

unsafe extern "C" {
    // Defined by the linker script: the lowest word of the stack.
    static _stack_end: u32;
}

/// More than any of the measured work uses.
const PAINTED: usize = 256 << 10;

/// Paints the stack below the caller's.
#[inline(never)]
fn paint_stack(top: usize) {
    // The stack that this function itself uses is not overwritten.
    let end = stack_pointer() - 64;
    for word in (bottom(top)..end).step_by(4) {
        // SAFETY: RAM below the stack pointer and above `_stack_end`, which nothing uses; interrupts,
        // which would use it, are off.
        unsafe { write_volatile(word as *mut u32, STACK_PAINT_VALUE) };
    }
}

/// Stack used below `top` since it was painted, bytes.
#[inline(never)]
fn used_stack(top: usize) -> u32 {
    let untouched = (bottom(top)..top)
        .step_by(4)
        // SAFETY: RAM, as above.
        .take_while(|&word| unsafe { read_volatile(word as *const u32) } == STACK_PAINT_VALUE)
        .count();
    assert!(untouched > 0, "more stack was used than was painted");
    (top - bottom(top) - 4 * untouched) as u32
}

fn bottom(top: usize) -> usize {
    (top - PAINTED).max(core::ptr::addr_of!(_stack_end) as usize)
}

fn stack_pointer() -> usize {
    let pointer: usize;
    // SAFETY: only reads a register.
    unsafe { asm!("mov {}, sp", out(reg) pointer, options(nomem, nostack, preserves_flags)) };
    pointer
}
