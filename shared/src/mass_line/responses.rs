//! The mass lines of all responses of one hit DOF, with a check that they are plateaus.
//!
//! A plateau does not depend on the ends of the band. So every response is fitted twice: over the whole band,
//! and over its inner part, without a fifth of it at either end on a logarithmic scale. Where an end reaches
//! into a suspension or an elastic mode, the three terms bend and A changes; where the whole band is full of
//! modes, neither fit works, and the residuals make the standard deviation of A large.

use nalgebra::Complex;

use super::{ABOVE_SUSPENSION, BasisRow, Bin, MassLineBasis, MassLineError, Terms};
use crate::capacity::Capacity;
use crate::real::Real;
use crate::responses::Responses;

/// Fraction of the band, on a logarithmic scale, that is left out at either end for the comparison.
const TRIMMED: f64 = 0.2;
/// A mass line is not a plateau when the change or the standard deviation of its A exceeds this fraction of
/// the motion of its DOF (root mean square of all A): twice the uncertainty of the sensors' gains. Bands from
/// three times the suspension to 0.4 times the elastic modes stay below 0.6 %, bands that contain a mode are
/// above 2.5 %.
pub const PLATEAU_LIMIT: f64 = 0.02;
/// A change counts only above this number of standard deviations of A over the inner band, so that noise does
/// not.
const SIGNIFICANT: f64 = 4.0;

/// Settings of the fit.
#[derive(Clone, Copy, Debug)]
pub struct FitSettings<R> {
    /// Lower and upper end of the band, Hz.
    pub band: [R; 2],
    /// σ of the exponential window, 1/s.
    pub decay: R,
    /// Terms of the model.
    pub terms: Terms,
    /// [`window_correlation`](super::window_correlation) of the records.
    pub correlation: R,
    /// Standard deviation of the difference between the true time constants of the low-passes of response and
    /// force and those that were taken out, s; zero for spectra without low-passes.
    pub lag_sigma: R,
}

/// The mass lines of one DOF with their noise and the check for plateaus; zero beyond the last response.
/// Theory, section 5.
///
/// ```
/// # use massline_shared::capacity::Fixed;
/// # use massline_shared::mass_line::*;
/// # use massline_shared::nalgebra::Complex;
/// // Two responses, of which the second bends at the lower end of the band.
/// let bins = (0..64).map(|k| Bin { frequency: 2.0 * f64::from(k), weight: 1.0 });
/// let h = |response: usize, bin: usize| {
///     let omega = std::f64::consts::TAU * 2.0 * bin as f64;
///     let mode = [0.0_f64, std::f64::consts::TAU * 9.0][response];
///     Complex::new(1.0 / (1.0 - (mode / omega).powi(2)), 0.0)
/// };
/// let fitting = FitSettings { band: [10.0, 120.0], decay: 0.0, terms: Terms::Abc, correlation: 1.0, lag_sigma: 0.0 };
/// let mut memory = [BasisRow::<f64>::EMPTY; 64];
/// let fits = ResponseFits::<f64, Fixed<1, 1>>::new(bins, &fitting, 2, h, &mut memory)?;
/// assert!((fits.accelerance[0] - 1.0).abs() < 1e-9);
/// assert_eq!(fits.unsteady().map(|(response, _)| response).collect::<Vec<_>>(), [1]);
/// # Ok::<(), MassLineError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseFits<R: Real, C: Capacity> {
    /// A of every response, (m/s²)/N.
    pub accelerance: Responses<R, C>,
    /// Standard deviation of each A due to noise, corrected for the window.
    pub noise: Responses<R, C>,
    /// What a low-pass that is off by one standard deviation adds to the noise, relative to A.
    lag_noise: R,
    /// B of every response, (m/s⁴)/N.
    suspension: Responses<R, C>,
    /// Change of each A when the ends of the band are left out, (m/s²)/N.
    moved: Responses<R, C>,
    /// Standard deviation of that change, from noise and low-passes.
    moved_noise: Responses<R, C>,
    responses: usize,
}

/// The fits of all responses over one band.
struct BandFits<R: Real, C: Capacity> {
    accelerance: Responses<R, C>,
    noise: Responses<R, C>,
    /// B of every response.
    suspension: Responses<R, C>,
    /// Change of A, relative, by a low-pass that is off by one standard deviation, and what that adds to the noise.
    lag_shift: R,
    lag_noise: R,
}

