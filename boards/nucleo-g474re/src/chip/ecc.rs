//! Flash with a code for errors: a word of eight bytes that a loss of power has torn cannot be read, and
//! the chip says so by the interrupt that cannot be masked.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m_rt::exception;
use embassy_stm32::pac::FLASH;
use massline_cortex_m::flash::Check;

static UNREADABLE: AtomicBool = AtomicBool::new(false);

/// What the interrupt has found.
pub struct Ecc;

impl Check for Ecc {
    fn take_error(&mut self) -> bool {
        UNREADABLE.swap(false, Ordering::Relaxed)
    }
}

/// The flags go out when ones are written to them; while they are on, the interrupt comes again.
#[exception]
unsafe fn NonMaskableInt() {
    let found = FLASH.eccr().read();
    if !found.eccd() && !found.eccd2() {
        panic!("an interrupt that cannot be masked, and not of the flash");
    }
    FLASH.eccr().modify(|w| {
        w.set_eccd(true);
        w.set_eccd2(true);
    });
    UNREADABLE.store(true, Ordering::Relaxed);
}
