//! Decimates the responses of a long record behind an anti-alias filter.
//!
//! ```text
//! scans at f ─▶ three moving sums of 16 ─▶ f/16 ─▶ symmetric filter of 50 taps ─▶ f/80: one row of responses
//! ```
//! At 4 kS/s a row covers 20 ms: 50 rows per second. Whatever would be aliased below a quarter of that rate is
//! attenuated by 76 dB or more against what belongs there, and the harmonics of 50 Hz by more than 100 dB. The transfer
//! function is known exactly at every complex frequency ([`transfer`]), so it is divided out of the spectra.

use nalgebra::Complex;

use super::{CHANNELS, DECIMATION, RESPONSES, ROW_BITS, Scan};
use crate::real::Real;
use crate::units::ScanIndex;

const _: () = assert!(FIRST * SECOND == DECIMATION, "the stages make a row");

/// Scans in a moving sum, and decimation of the first stage.
const FIRST: usize = 16;
/// Number of moving sums.
const ORDER: usize = 3;
/// Decimation of the second stage.
const SECOND: usize = 5;
/// Rows to which one output of the first stage contributes.
const OVERLAP: usize = TAPS / SECOND;
/// Taps of the second stage.
const TAPS: usize = 2 * HALF.len();
/// The first half of the second stage's symmetric impulse response, times 2¹⁵: a low-pass with its edge at a tenth of
/// its rate under a Kaiser window of β = 7.5 (Kaiser and Schafer 1980), rounded; the sum of all taps is 2¹⁵.
const HALF: [i16; 25] = [
    0, 3, 8, 12, 7, -11, -43, -76, -85, -44, 58, 199, 316, 326, 157, -197, -644, -995, -1011, -491,
    636, 2245, 4023, 5553, 6438,
];

/// Rows after the start in which the filter still fills.
pub const SETTLING_ROWS: usize = OVERLAP + 1;

/// Outputs of the first stage to which one scan contributes.
const OPEN: usize = ORDER;
/// Impulse response of the first stage, times 16³: three moving sums.
const SUMS: [u16; FIRST * OPEN] = moving_sums();

/// One row of responses, 16-bit codes.
pub type Row = [u16; RESPONSES];

/// The state of the filter of all responses.
#[derive(Clone, Copy, Debug)]
pub struct Decimator {
    /// What the scans have contributed so far to this output of the first stage and to the next ones; at most 2²⁸.
    outputs: [[u32; OPEN]; RESPONSES],
    /// What the outputs of the first stage have contributed so far to this row and to the next ones.
    rows: [[f32; OVERLAP]; RESPONSES],
    /// From an output of the first stage to a 16-bit code.
    scale: f32,
    /// Scans in the current row; `None` before the first row begins.
    scans: Option<u8>,
}

impl Decimator {
    /// A filter at rest for codes of this resolution, at most [`ROW_BITS`].
    pub fn new(bits: u8) -> Self {
        let gain = (1_u32 << ROW_BITS.saturating_sub(bits)) as f32;
        Self {
            outputs: [[0; OPEN]; RESPONSES],
            rows: [[0.0; OVERLAP]; RESPONSES],
            scale: gain / FIRST.pow(ORDER as u32) as f32,
            scans: None,
        }
    }

    /// Takes the scan with this index, which follows the one before, and returns a row when it completes one. Rows end
    /// before the scans whose index is a multiple of [`DECIMATION`]; the first rows ([`SETTLING_ROWS`]) do not count.
    pub fn feed(&mut self, scan: &Scan, index: ScanIndex) -> Option<Row> {
        let first = index.0.is_multiple_of(DECIMATION as u64);
        let scans = usize::from(self.scans.or(first.then_some(0))?) + 1;
        self.scans = Some((scans % DECIMATION) as u8);
        let tap = FIRST - 1 - (scans - 1) % FIRST;
        let taps: [u32; OPEN] = core::array::from_fn(|open| SUMS[tap + open * FIRST].into());
        for (outputs, &code) in self.outputs.iter_mut().zip(&scan[CHANNELS - RESPONSES..]) {
            for (output, tap) in outputs.iter_mut().zip(taps) {
                *output += tap * u32::from(code);
            }
        }
        if !scans.is_multiple_of(FIRST) {
            return None;
        }
        self.filter(SECOND - scans / FIRST);
        (scans == DECIMATION).then(|| self.row())
    }

