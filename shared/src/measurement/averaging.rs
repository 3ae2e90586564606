//! Processes the hits of one DOF into its mass lines, in steps between which other work can be done.
//!
//! A record is processed with [`HitAverager`]: the force and then each response are added to the averaged
//! spectra; then [`join`] compares the hit's own mass lines with those of its repeat hits. [`band_of`] and
//! [`fit_responses`] turn the averaged spectra into the mass lines of the DOF.

use nalgebra::Complex;

use crate::capacity::Rig;
use crate::identify::{DofMassLines, ScatterAccumulator};
use crate::layout::{HitPolicy, HitTreatment, RIG_SENSORS, TestSettings};
use crate::mass_line::{
    BasisRow, Bin, FitSettings, MassLineBasis, MassLineDesign, MassLineError, ResponseFits,
    find_band, window_correlation,
};
use crate::real::Real;
use crate::responses::Responses;
use crate::signal::{
    AdcProperties, CHANNELS, Calibration, FftError, HAMMER, HitAgreement, HitAnalysis, Hum,
    KnownScatter, PRE_TRIGGER_SCANS, RECORD_SCANS, RESPONSES, RealFft, RepeatHits, SPECTRUM_BINS,
    Samples, Spectra, divide_by_force, resolution,
};

/// The averaged spectra of one DOF, as a rig stores them.
pub type DofSpectra<R> = Spectra<R, RESPONSES, SPECTRUM_BINS>;

/// Settings for processing the records of a test.
#[derive(Clone, Copy, Debug)]
pub struct ProcessingSettings<'a, R> {
    /// Properties of the converter: rate, delays and number of the channels.
    pub adc: &'a AdcProperties,
    /// Calibration of the channels.
    pub calibration: &'a Calibration,
    /// Settings of the test: windows, band and terms.
    pub test: &'a TestSettings<R>,
}

/// What is known of a hit before it is averaged.
#[derive(Clone, Copy, Debug)]
pub struct ExpectedHit<R: Real> {
    /// The hum in its record.
    pub hum: Option<Hum<R>>,
    /// Expected scatter of the accelerances from hit to hit, relative:
    /// [`HitUncertainty::relative_scatter`](crate::layout::HitUncertainty::relative_scatter).
    pub scatter: R,
}

/// Memory for the analysis of one hit. Nothing in it is needed between two hits.
#[derive(Debug)]
pub struct HitMemory<'m, R> {
    /// Samples of one channel; length [`RECORD_SCANS`].
    pub scratch: &'m mut [R],
    /// Spectrum of the force; length [`SPECTRUM_BINS`].
    pub force: &'m mut [Complex<R>],
    /// Design of the mass line fit; length [`SPECTRUM_BINS`].
    pub basis: &'m mut [BasisRow<R>],
}

/// What is done with the spectra of a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Change {
    /// They are added to the averages.
    Add,
    /// They are removed from the averages.
    Remove,
}

/// A hit that is being averaged. The spectrum of the force and the design stay in the [`HitMemory`] until the
/// hit is finished.
#[derive(Clone, Debug)]
pub struct HitAverager<R: Real> {
    change: Change,
    analysis: HitAnalysis<R>,
    /// Factor on all spectra of this hit, which gives it its weight in the averages.
    factor: R,
    design: Result<MassLineDesign<R>, MassLineError>,
    single: Responses<R, Rig>,
    /// True when a response has no mass line of its own.
    incomplete: bool,
}

