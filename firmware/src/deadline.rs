//! Counts missed deadlines. Each deadline is stated on the function that must meet it.
//!
//! While a part of the application computes between two awaits, everything else waits: the sampler's buffer
//! fills, the link is not served, a watchdog is not fed. The table lists the longest computations with
//! their budgets in instructions from `tests/budgets.toml` (QEMU's Cortex-M4F counts instructions, not
//! cycles), and the time at 100 MHz with one and a half cycles per instruction:
//!
//! | part | while | budget | at 100 MHz |
//! | --- | --- | --- | --- |
//! | a block of 20 scans | sampling | not measured separately | far below 1 ms |
//! | `hit_step`: one channel of a hit | sampler stopped | 0.35 M | 5 ms |
//! | `hit_grading`: a record | sampler stopped | 0.565 M | 8 ms |
//! | `dof_closing`: all mass lines of a DOF | sampler stopped | 0.54 M | 8 ms |
//! | `ml_learn_step_12`: a step of the fit, twelve hit DOFs | sampler stopped | 1.6 M | 24 ms |
//! | the bytes of a result, for each piece of it | sampler stopped | not measured separately | not measured |
//! | `layout_check` | whenever a layout arrives | 0.615 M | 9 ms |
//! | `record_checksum`: the host requests a record | any time except sampling | 0.70 M | 11 ms |
//! | `rest_statistics`: six of them make a tumble test | idle | 0.24 M | 4 ms |
//! | `self_test_channel`: a channel of a self-test by buttons | idle | 0.56 M | 8 ms |
//!
//! On most chips, erasing a page of flash or writing a word stops the core: see
//! [`crate::board::Board::flash`]. That happens only while the sampler is stopped, and is not counted here.

use core::cell::RefCell;

use embassy_time::{Duration, Instant};
use massline_protocol::message::{STEP_LIMIT_MS, Stats};

/// Longest permitted computation between two awaits: every board buffers scans for this time.
pub(crate) const DEADLINE: Duration = Duration::from_millis(STEP_LIMIT_MS);

/// Measures a computation until it is dropped; not to be held across an await.
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
