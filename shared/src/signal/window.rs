//! Windows for force and response.

use crate::real::Real;

/// Number of samples in a block of the exponential.
const BLOCK: usize = 32;

/// Subtracts the rest value, scales and applies the exponential window:
/// `xₙ ← (xₙ − rest) · scale · e^{−decay·n}`, `decay = σ/rate`.
///
/// Applied to force and response alike, it only moves `s` from `iω` to `σ + iω` (theory, section 5).
///
/// The exponential is a running product over blocks of 32 samples and, within a block, over its samples. So
/// in `f32` the relative error of every value is below `160 · 2⁻²⁴ = 1e-5` for 2048 samples: 64 + 32 rounded
/// factors, and as many products. It is the same for every channel, so it cancels in `H` except for its
/// change along the record.
///
/// ```
/// # use massline_shared::signal::window::exponential;
/// let mut samples = [3.0_f64; 100];
/// exponential(&mut samples, 1.0, 0.5, 0.01);
/// assert_eq!(samples[0], 1.0);
/// assert!((samples[99] - (-0.99_f64).exp()).abs() < 1e-12);
/// ```
pub fn exponential<R: Real>(samples: &mut [R], rest: R, scale: R, decay: R) {
    let step = (-decay).exp();
    let block_step = (-decay * R::of(BLOCK as f64)).exp();
    let mut start = scale;
    for block in samples.chunks_mut(BLOCK) {
        let mut window = start;
        for sample in block {
            *sample = (*sample - rest) * window;
            window *= step;
        }
        start *= block_step;
    }
}

/// The force window: zero farther than `half_width` samples from `peak`, where the hammer has no contact, to
/// exclude its noise and drift.
///
/// It has no taper: on the project's chain case, a half cosine of a quarter to the whole half width changed
/// the ten properties by less than 0.01 % of scale.
///
/// ```
/// # use massline_shared::signal::window::force;
/// let mut samples = [1.0_f32; 8];
/// force(&mut samples, 3, 1);
/// assert_eq!(samples, [0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
/// ```
pub fn force<R: Real>(samples: &mut [R], peak: usize, half_width: usize) {
    let first = peak.saturating_sub(half_width);
    let end = peak.saturating_add(half_width).saturating_add(1);
    let (before, kept) = samples.split_at_mut(first.min(samples.len()));
    before.fill(R::zero());
    if let Some(after) = kept.get_mut(end - first..) {
        after.fill(R::zero());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_is_exact_within_its_stated_bound() {
        // σ/rate of the defaults, of the golden chain, and a decay of e⁻²⁰ over the record.
        for decay in [10.0 / 4000.0, 16.0 / 2000.0, 20.0 / 2048.0] {
            let mut single = [1.0_f32; 2048];
            let mut double = [1.0_f64; 2048];
            exponential(&mut single, 0.0, 1.0, decay as f32);
            exponential(&mut double, 0.0, 1.0, decay);
            for n in 0..2048 {
                let exact = (-decay * n as f64).exp();
                // Rounding `decay` to f32 adds up to `decay · n` units.
                let bound = 160.0 + decay * n as f64;
                let error = (f64::from(single[n]) / exact - 1.0).abs();
                assert!(error < bound * 2_f64.powi(-24), "f32, {n}: {error:e}");
                let error = (double[n] / exact - 1.0).abs();
                assert!(error < bound * 2_f64.powi(-53), "f64, {n}: {error:e}");
            }
        }
    }

    #[test]
    fn rest_value_and_scale_are_applied() {
        let mut samples = [3.0, 5.0];
        exponential(&mut samples, 3.0, 0.5, 0.0);
        assert_eq!(samples, [0.0, 1.0]);
    }

    #[test]
    fn the_force_window_is_one_about_the_peak_and_zero_far_from_it() {
        let mut samples = [1.0_f64; 40];
        force(&mut samples, 20, 5);
        for (n, &got) in samples.iter().enumerate() {
            assert_eq!(got, if n.abs_diff(20) <= 5 { 1.0 } else { 0.0 }, "{n}");
        }
    }

    #[test]
    fn a_force_window_over_the_ends_is_cut() {
        let mut samples = [1.0_f64; 8];
        force(&mut samples, 0, 100);
        assert_eq!(samples, [1.0; 8]);
        force(&mut samples, usize::MAX, usize::MAX);
        force(&mut [0.0_f64; 0], 3, 2);
    }
}