impl<R: RealFft> HitAverager<R> {
    /// Adds the force of a record to the spectra, or removes that of a hit which was added with the same settings.
    ///
    /// # Errors
    /// When the slices do not have the lengths given in [`HitMemory`].
    pub fn begin<D: Samples<R> + ?Sized>(
        settings: ProcessingSettings<'_, R>,
        record: &D,
        expected: ExpectedHit<R>,
        memory: HitMemory<'_, R>,
        (change, spectra): (Change, &mut DofSpectra<R>),
    ) -> Result<Self, FftError> {
        let HitMemory { scratch, force, basis } = memory;
        let ProcessingSettings { adc, calibration, test } = settings;
        let analysis = HitAnalysis::new(adc, calibration, test, PRE_TRIGGER_SCANS);
        let analysis = analysis.without_hum(expected.hum);
        analysis.force(record, scratch, force)?;
        let lines = lines(resolution(adc, test.profile), |line| {
            force.get(line).map_or(R::zero(), |f| f.norm_sqr())
        });
        // A wrong band has the same effect on every hit of a DOF, so it does not add scatter.
        let (band, decay) = (test.expected_band(), test.exponential_decay);
        let basis = MassLineBasis::new(lines, band, decay, test.terms, basis);
        let design = basis.map(|basis| basis.design());
        // Without a mass line of its own, a hit is averaged as it is.
        let factor = design.as_ref().map_or(R::one(), |design| {
            let noise = analysis.hit_noise(record, adc.responses());
            let variance = noise.variance * analysis.bin_variance(RECORD_SCANS) * design.variance();
            let correlation = window_correlation(decay, record_duration(adc));
            let noise = variance * correlation * correlation / noise.accelerance_squared;
            factor_of(design.total_weight(), expected.scatter, noise)
        });
        scale(force, factor);
        match change {
            Change::Add => spectra.add_force(force),
            Change::Remove => spectra.remove_force(force),
        }
        Ok(Self {
            change,
            analysis,
            factor,
            design,
            single: Responses::zeros(RIG_SENSORS),
            incomplete: false,
        })
    }

    /// Adds a response to the spectra, or removes it, and adds it to this hit's own mass lines.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn take_response<D: Samples<R> + ?Sized>(
        &mut self,
        response: usize,
        record: &D,
        memory: HitMemory<'_, R>,
        spectra: &mut DofSpectra<R>,
    ) -> Result<(), FftError> {
        let HitMemory { scratch, force, basis } = memory;
        let mut lines = [Complex::new(R::zero(), R::zero()); SPECTRUM_BINS];
        self.analysis.response(record, response, scratch, &mut lines)?;
        scale(&mut lines, self.factor);
        match self.change {
            Change::Add => spectra.add_response(response, force, &lines),
            Change::Remove => spectra.remove_response(response, force, &lines),
        }
        divide_by_force(&mut lines, force);
        let lines = lines.iter().copied();
        let basis = self.design.as_ref().ok().and_then(|design| design.over(basis));
        let fit = basis.and_then(|basis| basis.fit(lines).ok());
        match (fit, self.single.as_mut_slice().get_mut(response)) {
            (Some(fit), Some(own)) => *own = fit.accelerance(),
            _ => self.incomplete = true,
        }
        Ok(())
    }

    /// This hit's own mass lines after all responses have been added, zero beyond the last; `None` when one
    /// of them has none.
    pub fn mass_lines(&self, calibration: &Calibration) -> Option<Responses<R, Rig>> {
        let mut single = self.single.clone();
        calibration.undo_cross_axis(single.as_mut_slice());
        (!self.incomplete).then_some(single)
    }

    /// The squared force of this hit with the mass lines `single`, N², as the loudest response of its repeat hits shows
    /// it: the squared reading of that response over its squared accelerance. `None` when it is not finite or not
    /// positive.
    pub fn squared_force<D: Samples<R> + ?Sized>(
        &self,
        record: &D,
        single: &Responses<R, Rig>,
        repeats: &ScatterAccumulator<R, Rig>,
    ) -> Option<R> {
        let size = |response: usize| {
            if repeats.hits() > 0 { repeats.mean()[response] } else { single[response] }.abs()
        };
        let responses = 0..single.as_slice().len();
        let loudest =
            responses.reduce(|most, next| if size(next) > size(most) { next } else { most })?;
        let squared = self.analysis.squared_reading(record, loudest);
        let force = squared / (single[loudest] * single[loudest]);
        (force.finite() && force > R::zero()).then_some(force)
    }

    /// Removes a response from the spectra again. It is transformed again, as its spectrum is not stored.
    /// [`Spectra::remove_force`] removes the force.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn remove_response<D: Samples<R> + ?Sized>(
        &self,
        response: usize,
        record: &D,
        memory: HitMemory<'_, R>,
        spectra: &mut DofSpectra<R>,
    ) -> Result<(), FftError> {
        let mut lines = [Complex::new(R::zero(), R::zero()); SPECTRUM_BINS];
        self.analysis.response(record, response, memory.scratch, &mut lines)?;
        scale(&mut lines, self.factor);
        spectra.remove_response(response, memory.force, &lines);
        Ok(())
    }
}