impl<R: Real, C: Capacity> ResponseFits<R, C> {
    /// Fits `responses` responses. `bins` as for [`MassLineBasis::new`]; `h(response, bin)` is the
    /// accelerance of a response at a bin, by the same index as in `bins`.
    ///
    /// # Errors
    /// See [`MassLineError`].
    pub fn new<I>(
        bins: I,
        fitting: &FitSettings<R>,
        responses: usize,
        h: impl Fn(usize, usize) -> Complex<R>,
        workspace: &mut [BasisRow<R>],
    ) -> Result<Self, MassLineError>
    where
        I: Iterator<Item = Bin<R>> + Clone,
    {
        let count = bins.clone().count();
        let sensors = responses.div_ceil(3);
        let responses = responses.min(Responses::<R, C>::zeros(sensors).as_slice().len());
        let mut fit = |band: [R; 2]| {
            let FitSettings { decay, terms, correlation, lag_sigma, .. } = *fitting;
            let basis = MassLineBasis::new(bins.clone(), band, decay, terms, workspace)?;
            // A response whose low-pass is off by one standard deviation reads H (1 + s δτ).
            let lag = |bin: Bin<R>| Complex::new(decay, bin.frequency * R::two_pi()) * lag_sigma;
            let lag = basis.fit(bins.clone().map(lag))?;
            let mut fits = BandFits::<R, C> {
                accelerance: Responses::zeros(sensors),
                noise: Responses::zeros(sensors),
                suspension: Responses::zeros(sensors),
                lag_shift: lag.accelerance(),
                lag_noise: lag.sigma[0] * correlation,
            };
            for response in 0..responses {
                let fitted = basis.fit((0..count).map(|bin| h(response, bin)))?;
                fits.accelerance[response] = fitted.accelerance();
                fits.suspension[response] = fitted.coefficients[1];
                fits.noise[response] = fitted.sigma[0] * correlation;
            }
            Ok::<BandFits<R, C>, MassLineError>(fits)
        };
        // A band that is too narrow to be trimmed is not compared.
        let inner = fit(inner(fitting.band));
        let BandFits { accelerance, noise, suspension, lag_shift, lag_noise } = fit(fitting.band)?;
        let (moved, moved_noise) = match inner {
            // The difference of two least squares fits, one of them over a part of the data, scatters less
            // than the fit to that part.
            Ok(inner) => {
                let by_lag = inner.lag_shift - lag_shift;
                let sigma = inner.noise.zip_map(&accelerance, |noise: R, a: R| {
                    (noise * noise + a * a * by_lag * by_lag).sqrt()
                });
                (&inner.accelerance - &accelerance, sigma)
            }
            Err(_) => (Responses::zeros(sensors), Responses::zeros(sensors)),
        };
        Ok(Self { accelerance, noise, lag_noise, suspension, moved, moved_noise, responses })
    }

    /// Zeros for this number of responses, to be filled with [`Self::set`].
    pub fn zeros(responses: usize) -> Self {
        let zero = || Responses::<R, C>::zeros(responses.div_ceil(3));
        Self {
            accelerance: zero(),
            noise: zero(),
            lag_noise: R::zero(),
            suspension: zero(),
            moved: zero(),
            moved_noise: zero(),
            responses: responses.min(zero().as_slice().len()),
        }
    }

    /// Stores the mass line of one response that was fitted alone; no effect for a response that does not
    /// exist.
    pub fn set<D: Capacity>(&mut self, response: usize, alone: &ResponseFits<R, D>) {
        if response < self.responses {
            self.accelerance[response] = alone.accelerance[0];
            self.noise[response] = alone.noise[0];
            self.lag_noise = self.lag_noise.max(alone.lag_noise);
            self.suspension[response] = alone.suspension[0];
            self.moved[response] = alone.moved[0];
            self.moved_noise[response] = alone.moved_noise[0];
        }
    }

    /// Frequency of the suspension as the motion of this DOF shows it, Hz, when the band begins below three times
    /// of it: that of a single mode with the same `B/s²`, `B = −A ω²`.
    pub fn suspension_in_band(&self, band: [R; 2]) -> Option<R> {
        let ratio = self.suspension.norm() / self.accelerance.norm();
        let frequency = ratio.sqrt() / R::two_pi();
        (frequency.finite() && frequency * R::of(ABOVE_SUSPENSION) > band[0]).then_some(frequency)
    }

    /// Change of every A when the ends of the band are left out, (m/s²)/N; zero where it is within the noise, and for
    /// plateaus above the suspension.
    pub fn band_shift(&self, band: [R; 2]) -> Responses<R, C> {
        if self.unsteady().next().is_none() && self.suspension_in_band(band).is_none() {
            return Responses::zeros(self.accelerance.sensors());
        }
        self.moved_beyond_noise()
    }

