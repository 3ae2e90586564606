//! How long the rest of a campaign takes, from how long its hits took so far.

use std::collections::VecDeque;
use std::time::Duration;

/// Intervals between accepted hits that are looked at.
const WINDOW: usize = 12;
/// Fewer say nothing.
const FEWEST: usize = 3;

/// The pace of accepted hits.
#[derive(Clone, Debug, Default)]
pub struct Pace {
    accepted: usize,
    last: Option<Duration>,
    intervals: VecDeque<Duration>,
}

impl Pace {
    /// Takes the number of accepted hits at a time.
    pub fn take(&mut self, accepted: usize, at: Duration) {
        if accepted == self.accepted {
            return;
        }
        if let Some(last) = self.last
            && accepted > self.accepted
        {
            self.intervals.push_back(at.saturating_sub(last) / (accepted - self.accepted) as u32);
            if self.intervals.len() > WINDOW {
                self.intervals.pop_front();
            }
        }
        self.accepted = accepted;
        self.last = Some(at);
    }

    /// The time that this number of further hits takes, by the median of the last intervals; `None` before it can be
    /// said.
    pub fn left(&self, hits: usize) -> Option<Duration> {
        if self.intervals.len() < FEWEST {
            return None;
        }
        let mut sorted: Vec<Duration> = self.intervals.iter().copied().collect();
        sorted.sort_unstable();
        Some(sorted[sorted.len() / 2] * u32::try_from(hits).unwrap_or(u32::MAX))
    }
}

/// `40 s` or `3 min`.
pub fn in_words(left: Duration) -> String {
    match left.as_secs() {
        0..=90 => format!("{} s", left.as_secs().max(1).div_ceil(10) * 10),
        seconds => format!("{} min", seconds.div_ceil(60)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(n: u64) -> Duration {
        Duration::from_secs(n)
    }

    #[test]
    fn a_break_of_ten_minutes_does_not_change_the_pace() {
        let mut pace = Pace::default();
        pace.take(4, seconds(0));
        assert_eq!(pace.left(10), None);
        for (hit, at) in [(5, 6), (6, 12), (7, 612), (8, 618)] {
            pace.take(hit, seconds(at));
        }
        assert_eq!(pace.left(10), Some(seconds(60)));
        assert_eq!(in_words(seconds(60)), "60 s");
        assert_eq!(in_words(seconds(100)), "2 min");
    }

    #[test]
    fn hits_that_are_taken_back_are_no_pace() {
        let mut pace = Pace::default();
        for (hit, at) in [(1, 0), (2, 6), (3, 12), (2, 13), (3, 20), (4, 26)] {
            pace.take(hit, seconds(at));
        }
        assert_eq!(pace.left(1), Some(seconds(6)));
    }
}