    /// Adds the current output of the first stage to all rows to which it contributes; `first` is its tap in the
    /// current row.
    fn filter(&mut self, first: usize) {
        for (outputs, rows) in self.outputs.iter_mut().zip(&mut self.rows) {
            let output = outputs[0] as f32 * self.scale;
            outputs.copy_within(1.., 0);
            outputs[OPEN - 1] = 0;
            let taps = (first..TAPS).step_by(SECOND);
            rows.iter_mut().zip(taps).for_each(|(row, at)| *row += tap(at) * output);
        }
    }

    /// The current row, which is complete.
    fn row(&mut self) -> Row {
        let mut codes = [0; RESPONSES];
        for (code, rows) in codes.iter_mut().zip(&mut self.rows) {
            // The cast limits the value to the range of a code.
            *code = (rows[0] + 0.5) as u16;
            rows.copy_within(1.., 0);
            rows[OVERLAP - 1] = 0.0;
        }
        codes
    }
}

/// Three moving sums one after the other.
const fn moving_sums() -> [u16; FIRST * OPEN] {
    let mut sums = [0; FIRST * OPEN];
    sums[0] = 1;
    let mut order = 0;
    while order < ORDER {
        // From the end, so that each value is the sum of those before the change.
        let mut at = sums.len();
        while at > 0 {
            at -= 1;
            let mut back = 1;
            while back < FIRST && back <= at {
                sums[at] += sums[at - back];
                back += 1;
            }
        }
        order += 1;
    }
    sums
}

/// A tap of the second stage.
fn tap(at: usize) -> f32 {
    const UNIT: f32 = 1.0 / 32_768.0;
    let at = at.min(TAPS.saturating_sub(1 + at));
    HALF.get(at).map_or(0.0, |&tap| f32::from(tap) * UNIT)
}

/// Transfer function of the filter at the Laplace variable `s`, 1/s, for a time between scans of `interval` s: the
/// spectrum of the rows, each at the time of its last scan, over that of the scans.
///
/// ```
/// # use massline_shared::nalgebra::Complex;
/// # use massline_shared::signal::transfer;
/// // Constants pass; half the rate of the rows is 25 Hz.
/// assert!((transfer(Complex::new(0.0, 1e-6), 1.0 / 4000.0).re - 1.0_f64).abs() < 1e-9);
/// let at = |hertz: f64| transfer(Complex::new(0.0, hertz * std::f64::consts::TAU), 1.0 / 4000.0).norm();
/// assert!(at(12.4) > 0.98 && at(37.6) < 1e-3 && at(50.0) < 1e-5);
/// ```
pub fn transfer<R: Real>(s: Complex<R>, interval: R) -> Complex<R> {
    let one = Complex::new(R::one(), R::zero());
    let after = |scans: usize| complex_exp(-(s.scale(interval * R::of(scans as f64))));
    let count = R::of(FIRST as f64);
    let mut sum = Complex::new(R::zero(), R::zero());
    // Summed rather than divided, since numerator and denominator of the closed form vanish with s.
    for scan in 0..FIRST {
        sum += after(scan);
    }
    let mean = sum.unscale(count);
    let (step, mut delay) = (after(FIRST), one);
    let mut second = Complex::new(R::zero(), R::zero());
    for at in 0..TAPS {
        second += delay.scale(R::of(f64::from(tap(at))));
        delay *= step;
    }
    mean * mean * mean * second
}

