//! Writes firmware to a board.
//!
//! ```text
//!  ELF ─ image ─▶ segments ─ plan ─▶ sectors to erase, bytes to write ─┬─ dfuse ─ usb    the chip's USB boot loader
//!        │                   │                                        ├─ uf2   ─ drive  a drive that the board shows
//!        is it for this      never the store                          ├─ bin   ─ drive
//!        board?                                                       └─ probe          SWD, feature `probe`
//! ```
//! A **sector** is the smallest unit that the flash erases. The **store** is the part of the flash that the
//! rig itself writes: settings, layouts, calibration, results. No way of flashing writes there, and none can
//! erase there except the ST-LINK's drive, whose own firmware decides what it erases.

pub mod board;
pub mod dfuse;
pub mod drive;
pub mod image;
pub mod plan;
#[cfg(feature = "probe")]
pub mod probe;
pub mod uf2;
pub mod usb;

use massline_result::Result;

/// The current step of flashing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Sectors are erased.
    Erase,
    /// Bytes are written.
    Write,
    /// Bytes are read back and compared.
    Verify,
}

/// Receives the progress, and may stop the work.
pub trait ProgressObserver {
    /// `done` of `of` bytes of this step are complete.
    ///
    /// # Errors
    /// When the user wants to stop.
    fn at(&mut self, step: Step, done: u64, total: u64) -> Result<()>;
}
