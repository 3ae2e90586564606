//! Fourier transform of a real record.
//!
//! *Lines* are the complex values at `0, 1, 2, … · rate/points`; the transform is
//! `X_l = Σ x_n e^{−2πi l n / points}`, without a scale factor.

use core::fmt;

use nalgebra::Complex;

use crate::real::Real;

/// Why samples cannot be transformed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FftError {
    /// The number of samples is not a power of two of at least 4.
    NotPowerOfTwo,
    /// The number of lines exceeds half the number of samples.
    TooManyLines,
    /// The record is longer than the buffer of the transform.
    RecordTooLong,
}

impl fmt::Display for FftError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotPowerOfTwo => "the number of samples is not a power of two of at least 4",
            Self::TooManyLines => "more lines are wanted than half the number of samples",
            Self::RecordTooLong => "the record is longer than the buffer of the transform",
        })
    }
}

impl core::error::Error for FftError {}

/// A scalar type with a Fourier transform of real records.
///
/// ```
/// # use massline_shared::nalgebra::Complex;
/// # use massline_shared::signal::{FftError, RealFft};
/// // Three periods of a cosine in 64 samples: N/2 at line 3, nothing elsewhere.
/// let mut samples: Vec<f64> =
///     (0..64).map(|n| (std::f64::consts::TAU * 3.0 * f64::from(n) / 64.0).cos()).collect();
/// let mut lines = [Complex::new(0.0, 0.0); 8];
/// f64::real_fft(&mut samples, &mut lines)?;
/// assert!((lines[3].re - 32.0).abs() < 1e-12 && lines[4].norm() < 1e-12);
/// assert_eq!(f64::real_fft(&mut [0.0; 63], &mut lines), Err(FftError::NotPowerOfTwo));
/// # Ok::<(), FftError>(())
/// ```
pub trait RealFft: Real {
    /// Transforms `samples` in place, which leaves undefined values in them, and writes the first lines to
    /// `lines`.
    ///
    /// # Errors
    /// When the number of samples is not a power of two, or `lines` is longer than half of it.
    fn real_fft(samples: &mut [Self], lines: &mut [Complex<Self>]) -> Result<(), FftError>;
}

impl RealFft for f64 {
    fn real_fft(samples: &mut [Self], lines: &mut [Complex<Self>]) -> Result<(), FftError> {
        check(samples, lines)?;
        radix_2(samples, lines);
        Ok(())
    }
}

impl RealFft for f32 {
    /// Uses tables for 1024, 2048 and 4096 samples.
    #[inline]
    fn real_fft(samples: &mut [Self], lines: &mut [Complex<Self>]) -> Result<(), FftError> {
        check(samples, lines)?;
        if let Ok(samples) = <&mut [f32; 2048]>::try_from(&mut *samples) {
            unpack(microfft::real::rfft_2048(samples), lines);
        } else if let Ok(samples) = <&mut [f32; 1024]>::try_from(&mut *samples) {
            unpack(microfft::real::rfft_1024(samples), lines);
        } else if let Ok(samples) = <&mut [f32; 4096]>::try_from(&mut *samples) {
            unpack(microfft::real::rfft_4096(samples), lines);
        } else {
            radix_2(samples, lines);
        }
        Ok(())
    }
}

fn check<R>(samples: &[R], lines: &[Complex<R>]) -> Result<(), FftError> {
    if samples.len() < 4 || !samples.len().is_power_of_two() {
        Err(FftError::NotPowerOfTwo)
    } else if lines.len() > samples.len() / 2 {
        Err(FftError::TooManyLines)
    } else {
        Ok(())
    }
}

/// The Nyquist line is packed into the imaginary part of line 0, whose own imaginary part is zero.
fn unpack(packed: &[Complex<f32>], lines: &mut [Complex<f32>]) {
    for (line, value) in lines.iter_mut().zip(packed) {
        *line = *value;
    }
    if let Some(first) = lines.first_mut() {
        first.im = 0.0;
    }
}

/// Transforms 2M real samples as M complex ones (even samples real, odd ones imaginary) with decimation in
/// time, then separates the two.
fn radix_2<R: Real>(samples: &mut [R], lines: &mut [Complex<R>]) {
    let (points, _) = samples.as_chunks_mut::<2>();
    reverse_bits(points);
    let mut length = 2;
    while length <= points.len() {
        butterflies(points, length);
        length *= 2;
    }
    separate(points, lines);
}

fn reverse_bits<R>(points: &mut [[R; 2]]) {
    let shift = points.len().leading_zeros() + 1;
    for i in 0..points.len() {
        let j = i.reverse_bits() >> shift;
        if i < j {
            points.swap(i, j);
        }
    }
}

/// One stage: blocks of `length` points. The twiddle factor is in the outer loop, so each is computed only
/// once, without a recurrence.
fn butterflies<R: Real>(points: &mut [[R; 2]], length: usize) {
    let half = length / 2;
    for k in 0..half {
        let w = twiddle::<R>(k, length);
        for block in points.chunks_exact_mut(length) {
            let (lower, upper) = block.split_at_mut(half);
            if let (Some(a), Some(b)) = (lower.get_mut(k), upper.get_mut(k)) {
                let turned = Complex::new(b[0], b[1]) * w;
                let kept = Complex::new(a[0], a[1]);
                let (sum, difference) = (kept + turned, kept - turned);
                *a = [sum.re, sum.im];
                *b = [difference.re, difference.im];
            }
        }
    }
}

