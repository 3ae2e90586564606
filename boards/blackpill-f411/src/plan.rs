//! Timing of the sampling: clocks, inputs, times. The arithmetic is checked at compile time.

use massline_cortex_m::sequence::Input;
use massline_firmware::scan_ring::Decimation;
use massline_shared::signal::{AdcProperties, CHANNELS};
use massline_shared::units::{Hertz, Seconds, Volts};

use crate::sequence::SampleTime;

/// Clock of the core and of the timers on both buses: 25 MHz / 25 · 192 / 2.
pub const CORE_HZ: u32 = 96_000_000;
/// Longest erase of a sector of the store, by bytes, during which no interrupt is served: data sheet, table "Flash
/// memory programming".
pub const LONGEST_ERASE_US: u64 = 800_000;
/// Clock of the ADC: a quarter of its bus clock. The limit is 36 MHz; a half would be 48 MHz.
pub const ADC_HZ: u32 = CORE_HZ / 4;
/// Scans per second.
pub const RATE_HZ: u32 = 4000;
/// Raw scans per scan: with one more, there would not be enough time for the sequence.
pub const RATIO: u32 = 6;
/// Core cycles between two raw scans, which the timer counts.
pub const TIMER_CYCLES: u32 = CORE_HZ / (RATE_HZ * RATIO);

/// The channels, then the reference.
pub const RANKS: usize = CHANNELS + 1;
/// The rank of the reference.
pub const SENTINEL: usize = CHANNELS;
/// The internal reference.
const VREFINT: u32 = 17;

/// Sample time of a channel, 1.17 µs. By the data sheet that is enough for sources of up to 10 kΩ; the
/// impedance of the 10 nF at each input is lower at these frequencies.
const CHANNEL_TIME: SampleTime = SampleTime::Cycles28;
/// Sample time of the reference, 20 µs; it needs 10 µs.
const SENTINEL_TIME: SampleTime = SampleTime::Cycles480;
/// Cycles of a conversion after sampling.
const CONVERSION: u32 = 12;

/// PA0 to PA7 and PB0, PB1 are the inputs 0 to 9, hammer first.
pub const INPUTS: [Input; RANKS] = {
    let mut inputs = [Input { channel: VREFINT, time: SENTINEL_TIME as u32 }; RANKS];
    let mut channel = 0;
    while channel < CHANNELS {
        inputs[channel] = Input { channel: channel as u32, time: CHANNEL_TIME as u32 };
        channel += 1;
    }
    inputs
};

/// ADC cycles per raw scan.
const SCAN_CYCLES: u32 =
    CHANNELS as u32 * (CHANNEL_TIME.cycles() + CONVERSION) + SENTINEL_TIME.cycles() + CONVERSION;
/// ADC cycles between the starts of two raw scans.
const SCAN_ROOM: u32 = ADC_HZ / (RATE_HZ * RATIO);

const _: () = assert!(TIMER_CYCLES * RATE_HZ * RATIO == CORE_HZ, "the rate is exact");
const _: () = assert!(TIMER_CYCLES.is_multiple_of(CORE_HZ / ADC_HZ), "the trigger is in phase");
const _: () = assert!(SCAN_CYCLES + 20 <= SCAN_ROOM, "a raw scan ends before the next trigger");
const _: () = assert!(SCAN_CYCLES > ADC_HZ / (RATE_HZ * (RATIO + 1)), "one more would not fit");
const _: () = assert!(SENTINEL_TIME.cycles() * 100_000 >= ADC_HZ, "the reference takes 10 µs");

/// Six codes of 12 bits are averaged into one of 14.
pub const DECIMATION: Decimation =
    Decimation { raw_bits: 12, raw_full: 4095, ratio: RATIO as u16, fraction_bits: 2 };
const _: () = assert!(DECIMATION.is_usable());

/// Raw scans per half of the buffer: one interrupt per scan, every quarter of a millisecond.
pub const HALF_SCANS: usize = 6;
/// Values in the buffer.
pub const RAW_LENGTH: usize = 2 * HALF_SCANS * RANKS;
/// Scans that can wait to be read: 40 ms, a block of 20 that is not full yet, and a margin.
pub const RING_SCANS: usize = 184;
const _: () = assert!(RING_SCANS >= RATE_HZ as usize * 40 / 1000 + 20);

/// Properties that the sampler states; `reference` is the voltage to which codes are corrected.
pub const fn properties(reference: Volts) -> AdcProperties {
    AdcProperties {
        rate: Hertz(RATE_HZ as f32),
        channels: CHANNELS as u8,
        bits: DECIMATION.bits(),
        reference,
        channel_delay: Seconds((CHANNEL_TIME.cycles() + CONVERSION) as f32 / ADC_HZ as f32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facts::CONVERSION_ORDER;

    #[test]
    fn the_figures_of_the_readme_are_those_of_the_plan() {
        assert_eq!((SCAN_CYCLES, SCAN_ROOM), (892, 1000));
        let properties = properties(Volts(3.0));
        assert_eq!((properties.bits, properties.rate.0), (14, 4000.0));
        // 40 cycles at 24 MHz.
        assert!((properties.channel_delay.0 - 1.6667e-6).abs() < 1e-10);
    }

    #[test]
    fn the_order_of_conversion_is_the_one_of_the_facts() {
        let [order] = CONVERSION_ORDER else { panic!("{CONVERSION_ORDER:?}") };
        assert_eq!(order.len(), RANKS);
        for (input, &channel) in INPUTS.iter().zip(*order) {
            // PA0 to PA7, PB0 and PB1 are the inputs of the channels, and in that order.
            let expected = if usize::from(channel) == SENTINEL { VREFINT } else { channel.into() };
            assert_eq!(input.channel, expected);
        }
    }
}
