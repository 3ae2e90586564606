//! The registers of an ADC's sequence: RM0440, 21.7, "ADC registers".

use massline_cortex_m::sequence::Layout;

/// Sample time of an input, in ADC cycles; the discriminant is the register's value.
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
    /// Number of ADC cycles, including the 12.5 of a 12-bit conversion.
    pub const fn with_conversion(self) -> u32 {
        [15, 19, 25, 37, 60, 105, 260, 653][self as usize]
    }
}

/// SQR1 to SQR4: ranks of six bits, five per register; the lowest position of SQR1 holds the length.
pub const LAYOUT: Layout = Layout { bits: 6, per_word: 5, first: 1, length: (0, 0) };

#[cfg(test)]
mod tests {
    use massline_cortex_m::sequence::{Input, MOST_RANKS, Registers, sequence};

    use super::*;
    use crate::plan::{ADC1, ADC2};

    /// Decodes the registers as the chip does, by the manual's tables of the position of each `SQn`.
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
        let ranks = (registers.ranks[0] & 0xF) as usize + 1;
        PLACES[..ranks]
            .iter()
            .map(|&(word, at)| {
                let channel = registers.ranks[word] >> at & 0x1F;
                let (word, at) = if channel < 10 { (0, channel) } else { (1, channel - 10) };
                (channel, registers.times[word] >> (3 * at) & 7)
            })
            .collect()
    }

    #[test]
    fn the_rigs_sequences_have_the_registers_that_were_worked_out_by_hand() {
        // ADC1: 1, 6, 8, 15, 5, 18. SQR1: 5 | 1 << 6 | 6 << 12 | 8 << 18 | 15 << 24, SQR2: 5 | 18 << 6;
        // SMPR1: 3 for 1, 5, 6, 8; SMPR2: 3 for 15 in bits 17:15, 6 for 18 in bits 26:24.
        let first = Registers {
            ranks: [0x0F20_6045, 0x0000_0485, 0, 0],
            times: [3 << 3 | 3 << 15 | 3 << 18 | 3 << 24, 3 << 15 | 6 << 24],
        };
        assert_eq!(sequence(&ADC1, &LAYOUT), first);
        // ADC2: 2, 7, 9, 17, 3, 4. SQR1: 5 | 2 << 6 | 7 << 12 | 9 << 18 | 17 << 24, SQR2: 3 | 4 << 6;
        // SMPR1: 3 for 2, 3, 7, 9 and 6 for 4, which is converted beside the reference; SMPR2: 3 for 17.
        let second = Registers {
            ranks: [0x1124_7085, 0x0000_0103, 0, 0],
            times: [3 << 6 | 3 << 9 | 6 << 12 | 3 << 21 | 3 << 27, 3 << 21],
        };
        assert_eq!(sequence(&ADC2, &LAYOUT), second);
    }

    #[test]
    fn every_rank_and_channel_is_where_the_manual_has_it() {
        use SampleTime::*;
        let times =
            [Cycles2, Cycles6, Cycles12, Cycles24, Cycles47, Cycles92, Cycles247, Cycles640];
        for shift in 0..19 {
            let inputs: [Input; MOST_RANKS] = core::array::from_fn(|rank| {
                let channel = (7 * rank as u32 + shift) % 19;
                Input { channel, time: times[channel as usize % 8] as u32 }
            });
            let expected: Vec<_> = inputs.iter().map(|input| (input.channel, input.time)).collect();
            assert_eq!(decode(&sequence(&inputs, &LAYOUT)), expected);
        }
        let input = Input { channel: 18, time: SampleTime::Cycles2 as u32 };
        assert_eq!(decode(&sequence(&[input], &LAYOUT)), [(18, 0)]);
    }
}
