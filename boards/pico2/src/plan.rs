//! Timing of the sampling: clocks, frames, times. The arithmetic is checked at compile time.
//!
//! The state machine of a PIO makes frames continuously and never waits, so the sampling times depend only
//! on its clock, which is derived from the crystal.

use massline_firmware::scan_ring::Decimation;
use massline_shared::signal::{AdcProperties, CHANNELS};
use massline_shared::units::{Hertz, Seconds, Volts};

/// Clock of the core: 12 MHz · 125 / 5 / 2.
pub const CORE_HZ: u32 = 150_000_000;
/// Core cycles per cycle of the state machine.
pub const DIVIDER: u32 = 5;
/// Scans per second.
pub const RATE_HZ: u32 = 4000;
/// Passes of the converter per scan.
pub const RATIO: u32 = 6;

/// Clocks per frame.
pub const FRAME_BITS: u32 = 16;
/// Cycles of the state machine for which a clock is low: 0.1 µs, as for high. The converter allows a clock
/// of 20 MHz; at 5 MHz, wires of a hand's length are harmless.
pub const LOW: u32 = 3;
/// Cycles for which a clock is high: see [`LOW`].
pub const HIGH: u32 = 3;
/// Cycles before the first clock of a frame, in which the converter is not selected: 0.9 µs. The converter
/// needs 0.325 µs of these to sample.
pub const GAP: u32 = 27;
/// Cycles from the last falling edge of the clock until the converter is not selected any more: 0.07 µs.
pub const HOLD: u32 = 2;
/// Core cycles by which the state machine sees an input late: the two flip-flops of its synchroniser, which is not
/// bypassed.
const INPUT_DELAY: u32 = 2;
/// Longest time in nanoseconds until a bit of the converter is valid: the first, after CS falls, with 1.8 V at +VBD (27
/// ns with 3 V). It has 13 core cycles, 87 ns, so that 49 ns remain for wires and pads.
const BIT_VALID_NS: u32 = 38;
/// Cycles per frame.
const FRAME: u32 = FRAME_BITS * (LOW + HIGH) + HOLD + GAP;

const PASS_CYCLES: u32 = FRAME * CHANNELS as u32 * DIVIDER;
const _: () = assert!(PASS_CYCLES * RATIO * RATE_HZ == CORE_HZ, "the rate is exact");
const _: () = assert!(CORE_HZ / DIVIDER / (LOW + HIGH) <= 20_000_000, "a clock of 20 MHz at most");
const _: () = assert!(CORE_HZ / (FRAME * DIVIDER) <= 1_000_000, "a million conversions a second");
const _: () = assert!(
    GAP as u64 * 1_000_000 >= (CORE_HZ / DIVIDER) as u64 * 325 / 1000,
    "the gap is at least 325 ns"
);
const _: () = assert!(
    (LOW * DIVIDER - INPUT_DELAY) as u64 * 1_000_000_000 >= BIT_VALID_NS as u64 * CORE_HZ as u64,
    "a bit is valid when it is sampled, where its clock rises"
);

/// The channels, then the sentinel, which shows whether the frames were in step.
pub const RANKS: usize = CHANNELS + 1;
/// The rank of the sentinel.
pub const SENTINEL: usize = CHANNELS;
/// Sentinel code: every frame was of the expected channel.
pub const IN_STEP: u16 = 1;
/// Sentinel code: a frame was of another channel.
pub const OUT_OF_STEP: u16 = 0;

/// Six codes of 12 bits are averaged into one of 14.
pub const DECIMATION: Decimation =
    Decimation { raw_bits: 12, raw_full: 4095, ratio: RATIO as u16, fraction_bits: 2 };
const _: () = assert!(DECIMATION.is_usable());

/// Voltage of the reference that supplies the converter and the sensors.
const REFERENCE: Volts = Volts(3.0);

/// Passes per half of the buffer: 3.5 ms. While a page of the flash is written, nothing runs and no
/// interrupt is handled, for 3 ms at most (W25Q32: t_PP) and the time to leave the flash and return: the
/// transfer continues and is read in time. While a sector is erased, for 45 ms typically and 400 ms at
/// most, an overrun occurs and is reported; the application erases only while it is idle.
pub const HALF_PASSES: usize = 84;
/// Frames in the buffer.
pub const RAW_LENGTH: usize = 2 * HALF_PASSES * CHANNELS;
const HALF_US: u32 = HALF_PASSES as u32 * 1_000_000 / (RATE_HZ * RATIO);
const _: () = assert!(HALF_US >= 3000 + 500, "a page is written, and half the buffer read");

/// Scans that can wait to be read: 40 ms, those of half the buffer, and a block of 20 that is not full yet.
pub const RING_SCANS: usize = 194;
const _: () =
    assert!(RING_SCANS >= RATE_HZ as usize * 40 / 1000 + HALF_PASSES / RATIO as usize + 20);

/// Properties that the sampler states.
pub const PROPERTIES: AdcProperties = AdcProperties {
    rate: Hertz(RATE_HZ as f32),
    channels: CHANNELS as u8,
    bits: DECIMATION.bits(),
    reference: REFERENCE,
    channel_delay: Seconds((FRAME * DIVIDER) as f32 / CORE_HZ as f32),
};

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facts::CONVERSION_ORDER;

    #[test]
    fn the_figures_of_the_readme_are_those_of_the_plan() {
        assert_eq!((FRAME, HALF_US, RAW_LENGTH), (125, 3500, 1680));
        assert_eq!((PROPERTIES.bits, PROPERTIES.rate.0), (14, 4000.0));
        // 625 cycles at 150 MHz.
        assert!((PROPERTIES.channel_delay.0 - 4.1667e-6).abs() < 1e-10);
    }

    #[test]
    fn the_order_of_conversion_is_the_one_of_the_facts() {
        // In the mode Auto-2 the channels follow one another, and the first follows the last.
        let order: Vec<u8> = (0..CHANNELS as u8).collect();
        assert_eq!(CONVERSION_ORDER, [order]);
    }
}
