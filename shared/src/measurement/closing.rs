//! Computes the mass lines of a DOF from its averaged hits.

use core::ops::RangeInclusive;

use super::averaging::{ProcessingSettings, band_of, fit_responses};
use super::{MeasuredDof, Measurement};
use crate::capacity::Rig;
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::identify::{ForceTrend, MassLines, RIGIDITY_LIMIT, ScatterAccumulator, rigid_residuals};
use crate::layout::{RIG_SENSORS, TestSettings};
use crate::mass_line::MassLineError;
use crate::responses::{ResponseSquare, Responses};
use crate::signal::{RESPONSES, RealFft, SPECTRUM_BINS, Spectra, bins_of_band, resolution};

impl<R: RealFft> Measurement<'_, R> {
    /// Computes the mass lines of a DOF from its averaged spectra and stores them.
    // Never inlined: this saves 1.9 KB of the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn close_dof(&mut self, dof: usize) {
        let Some(hit) = self.layout.as_ref().and_then(|layout| layout.hits.get(dof)) else {
            return;
        };
        let name = hit.dof;
        let (test, adc) = (self.test(), self.adc_in_use());
        let settings =
            ProcessingSettings { adc: &adc, calibration: &self.calibration, test: &test };
        let squares = &mut self.memory.scratch[..SPECTRUM_BINS];
        let measured_band = band_of(settings, &self.memory.spectra, squares);
        let band = measured_band.unwrap_or_else(TestSettings::default_band);
        let fits = fit_responses(settings, &self.memory.spectra, band, &mut self.memory.basis);
        if measured_band.is_none() {
            self.push_diagnostic(Diagnostic::about(
                Code::BandNotFound,
                Severity::Warning,
                Subject::hit(dof),
                0.0,
            ));
        }
        let fits = match fits {
            Ok(fits) => fits,
            // When one response has no mass line, the DOF has none.
            Err(error) => {
                self.memory.discard_dof(dof);
                return self.push_diagnostic(Diagnostic::about(
                    code_of(error),
                    Severity::Error,
                    Subject::hit(dof),
                    0.0,
                ));
            }
        };
        for (response, part) in fits.unsteady() {
            let subject = Subject::response(dof, response);
            let part = part.to_f32();
            self.push_diagnostic(Diagnostic::about(
                Code::NoPlateau,
                Severity::Warning,
                subject,
                part,
            ));
        }
        if let Some(suspension) = fits.suspension_in_band(band) {
            let (code, value) = (Code::SuspensionInBand, suspension.to_f32());
            self.push_diagnostic(Diagnostic::whole(code, Severity::Warning, value));
        }
        let mut band_shift = fits.band_shift(band);
        let mut accelerance = fits.accelerance;
        // The noise of a channel is not corrected: it changes only by the square of the cross-axis
        // sensitivities.
        self.calibration.undo_cross_axis(accelerance.as_mut_slice());
        self.calibration.undo_cross_axis(band_shift.as_mut_slice());
        self.check_rigidity(&test, &accelerance);
        let spectra = &self.memory.spectra;
        let hits = spectra.hits();
        // A single hit has no scatter, and the scatter of fewer hits than were averaged does not apply.
        let single = self.memory.single_hits.as_ref();
        let single = single.filter(|single| single.hits() == hits && hits > 1);
        let scatter = single.map(ScatterAccumulator::covariance);
        let scatter = scatter.unwrap_or_else(|| ResponseSquare::zeros(RIG_SENSORS));
        let trend = single.map(|single| single.trend().clone());
        let trend = trend.unwrap_or_else(|| ForceTrend::unknown(RIG_SENSORS));
        let lines = MassLines { accelerance, noise: fits.noise, scatter, hits, trend, band_shift };
        let inside = bins_of_band(band, resolution(&adc, test.profile));
        let coherence = coherences(spectra, adc.responses(), inside);
        let details = MeasuredDof { dof: name, band_hz: band, coherence };
        self.memory.store_dof(details, (dof, lines));
    }

    /// Reports the sensor with the largest residual, when the readings do not fit a rigid body.
    fn check_rigidity(&mut self, test: &TestSettings<R>, readings: &Responses<R, Rig>) {
        let residuals = self.layout.as_ref().and_then(|layout| rigid_residuals(layout, readings));
        let numbers = residuals.iter().flatten().map(|left| left.to_f32()).enumerate();
        let worst = numbers.filter(|(_, left)| left.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((sensor, left)) = worst.filter(|(_, left)| *left > RIGIDITY_LIMIT as f32) {
            // The finding concerns the sensor and not the hit. Hitting again would not help, so it is at most
            // a warning.
            let treatment = test.policy.treatment(Code::MotionNotRigid);
            let severity = treatment.severity().min(Severity::Warning);
            self.push_diagnostic(Diagnostic::about(
                Code::MotionNotRigid,
                severity,
                Subject::sensor(sensor),
                left,
            ));
        }
    }
}

/// Mean coherence of each response over these bins; `None` for a single hit.
pub(super) fn coherences<R: RealFft>(
    spectra: &Spectra<R, RESPONSES, SPECTRUM_BINS>,
    responses: usize,
    bins: RangeInclusive<usize>,
) -> Option<[R; RESPONSES]> {
    let mean = |response: usize| {
        let exists = response < responses;
        let mean = exists.then(|| spectra.mean_coherence(response, bins.clone())).flatten();
        mean.unwrap_or_else(R::zero)
    };
    (spectra.hits() > 1).then(|| core::array::from_fn(mean))
}

fn code_of(error: MassLineError) -> Code {
    match error {
        MassLineError::NotFinite => Code::DataNotFinite,
        _ => Code::BandTooNarrow,
    }
}
