//! What a rig's clocks are derived from.

use num_enum::{FromPrimitive, IntoPrimitive};

/// What a rig's clocks are derived from. It travels as its number: what an older host does not know, it reads as
/// [`Unknown`](Self::Unknown).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, FromPrimitive, IntoPrimitive)]
#[repr(u8)]
pub enum Clock {
    /// The board does not say, or this program does not know it.
    #[default]
    Unknown = 0,
    /// The board's crystal.
    Crystal = 1,
    /// The chip's own oscillator, because the crystal does not oscillate. It may be wrong by a few per cent, and USB
    /// may fail.
    Internal = 2,
}

impl Clock {
    /// The name on the screen and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unknown => "unknown",
            Self::Crystal => "crystal",
            Self::Internal => "internal",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Clock::{self, *};

    #[test]
    fn the_numbers_are_those_of_the_wire() {
        assert_eq!([Unknown, Crystal, Internal].map(u8::from), [0, 1, 2]);
        assert_eq!([0, 1, 2].map(Clock::from), [Unknown, Crystal, Internal]);
        assert!((3..=u8::MAX).all(|raw| Clock::from(raw) == Unknown));
    }
}
