//! How long the rig still computes.

use std::time::Duration;

use massline_protocol::message::Status;

/// The least percentage that shows how fast it is.
const LEAST: u32 = 2;

/// The computation of a rig, as its statuses show it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Computing {
    /// The percentage at the first status of it and at the last new one, and when they came, since any moment.
    seen: Option<[(u8, Duration); 2]>,
}

impl Computing {
    /// Takes a status, at a time since any moment.
    pub fn status(&mut self, status: &Status, now: Duration) {
        self.seen = status.computed.map(|percent| match self.seen {
            Some(seen) if seen[1].0 == percent => seen,
            Some([first, last]) if last.0 < percent => [first, (percent, now)],
            _ => [(percent, now); 2],
        });
    }

    /// The percentage that is done; `None` while the rig does not compute.
    pub fn percent(&self) -> Option<u8> {
        self.seen.map(|[_, (percent, _)]| percent)
    }

    /// The time that the rest takes if it goes on as so far; `None` before that is known.
    fn left(&self) -> Option<Duration> {
        let [(first, began), (last, came)] = self.seen?;
        let done = u32::from(last - first);
        let rest = u32::from(100_u8.saturating_sub(last));
        (done >= LEAST).then(|| came.saturating_sub(began) * rest / done)
    }

    /// What is done and what is left, in words; `None` while the rig does not compute.
    pub fn words(&self) -> Option<String> {
        let percent = self.percent()?;
        let left = self.left().map(|left| format!(", {} s left", left.as_secs_f64().ceil()));
        Some(format!("the rig is computing: {percent} %{}", left.unwrap_or_default()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nothing() -> Status {
        Status {
            phase: 5,
            dof: 0,
            armings: 1,
            accepted: heapless::Vec::new(),
            hits_per_dof: 5,
            rejected: 0,
            last_hit: 0,
            layout_hash: 0,
            result: 0,
            started_unix_s: 0,
            computed: None,
            diagnostics: heapless::Vec::new(),
        }
    }

    #[test]
    fn the_rest_takes_as_long_as_the_pace_so_far_says() {
        let mut computing = Computing::default();
        let mut take = |computed, second| {
            let status = Status { computed, ..nothing() };
            computing.status(&status, Duration::from_secs(second));
            computing.words()
        };
        assert_eq!(take(None, 0), None);
        assert_eq!(take(Some(1), 1).as_deref(), Some("the rig is computing: 1 %"));
        // Nine percent in nine seconds: the last ninety take ninety.
        let text = take(Some(10), 10);
        assert_eq!(text.as_deref(), Some("the rig is computing: 10 %, 90 s left"));
        assert_eq!(take(Some(10), 15), text, "a status without news");
        // It is interrupted, and begins anew.
        assert_eq!(take(None, 20), None);
        assert_eq!(take(Some(0), 30).as_deref(), Some("the rig is computing: 0 %"));
    }
}
