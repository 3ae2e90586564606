//! What a board reports about itself.

use massline_protocol::BootReason;

/// What a board reports about itself.
#[derive(Clone, Copy, Debug)]
pub struct BoardInfo {
    /// Name of its folder under `boards/`.
    pub name: &'static str,
    /// Version of the firmware.
    pub firmware: &'static str,
    /// Commit that the firmware was built from.
    pub git_hash: &'static str,
    /// True when the working tree differed from that commit.
    pub git_dirty: bool,
    /// Why the board started.
    pub boot_reason: BootReason,
    /// Message of the panic that ended the previous run; empty without one.
    pub last_panic: &'static str,
    /// Returns the stack's high-water mark and its size.
    pub stack: fn() -> StackUse,
}

/// Stack of the board, bytes; zeros when the board does not measure it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StackUse {
    /// Most bytes ever used.
    pub high_water: u32,
    /// Size.
    pub size: u32,
}
