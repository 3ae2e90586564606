//! Why a rig has started.

use num_enum::{FromPrimitive, IntoPrimitive};

/// Why a rig has started. On the wire it is its number, so that a newer rig may state a reason that an older
/// host does not know: the host reads it as [`Unknown`](Self::Unknown).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, FromPrimitive, IntoPrimitive)]
#[repr(u8)]
pub enum BootReason {
    /// The chip does not say, or says what this program does not know.
    #[default]
    Unknown = 0,
    /// The supply came up.
    PowerOn = 1,
    /// Someone pressed reset, or a probe did.
    ResetPin = 2,
    /// The firmware hung and the watchdog ran out.
    Watchdog = 3,
    /// The firmware panicked.
    Panic = 4,
}

#[cfg(test)]
mod tests {
    use super::BootReason::{self, *};

    #[test]
    fn the_numbers_are_those_of_the_wire() {
        assert_eq!([Unknown, PowerOn, ResetPin, Watchdog, Panic].map(u8::from), [0, 1, 2, 3, 4]);
        assert_eq!(
            [0, 1, 2, 3, 4].map(BootReason::from),
            [Unknown, PowerOn, ResetPin, Watchdog, Panic]
        );
    }

    #[test]
    fn a_reason_of_a_newer_rig_is_unknown() {
        assert!((5..=u8::MAX).all(|raw| BootReason::from(raw) == Unknown));
    }
}
