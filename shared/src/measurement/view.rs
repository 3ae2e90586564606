//! The state of a measurement, for display.

use super::averaging::DofSpectra;
use super::campaign::{Campaign, Phase};
use super::{Activity, Measurement, Memory, NextAction, TestResult};
use crate::diagnosis::Diagnostics;
use crate::signal::{RealFft, Record, Swing};

/// Capacity of the queue of graded hits.
pub(super) const EVENTS: usize = 4;

/// Progress of a stream of scans.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StreamProgress {
    /// Index of the scan after the last one taken.
    pub end: u64,
    /// Number of scans taken without a gap.
    pub held: u64,
}

/// Content of the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RecordContent {
    /// Nothing complete.
    Nothing,
    /// The hit with this number.
    Hit(u32),
    /// The hit with this number, while the rig waits for the next one.
    HitBefore(u32),
    /// A reading of the channels without a hit.
    Reading,
    /// Nothing: the converter stopped during a reading without a hit.
    ReadingFailed,
}

/// A graded hit. A later one with the same number replaces it: the hit passed its own grading and was
/// withdrawn after the comparison with its repeat hits, or undone by the operator.
#[derive(Clone, Debug, PartialEq)]
pub struct GradedHit {
    /// Number of the hit, counted from 1.
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
    pub findings: Diagnostics,
}

/// Counters of the measurement.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Scans taken.
    pub scans: u64,
    /// Scans lost.
    pub scans_lost: u64,
    /// Number of times scans were lost.
    pub overruns: u32,
    /// Triggers.
    pub triggers: u32,
    /// Hits aborted because scans of their record were lost.
    pub hits_aborted: u32,
    /// Graded hits that were not fetched in time.
    pub events_dropped: u32,
}

impl<R: RealFft> Measurement<'_, R> {
    /// State of the rig as shown to the operator.
    pub fn phase(&self) -> Phase {
        self.campaign().map_or(Phase::Idle, Campaign::phase)
    }

    /// The running campaign, otherwise the one that ended last.
    pub fn campaign(&self) -> Option<&Campaign> {
        self.running().or(self.ended.as_ref())
    }

    pub(super) fn running(&self) -> Option<&Campaign> {
        match &self.activity {
            Activity::Measuring(campaign, _) => Some(campaign),
            _ => None,
        }
    }

    /// True when layout, calibration and results may be changed.
    pub fn is_idle(&self) -> bool {
        matches!(self.activity, Activity::Idle | Activity::Changing)
    }

    /// True when nothing is sampled or computed: idle or paused.
    pub fn rests(&self) -> bool {
        let paused = |campaign: &Campaign| campaign.phase() == Phase::Paused;
        self.is_idle()
            || (self.running().is_some_and(paused) && self.next_action() == NextAction::Wait)
    }

    /// Progress of the stream of scans; `None` without a stream.
    pub fn streamed(&self) -> Option<StreamProgress> {
        match self.activity {
            Activity::Streaming(streamed) => Some(streamed),
            _ => None,
        }
    }

    /// True while a reading without a hit is being taken.
    pub fn reads(&self) -> bool {
        matches!(self.activity, Activity::Reading)
    }

    /// Content of the record.
    pub fn recorded(&self) -> RecordContent {
        self.recorded
    }

    /// The record. [`Self::recorded`] shows whether it is complete.
    pub fn record(&self) -> &Record {
        &self.memory.record
    }

    /// Copies the bytes from `offset` on of what is [recorded](Self::recorded) into `bytes`, and returns their number:
    /// see [`Record::read_bytes`].
    pub fn read_recorded(&self, offset: usize, bytes: &mut [u8]) -> usize {
        let Memory { record, scratch, .. } = &*self.memory;
        match self.recorded {
            RecordContent::HitBefore(_) => record.read_bytes_before_wait(
                scratch.get(..Record::START_CODES).unwrap_or_default(),
                offset,
                bytes,
            ),
            _ => record.read_bytes(offset, bytes),
        }
    }

    /// The averaged spectra and the index of their DOF.
    pub fn spectra(&self) -> Option<(u8, &DofSpectra<R>)> {
        Some((self.averaged?, &self.memory.spectra))
    }

    /// The last graded hit of this campaign.
    pub fn last_hit(&self) -> Option<&GradedHit> {
        self.last_hit.as_ref()
    }

    /// Fetches the next graded hit.
    pub fn next_hit(&mut self) -> Option<GradedHit> {
        self.events.pop_front()
    }

    /// Number of hits graded.
    pub fn hits(&self) -> u32 {
        self.hits
    }

    /// Number of times the trigger was armed.
    pub fn armings(&self) -> u32 {
        self.armings
    }

    /// Number of campaigns started.
    pub fn campaigns(&self) -> u32 {
        self.campaigns
    }

    /// Counters of the measurement.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Diagnostics of the campaign.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// Measured data and estimates so far.
    pub fn result(&self) -> TestResult<'_, R> {
        TestResult {
            dofs: &self.memory.dofs,
            mass_lines: &self.memory.mass_lines,
            lines: &self.memory.lines,
            estimates: self.memory.answers.estimates(),
            refusals: self.memory.answers.refusals(),
            block: self.block,
            gains: self.gains(),
            diagnostics: &self.diagnostics,
        }
    }

    /// Queues a graded hit; the oldest is dropped when the queue is full.
    pub(super) fn report(&mut self, hit: GradedHit) {
        if self.events.is_full() {
            self.events.pop_front();
            self.counts.events_dropped += 1;
        }
        // There is room: a full queue was shortened above.
        let _ = self.events.push_back(hit);
    }
}
