//! Whether the parts of the application get on with their work, so that a watchdog is fed only then.

use core::cell::Cell;
use core::convert::Infallible;

use embassy_time::{Duration, Instant, Timer};

/// A part that has worked for longer than this without a sign of progress hangs. The longest wait of a healthy part is
/// for the flash: three sectors of an STM32F411 in 2.4 s.
const PATIENCE: Duration = Duration::from_secs(5);
/// How often the watchdog is fed.
const FED_EVERY: Duration = Duration::from_secs(1);

/// A part of the application.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Measuring,
    Session,
    Panel,
}

/// What the parts do.
pub(crate) struct Pulse {
    /// Last sign of progress of each part; `None` while it waits for an event from outside.
    at_work_since: [Cell<Option<Instant>>; 3],
}

impl Pulse {
    /// All parts wait.
    pub const fn new() -> Self {
        Self { at_work_since: [const { Cell::new(None) }; 3] }
    }

    /// The part has nothing to do until something happens outside.
    pub fn waits(&self, part: Part) {
        self.at_work_since[part as usize].set(None);
    }

    /// The part has work to do, and gets on with it.
    pub fn works(&self, part: Part) {
        self.at_work_since[part as usize].set(Some(Instant::now()));
    }

    /// True when no part hangs.
    fn is_steady(&self, now: Instant) -> bool {
        let is_late = |since: Instant| now.saturating_duration_since(since) > PATIENCE;
        !self.at_work_since.iter().any(|since| since.get().is_some_and(is_late))
    }

    /// Feeds the watchdog while no part hangs; never returns.
    pub async fn watch(&self, feed_watchdog: fn()) -> Infallible {
        loop {
            if self.is_steady(Instant::now()) {
                feed_watchdog();
            }
            Timer::after(FED_EVERY).await;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_hangs_when_it_works_without_progress_for_longer_than_the_patience() {
        let pulse = Pulse::new();
        let now = Instant::from_secs(100);
        let later = now + PATIENCE + Duration::from_secs(1);
        assert!(pulse.is_steady(later), "all wait");
        for part in [Part::Measuring, Part::Session, Part::Panel] {
            pulse.at_work_since[part as usize].set(Some(now));
            assert!(pulse.is_steady(now), "{part:?}");
            assert!(!pulse.is_steady(later), "{part:?}");
            pulse.waits(part);
            assert!(pulse.is_steady(later), "{part:?}");
        }
    }
}
