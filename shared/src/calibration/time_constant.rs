//! Difference between the low-pass of a sensor and that of the hammer.
//!
//! First-order low-passes with the time constants τ of the sensor and τ_F of the hammer give
//! `H (1 + s τ_F)/(1 + s τ)`, or, exact in τ and linear in the difference, `H (1 + s (τ_F − τ)/(1 + s τ))`.
//! This adds two terms to the mass line model of a rigid block: one whose phase grows with the frequency, and
//! one for the damping of the suspension, whose phase falls with it:
//!
//! ```text
//! H(s) = A + B/s² + C s² + D s/(1 + s τ) + E/s        τ_F − τ = D/A
//! ```
//! Without E, suspension modes of 1 to 3 Hz with 1 % damping shift D/A by 0.5 to 1 µs. The same holds when
//! low-passes have been compensated in the spectra; the errors of that compensation then take the place of
//! τ_F and τ. Only the difference can be determined: an error common to both does not change `H`.

use nalgebra::{Complex, SMatrix, SVector};

use crate::estimated::EstimatedValue;
use crate::mass_line::{Bin, MassLineError, window_correlation};
use crate::real::Real;

/// How the spectra were measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectraSettings<R> {
    /// Band of the fit, Hz, both ends included; bins outside are left out.
    pub band: [R; 2],
    /// τ of the model, s: roughly the time constant of either low-pass.
    pub lag: R,
    /// σ of the exponential window, 1/s.
    pub decay: R,
    /// Length of the record, s.
    pub record: R,
}

/// Terms of the model.
const TERMS: usize = 5;
/// Index of D among them.
const ODD: usize = 3;

/// Determines `τ_F − τ` from the accelerance along the driven axis of a block; `lines` are bins
/// with their accelerances, in any order.
///
/// # Errors
/// [`MassLineError::BandTooNarrow`] with fewer than three lines in the band or without an accelerance,
/// [`MassLineError::NotFinite`].
///
/// ```
/// # use massline_shared::calibration::time_constant::{SpectraSettings, difference};
/// # use massline_shared::mass_line::{Bin, MassLineError};
/// # use massline_shared::nalgebra::Complex;
/// // A rigid block of 2 kg; low-passes of 330 µs on the hammer and 320 µs on the sensor.
/// let (hammer, sensor) = (330e-6, 320e-6);
/// let lines = (5..150).map(|k| {
///     let frequency = 2.0 * f64::from(k);
///     let s = Complex::new(10.0, std::f64::consts::TAU * frequency);
///     let h = (s * hammer + 1.0) / (s * sensor + 1.0) * 0.5;
///     (Bin { frequency, weight: 1.0 }, h)
/// });
/// let how = SpectraSettings { band: [10.0, 300.0], lag: sensor, decay: 10.0, record: 0.512 };
/// let estimate = difference(lines, how)?;
/// assert!((estimate.value - (hammer - sensor)).abs() < 1e-9);
/// # Ok::<(), MassLineError>(())
/// ```
pub fn difference<R, I>(
    lines: I,
    how: SpectraSettings<R>,
) -> Result<EstimatedValue<R>, MassLineError>
where
    R: Real,
    I: IntoIterator<Item = (Bin<R>, Complex<R>)>,
    I::IntoIter: Clone,
{
    let SpectraSettings { band, decay, .. } = how;
    // With the geometric mean of the band as the reference, every scaled column is about one.
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
    let mut normal = SMatrix::<R, TERMS, TERMS>::zeros();
    let mut right = SVector::<R, TERMS>::zeros();
    let mut square = R::zero();
    for (line, h) in inside {
        let weight = line.weight * to_mean_one;
        let s = Complex::new(decay, line.frequency * R::two_pi());
        for (row, value) in rows(s, how.lag, reference).into_iter().zip([h.re, h.im]) {
            normal += row * row.transpose() * weight;
            right += row * (value * weight);
            square += value * value * weight;
        }
    }
    let inverse = normal.cholesky().ok_or(MassLineError::BandTooNarrow)?.inverse();
    let x = inverse * right;
    let freedom = R::of(f64::from(2 * count) - TERMS as f64);
    let spread = ((square - x.dot(&right)).max(R::zero()) / freedom).sqrt();
    let to_seconds = R::one() / (x[0] * reference);
    let value = x[ODD] * to_seconds;
    let correlation = window_correlation(decay, how.record);
    let sigma = (inverse[(ODD, ODD)].sqrt() * spread * correlation * to_seconds).abs();
    if value.finite() && sigma.finite() {
        Ok(EstimatedValue { value, sigma })
    } else {
        Err(MassLineError::BandTooNarrow)
    }
}

/// Mean of several differences of the same two low-passes, weighted by inverse variance. When they scatter
/// more than their standard deviations allow, that of the mean is increased by the same factor. `None` for an
/// empty slice or when a standard deviation is zero.
pub fn mean<R: Real>(parts: &[EstimatedValue<R>]) -> Option<EstimatedValue<R>> {
    let (mut weights, mut sum) = (R::zero(), R::zero());
    for part in parts {
        let weight = R::one() / (part.sigma * part.sigma);
        weights += weight;
        sum += weight * part.value;
    }
    let value = sum / weights;
    let square = |part: &EstimatedValue<R>| ((part.value - value) / part.sigma).powi(2);
    let chi_squared = parts.iter().map(square).fold(R::zero(), |sum, square| sum + square);
    let freedom = R::of(parts.len().saturating_sub(1).max(1) as f64);
    let sigma = (R::one() / weights).sqrt() * (chi_squared / freedom).sqrt().max(R::one());
    (value.finite() && sigma.finite()).then_some(EstimatedValue { value, sigma })
}

