//! Why a rig has started.

use num_enum::{FromPrimitive, IntoPrimitive};

/// Why a rig has started. It travels as its number: when a newer rig sends a reason that an older host does
/// not know, the host reads it as [`Unknown`](Self::Unknown).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, FromPrimitive, IntoPrimitive)]
#[repr(u8)]
pub enum BootReason {
    /// The chip gives no reason, or one that this program does not know.
    #[default]
    Unknown = 0,
    /// The supply was switched on.
    PowerOn = 1,
    /// A person or a debug probe pressed reset.
    ResetPin = 2,
    /// The firmware hung, and the watchdog reset the chip.
    Watchdog = 3,
    /// The firmware panicked.
    Panic = 4,
    /// The last starts all ended in a panic or a hang: the rig answers and erases its store, and does nothing else.
    SafeMode = 5,
}

impl BootReason {
    /// The name on the screen and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::PowerOn => "power-on",
            Self::ResetPin => "reset pin",
            Self::Watchdog => "watchdog",
            Self::Panic => "panic",
            Self::SafeMode => "safe mode",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::BootReason::{self, *};

    #[test]
    fn the_numbers_are_those_of_the_wire() {
        let reasons = [Unknown, PowerOn, ResetPin, Watchdog, Panic, SafeMode];
        assert_eq!(reasons.map(u8::from), [0, 1, 2, 3, 4, 5]);
        assert_eq!([0, 1, 2, 3, 4, 5].map(BootReason::from), reasons);
    }

    #[test]
    fn a_reason_of_a_newer_rig_is_unknown() {
        assert!((6..=u8::MAX).all(|raw| BootReason::from(raw) == Unknown));
    }
}
