//! Flash with an error correcting code: a word of eight bytes that was torn by a loss of power cannot be
//! read, and the chip reports it by a non-maskable interrupt.

use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m_rt::exception;
use embassy_stm32::pac::FLASH;
use embassy_stm32::pac::flash::regs::Eccr;
use massline_cortex_m::flash::Supervisor;

use crate::STORE_IN_BANK_2;
use crate::ecc::{FLAGS, NmiSource, nmi_source};

/// The store is reading.
static READING: AtomicBool = AtomicBool::new(false);
/// The interrupt has occurred since the store began to read.
static UNREADABLE: AtomicBool = AtomicBool::new(false);

/// Error that the interrupt has found.
pub struct Ecc;

impl Supervisor for Ecc {
    /// Clears the flags of corrected errors too, so that the register is free for the next address.
    fn before_read(&mut self) {
        clear();
        UNREADABLE.store(false, Ordering::SeqCst);
        READING.store(true, Ordering::SeqCst);
    }

    fn read_failed(&mut self) -> bool {
        // An error of the last read arrives before this.
        cortex_m::asm::dsb();
        cortex_m::asm::isb();
        READING.store(false, Ordering::SeqCst);
        clear();
        UNREADABLE.load(Ordering::SeqCst)
    }
}

/// The flags are cleared by writing ones; while one is set, the interrupt is raised again.
fn clear() {
    FLASH.eccr().modify(|w| *w = Eccr(w.0 | FLAGS));
}

/// A torn word of the store is survived; anything else ends the run.
#[exception]
unsafe fn NonMaskableInt() {
    let reading = READING.load(Ordering::SeqCst);
    match nmi_source(FLASH.eccr().read().0, reading, &STORE_IN_BANK_2) {
        NmiSource::Store => UNREADABLE.store(true, Ordering::SeqCst),
        NmiSource::Elsewhere { bank, offset } => {
            panic!("bank {bank} of the flash decays at {offset:#x}")
        }
        NmiSource::Other => panic!("an interrupt that cannot be masked, and not of the flash"),
    }
    clear();
}
