//! Puts firmware on a board.
//!
//! ```text
//!  ELF ─ image ─▶ segments ─ plan ─▶ sectors to erase, bytes to write ─┬─ dfuse ─ usb    the chip's USB boot loader
//!        │                   │                                        ├─ uf2   ─ drive  a drive that the board shows
//!        is it for this      never the store                          ├─ bin   ─ drive
//!        board?                                                       └─ probe          SWD, feature `probe`
//! ```
//! A **sector** is what the flash erases at once. The **store** is the part of it that the rig itself writes:
//! settings, layouts, calibration, results. No way of flashing writes there, and
//! none but the ST-LINK's drive, whose own firmware decides that, may erase there.

pub mod board;
pub mod dfuse;
pub mod drive;
pub mod image;
pub mod plan;
#[cfg(feature = "probe")]
pub mod probe;
pub mod uf2;
pub mod usb;

use crate::error::Result;

/// What is being done to the flash.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Sectors are erased.
    Erase,
    /// Bytes are written.
    Write,
    /// Bytes are read back and compared.
    Verify,
}

/// Is told how far the work is, and may end it.
pub trait Watch {
    /// `done` of `of` bytes of this step are done.
    ///
    /// # Errors
    /// When the user wants to stop.
    fn at(&mut self, step: Step, done: u64, of: u64) -> Result<()>;
}
