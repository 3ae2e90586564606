//! Spectra averaged over the hits of one DOF.

use core::ops::RangeInclusive;

use nalgebra::Complex;

use crate::layout::FrfEstimator;
use crate::real::Real;

/// Auto and cross spectra of force and responses, and the frequency responses computed from them.
///
/// `G_FF = mean |F|²`, `G_XF = mean X F*`, `G_XX = mean |X|²` over the hits, `F` in N s and `X` in (m/s²) s; both
/// may have a common factor for each hit, which gives the hit its weight.
/// `H1 = G_XF/G_FF` and `H2 = G_XX/G_FX` are the least squares estimates of H for noise on the responses
/// alone and on the force alone; `Hv = √(G_XX/G_FF) · G_XF/|G_XF|` is their geometric mean. The coherence is
/// `γ² = |G_XF|²/(G_FF G_XX) = H1/H2`.
///
/// Takes 14 KiB for nine responses, 128 bins and `f32`. It is all zero bytes when empty, so a static one is
/// in `.bss`.
///
/// ```
/// # use massline_shared::nalgebra::Complex;
/// # use massline_shared::signal::Spectra;
/// let mut spectra = Spectra::<f64, 1, 1>::new();
/// for (force, noise) in [(2.0, 0.1), (3.0, -0.1), (4.0, 0.1)] {
///     let force = [Complex::new(force, 0.0)];
///     spectra.add_force(&force);
///     spectra.add_response(0, &force, &[Complex::new(0.8 * force[0].re + noise, 0.0)]);
/// }
/// assert_eq!(spectra.hits(), 3);
/// // H is 0.8 (m/s²)/N; the noise is not coherent with the force.
/// assert!((spectra.h1(0, 0).re - 0.8).abs() < 0.02);
/// assert!(0.99 < spectra.coherence(0, 0) && spectra.coherence(0, 0) < 1.0);
/// ```
#[derive(Clone, Debug)]
pub struct Spectra<R, const RESPONSES: usize, const BINS: usize> {
    hits: u16,
    force: [R; BINS],
    cross: [[Complex<R>; BINS]; RESPONSES],
    response: [[R; BINS]; RESPONSES],
}

impl<const RESPONSES: usize, const BINS: usize> Spectra<f32, RESPONSES, BINS> {
    /// Spectra without hits.
    pub const fn new() -> Self {
        Self::filled_with(0.0)
    }
}

impl<const RESPONSES: usize, const BINS: usize> Spectra<f64, RESPONSES, BINS> {
    /// Spectra without hits.
    pub const fn new() -> Self {
        Self::filled_with(0.0)
    }
}

impl<R: Real, const RESPONSES: usize, const BINS: usize> Default for Spectra<R, RESPONSES, BINS> {
    fn default() -> Self {
        Self::filled_with(R::zero())
    }
}

impl<R: Copy, const RESPONSES: usize, const BINS: usize> Spectra<R, RESPONSES, BINS> {
    const fn filled_with(zero: R) -> Self {
        Self {
            hits: 0,
            force: [zero; BINS],
            cross: [[Complex { re: zero, im: zero }; BINS]; RESPONSES],
            response: [[zero; BINS]; RESPONSES],
        }
    }
}

impl<R: Real, const RESPONSES: usize, const BINS: usize> Spectra<R, RESPONSES, BINS> {
    /// Discards all hits.
    pub fn clear(&mut self) {
        self.hits = 0;
        self.force.fill(R::zero());
        for (cross, response) in self.cross.iter_mut().zip(&mut self.response) {
            cross.fill(Complex::new(R::zero(), R::zero()));
            response.fill(R::zero());
        }
    }

    /// Number of hits averaged.
    pub fn hits(&self) -> u16 {
        self.hits
    }

    /// Starts a hit with the spectrum of its force. Call [`Self::add_response`] for every response before the
    /// next hit starts.
    pub fn add_force(&mut self, force: &[Complex<R>]) {
        self.hits = self.hits.saturating_add(1);
        for (sum, f) in self.force.iter_mut().zip(force) {
            *sum += f.norm_sqr();
        }
    }

    /// Adds the spectrum of one response to the hit started last; `force` is the spectrum passed then. A
    /// response that does not exist is ignored.
    pub fn add_response(&mut self, response: usize, force: &[Complex<R>], bins: &[Complex<R>]) {
        let (Some(cross), Some(auto)) =
            (self.cross.get_mut(response), self.response.get_mut(response))
        else {
            return;
        };
        for (((cross, auto), f), x) in cross.iter_mut().zip(auto).zip(force).zip(bins) {
            *cross += x * f.conj();
            *auto += x.norm_sqr();
        }
    }

