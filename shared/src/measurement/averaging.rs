//! Processes the hits of one DOF into its mass lines, in steps between which other work can be done.
//!
//! A record is processed with [`HitAverager`]: the force and then each response are added to the averaged
//! spectra; then [`join`] compares the hit's own mass lines with those of its repeat hits. [`band_of`] and
//! [`fit_responses`] turn the averaged spectra into the mass lines of the DOF.

use nalgebra::Complex;

use crate::identify::ScatterAccumulator;
use crate::layout::{RIG_SENSORS, TestSettings, Verdict};
use crate::mass_line::{
    BasisRow, Bin, Fitting, MassLineBasis, MassLineDesign, MassLineError, ResponseFits, find_band,
    window_correlation,
};
use crate::responses::Responses;
use crate::signal::{
    AdcProperties, Calibration, FftError, HitAgreement, HitAnalysis, PRE_TRIGGER_SCANS,
    RECORD_SCANS, RESPONSES, RealFft, RepeatHits, SPECTRUM_BINS, Samples, Spectra,
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

/// Spacing of the rig's bins, Hz.
pub fn resolution<R: RealFft>(adc: &AdcProperties) -> R {
    R::of(f64::from(adc.rate.0)) / R::of(RECORD_SCANS as f64)
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

/// A hit that is being averaged. The spectrum of the force and the design stay in the [`HitMemory`] until the
/// hit is finished.
#[derive(Clone, Debug)]
pub struct HitAverager<R> {
    analysis: HitAnalysis<R>,
    design: Result<MassLineDesign<R>, MassLineError>,
    single: Responses<R, RIG_SENSORS>,
    /// True when a response has no mass line of its own.
    incomplete: bool,
}

impl<R: RealFft> HitAverager<R> {
    /// Adds the force of a record to the spectra.
    ///
    /// # Errors
    /// When the slices do not have the lengths given in [`HitMemory`].
    pub fn begin<D: Samples<R> + ?Sized>(
        settings: ProcessingSettings<'_, R>,
        record: &D,
        memory: HitMemory<'_, R>,
        spectra: &mut DofSpectra<R>,
    ) -> Result<Self, FftError> {
        let HitMemory { scratch, force, basis } = memory;
        let ProcessingSettings { adc, calibration, test } = settings;
        let analysis = HitAnalysis::new(adc, calibration, test, PRE_TRIGGER_SCANS);
        analysis.force(record, scratch, force)?;
        spectra.add_force(force);
        let lines =
            lines(resolution(adc), |line| force.get(line).map_or(R::zero(), |f| f.norm_sqr()));
        // A wrong band has the same effect on every hit of a DOF, so it does not add scatter.
        let (band, decay) = (test.expected_band(), test.exponential_decay);
        let basis = MassLineBasis::new(lines, band, decay, test.terms, basis);
        let design = basis.map(|basis| basis.design());
        Ok(Self { analysis, design, single: Responses::zeros(), incomplete: false })
    }

    /// Adds a response to the spectra, and to this hit's own mass lines.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn add_response<D: Samples<R> + ?Sized>(
        &mut self,
        response: usize,
        record: &D,
        memory: HitMemory<'_, R>,
        spectra: &mut DofSpectra<R>,
    ) -> Result<(), FftError> {
        let HitMemory { scratch, force, basis } = memory;
        let mut lines = [Complex::new(R::zero(), R::zero()); SPECTRUM_BINS];
        self.analysis.response(record, response, scratch, &mut lines)?;
        spectra.add_response(response, force, &lines);
        HitAnalysis::divide(&mut lines, force);
        let lines = lines.iter().copied();
        let basis = self.design.as_ref().ok().and_then(|design| design.over(basis));
        let fit = basis.and_then(|basis| basis.fit(lines).ok());
        match (fit, self.single.get_mut(response)) {
            (Some(fit), Some(own)) => *own = fit.accelerance(),
            _ => self.incomplete = true,
        }
        Ok(())
    }

    /// This hit's own mass lines after all responses have been added, zero beyond the last; `None` when one
    /// of them has none.
    pub fn mass_lines(&self, calibration: &Calibration) -> Option<Responses<R, RIG_SENSORS>> {
        let mut single = self.single;
        calibration.undo_cross_axis(single.as_mut_slice());
        (!self.incomplete).then_some(single)
    }

    /// Removes a response from the spectra. It is transformed again, as its spectrum is not stored.
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
        spectra.remove_response(response, memory.force, &lines);
        Ok(())
    }
}

/// Compares a hit with its repeat hits by their own mass lines, and adds it to them unless it disagrees and
/// `verdict` is to reject such hits. The caller then has to remove an [`HitAgreement::Outlier`] from the spectra,
/// and to start the DOF again after [`HitAgreement::Inconsistent`].
pub fn join<R: RealFft>(
    repeats: &mut ScatterAccumulator<R, RIG_SENSORS>,
    single: &Responses<R, RIG_SENSORS>,
    verdict: Verdict,
) -> HitAgreement<R> {
    let mean = repeats.mean();
    let hit = RepeatHits {
        others: u32::from(repeats.hits()),
        mean_squared: mean.norm_squared(),
        scatter_squared: repeats.scatter_squared(),
        distance_squared: (single - mean).norm_squared(),
    };
    let standing = hit.standing();
    if standing == HitAgreement::Agrees || verdict != Verdict::Reject {
        repeats.add(single);
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
    let resolution: R = resolution(settings.adc);
    let frequency = |line: usize| R::of(line as f64) * resolution;
    find_band(squares, frequency, settings.test.exponential_decay).map(|found| found.ends)
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
) -> Result<ResponseFits<R, RIG_SENSORS>, MassLineError> {
    let ProcessingSettings { adc, test, .. } = settings;
    let decay = test.exponential_decay;
    let duration = R::of(RECORD_SCANS as f64) / R::of(f64::from(adc.rate.0));
    let correlation = window_correlation(decay, duration);
    let fitting = Fitting { band, decay, terms: test.terms, correlation };
    let frf = |response, line| spectra.frf(test.frf_estimator, response, line);
    let lines = lines(resolution(adc), |line| spectra.force_auto(line));
    ResponseFits::new(lines, &fitting, adc.responses(), frf, basis)
}

/// The rig's bins with their weights.
fn lines<R: RealFft>(
    resolution: R,
    weight: impl Fn(usize) -> R + Clone,
) -> impl Iterator<Item = Bin<R>> + Clone {
    (0..SPECTRUM_BINS)
        .map(move |i| Bin { frequency: R::of(i as f64) * resolution, weight: weight(i) })
}
