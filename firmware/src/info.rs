//! What a board reports about itself.

use massline_protocol::message::Identity;
use massline_protocol::{BootReason, PROTOCOL_MAJOR, PROTOCOL_MINOR};
use massline_shared::layout::{RIG_HITS, RIG_SENSORS};
use massline_shared::signal::{AdcProperties, PRE_TRIGGER_SCANS, RECORD_SCANS};

use crate::rig::cut;

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

/// Identity of a rig with this converter, whose link carries all scans if `streams` is true.
pub(crate) fn identity(info: &BoardInfo, adc: AdcProperties, streams: bool) -> Identity {
    Identity {
        protocol_major: PROTOCOL_MAJOR,
        protocol_minor: PROTOCOL_MINOR,
        firmware: cut(info.firmware),
        git_hash: cut(info.git_hash),
        git_dirty: info.git_dirty,
        board: cut(info.name),
        adc,
        record_scans: RECORD_SCANS as u16,
        pre_trigger_scans: PRE_TRIGGER_SCANS as u16,
        max_sensors: RIG_SENSORS as u8,
        max_hits: RIG_HITS as u8,
        streams,
        boot_reason: info.boot_reason.into(),
        last_panic: cut(info.last_panic),
    }
}
