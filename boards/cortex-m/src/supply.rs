//! Corrects the hammer's codes for the chip's supply voltage, so that they have the same unit as the
//! sensors' codes.
//!
//! The converter measures fractions of its supply. A sensor on the same supply has an output that is a
//! fraction of it as well, so its codes do not depend on the supply. The hammer's conditioner has an output
//! in volts, so its codes fall when the supply rises. The chip's internal reference is a fixed voltage too,
//! and the manufacturer has stored its reading at 3.3 V in the chip:
//!
//! ```text
//! supply = 3.3 V · stored / read
//! corrected = code · supply / 3.0 V
//! ```
//!
//! After the correction all codes are those of a converter with a reference of 3.0 V, which is the supply
//! for which the sensors' data sheet states volts.

use core::ops::RangeInclusive;

use massline_shared::units::Volts;

/// Full scale of corrected codes: the voltage of one code above the largest.
pub const REFERENCE: Volts = Volts(3.0);
/// Supply at which the manufacturer read the internal reference, mV.
const NOTED_AT: u32 = 3300;
/// Reading of a typical chip (1.21 V), used when the stored one is implausible.
const TYPICAL: u16 = 1502;
/// Bits of the stored reading.
const NOTED_BITS: u8 = 12;
/// The supply is averaged over about the last 256 scans: slower than any hit, faster than its drift.
const MEMORY_BITS: u32 = 8;
const FRACTION_BITS: u32 = 16;

/// The manufacturer's reading of the internal reference: 12 bits at 3.3 V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FactoryReading(u16);

impl FactoryReading {
    /// The stored reading if it is within the specified 1.18 to 1.24 V, else that of a typical chip.
    pub const fn new(noted: u16) -> Self {
        Self(if noted >= 1464 && noted <= 1539 { noted } else { TYPICAL })
    }

    /// The reading at 3.3 V of a chip whose manufacturer stores the reading at 3.0 V.
    pub const fn code_at_three_volts(noted: u16) -> u16 {
        (noted as u32 * 3000 / NOTED_AT) as u16
    }

    /// Range of the reference's codes, of `bits` bits, on a supply of 3.0 to 3.6 V. A sensor without motion reads
    /// higher, a hammer for upward pulses lower; one for downward pulses may rest in it.
    pub fn codes(self, bits: u8) -> RangeInclusive<u16> {
        let at = |millivolts| {
            ((u32::from(self.0) << (bits - NOTED_BITS)) * NOTED_AT / millivolts) as u16
        };
        at(3600)..=at(3000)
    }
}

/// Tracks the supply and corrects the hammer's codes.
#[derive(Clone, Copy, Debug)]
pub struct Supply {
    noted: FactoryReading,
    bits: u8,
    /// Mean reading of the reference in 2^-16 codes; zero before the first.
    mean: u32,
}

impl Supply {
    /// For codes of `bits` bits, 12 to 16.
    pub const fn new(noted: FactoryReading, bits: u8) -> Self {
        Self { noted, bits, mean: 0 }
    }

    /// Adds the reference's code of this scan and returns the hammer's code, corrected. A code at either
    /// end of the range stays there, so that an overload remains visible.
    pub fn correct(&mut self, hammer: u16, reference: u16) -> u16 {
        self.follow(reference);
        let full = ((1_u32 << self.bits) - 1) as u16;
        if hammer == 0 || hammer >= full || self.mean == 0 {
            return hammer;
        }
        // Corrected = hammer · 1.1 · stored · 2^(bits - 12) / read.
        let noted = u64::from(self.noted.0) << (u32::from(self.bits - NOTED_BITS) + FRACTION_BITS);
        let numerator = u64::from(hammer) * noted * 11;
        let denominator = u64::from(self.mean) * 10;
        let corrected = (numerator + denominator / 2) / denominator;
        u16::try_from(corrected).map_or(full, |code| code.min(full))
    }

