//! What the board says of itself.

use embassy_stm32::pac;
use massline_cortex_m::boot::{ResetFlags, reason};
use massline_cortex_m::{last_words, stack};
use massline_firmware::board::BoardInfo;

/// Reads and clears what the reset has left. To be called once, before anything else.
pub fn read() -> BoardInfo {
    let csr = pac::RCC.csr().read();
    let flags = ResetFlags {
        power: csr.porrstf() || csr.borrstf(),
        pin: csr.padrstf(),
        watchdog: csr.wdgrstf() || csr.wwdgrstf(),
        software: csr.sftrstf(),
    };
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    let last_panic = last_words::take();
    BoardInfo {
        name: "blackpill-f411",
        firmware: env!("CARGO_PKG_VERSION"),
        git_hash: env!("MASSLINE_GIT_HASH"),
        git_dirty: matches!(env!("MASSLINE_GIT_DIRTY").as_bytes(), b"true"),
        boot_reason: reason(flags, !last_panic.is_empty()),
        last_panic,
        stack: stack::measure,
    }
}