    /// Removes a hit that was added with this spectrum of its force; call [`Self::remove_response`] for every
    /// response as well. The remaining averages differ from averages without the hit by rounding only.
    pub fn remove_force(&mut self, force: &[Complex<R>]) {
        self.hits = self.hits.saturating_sub(1);
        for (sum, f) in self.force.iter_mut().zip(force) {
            *sum = (*sum - f.norm_sqr()).max(R::zero());
        }
    }

    /// Removes the spectrum of one response.
    pub fn remove_response(&mut self, response: usize, force: &[Complex<R>], bins: &[Complex<R>]) {
        let (Some(cross), Some(auto)) =
            (self.cross.get_mut(response), self.response.get_mut(response))
        else {
            return;
        };
        for (((cross, auto), f), x) in cross.iter_mut().zip(auto).zip(force).zip(bins) {
            *cross -= x * f.conj();
            *auto = (*auto - x.norm_sqr()).max(R::zero());
        }
    }

    /// `G_FF` at a bin, N² s²; 0 beyond the last bin.
    pub fn force_auto(&self, bin: usize) -> R {
        self.mean(self.force.get(bin))
    }

    /// `G_XF` at a bin, N (m/s²) s²; 0 beyond the last response or bin.
    pub fn cross(&self, response: usize, bin: usize) -> Complex<R> {
        let sum = self.cross.get(response).and_then(|bins| bins.get(bin));
        let count = self.count();
        sum.map_or(Complex::new(R::zero(), R::zero()), |sum| sum.unscale(count))
    }

    /// `G_XX` at a bin, (m/s²)² s²; 0 beyond the last response or bin.
    pub fn response_auto(&self, response: usize, bin: usize) -> R {
        self.mean(self.response.get(response).and_then(|bins| bins.get(bin)))
    }

    /// `H1 = G_XF/G_FF`, (m/s²)/N; 0 where there is no force (such a bin has no weight either).
    pub fn h1(&self, response: usize, bin: usize) -> Complex<R> {
        ratio(self.cross(response, bin), self.force_auto(bin))
    }

    /// H by one of the estimators, (m/s²)/N; 0 where there is no force.
    pub fn frf(&self, estimator: FrfEstimator, response: usize, bin: usize) -> Complex<R> {
        let h1 = self.h1(response, bin);
        let coherence = self.coherence(response, bin);
        match estimator {
            FrfEstimator::H1 => h1,
            FrfEstimator::H2 => ratio(h1, coherence),
            FrfEstimator::Hv => ratio(h1, coherence.sqrt()),
        }
    }

    /// Adds the squared accelerances of the first `responses` responses to `squares`, bin by bin: the input
    /// of [`find_band`](crate::mass_line::find_band).
    pub fn add_squares(&self, responses: usize, squares: &mut [R]) {
        for (bin, sum) in squares.iter_mut().enumerate() {
            for response in 0..responses {
                *sum += self.h1(response, bin).norm_sqr();
            }
        }
    }

    /// `γ²`, from 0 to 1; 0 where there is no force or no response.
    pub fn coherence(&self, response: usize, bin: usize) -> R {
        let cross = self.cross(response, bin);
        let to_force = ratio(cross, self.force_auto(bin));
        let to_response = ratio(cross, self.response_auto(response, bin));
        let squared = (to_force * to_response.conj()).re;
        if squared.finite() { squared.min(R::one()) } else { R::zero() }
    }

    /// Mean coherence of a response over those of the bins that exist; 0 when none does. `None` with fewer
    /// than two hits, for which the coherence is always one.
    pub fn mean_coherence(&self, response: usize, bins: RangeInclusive<usize>) -> Option<R> {
        if self.hits < 2 {
            return None;
        }
        let (mut sum, mut count) = (R::zero(), R::zero());
        // A band may extend far beyond the last bin.
        let end = if bins.is_empty() { 0 } else { bins.end().saturating_add(1).min(BINS) };
        for bin in *bins.start()..end {
            sum += self.coherence(response, bin);
            count += R::one();
        }
        Some(if count > R::zero() { sum / count } else { R::zero() })
    }

    fn mean(&self, sum: Option<&R>) -> R {
        sum.map_or(R::zero(), |&sum| sum / self.count())
    }

    fn count(&self) -> R {
        R::from_u16(self.hits.max(1)).unwrap_or_else(R::one)
    }
}

