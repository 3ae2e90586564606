//! Counts the deadlines that are missed. Each is stated on the function that must meet it.
//!
//! While a part of the application computes between two awaits everything else waits: the sampler's
//! buffer fills, the link is not served, a watchdog is not fed.

use embassy_time::{Duration, Instant};

use crate::rig::Rig;

/// The longest that any part computes between two awaits: as long as every board buffers scans.
pub(crate) const DEADLINE: Duration = Duration::from_millis(40);

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
        if missed(self.began, Instant::now()) {
            self.rig.stats.borrow_mut().deadlines_missed += 1;
        }
    }
}

fn missed(began: Instant, ended: Instant) -> bool {
    ended.saturating_duration_since(began) > DEADLINE
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deadline_is_missed_from_the_next_tick_on() {
        let began = Instant::from_millis(1000);
        assert!(!missed(began, began));
        assert!(!missed(began, began + DEADLINE));
        assert!(missed(began, began + DEADLINE + Duration::from_ticks(1)));
    }
}
