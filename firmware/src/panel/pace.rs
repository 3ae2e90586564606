//! Estimates the remaining time of a campaign.

use embassy_time::{Duration, Instant};
use massline_shared::layout::TestProfile;
use massline_shared::measurement::campaign::Phase;

use super::PanelModel;

/// The operator's pace: mean time per accepted hit, including rejected hits and the way to the next node,
/// but not pauses.
#[derive(Clone, Copy, Debug)]
pub(super) struct TimeEstimator {
    /// Time of the last accepted hit, or of the start or resumption of measuring.
    since: Instant,
    /// Mean time of a hit; `None` before the first.
    hit: Option<Duration>,
    averaged: u16,
    measuring: bool,
    /// When the record began that is being taken.
    record: Option<Instant>,
}

/// A new hit has the weight `1 / MEMORY` in the mean.
const MEMORY: u32 = 4;

impl TimeEstimator {
    pub fn new(now: Instant) -> Self {
        Self { since: now, hit: None, averaged: 0, measuring: false, record: None }
    }

    /// Updates the pace from the current model.
    pub fn follow(&mut self, model: &PanelModel, now: Instant) {
        let measuring = matches!(model.phase, Phase::Armed | Phase::Busy | Phase::Confirming);
        if !measuring {
            self.hit = self.hit.filter(|_| model.phase == Phase::Paused);
        } else if self.measuring && model.averaged > self.averaged {
            let took = now.saturating_duration_since(self.since);
            let took = took / u32::from(model.averaged - self.averaged);
            let mean = |hit: Duration| (hit * (MEMORY - 1) + took) / MEMORY;
            self.hit = Some(self.hit.map_or(took, mean));
        }
        if !self.measuring || self.averaged != model.averaged {
            self.since = now;
        }
        (self.measuring, self.averaged) = (measuring, model.averaged);
        let records = model.phase == Phase::Busy && model.profile == TestProfile::Suspension;
        self.record = records.then(|| self.record.unwrap_or(now));
    }

    /// Time for which the object still rings in the record that is being taken, which lasts so long; `None` when none
    /// is. After it the hit is analysed.
    pub fn ringing_left(&self, record: Duration, now: Instant) -> Option<u8> {
        let took = now.saturating_duration_since(self.record?);
        let left = record.as_millis().saturating_sub(took.as_millis()).div_ceil(1000);
        u8::try_from(left).ok().filter(|left| *left > 0)
    }

    /// Estimated time for the rest of the campaign, s.
    pub fn seconds_left(&self, model: &PanelModel) -> Option<u16> {
        let left = self.hit? * u32::from(model.hits.saturating_sub(model.hits_done));
        Some(u16::try_from(left.as_millis().div_ceil(1000)).unwrap_or(u16::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(hits_done: u16, phase: Phase) -> PanelModel {
        PanelModel { phase, averaged: hits_done, hits_done, hits: 10, ..PanelModel::START }
    }

    fn pace_of(seen: &[(u16, Phase, u64)]) -> TimeEstimator {
        let mut pace = TimeEstimator::new(Instant::from_secs(0));
        for &(hits, phase, second) in seen {
            pace.follow(&at(hits, phase), Instant::from_secs(second));
        }
        pace
    }

    #[test]
    fn the_ringing_of_a_record_is_counted_down_and_that_of_the_next_anew() {
        let mut pace = TimeEstimator::new(Instant::from_secs(0));
        let mut left = |phase, profile, second| {
            let now = Instant::from_secs(second);
            pace.follow(&PanelModel { profile, ..at(0, phase) }, now);
            pace.ringing_left(Duration::from_millis(39_400), now)
        };
        assert_eq!(left(ARMED, TestProfile::Suspension, 10), None);
        assert_eq!(left(Phase::Busy, TestProfile::Suspension, 20), Some(40));
        assert_eq!(left(Phase::Busy, TestProfile::Suspension, 58), Some(2));
        assert_eq!(left(Phase::Busy, TestProfile::Suspension, 60), None);
        assert_eq!(left(ARMED, TestProfile::Suspension, 61), None);
        assert_eq!(left(Phase::Busy, TestProfile::Suspension, 70), Some(40));
        assert_eq!(left(Phase::Busy, TestProfile::MassLine, 71), None);
    }

    const ARMED: Phase = Phase::Armed;

    #[test]
    fn the_time_left_is_that_of_the_hits_left() {
        let mut pace = pace_of(&[(0, ARMED, 0), (0, ARMED, 1)]);
        assert_eq!(pace.seconds_left(&at(0, ARMED)), None);
        pace.follow(&at(1, ARMED), Instant::from_secs(4));
        assert_eq!(pace.seconds_left(&at(1, ARMED)), Some(36));
        // The next hit takes eight seconds: the mean moves a quarter of the way from 4 to 8.
        pace.follow(&at(2, ARMED), Instant::from_secs(12));
        assert_eq!(pace.seconds_left(&at(2, ARMED)), Some(40));
    }

    #[test]
    fn a_pause_does_not_count_however_long_it_is() {
        let before = [(0, ARMED, 0), (1, ARMED, 4), (1, Phase::Paused, 10)];
        let pace = pace_of(&[&before[..], &[(1, ARMED, 1000), (2, ARMED, 1004)]].concat());
        assert_eq!(pace.seconds_left(&at(2, ARMED)), Some(32));
    }

    #[test]
    fn a_dof_that_is_left_out_takes_no_hits_and_no_time() {
        let mut pace = pace_of(&[(0, ARMED, 0), (1, ARMED, 4)]);
        let skipped = PanelModel { averaged: 1, ..at(5, ARMED) };
        pace.follow(&skipped, Instant::from_secs(5));
        assert_eq!(pace.seconds_left(&skipped), Some(20));
    }

    #[test]
    fn a_new_campaign_begins_anew() {
        let pace = pace_of(&[(0, ARMED, 0), (1, ARMED, 4), (0, Phase::Idle, 10), (0, ARMED, 11)]);
        assert_eq!(pace.seconds_left(&at(0, ARMED)), None);
    }
}
