//! How long the object still rings in a record of the suspension profile.

use std::time::{Duration, Instant};

use massline_shared::measurement::campaign::Phase;

/// Counts the seconds of each record since its hit, because the rig says only that it is busy.
#[derive(Clone, Copy, Debug)]
pub struct Ringing {
    /// Length of a record after the hit.
    record: Duration,
    /// The arming whose record is taken, and when it was hit.
    hit: Option<(u32, Instant)>,
    /// The arming whose hit is graded: what the rig is busy with is no record.
    graded: Option<u32>,
}

impl Ringing {
    /// Records that last so long after the hit, s.
    pub fn new(record_s: f64) -> Self {
        Self {
            record: Duration::try_from_secs_f64(record_s).unwrap_or_default(),
            hit: None,
            graded: None,
        }
    }

    /// Takes the phase of the campaign and the number of its arming at this time.
    pub fn status(&mut self, phase: Option<Phase>, arming: u32, now: Instant) {
        self.hit = match self.hit {
            _ if phase != Some(Phase::Busy) || self.graded == Some(arming) => None,
            Some((same, since)) if same == arming => Some((same, since)),
            _ => Some((arming, now)),
        };
    }

    /// The hit of this record is graded.
    pub fn graded(&mut self) {
        self.graded = self.hit.take().map(|(arming, _)| arming).or(self.graded);
    }

    /// Whole seconds that are left of the record; `None` when none is taken, or it is complete.
    pub fn left_s(&self, now: Instant) -> Option<u64> {
        let (_, since) = self.hit?;
        let left = self.record.checked_sub(now.saturating_duration_since(since))?;
        Some(left.as_secs_f64().ceil() as u64).filter(|&left| left > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_seconds_of_a_record_run_down_from_its_hit() {
        let mut ringing = Ringing::new(39.4);
        let hit = Instant::now();
        ringing.status(Some(Phase::Armed), 1, hit);
        assert_eq!(ringing.left_s(hit), None);
        ringing.status(Some(Phase::Busy), 1, hit);
        assert_eq!(ringing.left_s(hit), Some(40));
        // A later status of the same arming does not begin anew.
        let later = hit + Duration::from_secs(10);
        ringing.status(Some(Phase::Busy), 1, later);
        assert_eq!(ringing.left_s(later), Some(30));
        // The record is complete, and the rig computes.
        assert_eq!(ringing.left_s(hit + Duration::from_secs(40)), None);
        // It averages the hit, and is busy yet.
        ringing.graded();
        ringing.status(Some(Phase::Busy), 1, later);
        assert_eq!(ringing.left_s(later), None);
        ringing.status(Some(Phase::Busy), 2, later);
        assert_eq!(ringing.left_s(later), Some(40));
    }
}