/// The bins within a band, Hz, both ends included: `[low, high]` with a bin spacing of `resolution` Hz.
///
/// An end that coincides with a bin within rounding includes it. Empty when there is no bin inside.
pub fn bins_of_band<R: Real>(band: [R; 2], resolution: R) -> RangeInclusive<usize> {
    let ends = band.map(|end| end.to_f64() / resolution.to_f64());
    let slack = 1e-4;
    let (low, high) = (libm::ceil(ends[0] - slack), libm::floor(ends[1] + slack));
    if low.is_finite() && high >= low.max(0.0) {
        // The cast limits larger values to the range of `usize`.
        low.max(0.0) as usize..=high as usize
    } else {
        #[expect(clippy::reversed_empty_ranges, reason = "the empty range")]
        let empty = 1..=0;
        empty
    }
}

/// `numerator/denominator`, or 0 when the quotient is not finite.
pub(super) fn ratio<R: Real>(numerator: Complex<R>, denominator: R) -> Complex<R> {
    let quotient = numerator.unscale(denominator);
    if quotient.re.finite() && quotient.im.finite() {
        quotient
    } else {
        Complex::new(R::zero(), R::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    type Small = Spectra<f64, 1, 4>;
    type Bins = [Complex<f64>; 4];

    fn complex() -> impl Strategy<Value = Complex<f64>> {
        (-10.0..10.0_f64, -10.0..10.0_f64).prop_map(|(re, im)| Complex::new(re, im))
    }

    fn bins() -> impl Strategy<Value = Bins> {
        prop::array::uniform4(complex())
    }

    fn averaged(hits: &[(Bins, Bins)]) -> Small {
        let mut spectra = Small::new();
        for (force, response) in hits {
            spectra.add_force(force);
            spectra.add_response(0, force, response);
        }
        spectra
    }

    proptest! {
        #[test]
        fn h1_of_a_pure_gain_is_that_gain_with_coherence_one(
            forces in prop::collection::vec(bins(), 1..6),
            gain in complex(),
        ) {
            prop_assume!(gain.norm() > 1e-3);
            let hits: std::vec::Vec<_> = forces.iter().map(|f| (*f, f.map(|f| f * gain))).collect();
            let spectra = averaged(&hits);
            prop_assert_eq!(usize::from(spectra.hits()), hits.len());
            for bin in 0..4 {
                // The tolerance covers rounding; the sums have few terms.
                for estimator in FrfEstimator::ALL {
                    let h = spectra.frf(estimator, 0, bin);
                    prop_assert!((h - gain).norm() < 1e-13 * gain.norm(), "{estimator:?}");
                }
                prop_assert!((spectra.coherence(0, bin) - 1.0).abs() < 1e-13);
            }
            match spectra.mean_coherence(0, 0..=3) {
                Some(mean) => prop_assert!((mean - 1.0).abs() < 1e-13),
                None => prop_assert_eq!(hits.len(), 1),
            }
        }

        #[test]
        fn noise_in_the_force_leaves_h2_at_the_least_squares_gain_and_hv_between(
            hits in prop::collection::vec((bins(), bins()), 3..6),
        ) {
            let spectra = averaged(&hits);
            for bin in 0..4 {
                prop_assume!(spectra.coherence(0, bin) > 1e-3);
                // The definition of H2: it minimises Σ|F − X/H|².
                let left = |h: Complex<f64>| -> f64 {
                    hits.iter().map(|(f, x)| (f[bin] - x[bin] / h).norm_sqr()).sum()
                };
                let h2 = spectra.frf(FrfEstimator::H2, 0, bin);
                for aside in [Complex::new(1.01, 0.0), Complex::new(1.0, -0.01)] {
                    prop_assert!(left(h2) <= left(h2 * aside));
                    prop_assert!(left(h2) <= left(h2 / aside));
                }
                // Hv is the geometric mean with the common phase; the tolerance covers rounding.
                let (h1, hv) = (spectra.h1(0, bin), spectra.frf(FrfEstimator::Hv, 0, bin));
                prop_assert!((hv * hv - h1 * h2).norm() < 1e-12 * hv.norm_sqr());
                prop_assert!((hv * h1.conj()).im.abs() < 1e-12 * hv.norm_sqr());
            }
        }

        #[test]
        fn coherence_lies_between_zero_and_one(
            hits in prop::collection::vec((bins(), bins()), 0..6),
        ) {
            let spectra = averaged(&hits);
            for bin in 0..6 {
                prop_assert!((0.0..=1.0).contains(&spectra.coherence(0, bin)));
            }
        }

        #[test]
        fn noise_in_the_response_lowers_coherence_and_leaves_h1_at_the_least_squares_gain(
            hits in prop::collection::vec((bins(), bins()), 3..6),
        ) {
            // The definition of H1: it minimises Σ|X − H F|².
            let spectra = averaged(&hits);
            for bin in 0..4 {
                let left = |h: Complex<f64>| -> f64 {
                    hits.iter().map(|(f, x)| (x[bin] - h * f[bin]).norm_sqr()).sum()
                };
                let h1 = spectra.h1(0, bin);
                let total = left(Complex::new(0.0, 0.0));
                for aside in [Complex::new(0.01, 0.0), Complex::new(0.0, -0.01)] {
                    prop_assert!(left(h1) <= left(h1 + aside));
                    prop_assert!(left(h1) <= left(h1 - aside));
                }
                // The coherence is the share of the response that H1 explains.
                let explained = 1.0 - left(h1) / total;
                prop_assert!((spectra.coherence(0, bin) - explained).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn a_hit_that_is_taken_out_leaves_the_others() {
        let hit = |k: f64| {
            let force = [1.0, 2.0, 3.0, 0.0].map(|f| Complex::new(f + k, 0.5 * k));
            (force, force.map(|f| f * Complex::new(2.0, 0.1 * k) + 0.3 * k))
        };
        let mut spectra = averaged(&[hit(1.0), hit(2.0), hit(-3.0)]);
        let (force, response) = hit(-3.0);
        spectra.remove_force(&force);
        spectra.remove_response(0, &force, &response);
        let without = averaged(&[hit(1.0), hit(2.0)]);
        assert_eq!(spectra.hits(), 2);
        for bin in 0..4 {
            // The tolerance covers rounding; the sums have few terms.
            assert!((spectra.h1(0, bin) - without.h1(0, bin)).norm() < 1e-13);
            assert!((spectra.coherence(0, bin) - without.coherence(0, bin)).abs() < 1e-13);
        }
    }

    #[test]
    fn without_force_there_are_zeros_and_no_nan() {
        let zero = [Complex::new(0.0, 0.0); 4];
        let some = [Complex::new(1.0, 2.0); 4];
        for (force, response) in [(zero, zero), (zero, some), (some, zero)] {
            let spectra = averaged(&[(force, response)]);
            assert_eq!(spectra.h1(0, 1), zero[0]);
            assert_eq!(spectra.coherence(0, 1), 0.0);
        }
        assert_eq!(Small::new().h1(0, 0), zero[0]);
        assert_eq!(Small::new().mean_coherence(0, 0..=3), None);
    }

    #[test]
    fn a_band_beyond_the_last_line_costs_no_more_than_the_lines() {
        let some = [Complex::new(1.0, 2.0); 4];
        let spectra = averaged(&[(some, some), (some, some)]);
        let band = bins_of_band([1.0, 1e300], 1.0);
        assert_eq!(band, 1..=usize::MAX);
        // The tolerance covers rounding; the sums have few terms.
        assert!((spectra.mean_coherence(0, band).unwrap() - 1.0).abs() < 1e-13);
        assert_eq!(spectra.mean_coherence(0, 4..=usize::MAX), Some(0.0));
        assert_eq!(spectra.mean_coherence(0, bins_of_band([5.0, 4.0], 1.0)), Some(0.0));
    }

    #[test]
    fn a_cleared_spectrum_is_a_new_one() {
        let some = [Complex::new(1.0, 2.0); 4];
        let mut spectra = averaged(&[(some, some), (some, some)]);
        spectra.clear();
        assert_eq!(spectra.hits(), 0);
        assert_eq!(spectra.force_auto(1), 0.0);
        assert_eq!(spectra.cross(0, 1), Complex::new(0.0, 0.0));
        assert_eq!(spectra.response_auto(0, 1), 0.0);
    }

    #[test]
    fn a_band_includes_both_its_ends() {
        assert_eq!(bins_of_band([10.0, 120.0], 1.953_125), 6..=61);
        assert_eq!(bins_of_band([0.3, 0.9], 0.1), 3..=9);
        assert_eq!(bins_of_band([0.3_f32, 0.9], 0.1), 3..=9);
        assert_eq!(bins_of_band([-5.0, 4.0], 2.0), 0..=2);
        assert!(bins_of_band([2.1, 2.9], 1.0).is_empty());
        assert!(bins_of_band([5.0, 4.0], 1.0).is_empty());
        assert!(bins_of_band([f64::NAN, 4.0], 1.0).is_empty());
        assert!(bins_of_band([1.0, f64::NAN], 1.0).is_empty());
    }

    #[test]
    fn spectra_of_the_rig_fit_their_memory() {
        assert!(size_of::<Spectra<f32, 9, 128>>() <= 14 * 1024 + 4);
    }
}
