//! The registers of an STM32's ADC sequence. The families differ in the positions of the fields.
//!
//! *Rank*: a place in the sequence, from 0.

/// Longest sequence.
pub const MOST_RANKS: usize = 16;
/// Inputs that an ADC has.
const INPUTS: u32 = 19;

/// An input of the ADC and how long it is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// Number of the channel, 0 to 18.
    pub channel: u32,
    /// Code of the sample time; the same for every occurrence of the channel.
    pub time: u32,
}

/// Positions of the ranks in the registers of a family.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Layout {
    /// Bits per rank.
    pub bits: u32,
    /// Ranks per register.
    pub per_word: usize,
    /// Position of rank 0 in the first register, in ranks.
    pub first: usize,
    /// Register and lowest bit of the length, which is stored less 1.
    pub length: (usize, u32),
}

/// Values of the registers that define a sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers {
    /// Registers of the ranks, beginning with that of rank 0, and the length.
    pub ranks: [u32; 4],
    /// Sample times of three bits each: channels 0 to 9, and 10 to 18.
    pub times: [u32; 2],
}

/// The registers for a sequence of 1 to [`MOST_RANKS`] inputs.
pub const fn sequence<const RANKS: usize>(inputs: &[Input; RANKS], layout: &Layout) -> Registers {
    const { assert!(RANKS >= 1 && RANKS <= MOST_RANKS) };
    let mut registers = Registers { ranks: [0; 4], times: [0; 2] };
    registers.ranks[layout.length.0] = (RANKS as u32 - 1) << layout.length.1;
    let mut rank = 0;
    while rank < RANKS {
        let Input { channel, time } = inputs[rank];
        assert!(channel < INPUTS, "the ADC has no such input");
        let place = layout.first + rank;
        registers.ranks[place / layout.per_word] |=
            channel << (layout.bits * (place % layout.per_word) as u32);
        registers.times[(channel / 10) as usize] |= time << (3 * (channel % 10));
        rank += 1;
    }
    registers
}
