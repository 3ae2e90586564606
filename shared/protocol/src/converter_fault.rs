//! What is wrong with the frames of an external converter.

use num_enum::{FromPrimitive, IntoPrimitive};

/// What is wrong with the frames of an external converter. It travels as its number: what an older host does not know,
/// it reads as [`None`](Self::None).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, FromPrimitive, IntoPrimitive)]
#[repr(u8)]
pub enum ConverterFault {
    /// Nothing, or the board has none.
    #[default]
    None = 0,
    /// Its data line stays high: nothing drives it.
    LineHigh = 1,
    /// Its data line stays low.
    LineLow = 2,
    /// All frames are of the same channel: it does not receive the commands.
    NoCommands = 3,
    /// A frame is not of the channel that is due.
    WrongTag = 4,
}

#[cfg(test)]
mod tests {
    use super::ConverterFault::{self, *};

    #[test]
    fn the_numbers_are_those_of_the_wire() {
        let faults = [None, LineHigh, LineLow, NoCommands, WrongTag];
        assert_eq!(faults.map(u8::from), [0, 1, 2, 3, 4]);
        assert_eq!([0, 1, 2, 3, 4].map(ConverterFault::from), faults);
        assert!((5..=u8::MAX).all(|raw| ConverterFault::from(raw) == None));
    }
}
