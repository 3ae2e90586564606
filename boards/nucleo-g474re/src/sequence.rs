//! The registers of an ADC's sequence: RM0440, 21.7, "ADC registers".
//!
//! *Rank*: a place in the sequence, from 0.

/// Longest sequence.
pub const MOST_RANKS: usize = 16;

/// How long an input is sampled, in cycles of the ADC's clock; the value is the register's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum SampleTime {
    /// 2.5 cycles.
    Cycles2 = 0,
    /// 6.5 cycles.
    Cycles6 = 1,
    /// 12.5 cycles.
    Cycles12 = 2,
    /// 24.5 cycles.
    Cycles24 = 3,
    /// 47.5 cycles.
    Cycles47 = 4,
    /// 92.5 cycles.
    Cycles92 = 5,
    /// 247.5 cycles.
    Cycles247 = 6,
    /// 640.5 cycles.
    Cycles640 = 7,
}

impl SampleTime {
    /// Cycles with the 12.5 that a conversion of 12 bits takes.
    pub const fn with_conversion(self) -> u32 {
        [15, 19, 25, 37, 60, 105, 260, 653][self as usize]
    }
}

/// An input of an ADC and how long it is sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Input {
    /// 0 to 18.
    pub channel: u32,
    /// The same wherever the channel occurs.
    pub time: SampleTime,
}

/// Values of the registers that define a sequence.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Registers {
    /// Length and ranks 0 to 3; ranks 4 to 8; 9 to 13; 14 and 15.
    pub sqr: [u32; 4],
    /// Sample times of channels 0 to 9, and 10 to 18.
    pub smpr: [u32; 2],
}

/// The registers for a sequence of 1 to [`MOST_RANKS`] inputs.
pub const fn sequence<const RANKS: usize>(inputs: &[Input; RANKS]) -> Registers {
    const { assert!(RANKS >= 1 && RANKS <= MOST_RANKS) };
    let mut registers = Registers { sqr: [RANKS as u32 - 1, 0, 0, 0], smpr: [0; 2] };
    let mut rank = 0;
    while rank < RANKS {
        let Input { channel, time } = inputs[rank];
        assert!(channel <= 18, "the ADC has no such input");
        // Places of six bits, the lowest taken by the length.
        let place = rank + 1;
        registers.sqr[place / 5] |= channel << (6 * (place % 5));
        registers.smpr[(channel / 10) as usize] |= (time as u32) << (3 * (channel % 10));
        rank += 1;
    }
    registers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::{ADC1, ADC2};

    /// What the chip reads out of the registers, by the manual's tables: where each `SQn` begins.
    fn decode(registers: &Registers) -> Vec<(u32, u32)> {
        const PLACES: [(usize, u32); MOST_RANKS] = [
            (0, 6),
            (0, 12),
            (0, 18),
            (0, 24),
            (1, 0),
            (1, 6),
            (1, 12),
            (1, 18),
            (1, 24),
            (2, 0),
            (2, 6),
            (2, 12),
            (2, 18),
            (2, 24),
            (3, 0),
            (3, 6),
        ];
        let ranks = (registers.sqr[0] & 0xF) as usize + 1;
        PLACES[..ranks]
            .iter()
            .map(|&(word, at)| {
                let channel = registers.sqr[word] >> at & 0x1F;
                let (word, at) = if channel < 10 { (0, channel) } else { (1, channel - 10) };
                (channel, registers.smpr[word] >> (3 * at) & 7)
            })
            .collect()
    }

    #[test]
    fn the_rigs_sequences_have_the_registers_that_were_worked_out_by_hand() {
        // ADC1: 1, 6, 8, 15, 5, 18. SQR1: 5 | 1 << 6 | 6 << 12 | 8 << 18 | 15 << 24, SQR2: 5 | 18 << 6;
        // SMPR1: 3 for 1, 5, 6, 8; SMPR2: 3 for 15 in bits 17:15, 6 for 18 in bits 26:24.
        let first = Registers {
            sqr: [0x0F20_6045, 0x0000_0485, 0, 0],
            smpr: [3 << 3 | 3 << 15 | 3 << 18 | 3 << 24, 3 << 15 | 6 << 24],
        };
        assert_eq!(sequence(&ADC1), first);
        // ADC2: 2, 7, 9, 17, 3, 3. SQR1: 5 | 2 << 6 | 7 << 12 | 9 << 18 | 17 << 24, SQR2: 3 | 3 << 6.
        let second = sequence(&ADC2);
        assert_eq!(second.sqr, [0x1124_7085, 0x0000_00C3, 0, 0]);
    }

    #[test]
    fn every_rank_and_channel_is_where_the_manual_has_it() {
        use SampleTime::*;
        let times =
            [Cycles2, Cycles6, Cycles12, Cycles24, Cycles47, Cycles92, Cycles247, Cycles640];
        for shift in 0..19 {
            let inputs: [Input; MOST_RANKS] = core::array::from_fn(|rank| {
                let channel = (7 * rank as u32 + shift) % 19;
                Input { channel, time: times[channel as usize % 8] }
            });
            let expected: Vec<_> =
                inputs.iter().map(|input| (input.channel, input.time as u32)).collect();
            assert_eq!(decode(&sequence(&inputs)), expected);
        }
        let input = Input { channel: 18, time: SampleTime::Cycles2 };
        assert_eq!(decode(&sequence(&[input])), [(18, 0)]);
    }
}