    fn moved_beyond_noise(&self) -> Responses<R, C> {
        self.moved.zip_map(&self.moved_noise, |moved: R, noise| {
            if moved.abs() > noise * R::of(SIGNIFICANT) { moved } else { R::zero() }
        })
    }

    /// The responses whose mass line is not a plateau, each with the larger of its change with the ends of
    /// the band and its standard deviation, relative to the root mean square of all A of this DOF.
    pub fn unsteady(&self) -> impl Iterator<Item = (usize, R)> + '_ {
        let size = (self.accelerance.norm_squared() / R::of(self.responses.max(1) as f64)).sqrt();
        let moved = self.moved_beyond_noise();
        let part = move |k: usize| {
            let by_lag = self.accelerance[k] * self.lag_noise * R::of(SIGNIFICANT);
            let noise = (self.noise[k] * self.noise[k] - by_lag * by_lag).max(R::zero()).sqrt();
            (k, noise.max(moved[k].abs()) / size)
        };
        (0..self.responses).map(part).filter(|(_, part)| *part > R::of(PLATEAU_LIMIT))
    }
}

/// The band without its ends.
fn inner<R: Real>([low, high]: [R; 2]) -> [R; 2] {
    let cut = (high / low).powf(R::of(TRIMMED));
    [low * cut, high / cut]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Rig;
    use std::vec::Vec;

    const RESOLUTION: f64 = 4000.0 / 2048.0;
    const BINS: usize = 256;

    fn random(state: &mut u64) -> f64 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    }

    /// Three responses of a body with a suspension mode and elastic ones at 314 and 515 Hz.
    fn responses(suspension: f64, noise: f64) -> Vec<[Complex<f64>; 3]> {
        let mut state = 9;
        (0..BINS)
            .map(|k| {
                let s = Complex::new(10.0, std::f64::consts::TAU * RESOLUTION * k as f64);
                [1.0, -0.4, 0.05].map(|size| {
                    let mode = |f: f64, zeta: f64| {
                        let w = std::f64::consts::TAU * f;
                        s * s / (s * s + s * (2.0 * zeta * w) + w * w)
                    };
                    let rough = Complex::new(random(&mut state), random(&mut state)) * noise;
                    mode(suspension, 0.01) * size + mode(314.0, 0.005) * 0.5
                        - mode(515.0, 0.005) * 0.3
                        + rough
                })
            })
            .collect()
    }

    fn fits(suspension: f64, band: [f64; 2], noise: f64, terms: Terms) -> ResponseFits<f64, Rig> {
        let h = responses(suspension, noise);
        let bins = (0..BINS).map(|k| Bin { frequency: RESOLUTION * k as f64, weight: 1.0 });
        let fitting = FitSettings { band, decay: 10.0, terms, correlation: 2.26, lag_sigma: 0.0 };
        let mut workspace = [BasisRow::default(); BINS];
        let at = |response: usize, bin: usize| h[bin][response];
        ResponseFits::new(bins, &fitting, 3, at, &mut workspace).unwrap()
    }

    #[test]
    fn a_band_between_the_modes_is_a_plateau_with_noise_and_without() {
        for noise in [0.0, 0.02, 0.05] {
            let fits = fits(4.0, [12.0, 0.4 * 314.0], noise, Terms::Abc);
            assert_eq!(fits.unsteady().next(), None, "noise {noise}");
        }
    }

    #[test]
    fn a_band_that_reaches_into_the_modes_is_none() {
        for (band, noise) in [
            ([6.0, 120.0], 0.0),
            ([6.0, 120.0], 0.02),
            ([2.0, 120.0], 0.02),
            ([12.0, 330.0], 0.0),
            ([12.0, 330.0], 0.02),
            ([300.0, 480.0], 0.02),
        ] {
            let (_, part) = fits(8.0, band, noise, Terms::Abc).unsteady().next().unwrap();
            assert!(part > PLATEAU_LIMIT, "{band:?}: {part}");
        }
    }

    #[test]
    fn without_its_terms_a_mass_line_is_less_steady() {
        let with = fits(4.0, [6.0, 120.0], 0.0, Terms::Abc);
        let without = fits(4.0, [6.0, 120.0], 0.0, Terms::A);
        assert!(without.moved.norm() > 3.0 * with.moved.norm());
    }

    #[test]
    fn a_band_too_narrow_to_be_trimmed_is_judged_by_what_it_knows() {
        assert!(fits(4.0, [20.0, 24.0], 0.02, Terms::Abc).unsteady().next().is_some());
        assert_eq!(fits(0.1, [20.0, 24.0], 0.0, Terms::A).moved.norm(), 0.0);
    }
}
