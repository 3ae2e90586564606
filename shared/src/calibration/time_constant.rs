//! The low-pass of a sensor against that of the hammer.
//!
//! Outputs behind first-order low-passes with the time constants τ of the sensor and τ_F of the hammer
//! give `H (1 + s τ_F)/(1 + s τ)`. Below both corners that is `H (1 + s (τ_F − τ))`: to the mass line
//! model comes a term odd in s, which nothing else of a rigid block has,
//!
//! ```text
//! H(s) = A + B/s² + C s² + D s        τ_F − τ = D/A
//! ```
//! Only this difference shows. What both have in common does not change `H`.

use nalgebra::{Complex, Matrix4, Vector4};

use crate::Real;
use crate::mass_line::{Line, MassLineError, window_correlation};

/// A difference of time constants, s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeConstantDifference<R> {
    /// The hammer's minus the sensor's, s.
    pub value: R,
    /// Its standard deviation from the scatter of the lines about the model, corrected for the
    /// exponential window, s.
    pub sigma: R,
}

/// The difference from the accelerance `h` of the driven axis of a block.
///
/// `lines` are lines and accelerances in any order, those outside of `band` (Hz, both ends included)
/// are left out; `decay` is σ of the exponential window in 1/s and `record` the length of the record
/// in s.
///
/// # Errors
/// [`MassLineError::BandTooNarrow`] with fewer than three lines in the band or without an accelerance,
/// [`MassLineError::NotFinite`].
pub fn difference<R, I>(
    lines: I,
    band: [R; 2],
    decay: R,
    record: R,
) -> Result<TimeConstantDifference<R>, MassLineError>
where
    R: Real,
    I: IntoIterator<Item = (Line<R>, Complex<R>)>,
    I::IntoIter: Clone,
{
    // At the geometric mean of the band every scaled column has size one.
    let reference = (band[0] * band[1]).sqrt() * R::two_pi();
    let inside =
        lines.into_iter().filter(|(l, _)| band[0] <= l.frequency && l.frequency <= band[1]);
    let (mut count, mut weights) = (0_u32, R::zero());
    for (line, h) in inside.clone() {
        if ![line.frequency, line.weight, h.re, h.im].iter().all(|v| v.finite()) {
            return Err(MassLineError::NotFinite);
        }
        count += 1;
        weights += line.weight;
    }
    if count < 3 || weights <= R::zero() || reference <= R::zero() {
        return Err(MassLineError::BandTooNarrow);
    }
    let to_mean_one = R::of(f64::from(count)) / weights;
    let mut normal = Matrix4::zeros();
    let mut right = Vector4::zeros();
    let mut square = R::zero();
    for (line, h) in inside {
        let weight = line.weight * to_mean_one;
        for (row, value) in rows(line.frequency, decay, reference).into_iter().zip([h.re, h.im]) {
            normal += row * row.transpose() * weight;
            right += row * (value * weight);
            square += value * value * weight;
        }
    }
    let inverse = normal.cholesky().ok_or(MassLineError::BandTooNarrow)?.inverse();
    let x = inverse * right;
    let freedom = R::of(f64::from(2 * count) - 4.0);
    let spread = ((square - x.dot(&right)).max(R::zero()) / freedom).sqrt();
    let to_seconds = R::one() / (x[0] * reference);
    let value = x[3] * to_seconds;
    let correlation = window_correlation(decay, record);
    let sigma = (inverse[(3, 3)].sqrt() * spread * correlation * to_seconds).abs();
    if value.finite() && sigma.finite() {
        Ok(TimeConstantDifference { value, sigma })
    } else {
        Err(MassLineError::BandTooNarrow)
    }
}

/// The real and the imaginary equation of one line: factors of A, B/ω², C ω², D ω at the reference.
fn rows<R: Real>(frequency: R, decay: R, reference: R) -> [Vector4<R>; 2] {
    let s = Complex::new(decay, frequency * R::two_pi()).unscale(reference);
    let square = s * s;
    let inverse = square.conj().unscale(square.norm_sqr());
    [
        Vector4::new(R::one(), inverse.re, square.re, s.re),
        Vector4::new(R::zero(), inverse.im, square.im, s.im),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use std::vec::Vec;

    const BAND: [f64; 2] = [10.0, 120.0];
    const RECORD: f64 = 0.512;

    /// A block of 2 kg on a suspension of 2 Hz, seen through low-passes of 497 Hz, the sensor's 3 %
    /// lower; `noise` alternates on the lines.
    fn measured<R: Real>(noise: f64) -> Vec<(Line<R>, Complex<R>)> {
        let [hammer, sensor] = [497.36, 482.44].map(|corner: f64| (TAU * corner).recip());
        (0..128)
            .map(|k| {
                let frequency = f64::from(k) / RECORD;
                let s = Complex::new(10.0, TAU * frequency);
                let suspension = (TAU * 2.0).powi(2);
                let h = s * s / (s * s + suspension) / 2.0;
                let filtered = h * (s * hammer + 1.0) / (s * sensor + 1.0);
                let sign = if k % 2 == 0 { noise } else { -noise };
                let line = Line { frequency: R::of(frequency), weight: R::one() };
                (line, Complex::new(R::of(filtered.re + sign), R::of(filtered.im - sign)))
            })
            .collect()
    }

    fn found<R: Real>(noise: f64) -> TimeConstantDifference<f64> {
        let band = BAND.map(R::of);
        let found = difference(measured::<R>(noise), band, R::of(10.0), R::of(RECORD)).unwrap();
        TimeConstantDifference { value: found.value.to_f64(), sigma: found.sigma.to_f64() }
    }

    /// 1/(2π 497.36) − 1/(2π 482.44): −9.897 µs. Third order in s τ is left out: (2π 120 · 330e-6)²
    /// of it at the end of the band, 6 %, half of which the fit sees.
    #[test]
    fn the_difference_of_two_low_passes_is_found() {
        let truth = (TAU * 497.36).recip() - (TAU * 482.44).recip();
        for value in [found::<f64>(0.0).value, found::<f32>(0.0).value] {
            assert!((value / truth - 1.0).abs() < 0.06, "{value:e} {truth:e}");
        }
    }

    #[test]
    fn noise_shows_in_the_sigma() {
        // 1 % of the accelerance on each of 56 lines: about 1 %/√112 of A at ω_ref = 218 rad/s, and
        // the window widens it by √(10 · 0.512).
        let sigma = found::<f64>(0.005).sigma;
        let expected = 0.01 / 112.0_f64.sqrt() / 218.0 * (5.12_f64).sqrt();
        assert!((0.3..3.0).contains(&(sigma / expected)), "{sigma:e} {expected:e}");
        assert!(found::<f64>(0.0).sigma < 0.1 * sigma);
    }

    #[test]
    fn too_few_lines_and_broken_ones_are_refused() {
        let lines = measured::<f64>(0.0);
        let narrow = difference(lines.iter().copied(), [10.0, 12.0], 10.0, RECORD);
        assert_eq!(narrow, Err(MassLineError::BandTooNarrow));
        let silent = lines.iter().map(|&(line, _)| (line, Complex::new(0.0, 0.0)));
        assert_eq!(difference(silent, BAND, 10.0, RECORD), Err(MassLineError::BandTooNarrow));
        let broken = lines.iter().map(|&(line, h)| (line, h * f64::NAN));
        assert_eq!(difference(broken, BAND, 10.0, RECORD), Err(MassLineError::NotFinite));
    }
}