/// Real and imaginary equation of the line at `s`: the coefficients of A, B/ω², C ω², D ω, E/ω at the
/// reference.
fn rows<R: Real>(s: Complex<R>, lag: R, reference: R) -> [SVector<R, TERMS>; 2] {
    let odd = s / (s.scale(lag) + R::one());
    let (s, odd) = (s.unscale(reference), odd.unscale(reference));
    let inverse = s.conj().unscale(s.norm_sqr());
    let even = [Complex::new(R::one(), R::zero()), inverse * inverse, s * s];
    let [one, inertia, residual] = even;
    let terms = [one, inertia, residual, odd, inverse];
    [SVector::from(terms.map(|term| term.re)), SVector::from(terms.map(|term| term.im))]
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f64::consts::TAU;
    use std::vec::Vec;

    const BAND: [f64; 2] = [10.0, 120.0];
    const RECORD: f64 = 0.512;
    const CUTOFFS_HZ: [f64; 2] = [497.36, 482.44];

    fn how<R: Real>(band: [f64; 2]) -> SpectraSettings<R> {
        let lag = (TAU * CUTOFFS_HZ[0]).recip();
        let [lag, decay, record] = [lag, 10.0, RECORD].map(R::of);
        SpectraSettings { band: band.map(R::of), lag, decay, record }
    }

    /// A block of 2 kg on a suspension of 2 Hz with 2 % damping, measured through low-passes of 497 Hz, the
    /// sensor's 3 % lower; `noise` alternates in sign from line to line.
    fn measured<R: Real>(noise: f64) -> Vec<(Bin<R>, Complex<R>)> {
        let [hammer, sensor] = CUTOFFS_HZ.map(|cutoff| (TAU * cutoff).recip());
        (0..128)
            .map(|k| {
                let frequency = f64::from(k) / RECORD;
                let s = Complex::new(10.0, TAU * frequency);
                let suspension = TAU * 2.0;
                let h = s * s / (s * s + s * (0.04 * suspension) + suspension.powi(2)) / 2.0;
                let filtered = h * (s * hammer + 1.0) / (s * sensor + 1.0);
                let sign = if k % 2 == 0 { noise } else { -noise };
                let line = Bin { frequency: R::of(frequency), weight: R::one() };
                (line, Complex::new(R::of(filtered.re + sign), R::of(filtered.im - sign)))
            })
            .collect()
    }

    fn estimate_difference<R: Real>(noise: f64) -> EstimatedValue<f64> {
        let estimate = difference(measured::<R>(noise), how(BAND)).unwrap();
        EstimatedValue { value: estimate.value.to_f64(), sigma: estimate.sigma.to_f64() }
    }

    /// 1/(2π 497.36) − 1/(2π 482.44): −9.897 µs. The neglected second order is that times ω at the end of the
    /// band, 0.75 %. Without the damping term the result would be 26 % off.
    #[test]
    fn the_difference_of_two_low_passes_is_found() {
        let truth = (TAU * CUTOFFS_HZ[0]).recip() - (TAU * CUTOFFS_HZ[1]).recip();
        for value in [estimate_difference::<f64>(0.0).value, estimate_difference::<f32>(0.0).value]
        {
            assert!((value / truth - 1.0).abs() < 0.0075, "{value:e} {truth:e}");
        }
    }

    #[test]
    fn noise_shows_in_the_sigma() {
        // 1 % of the accelerance on each of 56 lines gives about 1 %/√112 of A at ω_ref = 218 rad/s, and the
        // window raises it by √(10 · 0.512).
        let sigma = estimate_difference::<f64>(0.005).sigma;
        let expected = 0.01 / 112.0_f64.sqrt() / 218.0 * (5.12_f64).sqrt();
        assert!((0.3..3.0).contains(&(sigma / expected)), "{sigma:e} {expected:e}");
        assert!(estimate_difference::<f64>(0.0).sigma < 0.1 * sigma);
    }

    #[test]
    fn too_few_lines_and_broken_ones_are_refused() {
        let lines = measured::<f64>(0.0);
        let narrow = difference(lines.iter().copied(), how([10.0, 12.0]));
        assert_eq!(narrow, Err(MassLineError::BandTooNarrow));
        let silent = lines.iter().map(|&(line, _)| (line, Complex::new(0.0, 0.0)));
        assert_eq!(difference(silent, how(BAND)), Err(MassLineError::BandTooNarrow));
        let broken = lines.iter().map(|&(line, h)| (line, h * f64::NAN));
        assert_eq!(difference(broken, how(BAND)), Err(MassLineError::NotFinite));
    }

    #[test]
    fn the_mean_weighs_by_variance_and_sees_a_contradiction() {
        let part = |value: f64, sigma| EstimatedValue { value, sigma };
        // Weights 4 and 1, χ² = 0.05: the formal standard deviation is 1/√5.
        let agreeing = mean(&[part(1.0, 0.5), part(1.25, 1.0)]).unwrap();
        assert!((agreeing.value - 1.05).abs() < 1e-12, "{agreeing:?}");
        assert!((agreeing.sigma - 0.2_f64.sqrt()).abs() < 1e-12, "{agreeing:?}");
        // Two values with unit standard deviation, ten apart: χ² = 50, so 1/√2 · √50 = 5, half their
        // distance.
        let contradicting = mean(&[part(0.0, 1.0), part(10.0, 1.0)]).unwrap();
        assert!((contradicting.sigma - 5.0).abs() < 1e-12, "{contradicting:?}");
        assert_eq!(mean(&[part(3.0, 2.0)]), Some(part(3.0, 2.0)));
        assert_eq!(mean::<f64>(&[]), None);
        assert_eq!(mean(&[part(1.0, 0.0)]), None);
    }
}
