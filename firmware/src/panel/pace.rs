//! How long the campaign will take still.

use embassy_time::{Duration, Instant};
use massline_shared::protocol::message::Phase;

use super::PanelModel;

/// The pace of the person with the hammer: how long a hit takes that counts, rejected ones and the way
/// to the next node included, pauses not.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// The last hit that counted, or the end of a pause.
    since: Instant,
    /// Mean time of a hit; none before the first.
    hit: Option<Duration>,
    hits_done: u16,
}

/// A new hit counts for one part in so many of the mean.
const MEMORY: u32 = 4;

impl Pace {
    pub fn new(now: Instant) -> Self {
        Self { since: now, hit: None, hits_done: 0 }
    }

    /// Takes note of what is shown now.
    pub fn follow(&mut self, model: &PanelModel, now: Instant) {
        let measuring = matches!(model.phase, Phase::Armed | Phase::Busy | Phase::Confirming);
        if !measuring || model.hits_done < self.hits_done {
            let hit = self.hit.filter(|_| model.phase == Phase::Paused);
            *self = Self { hit, hits_done: model.hits_done, ..Self::new(now) };
        } else if model.hits_done > self.hits_done {
            let took = now.saturating_duration_since(self.since);
            let took = took / u32::from(model.hits_done - self.hits_done);
            let mean = |hit: Duration| (hit * (MEMORY - 1) + took) / MEMORY;
            self.hit = Some(self.hit.map_or(took, mean));
            (self.since, self.hits_done) = (now, model.hits_done);
        }
    }

    /// Time that the rest of the campaign will take, s.
    pub fn seconds_left(&self, model: &PanelModel) -> Option<u16> {
        let hits = u32::from(model.hits.saturating_sub(model.hits_done));
        let seconds = (self.hit? * hits).as_millis().div_ceil(1000);
        Some(u16::try_from(seconds).unwrap_or(u16::MAX))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(hits_done: u16, phase: Phase) -> PanelModel {
        PanelModel { phase, hits_done, hits: 10, ..PanelModel::START }
    }

    #[test]
    fn the_time_left_is_that_of_the_hits_left() {
        let mut pace = Pace::new(Instant::from_secs(0));
        pace.follow(&at(0, Phase::Armed), Instant::from_secs(1));
        assert_eq!(pace.seconds_left(&at(0, Phase::Armed)), None);
        pace.follow(&at(1, Phase::Armed), Instant::from_secs(4));
        assert_eq!(pace.seconds_left(&at(1, Phase::Armed)), Some(36));
        // Eight seconds in the next: a quarter of the way from 4 to 8.
        pace.follow(&at(2, Phase::Armed), Instant::from_secs(12));
        assert_eq!(pace.seconds_left(&at(2, Phase::Armed)), Some(40));
    }

    #[test]
    fn a_pause_does_not_count_and_a_new_campaign_begins_anew() {
        let mut pace = Pace::new(Instant::from_secs(0));
        pace.follow(&at(1, Phase::Armed), Instant::from_secs(4));
        pace.follow(&at(1, Phase::Paused), Instant::from_secs(1000));
        pace.follow(&at(2, Phase::Armed), Instant::from_secs(1004));
        assert_eq!(pace.seconds_left(&at(2, Phase::Armed)), Some(32));
        pace.follow(&at(0, Phase::Idle), Instant::from_secs(1010));
        assert_eq!(pace.seconds_left(&at(0, Phase::Armed)), None);
    }
}
