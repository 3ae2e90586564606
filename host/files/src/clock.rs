//! The clock of this computer, and times as text: a rig has no calendar.

use jiff::Timestamp;

/// The time by the clock of this computer, seconds since 1970-01-01 00:00 UTC; zero for a time that 32 bits do not
/// hold.
pub fn unix_seconds() -> u32 {
    u32::try_from(Timestamp::now().as_second()).unwrap_or(0)
}

/// The time by the clock of this computer, RFC 3339 in UTC.
pub fn now() -> String {
    moment(unix_seconds()).unwrap_or_default()
}

/// Seconds since 1970-01-01 00:00 UTC as RFC 3339; `None` for zero, which stands for an unknown time.
pub fn moment(unix_s: u32) -> Option<String> {
    let known = (unix_s != 0).then(|| Timestamp::from_second(unix_s.into()).ok())?;
    known.map(|time| time.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_is_utc_to_the_second_and_zero_is_unknown() {
        assert_eq!(moment(1_795_000_000).unwrap(), "2026-11-18T11:06:40Z");
        assert_eq!(moment(0), None);
        // The whole range of the wire.
        assert_eq!(moment(u32::MAX).unwrap(), "2106-02-07T06:28:15Z");
    }
}
