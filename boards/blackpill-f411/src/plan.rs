//! What is converted when: clocks, inputs, times. The arithmetic is checked when this compiles.

use massline_cortex_m::sequence::Input;
use massline_firmware::scan_ring::Decimation;
use massline_shared::signal::{AdcProperties, CHANNELS};
use massline_shared::units::{Hertz, Seconds, Volts};

use crate::sequence::SampleTime;

/// The core, and the timers behind both buses: 25 MHz / 25 · 192 / 2.
pub const CORE_HZ: u32 = 96_000_000;
/// The ADC: a quarter of its bus. Up to 36 MHz are allowed, a half would be 48.
pub const ADC_HZ: u32 = CORE_HZ / 4;
/// Scans a second.
pub const RATE_HZ: u32 = 4000;
/// Raw scans of one scan: with one more the sequence would take longer than there is time.
pub const RATIO: u32 = 6;
/// Cycles of the core between two raw scans: what the timer counts.
pub const TIMER_CYCLES: u32 = CORE_HZ / (RATE_HZ * RATIO);

/// The channels, then the reference.
pub const RANKS: usize = CHANNELS + 1;
/// The rank of the reference.
pub const SENTINEL: usize = CHANNELS;
/// The internal reference.
const VREFINT: u32 = 17;

/// 1.17 µs. By the data sheet that is enough for sources of up to 10 kΩ; the 10 nF at each input are less
/// than that at these frequencies.
const CHANNEL_TIME: SampleTime = SampleTime::Cycles28;
/// 20 µs; the reference needs 10.
const SENTINEL_TIME: SampleTime = SampleTime::Cycles480;
/// Cycles that a conversion takes after sampling.
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

/// Cycles of the ADC that a raw scan takes.
const SCAN_CYCLES: u32 =
    CHANNELS as u32 * (CHANNEL_TIME.cycles() + CONVERSION) + SENTINEL_TIME.cycles() + CONVERSION;
/// Cycles of the ADC between two raw scans.
const SCAN_ROOM: u32 = ADC_HZ / (RATE_HZ * RATIO);

const _: () = assert!(TIMER_CYCLES * RATE_HZ * RATIO == CORE_HZ, "the rate is exact");
const _: () = assert!(TIMER_CYCLES.is_multiple_of(CORE_HZ / ADC_HZ), "the trigger is in phase");
const _: () = assert!(SCAN_CYCLES + 20 <= SCAN_ROOM, "a raw scan ends before the next trigger");
const _: () = assert!(SCAN_CYCLES > ADC_HZ / (RATE_HZ * (RATIO + 1)), "one more would not fit");
const _: () = assert!(SENTINEL_TIME.cycles() * 100_000 >= ADC_HZ, "the reference takes 10 µs");

/// Six codes of 12 bits make one of 14.
pub const DECIMATION: Decimation =
    Decimation { raw_bits: 12, raw_full: 4095, ratio: RATIO as u16, fraction_bits: 2 };
const _: () = assert!(DECIMATION.is_usable());

/// Raw scans of half the buffer: an interrupt every quarter of a millisecond, for each scan.
pub const HALF_SCANS: usize = 6;
/// Values of the buffer.
pub const RAW_LENGTH: usize = 2 * HALF_SCANS * RANKS;
/// Scans that wait to be read: 40 ms, a block of 20 that is not full yet, and some more.
pub const RING_SCANS: usize = 184;
const _: () = assert!(RING_SCANS >= RATE_HZ as usize * 40 / 1000 + 20);

/// What the sampler states; `reference` is the voltage to which codes are corrected.
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

    #[test]
    fn the_figures_of_the_readme_are_those_of_the_plan() {
        assert_eq!((SCAN_CYCLES, SCAN_ROOM), (892, 1000));
        let properties = properties(Volts(3.0));
        assert_eq!((properties.bits, properties.rate.0), (14, 4000.0));
        // 40 cycles of 24 MHz.
        assert!((properties.channel_delay.0 - 1.6667e-6).abs() < 1e-10);
    }
}
