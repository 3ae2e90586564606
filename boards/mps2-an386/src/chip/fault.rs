//! The end: last words on UART1, then a lockup of the core, which ends QEMU with a failure.

use core::fmt::{self, Write};
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m_rt::{ExceptionFrame, exception};

use super::registers::UART1;

static SPOKEN: AtomicBool = AtomicBool::new(false);

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    print(format_args!("{info}"));
    lock_up()
}

#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    // SAFETY: reading the fault status has no side effect.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    print(format_args!(
        "hard fault at {:#010x}, called from {:#010x}, fault status {status:#010x}",
        frame.pc(),
        frame.lr()
    ));
    lock_up()
}

#[exception]
unsafe fn DefaultHandler(number: i16) {
    panic!("interrupt {number} has no handler");
}

/// Says the first thing that went wrong; what follows is its consequence.
fn print(words: fmt::Arguments<'_>) {
    if !SPOKEN.swap(true, Ordering::Relaxed) {
        UART1.enable_sending();
        // Writing to the UART does not fail.
        let _ = writeln!(LastWords, "{words}");
    }
}

/// An undefined instruction is a hard fault; within a hard fault it locks the core up.
fn lock_up() -> ! {
    cortex_m::asm::udf()
}

struct LastWords;

impl Write for LastWords {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        for byte in text.bytes() {
            while !UART1.can_send() {}
            UART1.send(byte);
        }
        Ok(())
    }
}
