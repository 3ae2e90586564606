//! Events that are sent to the host without a request: hits, scans of a stream, a changed status.

use heapless::Vec;
use massline_protocol::event::{HIT, HitEvent, SCAN_BLOCK_BYTES, SCANS, STATUS_CHANGED, ScanBlock};
use massline_protocol::message::Status;
use massline_protocol::{MAX_FRAME, encode_frame};
use massline_shared::measurement::StreamProgress;
use massline_shared::signal::Record;

use crate::rig::Rig;

/// What the host has been sent.
#[derive(Default)]
pub(super) struct EventSender {
    status: Option<Status>,
    /// Next scan of the stream to be sent; `None` while there is no stream.
    next_scan: Option<u64>,
    sequence: u16,
}

impl EventSender {
    /// Writes the next event as a frame; returns its length, zero when there is none. The event takes no
    /// memory while its frame is sent.
    pub fn next(&mut self, rig: &Rig<'_>, out: &mut [u8; MAX_FRAME]) -> usize {
        let hit = rig.measurement.borrow_mut().next_hit();
        if let Some(hit) = hit {
            return self.encode(HIT, &HitEvent::from(hit), out);
        }
        if let Some(block) = self.scans(rig) {
            return self.encode(SCANS, &block, out);
        }
        let status = rig.status();
        if self.status.as_ref() == Some(&status) {
            return 0;
        }
        let length = self.encode(STATUS_CHANGED, &status, out);
        self.status = Some(status);
        length
    }

    /// The next scans of the stream, if there are enough for a block.
    fn scans(&mut self, rig: &Rig<'_>) -> Option<ScanBlock> {
        const SCANS: u64 = (SCAN_BLOCK_BYTES / Record::SCAN_BYTES) as u64;
        let measurement = rig.measurement.borrow();
        let Some(StreamProgress { end, held }) = measurement.streamed() else {
            self.next_scan = None;
            return None;
        };
        let record = measurement.record();
        let oldest = end.checked_sub(held.min(record.len() as u64))?;
        // Scans that were overwritten in the record before they were sent are missing; the host sees the
        // gap from the index.
        let first = self.next_scan.map_or(oldest, |next| next.max(oldest));
        if first + SCANS > end {
            return None;
        }
        // If the stream has not filled the record yet, the gap has another reason: scans were lost, or
        // the stream has just begun.
        if held > record.len() as u64 {
            let gone = self.next_scan.map_or(0, |next| first - next);
            rig.stats.borrow_mut().stream_scans_dropped += gone as u32;
        }
        self.next_scan = Some(first + SCANS);
        let start = record.len().checked_sub((end - first) as usize)?;
        let mut codes = Vec::new();
        codes.resize(SCAN_BLOCK_BYTES, 0).ok()?;
        record.read_bytes(start * Record::SCAN_BYTES, &mut codes);
        Some(ScanBlock { first, codes })
    }

    fn encode<T: serde::Serialize>(
        &mut self,
        kind: u16,
        body: &T,
        out: &mut [u8; MAX_FRAME],
    ) -> usize {
        self.sequence = self.sequence.wrapping_add(1);
        encode_frame(kind, self.sequence, body, out).unwrap_or(0)
    }
}
