//! Counts the deadlines that are missed. Each is stated on the function that must meet it.
//!
//! While a part of the application computes between two awaits everything else waits: the sampler's
//! buffer fills, the link is not served, a watchdog is not fed.

use embassy_time::{Duration, Instant};
use massline_shared::protocol::message::STEP_LIMIT_MS;

use crate::rig::Rig;

/// The longest that any part computes between two awaits: as long as every board buffers scans.
pub(crate) const DEADLINE: Duration = Duration::from_millis(STEP_LIMIT_MS);

/// Runs while a part computes, until it is dropped; not to be held across an await.
pub(crate) struct Deadline<'a> {
    rig: &'a Rig,
    began: Instant,
}

impl<'a> Deadline<'a> {
    pub fn begin(rig: &'a Rig) -> Self {
        Self { rig, began: Instant::now() }
    }
}

impl Drop for Deadline<'_> {
    fn drop(&mut self) {
        let took = Instant::now().saturating_duration_since(self.began);
        if missed(took) {
            self.rig.stats.borrow_mut().deadlines_missed += 1;
        }
        let mut health = self.rig.health.borrow_mut();
        let microseconds = u32::try_from(took.as_micros()).unwrap_or(u32::MAX);
        health.longest_step_us = health.longest_step_us.max(microseconds);
    }
}

fn missed(took: Duration) -> bool {
    took > DEADLINE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_is_missed_from_the_next_tick_on() {
        assert!(!missed(Duration::from_ticks(0)));
        assert!(!missed(DEADLINE));
        assert!(missed(DEADLINE + Duration::from_ticks(1)));
    }
}
