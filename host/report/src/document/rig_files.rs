//! What was written to a tape or to a board.

use serde::Serialize;

use massline_result::FilePath;

/// A tape of a rig's scans.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct RecordedTape {
    /// Its path.
    pub tape: FilePath,
    /// Number of scans.
    pub scans: u64,
    /// Number of segments, one for each hit.
    pub segments: u32,
}

/// Firmware, and the part of a board's flash that it takes.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Flashing {
    /// Name of the board.
    pub board: String,
    /// Path of the image.
    pub image: String,
    /// How the board is flashed: `dfu`, `drive` or `probe`.
    pub via: &'static str,
    /// Addresses of the image.
    pub segments: Vec<AddressRange>,
    /// Length of the image.
    pub bytes: u64,
    /// The sectors that are erased.
    pub sectors: Vec<AddressRange>,
    /// What the rig's stored data occupy.
    pub store: AddressRange,
    /// Whether it was written; `false` after a dry run.
    pub flashed: bool,
    /// Whether the board is known to hold it; `null` after a dry run.
    pub verified: Option<bool>,
    /// Supply below which the chip resets itself, raised after flashing; `null` after a dry run, when the rig did not
    /// answer, and for a board without such a level.
    pub brown_out_mv: Option<u16>,
}

/// Addresses in a board's memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct AddressRange {
    /// The first.
    pub start: u32,
    /// The first behind it.
    pub end: u64,
}
