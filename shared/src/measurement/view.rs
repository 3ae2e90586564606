//! What there is to see of a measurement.

use super::averaging::DofSpectra;
use super::campaign::{Campaign, Phase};
use super::{Activity, Measurement, TestResult, Wish};
use crate::diagnosis::Diagnostics;
use crate::signal::{RealFft, Record};

/// Graded hits that wait to be fetched.
pub(super) const EVENTS: usize = 4;

/// How far a stream of scans has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Streamed {
    /// Index of the scan after the last one taken.
    pub end: u64,
    /// Scans taken without a gap.
    pub held: u64,
}

/// What the record holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// Nothing whole.
    Nothing,
    /// The hit of this number.
    Hit(u32),
    /// What the channels read without a hit.
    Reading,
    /// Nothing: the converter stopped while it was to be a reading without a hit.
    ReadingFailed,
}

/// A hit that was graded. A later one of the same number takes its place: the hit was good by itself and was
/// withdrawn after it had been compared with the other hits at its DOF.
#[derive(Clone, Debug, PartialEq)]
pub struct GradedHit {
    /// Counts the hits, from 1.
    pub number: u32,
    /// Index of the DOF that was hit.
    pub dof: u8,
    /// True when nothing was found that rejects it.
    pub good: bool,
    /// Scan of the trigger.
    pub scan: u64,
    /// Peak force, N.
    pub peak_force: f32,
    /// Largest acceleration of any channel, m/s².
    pub peak_acceleration: f32,
    /// What the grading found.
    pub findings: Diagnostics,
}

/// What has been counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Scans taken.
    pub scans: u64,
    /// Scans lost.
    pub scans_lost: u64,
    /// Times that scans were lost.
    pub overruns: u32,
    /// Triggers.
    pub triggers: u32,
    /// Hits aborted because scans of their record were lost.
    pub hits_aborted: u32,
    /// Graded hits that nobody fetched in time.
    pub events_dropped: u32,
}

impl<R: RealFft> Measurement<'_, R> {
    /// What is shown of the rig.
    pub fn phase(&self) -> Phase {
        self.campaign().map_or(Phase::Idle, Campaign::phase)
    }

    /// The campaign that is running, else the one that ended last.
    pub fn campaign(&self) -> Option<&Campaign> {
        self.running().or(self.ended.as_ref())
    }

    pub(super) fn running(&self) -> Option<&Campaign> {
        match &self.activity {
            Activity::Measuring(campaign, _) => Some(campaign),
            _ => None,
        }
    }

    /// True when layout, calibration and results may be changed: nothing is measured.
    pub fn is_idle(&self) -> bool {
        matches!(self.activity, Activity::Idle | Activity::Changing)
    }

    /// True when nothing is sampled or computed: idle or paused.
    pub fn rests(&self) -> bool {
        let paused = |campaign: &Campaign| campaign.phase() == Phase::Paused;
        self.is_idle() || (self.running().is_some_and(paused) && self.wish() == Wish::Rest)
    }

    /// How far the stream of scans has come; `None` without one.
    pub fn streamed(&self) -> Option<Streamed> {
        match self.activity {
            Activity::Streaming(streamed) => Some(streamed),
            _ => None,
        }
    }

    /// True while a reading without a hit is being taken.
    pub fn reads(&self) -> bool {
        matches!(self.activity, Activity::Reading)
    }

    /// What the record holds.
    pub fn recorded(&self) -> Recorded {
        self.recorded
    }

    /// The record. It is whole when [`Self::recorded`] says so.
    pub fn record(&self) -> &Record {
        &self.memory.record
    }

    /// The averaged spectra and the index of their DOF.
    pub fn spectra(&self) -> Option<(u8, &DofSpectra<R>)> {
        Some((self.averaged?, &self.memory.spectra))
    }

    /// The hit graded last in this campaign.
    pub fn last_hit(&self) -> Option<&GradedHit> {
        self.last_hit.as_ref()
    }

    /// The next graded hit that has not been fetched.
    pub fn next_hit(&mut self) -> Option<GradedHit> {
        self.events.pop_front()
    }

    /// Hits graded.
    pub fn hits(&self) -> u32 {
        self.hits
    }

    /// Times that the hammer has been waited for.
    pub fn armings(&self) -> u32 {
        self.armings
    }

    /// Campaigns begun.
    pub fn campaigns(&self) -> u32 {
        self.campaigns
    }

    /// What has been counted.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What is to be said about the campaign.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// What has been measured and identified so far.
    pub fn result(&self) -> TestResult<'_, R> {
        TestResult {
            dofs: &self.memory.dofs,
            mass_lines: &self.memory.mass_lines,
            estimates: self.memory.identification.estimates(),
            refusals: self.memory.identification.refusals(),
            block: self.block,
            diagnostics: &self.diagnostics,
        }
    }

    /// Queues a graded hit; the oldest goes when nobody fetches them.
    pub(super) fn report(&mut self, hit: GradedHit) {
        if self.events.is_full() {
            self.events.pop_front();
            self.counts.events_dropped += 1;
        }
        // There is room: one was taken out above.
        let _ = self.events.push_back(hit);
    }
}