/// Scatter of the repeat hits at the DOFs measured so far.
pub fn known_scatter<R: RealFft>(measured: &[DofMassLines<R, Rig>]) -> KnownScatter<R> {
    let mut known = KnownScatter::none();
    for (_, lines) in measured {
        let squares = lines.scatter.trace() * R::of(f64::from(lines.hits.max(1) - 1));
        // Without repeat hits the scatter is unknown.
        if squares > R::zero() {
            known.add(u32::from(lines.hits), lines.accelerance.norm_squared(), squares);
        }
    }
    known
}

/// Compares a hit of this squared force, N², with its repeat hits by their own mass lines, given the scatter of the
/// hits `elsewhere`, and adds it to them unless the policy rejects it or the others. The caller then has to remove a
/// hit that is an outlier from the spectra, and to start the DOF again after [`HitAgreement::Inconsistent`] and
/// [`HitAgreement::OthersInconsistent`].
pub fn join<R: RealFft>(
    repeats: &mut ScatterAccumulator<R, Rig>,
    single: &Responses<R, Rig>,
    squared_force: Option<R>,
    elsewhere: KnownScatter<R>,
    policy: HitPolicy,
) -> HitAgreement<R> {
    let mean = repeats.mean();
    let hit = RepeatHits {
        others: u32::from(repeats.hits()),
        mean_squared: mean.norm_squared(),
        scatter_squared: repeats.scatter_squared(),
        distance_squared: (single - mean).norm_squared(),
        elsewhere,
    };
    let standing = hit.standing();
    if standing.treatment(policy) != HitTreatment::Reject {
        repeats.add(single, squared_force);
    }
    standing
}

/// The band of a DOF, Hz: the one that is set, otherwise the one found from its averaged spectra; `None` when
/// they show none. `squares` is scratch memory of length [`SPECTRUM_BINS`].
pub fn band_of<R: RealFft>(
    settings: ProcessingSettings<'_, R>,
    spectra: &DofSpectra<R>,
    squares: &mut [R],
) -> Option<[R; 2]> {
    if settings.test.band_hz.is_some() {
        return settings.test.band_hz;
    }
    squares.fill(R::zero());
    spectra.add_squares(settings.adc.responses(), squares);
    let resolution: R = resolution(settings.adc, settings.test.profile);
    let frequency = |line: usize| R::of(line as f64) * resolution;
    find_band(squares, frequency, settings.test.exponential_decay).map(|band| band.ends)
}

/// The mass lines of all responses of a DOF over a band, without a correction for the cross-axis
/// sensitivities of the sensors.
///
/// # Errors
/// See [`MassLineError`].
pub fn fit_responses<R: RealFft>(
    settings: ProcessingSettings<'_, R>,
    spectra: &DofSpectra<R>,
    band: [R; 2],
    basis: &mut [BasisRow<R>],
) -> Result<ResponseFits<R, Rig>, MassLineError> {
    let ProcessingSettings { adc, test, .. } = settings;
    let decay = test.exponential_decay;
    let correlation = window_correlation(decay, record_duration(adc));
    let lag_sigma = lag_sigma(settings.calibration);
    let fitting = FitSettings { band, decay, terms: test.terms, correlation, lag_sigma };
    let frf = |response, line| spectra.frf(test.frf_estimator, response, line);
    let lines = lines(resolution(adc, test.profile), |line| spectra.force_auto(line));
    ResponseFits::new(lines, &fitting, adc.responses(), frf, basis)
}

/// Standard deviation of a low-pass of 32 kΩ in the sensor, ±15 % by its data sheet, relative.
const LOW_PASS_SIGMA: f64 = 0.05;

/// Standard deviation of the difference between the time constants of a response and the force, s.
fn lag_sigma<R: RealFft>(calibration: &Calibration) -> R {
    let lags = (HAMMER + 1..CHANNELS).map(|channel| calibration.lag(channel));
    let largest = lags.fold(0.0, f32::max);
    R::of(f64::from(libm::hypotf(calibration.lag(HAMMER), largest)) * LOW_PASS_SIGMA)
}

