//! The registers of the ADC's sequence: RM0383, 11.12, "ADC registers".

use massline_cortex_m::sequence::Layout;

/// Sample time of an input, in ADC cycles; the discriminant is the register's value.
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
    /// Number of ADC cycles.
    pub const fn cycles(self) -> u32 {
        [3, 15, 28, 56, 84, 112, 144, 480][self as usize]
    }
}

/// SQR3, SQR2, SQR1: ranks of five bits, six per register; the length is `L` of SQR1.
pub const LAYOUT: Layout = Layout { bits: 5, per_word: 6, first: 0, length: (2, 20) };

#[cfg(test)]
mod tests {
    use massline_cortex_m::sequence::{Input, MOST_RANKS, Registers, sequence};

    use super::*;
    use crate::plan::INPUTS;

    /// Decodes the registers as the chip does, by the manual's tables: `SQn` of five bits each, from SQ1
    /// in the lowest bits of SQR3, SQ7 in SQR2, SQ13 in SQR1; `L` in bits 23:20 of SQR1; `SMPn` of three
    /// bits each, channel 10 in the lowest of SMPR1, channel 0 in the lowest of SMPR2.
    fn decode(registers: &Registers) -> Vec<(u32, u32)> {
        let ranks = (registers.ranks[2] >> 20 & 0xF) + 1;
        (0..ranks)
            .map(|rank| {
                let channel = registers.ranks[rank as usize / 6] >> (5 * (rank % 6)) & 0x1F;
                let (word, at) = match channel {
                    0..=9 => (registers.times[0], channel),
                    _ => (registers.times[1], channel - 10),
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
            ranks: [0x0A41_8820, 0x0114_A0E6, 0x00A0_0000, 0],
            times: [0x1249_2492, 0x00E0_0000],
        };
        assert_eq!(sequence(&INPUTS, &LAYOUT), expected);
    }

    #[test]
    fn every_rank_and_channel_is_where_the_manual_has_it() {
        use SampleTime::*;
        let times =
            [Cycles3, Cycles15, Cycles28, Cycles56, Cycles84, Cycles112, Cycles144, Cycles480];
        for shift in 0..19 {
            let inputs: [Input; MOST_RANKS] = core::array::from_fn(|rank| {
                let channel = (7 * rank as u32 + shift) % 19;
                Input { channel, time: times[channel as usize % 8] as u32 }
            });
            let expected: Vec<_> = inputs
                .iter()
                .map(|i| (i.channel, times[i.channel as usize % 8].cycles()))
                .collect();
            assert_eq!(decode(&sequence(&inputs, &LAYOUT)), expected);
        }
    }

    #[test]
    fn a_short_sequence_has_its_length() {
        let input = Input { channel: 18, time: SampleTime::Cycles3 as u32 };
        assert_eq!(decode(&sequence(&[input], &LAYOUT)), [(18, 3)]);
        assert_eq!(decode(&sequence(&[input; 7], &LAYOUT)).len(), 7);
    }
}
