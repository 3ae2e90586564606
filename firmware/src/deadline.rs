//! Counts the deadlines that are missed. Each is stated on the function that must meet it.
//!
//! While a part of the application computes between two awaits everything else waits: the sampler's
//! buffer fills, the link is not served, a watchdog is not fed. The longest parts, as budgets of
//! `tests/budgets.toml` (a Cortex-M4F in QEMU counts instructions, not cycles) and at 100 MHz
//! with one and a half cycles each:
//!
//! | part | while | budget | at 100 MHz |
//! | --- | --- | --- | --- |
//! | a block of 20 scans | sampling | not measured apart | far below 1 ms |
//! | `hit_step`: one channel of a hit | sampler stopped | 0.25 M | 4 ms |
//! | `hit_grading`: a record | sampler stopped | 0.48 M | 7 ms |
//! | `dof_closing`: all mass lines of a DOF | sampler stopped | 0.45 M | 7 ms |
//! | `ml_step_12`: a step of the fit, twelve hit DOFs | sampler stopped | 1.0 M | 15 ms |
//! | the bytes of a result, once for every piece of it | sampler stopped | not measured apart | not measured |
//! | `layout_check` | whenever a layout comes | 0.45 M | 7 ms |
//! | `record_checksum`: the host asks for a record | any time but sampling | 0.6 M | 9 ms |
//! | `rest_statistics`: six of them make a tumble test | idle | 0.25 M | 4 ms |
//!
//! A page of flash that is erased or a word that is written stops the whole core of most chips: see
//! [`crate::board::Board::flash`]. That happens only while the sampler is stopped, and is not counted here.

use core::cell::RefCell;

use embassy_time::{Duration, Instant};
use massline_protocol::message::{STEP_LIMIT_MS, Stats};

/// The longest that any part computes between two awaits: as long as every board buffers scans.
pub(crate) const DEADLINE: Duration = Duration::from_millis(STEP_LIMIT_MS);

/// Runs while a part computes, until it is dropped; not to be held across an await.
pub(crate) struct Deadline<'a> {
    stats: &'a RefCell<Stats>,
    began: Instant,
}

impl<'a> Deadline<'a> {
    pub fn begin(stats: &'a RefCell<Stats>) -> Self {
        Self { stats, began: Instant::now() }
    }
}

impl Drop for Deadline<'_> {
    fn drop(&mut self) {
        let took = Instant::now().saturating_duration_since(self.began);
        let mut stats = self.stats.borrow_mut();
        stats.deadlines_missed += u32::from(missed(took));
        let microseconds = u32::try_from(took.as_micros()).unwrap_or(u32::MAX);
        stats.longest_step_us = stats.longest_step_us.max(microseconds);
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