/// Duration of a record, s.
fn record_duration<R: RealFft>(adc: &AdcProperties) -> R {
    R::of(RECORD_SCANS as f64) / R::of(f64::from(adc.rate.0))
}

/// Smallest scatter from hit to hit, relative: nobody hits the same place in the same direction twice.
const LEAST_SCATTER: f64 = 1e-3;

/// Factor on the spectra of a hit in the averages of its DOF.
///
/// A hit differs from its repeat hits by where and how it lands, which does not depend on its force, and by
/// noise, which matters less the harder the hit. The best weight of its accelerances is the inverse of both
/// variances together, and the averages weigh them by its squared spectra, so these become
/// `scatter²/(scatter² + noise²)`: hits of any force weigh the same where noise is small, and by their squared
/// force where it is large (theory, section 12).
///
/// `energy` is the energy of the force in the band, `noise` the variance of the accelerances from noise,
/// relative to their square.
fn factor_of<R: RealFft>(energy: R, scatter: R, noise: R) -> R {
    let least = R::of(LEAST_SCATTER * LEAST_SCATTER);
    let scatter = (scatter * scatter).max(least);
    let factor = (scatter / (scatter + noise) / energy).sqrt();
    if factor.finite() { factor } else { R::one() }
}

fn scale<R: RealFft>(lines: &mut [Complex<R>], factor: R) {
    lines.iter_mut().for_each(|line| *line *= factor);
}

/// The rig's bins with their weights.
fn lines<R: RealFft>(
    resolution: R,
    weight: impl Fn(usize) -> R + Clone,
) -> impl Iterator<Item = Bin<R>> + Clone {
    (0..SPECTRUM_BINS)
        .map(move |i| Bin { frequency: R::of(i as f64) * resolution, weight: weight(i) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::MassLines;

    #[test]
    fn where_noise_is_small_hits_of_any_force_weigh_the_same() {
        for force in [12.0_f64, 25.0, 40.0] {
            // Noise of 0.1 % at 25 N.
            let noise = (0.001 * 25.0 / force).powi(2);
            let factor = factor_of(force * force, 0.07, noise);
            // The square of the factor times the energy is the weight; 0.0021² / 0.07² is the largest part
            // that noise takes.
            assert!((factor * factor * force * force - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn where_noise_is_large_hits_weigh_by_their_squared_force() {
        let weight = |force: f64| {
            let noise = (10.0 / force).powi(2);
            factor_of(force * force, 0.05, noise).powi(2) * force * force
        };
        // 0.05² / 0.5² of the weight at 20 N is not noise.
        assert!((weight(20.0) / weight(10.0) / 4.0 - 1.0).abs() < 0.01);
    }

    #[test]
    fn the_weight_is_the_best_for_scatter_and_noise() {
        let noise = |force: f64| (0.03 * 25.0 / force).powi(2);
        let scatter = 0.05_f64;
        let weights = [12.0, 40.0].map(|force: f64| {
            (force * force) * factor_of(force * force, scatter, noise(force)).powi(2)
        });
        let variances = [12.0, 40.0].map(|force| scatter * scatter + noise(force));
        // Both are inverse variances up to one factor; rounding only.
        assert!((weights[0] * variances[0] / (weights[1] * variances[1]) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_hit_without_force_or_numbers_is_averaged_as_it_is() {
        for (energy, noise) in [(0.0, 0.0), (f64::NAN, 0.0), (1.0, f64::NAN)] {
            assert_eq!(factor_of(energy, 0.05, noise), 1.0);
        }
        assert_eq!(factor_of(4.0, 0.0, 0.0), 0.5, "no scatter stated and no noise");
    }

    #[test]
    fn the_scatter_of_the_measured_dofs_is_known() {
        let mut lines = MassLines::without_scatter(Responses::repeat(3, 0.5_f64));
        lines.hits = 5;
        lines.scatter[(0, 0)] = 0.01;
        let once = MassLines { hits: 1, ..MassLines::without_scatter(Responses::repeat(3, 0.5)) };
        let mut expected = KnownScatter::none();
        expected.add(5, 9.0 * 0.25, 4.0 * 0.01);
        assert_eq!(known_scatter(&[(0, lines), (1, once)]), expected);
    }
}
