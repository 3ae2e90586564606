//! What a board says of itself.

use massline_protocol::BootReason;

/// What a board says of itself.
#[derive(Clone, Copy, Debug)]
pub struct BoardInfo {
    /// The folder under `boards/`.
    pub name: &'static str,
    /// Version of the firmware.
    pub firmware: &'static str,
    /// Commit that it was built from.
    pub git_hash: &'static str,
    /// True when that commit had been changed before the build.
    pub git_dirty: bool,
    /// Why it started.
    pub boot_reason: BootReason,
    /// The last words of a panic before this start.
    pub last_panic: &'static str,
    /// Most stack ever used and stack that there is, bytes.
    pub stack: fn() -> StackUse,
}

/// Stack of the board, bytes; zeros when it does not measure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StackUse {
    /// Most ever used.
    pub high_water: u32,
    /// Size.
    pub size: u32,
}
