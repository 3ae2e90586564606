//! Ends a run after a panic or a fault: sends a message over UART1, then locks the core up, which makes
//! QEMU exit with a failure.

use core::fmt::{self, Write};
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m_rt::exception;

use super::hard_fault::HardFault;
use super::registers::UART1;

static SPOKEN: AtomicBool = AtomicBool::new(false);

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    print(format_args!("{info}"));
    lock_up()
}

hard_fault_entry!();

#[unsafe(no_mangle)]
extern "C" fn __hard_fault(stack_pointer: usize) -> ! {
    print(format_args!("{}", HardFault::read(stack_pointer)));
    lock_up()
}

#[exception]
unsafe fn DefaultHandler(number: i16) {
    panic!("interrupt {number} has no handler");
}

/// Sends the message of the first failure; further ones are its consequences.
fn print(words: fmt::Arguments<'_>) {
    if !SPOKEN.swap(true, Ordering::Relaxed) {
        UART1.enable_sending();
        // Writing to the UART does not fail.
        let _ = writeln!(LastWords, "{words}");
    }
}

/// An undefined instruction causes a hard fault; within a hard fault it locks the core up.
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
