//! Timing of the sampling: clocks, inputs, times. The arithmetic is checked at compile time.
//!
//! ADC1 and ADC2 convert at the same time, so the channels are converted in pairs. A pair of codes is one
//! word of the transfer, and in memory the codes are in the order of the channels.

use massline_cortex_m::sequence::Input;
use massline_firmware::scan_ring::Decimation;
use massline_shared::signal::{AdcProperties, CHANNELS};
use massline_shared::units::{Hertz, Seconds, Volts};

use crate::sequence::SampleTime;

/// Clock of the core and the timers: 24 MHz / 6 · 85 / 2.
pub const CORE_HZ: u32 = 170_000_000;
/// Longest erase of a page of the store, during which no code in its bank runs: data sheet, table "Flash memory
/// characteristics".
pub const LONGEST_ERASE_US: u64 = 24_500;
/// Clock of both ADCs: a quarter of the core clock. The limit for two ADCs at a time is 52 MHz.
pub const ADC_HZ: u32 = CORE_HZ / 4;
/// Scans per second.
pub const RATE_HZ: u32 = 4000;
/// Raw scans per scan.
pub const RATIO: u32 = 4;
/// Conversions that an ADC sums in hardware for one raw code; its register holds the exponent less 1.
pub const ADDED_UP: u32 = 4;
/// Core cycles between two raw scans, which the timer counts.
pub const TIMER_CYCLES: u32 = CORE_HZ / (RATE_HZ * RATIO);

/// Codes that are converted at the same time.
pub const PAIR: usize = 2;
/// Pairs per raw scan: the channels, then the reference.
pub const PAIRS: usize = CHANNELS / PAIR + 1;
/// Codes per raw scan.
pub const RANKS: usize = PAIR * PAIRS;
/// The rank of the reference: the first of the last pair.
pub const SENTINEL: usize = CHANNELS;

/// Sample time of a channel, 0.58 µs, for each of the four conversions.
const CHANNEL_TIME: SampleTime = SampleTime::Cycles24;
/// Sample time of the reference, 5.8 µs; it needs 4 µs.
const SENTINEL_TIME: SampleTime = SampleTime::Cycles247;

const fn input(channel: u32) -> Input {
    Input { channel, time: CHANNEL_TIME as u32 }
}

/// An input that is sampled for as long as the reference.
const fn slow_input(channel: u32) -> Input {
    Input { channel, time: SENTINEL_TIME as u32 }
}

/// Inputs of ADC1: PA0 hammer, PC0, PC2, PB0, PB14, the internal reference.
pub const ADC1: [Input; PAIRS] =
    [input(1), input(6), input(8), input(15), input(5), slow_input(18)];
/// Inputs of ADC2: PA1, PC1, PC3, PA4, PA6, and beside the reference PA7, which is at ground: its code
/// is not used.
pub const ADC2: [Input; PAIRS] = [input(2), input(7), input(9), input(17), input(3), slow_input(4)];
/// Both ADCs of a pair must take the same time: RM0440, "Regular simultaneous mode with independent
/// injected".
const _: () = assert!(take_equal_times(&ADC1, &ADC2), "an ADC of a pair would be late");

const fn take_equal_times(first: &[Input; PAIRS], second: &[Input; PAIRS]) -> bool {
    let mut pair = 0;
    while pair < PAIRS {
        if first[pair].time != second[pair].time {
            return false;
        }
        pair += 1;
    }
    true
}

/// ADC cycles per raw scan.
const SCAN_CYCLES: u32 = {
    let channels = (PAIRS as u32 - 1) * CHANNEL_TIME.with_conversion();
    ADDED_UP * (channels + SENTINEL_TIME.with_conversion())
};
/// ADC cycles between the starts of two raw scans.
const SCAN_ROOM: u32 = ADC_HZ / (RATE_HZ * RATIO);

const _: () = assert!(CHANNELS.is_multiple_of(PAIR));
const _: () = assert!(TIMER_CYCLES * RATE_HZ * RATIO == CORE_HZ, "the rate is exact");
const _: () = assert!(SCAN_CYCLES + 20 <= SCAN_ROOM, "a raw scan ends before the next trigger");
const _: () = assert!(SENTINEL_TIME.with_conversion() * 250_000 >= ADC_HZ, "4 µs");

/// Four sums of four codes of 12 bits are averaged into one code of 16 bits.
pub const DECIMATION: Decimation = Decimation {
    raw_bits: 14,
    raw_full: (ADDED_UP * 4095) as u16,
    ratio: RATIO as u16,
    fraction_bits: 2,
};
const _: () = assert!(DECIMATION.is_usable());

/// Raw scans per half of the buffer: one interrupt per scan, every quarter of a millisecond.
pub const HALF_SCANS: usize = 4;
/// Values in the buffer.
pub const RAW_LENGTH: usize = 2 * HALF_SCANS * RANKS;
/// Scans that can wait to be read: 40 ms, a block of 20 that is not full yet, and a margin.
pub const RING_SCANS: usize = 184;
const _: () = assert!(RING_SCANS >= RATE_HZ as usize * 40 / 1000 + 20);

/// Properties that the sampler states; `reference` is the voltage to which codes are corrected. Both
/// channels of a pair are sampled together, so stating half the time between pairs as the channel delay is
/// accurate to within that half.
pub const fn properties(reference: Volts) -> AdcProperties {
    let pair = ADDED_UP * CHANNEL_TIME.with_conversion();
    AdcProperties {
        rate: Hertz(RATE_HZ as f32),
        channels: CHANNELS as u8,
        bits: DECIMATION.bits(),
        reference,
        channel_delay: Seconds(pair as f32 / (PAIR as u32 * ADC_HZ) as f32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facts::CONVERSION_ORDER;

    #[test]
    fn the_figures_of_the_readme_are_those_of_the_plan() {
        assert_eq!((SCAN_CYCLES, SCAN_ROOM, TIMER_CYCLES), (1780, 2656, 10_625));
        let properties = properties(Volts(3.0));
        assert_eq!((properties.bits, properties.rate.0), (16, 4000.0));
        // 74 cycles at 42.5 MHz.
        assert!((properties.channel_delay.0 - 1.7412e-6).abs() < 1e-10);
    }

    #[test]
    fn a_pair_of_unequal_times_is_noticed() {
        assert!(take_equal_times(&ADC1, &ADC2));
        let mut twice = ADC2;
        twice[PAIRS - 1] = twice[PAIRS - 2];
        assert!(!take_equal_times(&ADC1, &twice), "PA6 beside the reference");
    }

    #[test]
    fn the_order_of_conversion_is_the_one_of_the_facts() {
        let [first, second] = CONVERSION_ORDER else { panic!("{CONVERSION_ORDER:?}") };
        assert_eq!((first.len(), second.len()), (ADC1.len(), ADC2.len()));
        for pair in 0..SENTINEL / PAIR {
            // A pair of codes is one word of the transfer, ADC1's first.
            assert_eq!(usize::from(first[pair]), PAIR * pair);
            assert_eq!(usize::from(second[pair]), PAIR * pair + 1);
        }
        assert_eq!(usize::from(first[PAIRS - 1]), SENTINEL);
        assert_eq!(usize::from(second[PAIRS - 1]), SENTINEL + 1);
    }
}