    fn follow(&mut self, reference: u16) {
        let reading = u32::from(reference) << FRACTION_BITS;
        self.mean = if self.mean == 0 {
            reading
        } else {
            // A weighted mean, so it stays between the old mean and the reading.
            self.mean - (self.mean >> MEMORY_BITS) + (reading >> MEMORY_BITS)
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BITS: u8 = 14;
    const FULL: u16 = 16383;

    /// Code of `volts` on a supply.
    fn code(volts: f64, supply: f64) -> u16 {
        (volts / supply * 16384.0).round().min(f64::from(FULL)) as u16
    }

    #[test]
    fn the_hammer_reads_the_same_volts_on_any_supply() {
        let noted = FactoryReading::new(1520);
        let reference_volts = 1520.0 / 4096.0 * 3.3;
        for supply in [3.0, 3.1, 3.3, 3.45, 3.6] {
            for volts in [0.1, 0.7, 2.0, 2.9] {
                let mut followed = Supply::new(noted, BITS);
                let corrected =
                    followed.correct(code(volts, supply), code(reference_volts, supply));
                let expected = volts / 3.0 * 16384.0;
                // Half a code of rounding for each of the hammer's code (scaled by up to 1.2), the
                // result, and the reference's code, which is 1 in 10 900 at least.
                let tolerance = 0.5 * 1.2 + 0.5 + expected * 0.5 / 5000.0;
                let error = f64::from(corrected) - expected;
                assert!(error.abs() <= tolerance, "{supply} V, {volts} V: {error} codes");
            }
        }
    }

    #[test]
    fn an_overload_remains_one_on_a_low_supply_and_becomes_one_beyond_the_range() {
        let low = code(1.21, 2.9);
        let mut followed = Supply::new(FactoryReading::new(TYPICAL), BITS);
        assert_eq!(followed.correct(FULL, low), FULL);
        assert_eq!(followed.correct(0, low), 0);
        assert!(followed.correct(FULL - 1, low) < FULL);
        let mut followed = Supply::new(FactoryReading::new(TYPICAL), BITS);
        assert_eq!(followed.correct(code(3.2, 3.3), code(1.21, 3.3)), FULL);
    }

    #[test]
    fn the_noise_of_the_reference_does_not_become_noise_of_the_hammer() {
        let mut followed = Supply::new(FactoryReading::new(TYPICAL), BITS);
        let steady = followed.correct(8000, 6008);
        // The reading alternates by 40 codes, 0.7 %. The mean over 256 scans passes 1/256 of that, 0.0026
        // % or a quarter of a code, and rounds.
        for k in 0..2000 {
            let noisy = if k % 2 == 0 { 6048 } else { 5968 };
            assert!(followed.correct(8000, noisy).abs_diff(steady) <= 1, "{k}");
        }
    }

    #[test]
    fn after_a_step_of_the_supply_the_correction_settles_on_the_new_supply() {
        let mut followed = Supply::new(FactoryReading::new(TYPICAL), BITS);
        followed.correct(8000, 6008);
        // After eight time constants, e^-8 of a step of 5 % is 1/6 of a code.
        let last = (0..8 * 256).map(|_| followed.correct(8000, 6308)).last().unwrap();
        let direct = Supply::new(FactoryReading::new(TYPICAL), BITS).correct(8000, 6308);
        assert!(last.abs_diff(direct) <= 1, "{last} {direct}");
    }

    #[test]
    fn a_chip_without_a_note_is_a_typical_one() {
        for nothing in [0, 0xFFFF, 1463, 1540] {
            assert_eq!(FactoryReading::new(nothing), FactoryReading(TYPICAL));
        }
        assert_eq!(FactoryReading::new(1539), FactoryReading(1539));
        // 1652 · 3.0 / 3.3
        assert_eq!(FactoryReading::code_at_three_volts(1652), 1501);
        assert_eq!(
            FactoryReading::new(FactoryReading::code_at_three_volts(0xFFFF)),
            FactoryReading(TYPICAL)
        );
    }

    #[test]
    fn the_reference_is_told_from_sensors_and_hammer() {
        for noted in [1464, TYPICAL, 1539] {
            let codes = FactoryReading::new(noted).codes(12);
            assert!(codes.contains(&noted), "at 3.3 V");
            // Other inputs: a sensor at its typical half of the range, a hammer at 0.1 V, a half-driven
            // input at 1.0 V.
            for other in [2048, 124, 1240] {
                assert!(!codes.contains(&other), "{noted}: {other}");
            }
        }
        // 6008 · 33 / 36 and 6008 · 33 / 30.
        assert_eq!(FactoryReading::new(TYPICAL).codes(14), 5507..=6608);
    }
}