/// `X_k = (Z_k + Z*_{M−k})/2 − i/2 · e^{−πik/M} (Z_k − Z*_{M−k})`.
fn separate<R: Real>(points: &[[R; 2]], lines: &mut [Complex<R>]) {
    let count = points.len();
    let half = R::of(0.5);
    let zero = [R::zero(); 2];
    let point = |k: usize| {
        let [re, im] = *points.get(k % count).unwrap_or(&zero);
        Complex::new(re, im)
    };
    for (k, line) in lines.iter_mut().enumerate() {
        let z = point(k);
        let mirrored = point(count - k).conj();
        let odd = (z - mirrored) * twiddle::<R>(k, 2 * count);
        *line = (z + mirrored + Complex::new(odd.im, -odd.re)) * half;
    }
}

/// `e^{−2πik/length}`.
fn twiddle<R: Real>(k: usize, length: usize) -> Complex<R> {
    let (sin, cos) = (R::two_pi() * R::of(k as f64 / length as f64)).sin_cos();
    Complex::new(cos, -sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustfft::FftPlanner;
    use std::vec;
    use std::vec::Vec;

    /// Reproducible numbers in [−1, 1).
    fn noise(count: usize) -> Vec<f64> {
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        (0..count)
            .map(|_| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                state as f64 / 2_f64.powi(63) - 1.0
            })
            .collect()
    }

    fn oracle(samples: &[f64]) -> Vec<Complex<f64>> {
        let mut points: Vec<_> = samples.iter().map(|&x| Complex::new(x, 0.0)).collect();
        FftPlanner::new().plan_fft_forward(points.len()).process(&mut points);
        points.truncate(samples.len() / 2);
        points
    }

    fn transform<R: RealFft>(samples: &[f64]) -> Vec<Complex<f64>> {
        let mut buffer: Vec<R> = samples.iter().map(|&x| R::of(x)).collect();
        let mut lines = vec![Complex::new(R::zero(), R::zero()); samples.len() / 2];
        R::real_fft(&mut buffer, &mut lines).unwrap();
        lines.iter().map(|x| Complex::new(x.re.to_f64(), x.im.to_f64())).collect()
    }

    /// Root mean square of the deviation over that of the lines.
    fn deviation(got: &[Complex<f64>], expected: &[Complex<f64>]) -> f64 {
        let square = |x: f64, y: Complex<f64>| x + y.norm_sqr();
        let difference = got.iter().zip(expected).map(|(a, b)| a - b).fold(0.0, square);
        (difference / expected.iter().copied().fold(0.0, square)).sqrt()
    }

    #[test]
    fn both_precisions_agree_with_rustfft() {
        for points in [4, 8, 512, 1024, 2048, 4096, 8192] {
            let samples = noise(points);
            let expected = oracle(&samples);
            // The tolerance covers the rounding of products and twiddle angles, about one unit per stage in
            // at most 13 stages, added in quadrature, and that of rustfft.
            let double = deviation(&transform::<f64>(&samples), &expected);
            assert!(double < 8.0 * 2_f64.powi(-53), "{points}: {double}");
            let single = deviation(&transform::<f32>(&samples), &expected);
            assert!(single < 8.0 * 2_f64.powi(-24), "{points}: {single}");
        }
    }

    #[test]
    fn parseval_holds() {
        for points in [64, 2048] {
            let samples = noise(points);
            let lines = transform::<f64>(&samples);
            let nyquist: f64 =
                samples.iter().enumerate().map(|(n, x)| if n % 2 == 0 { *x } else { -x }).sum();
            let inner: f64 = lines[1..].iter().map(|x| x.norm_sqr()).sum();
            let energy = (lines[0].norm_sqr() + 2.0 * inner + nyquist * nyquist) / points as f64;
            let expected: f64 = samples.iter().map(|x| x * x).sum();
            // The tolerance covers a sum of `points` terms of equal sign.
            assert!((energy / expected - 1.0).abs() < 1e-13);
        }
    }

    #[test]
    fn the_transform_is_linear() {
        let (x, y) = (noise(2048), noise(4096).split_off(2048));
        let mixed: Vec<f64> = x.iter().zip(&y).map(|(x, y)| 2.0 * x - 3.0 * y).collect();
        let (fx, fy) = (transform::<f32>(&x), transform::<f32>(&y));
        let expected: Vec<_> = fx.iter().zip(&fy).map(|(x, y)| x * 2.0 - y * 3.0).collect();
        // Three transforms in f32, each within 8 · 2⁻²⁴ of its own size; the parts together are up to 1.4
        // times the whole.
        assert!(deviation(&transform::<f32>(&mixed), &expected) < 24.0 * 2_f64.powi(-24));
    }

    #[test]
    fn a_wrong_length_is_refused() {
        let mut lines = [Complex::new(0.0, 0.0); 8];
        assert_eq!(f64::real_fft(&mut [0.0; 12], &mut lines[..2]), Err(FftError::NotPowerOfTwo));
        assert_eq!(f64::real_fft(&mut [], &mut []), Err(FftError::NotPowerOfTwo));
        assert_eq!(f64::real_fft(&mut [0.0; 8], &mut lines), Err(FftError::TooManyLines));
    }
}
