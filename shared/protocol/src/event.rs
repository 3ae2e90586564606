//! Messages that the rig sends unasked. Events may be lost; everything that matters can also be requested.

use heapless::Vec;
use serde::{Deserialize, Serialize};

use massline_shared::diagnosis::{Code, Diagnostics};
use massline_shared::measurement::GradedHit;
use massline_shared::signal::{Record, Swing};

/// Kind of a [`crate::message::Status`] that is sent because the status has changed.
pub const STATUS_CHANGED: u16 = 0x4001;
/// Kind of a [`HitEvent`].
pub const HIT: u16 = 0x4002;
/// Kind of a [`ScanBlock`].
pub const SCANS: u16 = 0x4003;

/// A hit was graded. A later event with the same number replaces it: the hit passed its own grading, and then the
/// comparison with its repeat hits found something (a warning, or an error that withdraws it), or the operator has
/// undone it ([`Code::HitUndone`]).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct HitEvent {
    /// Number of the hit, counted from 1 since power-on.
    pub number: u32,
    /// Index of the DOF that was hit.
    pub dof: u8,
    /// True when no finding rejects the hit.
    pub good: bool,
    /// Index of the scan at the trigger.
    pub scan: u64,
    /// Peak force, N.
    pub peak_force: f32,
    /// Largest acceleration of any channel, m/s².
    pub peak_acceleration: f32,
    /// What it was judged by in the suspension profile.
    pub swing: Option<Swing>,
    /// What the grading found.
    #[serde(with = "crate::diagnostic")]
    pub findings: Diagnostics,
}

impl HitEvent {
    /// True when the operator has taken back the hit after it had been accepted.
    pub fn is_undone(&self) -> bool {
        self.findings.iter().any(|finding| finding.code == Code::HitUndone)
    }
}

impl From<GradedHit> for HitEvent {
    fn from(hit: GradedHit) -> Self {
        let GradedHit { number, dof, good, scan, peak_force, peak_acceleration, swing, findings } =
            hit;
        Self { number, dof, good, scan, peak_force, peak_acceleration, swing, findings }
    }
}

/// Bytes of scans in a [`ScanBlock`].
pub const SCAN_BLOCK_BYTES: usize = 1000;

const _: () = assert!(SCAN_BLOCK_BYTES.is_multiple_of(Record::SCAN_BYTES), "whole scans");

/// A block of scans from the stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ScanBlock {
    /// Index of the first scan; when it does not follow the previous block, scans are missing.
    pub first: u64,
    /// Whole scans, little-endian u16 codes.
    pub codes: Vec<u8, SCAN_BLOCK_BYTES>,
}