/// `e^z`.
pub(super) fn complex_exp<R: Real>(z: Complex<R>) -> Complex<R> {
    let (sin, cos) = z.im.sin_cos();
    Complex::new(cos, sin).scale(z.re.exp())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    const INTERVAL: f64 = 1.0 / 4000.0;

    /// Rows of a signal in all responses from scan `first` on, without those in which the filter fills.
    fn rows(bits: u8, first: u64, count: usize, signal: impl Fn(u64) -> u16) -> Vec<(u64, Row)> {
        let mut decimator = Decimator::new(bits);
        let scans = (first..).map(|n| (n, [signal(n); CHANNELS]));
        let rows =
            scans.filter_map(|(n, scan)| decimator.feed(&scan, ScanIndex(n)).map(|row| (n, row)));
        rows.skip(SETTLING_ROWS).take(count).collect()
    }

    #[test]
    fn a_constant_passes_at_every_resolution_and_rows_end_at_multiples() {
        for (bits, code) in [(12, 4095), (12, 1), (14, 8191), (16, 65_535), (16, 0)] {
            for first in [0, 1, 79, 80, 1_000_003] {
                for (n, row) in rows(bits, first, 20, |_| code) {
                    assert_eq!((n + 1) % DECIMATION as u64, 0);
                    assert_eq!(row, [code << (ROW_BITS - bits); RESPONSES], "{bits} bits");
                }
            }
        }
    }

    #[test]
    fn a_sine_is_that_of_the_transfer_function() {
        // 3 Hz, 12.4 Hz, and 43 Hz, which appears at 7 Hz.
        for (hertz, seen) in [(3.0, 3.0), (12.4, 12.4), (43.0, -7.0)] {
            let omega = std::f64::consts::TAU * hertz;
            let time = |n: u64| n as f64 * INTERVAL;
            let amplitude = 30_000.0;
            let rows = rows(16, 0, 1000, |n| {
                (32_768.0 + amplitude * (omega * time(n)).cos()).round() as u16
            });
            // 1000 rows are 20 s: a whole number of periods of each.
            let seen = std::f64::consts::TAU * seen;
            let sum: Complex<f64> = rows
                .iter()
                .map(|(n, row)| {
                    let angle = -seen * time(*n);
                    Complex::new(angle.cos(), angle.sin()) * (f64::from(row[4]) - 32_768.0)
                })
                .sum();
            let measured = sum / 500.0 / amplitude;
            // The rows are 79 scans late, by which an alias turns.
            let turned = complex_exp(Complex::new(0.0, (omega - seen) * 79.0 * INTERVAL));
            let expected = transfer(Complex::new(0.0, omega), INTERVAL) * turned;
            // Rounding of a periodic signal is periodic too, so its mean product with a wave need not vanish: half a
            // code.
            let tolerance = 0.5 / amplitude;
            assert!((measured - expected).norm() < tolerance, "{hertz} Hz: {measured} {expected}");
        }
    }

    #[test]
    fn aliases_below_a_quarter_of_the_rate_are_76_db_down() {
        let at = |hertz: f64| {
            transfer(Complex::new(0.0, std::f64::consts::TAU * hertz), INTERVAL).norm()
        };
        let mut worst = 0.0_f64;
        for step in 0..=124 {
            let seen = 0.1 * f64::from(step);
            for image in 1..40 {
                for source in [50.0 * f64::from(image) - seen, 50.0 * f64::from(image) + seen] {
                    worst = worst.max(at(source) / at(seen));
                }
            }
        }
        let decibels = 20.0 * worst.log10();
        assert!(decibels < -76.0, "{decibels}");
    }

    #[test]
    fn a_complex_frequency_is_that_of_the_impulse_response() {
        let s = Complex::new(-0.7, 31.0);
        // The step of one scan at its place within the row, in 16-bit codes so large that rounding is small.
        let mut sum = Complex::new(0.0, 0.0);
        for place in 0..DECIMATION as u64 {
            let at = 10 * DECIMATION as u64 * 2 + place;
            let mut decimator = Decimator::new(16);
            for n in 0..40 * DECIMATION as u64 {
                let mut scan = [0; CHANNELS];
                scan[1] = if n == at { 65_535 } else { 20_000 };
                if let Some(row) = decimator.feed(&scan, ScanIndex(n)).filter(|_| n > at) {
                    let value = (f64::from(row[0]) - 20_000.0) / 45_535.0;
                    let delay = (n - at) as f64 * INTERVAL;
                    sum += complex_exp(-s * delay) * value;
                }
            }
        }
        // A row holds a scan's worth of 45 535/80 = 570 codes, rounded by half a code at most: 80 scans of ten rows.
        let expected = transfer(s, INTERVAL);
        assert!((sum - expected).norm() < 80.0 * 11.0 * 0.29 / 45_535.0, "{sum} {expected}");
    }

    #[test]
    fn single_precision_knows_the_transfer_function() {
        for hertz in [0.5, 3.0, 12.4] {
            let s = Complex::new(0.1, std::f64::consts::TAU * hertz);
            let double = transfer(s, INTERVAL);
            let single = transfer(s.map_parts(), INTERVAL as f32);
            let error = (Complex::new(f64::from(single.re), f64::from(single.im)) - double).norm();
            // Fifty products and as many rounded factors.
            assert!(error < 100.0 * f64::from(f32::EPSILON), "{hertz} Hz: {error:e}");
        }
    }

    trait MapParts {
        fn map_parts(self) -> Complex<f32>;
    }

    impl MapParts for Complex<f64> {
        fn map_parts(self) -> Complex<f32> {
            Complex::new(self.re as f32, self.im as f32)
        }
    }
}
