//! The registers of the ADC's sequence: RM0383, 11.12, "ADC registers".
//!
//! *Rank*: a place in the sequence, from 0.

/// Longest sequence.
pub const MOST_RANKS: usize = 16;

/// How long an input is sampled, in cycles of the ADC's clock; the value is the register's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum SampleTime {
    /// 3 cycles.
    Cycles3 = 0,
    /// 15 cycles.
    Cycles15 = 1,
    /// 28 cycles.
    Cycles28 = 2,
    /// 56 cycles.
    Cycles56 = 3,
    /// 84 cycles.
    Cycles84 = 4,
    /// 112 cycles.
    Cycles112 = 5,
    /// 144 cycles.
    Cycles144 = 6,
    /// 480 cycles.
    Cycles480 = 7,
}

impl SampleTime {
    /// Cycles.
    pub const fn cycles(self) -> u32 {
        [3, 15, 28, 56, 84, 112, 144, 480][self as usize]
    }
}

/// An input of the ADC and how long it is sampled.
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
    /// Length, ranks 12 to 15.
    pub sqr1: u32,
    /// Ranks 6 to 11.
    pub sqr2: u32,
    /// Ranks 0 to 5.
    pub sqr3: u32,
    /// Sample times of channels 10 to 18.
    pub smpr1: u32,
    /// Sample times of channels 0 to 9.
    pub smpr2: u32,
}

/// The registers for a sequence of 1 to [`MOST_RANKS`] inputs.
pub const fn sequence<const RANKS: usize>(inputs: &[Input; RANKS]) -> Registers {
    const { assert!(RANKS >= 1 && RANKS <= MOST_RANKS) };
    let mut registers =
        Registers { sqr1: (RANKS as u32 - 1) << 20, sqr2: 0, sqr3: 0, smpr1: 0, smpr2: 0 };
    let mut rank = 0;
    while rank < RANKS {
        let Input { channel, time } = inputs[rank];
        assert!(channel <= 18, "the ADC has no such input");
        let place = channel << (5 * (rank % 6));
        match rank / 6 {
            0 => registers.sqr3 |= place,
            1 => registers.sqr2 |= place,
            _ => registers.sqr1 |= place,
        }
        let time = (time as u32) << (3 * (channel % 10));
        if channel < 10 {
            registers.smpr2 |= time;
        } else {
            registers.smpr1 |= time;
        }
        rank += 1;
    }
    registers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::INPUTS;

    /// What the chip reads out of the registers, by the manual's tables: `SQRn` of five bits each, from
    /// SQ1 in the lowest bits of SQR3, SQ7 in SQR2, SQ13 in SQR1; `L` in bits 23:20 of SQR1; `SMPn` of
    /// three bits each, channel 10 in the lowest of SMPR1, channel 0 in the lowest of SMPR2.
    fn decode(registers: &Registers) -> Vec<(u32, u32)> {
        let ranks = (registers.sqr1 >> 20 & 0xF) + 1;
        let words = [registers.sqr3, registers.sqr2, registers.sqr1];
        (0..ranks)
            .map(|rank| {
                let channel = words[rank as usize / 6] >> (5 * (rank % 6)) & 0x1F;
                let (word, at) = match channel {
                    0..=9 => (registers.smpr2, channel),
                    _ => (registers.smpr1, channel - 10),
                };
                let code = word >> (3 * at) & 7;
                (channel, [3, 15, 28, 56, 84, 112, 144, 480][code as usize])
            })
            .collect()
    }

    #[test]
    fn the_rigs_sequence_has_the_registers_that_were_worked_out_by_hand() {
        // SQR3: 0 | 1 << 5 | 2 << 10 | 3 << 15 | 4 << 20 | 5 << 25, SQR2: 6 | 7 << 5 | 8 << 10 | 9 << 15 |
        // 17 << 20, SQR1: 10 << 20, SMPR2: ten times 2, SMPR1: 7 for channel 17 in bits 23:21.
        let expected = Registers {
            sqr1: 0x00A0_0000,
            sqr2: 0x0114_A0E6,
            sqr3: 0x0A41_8820,
            smpr1: 0x00E0_0000,
            smpr2: 0x1249_2492,
        };
        assert_eq!(sequence(&INPUTS), expected);
    }

    #[test]
    fn every_rank_and_channel_is_where_the_manual_has_it() {
        use SampleTime::*;
        let times =
            [Cycles3, Cycles15, Cycles28, Cycles56, Cycles84, Cycles112, Cycles144, Cycles480];
        for shift in 0..19 {
            let inputs: [Input; MOST_RANKS] = core::array::from_fn(|rank| {
                let channel = (7 * rank as u32 + shift) % 19;
                Input { channel, time: times[channel as usize % 8] }
            });
            let expected: Vec<_> =
                inputs.iter().map(|input| (input.channel, input.time.cycles())).collect();
            assert_eq!(decode(&sequence(&inputs)), expected);
        }
    }

    #[test]
    fn a_short_sequence_has_its_length() {
        let input = Input { channel: 18, time: SampleTime::Cycles3 };
        assert_eq!(decode(&sequence(&[input])), [(18, 3)]);
        assert_eq!(decode(&sequence(&[input; 7])).len(), 7);
    }
}
