//! Detects presses of a button whose contacts bounce.

/// Tracks one button. Times are in any one unit. One that decreases delays a press, and does no more.
#[derive(Clone, Copy, Debug)]
pub struct Debounce {
    /// Contacts have settled when they have not changed for this time.
    settle: u64,
    pressed: bool,
    seen: bool,
    since: u64,
}

impl Debounce {
    /// A button that is not pressed.
    pub const fn new(settle: u64) -> Self {
        Self { settle, pressed: false, seen: false, since: 0 }
    }

    /// Adds the state of the contact at `now`; returns true once for each press, when the contact has
    /// settled.
    pub fn feed(&mut self, down: bool, now: u64) -> bool {
        if down != self.seen {
            self.seen = down;
            self.since = now;
        }
        if self.seen == self.pressed || now.saturating_sub(self.since) < self.settle {
            return false;
        }
        self.pressed = self.seen;
        self.pressed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn presses(samples: &[(u64, bool)]) -> Vec<u64> {
        let mut button = Debounce::new(20);
        samples.iter().filter(|(now, down)| button.feed(*down, *now)).map(|s| s.0).collect()
    }

    #[test]
    fn a_press_is_told_once_when_it_has_settled() {
        let held: Vec<_> = (0..50).map(|k| (10 * k, k >= 3)).collect();
        assert_eq!(presses(&held), [50]);
    }

    #[test]
    fn bouncing_contacts_are_one_press() {
        let bounces = [(0, false), (10, true), (11, false), (13, true), (16, false), (18, true)];
        let rest = [(30, true), (37, true), (38, true), (60, true), (70, false), (71, true)];
        let end = [(72, false), (92, false), (100, true), (120, true)];
        assert_eq!(presses(&[&bounces[..], &rest[..], &end[..]].concat()), [38, 120]);
    }

    #[test]
    fn a_clock_that_steps_back_only_delays_a_press() {
        assert_eq!(presses(&[(100, true), (40, true), (90, true), (121, true)]), [121]);
    }

    #[test]
    fn a_spike_is_no_press() {
        assert_eq!(presses(&[(0, true), (19, true), (20, false), (100, false)]), []);
    }
}
