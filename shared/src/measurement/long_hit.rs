//! Averages the hits of one DOF in the suspension profile, a response at a time, and compares each with its repeat
//! hits.
//!
//! Hits are averaged as they are: where noise decides, the best weight of a hit is its squared force.

use core::ops::RangeInclusive;

use nalgebra::Complex;

use super::averaging::{Change, DofSpectra, HitMemory, ProcessingSettings};
use crate::signal::{
    FftError, HitAgreement, KnownScatter, LongRecordAnalysis, RealFft, RepeatHits, SPECTRUM_BINS,
    Samples, bins_of_band, resolution,
};
use crate::units::ScanIndex;

/// How the hits of a DOF scatter: sums over all responses and the lines of the band.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LineScatter<R> {
    /// Square of the mean, ((m/s²)/N)².
    pub mean_squared: R,
    /// Sum of the squared distances of the hits from it, ((m/s²)/N)².
    pub scatter_squared: R,
}

impl<R: RealFft> LineScatter<R> {
    /// Of the hits in the averaged spectra.
    pub fn of(spectra: &DofSpectra<R>, responses: usize, band: RangeInclusive<usize>) -> Self {
        let hits = R::of(f64::from(spectra.hits()));
        let mut sums = Self { mean_squared: R::zero(), scatter_squared: R::zero() };
        let end = band.end().saturating_add(1).min(SPECTRUM_BINS);
        for response in 0..responses {
            for line in *band.start()..end {
                let mean = spectra.h1(response, line).norm_sqr();
                let mean_square = spectra.response_auto(response, line) / spectra.force_auto(line);
                if mean.finite() && mean_square.finite() {
                    sums.mean_squared += mean;
                    sums.scatter_squared += (mean_square - mean).max(R::zero()) * hits;
                }
            }
        }
        sums
    }
}

/// A hit that is being averaged. The spectrum of the force stays in the [`HitMemory`] until the hit is finished.
#[derive(Clone, Debug)]
pub struct LongHitAverager<R> {
    change: Change,
    analysis: LongRecordAnalysis<R>,
    band: RangeInclusive<usize>,
    /// Of the other hits.
    others: LineScatter<R>,
    /// Square of the distance of this hit from their mean.
    distance_squared: R,
    /// Number of the others.
    count: u32,
}

impl<R: RealFft> LongHitAverager<R> {
    /// Adds the force of the record of the hit that triggered at this scan to the spectra, or removes that of a hit
    /// which was added.
    pub fn begin<D: Samples<R> + ?Sized>(
        settings: ProcessingSettings<'_, R>,
        (record, trigger): (&D, ScanIndex),
        memory: HitMemory<'_, R>,
        (change, spectra): (Change, &mut DofSpectra<R>),
    ) -> Self {
        let ProcessingSettings { adc, calibration, test } = settings;
        let analysis = LongRecordAnalysis::new(adc, calibration, test, trigger);
        analysis.force(record, memory.force);
        let count = spectra.hits().into();
        match change {
            Change::Add => spectra.add_force(memory.force),
            Change::Remove => spectra.remove_force(memory.force),
        }
        Self {
            change,
            analysis,
            band: bins_of_band(test.expected_band(), resolution(adc, test.profile)),
            others: LineScatter { mean_squared: R::zero(), scatter_squared: R::zero() },
            distance_squared: R::zero(),
            count,
        }
    }

    /// Adds a response to the spectra, or removes it.
    ///
    /// # Errors
    /// When the slices do not have the lengths given in [`HitMemory`].
    pub fn take_response<D: Samples<R> + ?Sized>(
        &mut self,
        response: usize,
        record: &D,
        memory: HitMemory<'_, R>,
        spectra: &mut DofSpectra<R>,
    ) -> Result<(), FftError> {
        let HitMemory { scratch, force, .. } = memory;
        let mut lines = [Complex::new(R::zero(), R::zero()); SPECTRUM_BINS];
        self.analysis.response(record, response, scratch, &mut lines)?;
        match self.change {
            Change::Add => {
                self.compare(response, &lines, force, spectra);
                spectra.add_response(response, force, &lines);
            }
            Change::Remove => spectra.remove_response(response, force, &lines),
        }
        Ok(())
    }

    /// Compares a response with those of the other hits. The force of this hit is in the spectra already, the response
    /// is not.
    fn compare(
        &mut self,
        response: usize,
        lines: &[Complex<R>],
        force: &[Complex<R>],
        spectra: &DofSpectra<R>,
    ) {
        let (hits, others) = (R::of(f64::from(spectra.hits())), R::of(f64::from(self.count)));
        let end = self.band.end().saturating_add(1).min(lines.len()).min(force.len());
        for line in *self.band.start()..end {
            let energy = spectra.force_auto(line) * hits - force[line].norm_sqr();
            let mean = spectra.cross(response, line).scale(hits).unscale(energy);
            let squared = spectra.response_auto(response, line) * hits / energy;
            let distance = (lines[line] / force[line] - mean).norm_sqr();
            if squared.finite() && distance.finite() {
                self.others.mean_squared += mean.norm_sqr();
                self.others.scatter_squared += (squared - mean.norm_sqr()).max(R::zero()) * others;
                self.distance_squared += distance;
            }
        }
    }

    /// How this hit agrees with its repeat hits, after all responses, given the scatter of the hits `elsewhere`.
    pub fn standing(&self, elsewhere: KnownScatter<R>) -> HitAgreement<R> {
        let hit = RepeatHits {
            others: self.count,
            mean_squared: self.others.mean_squared,
            scatter_squared: self.others.scatter_squared,
            distance_squared: self.distance_squared,
            elsewhere,
        };
        hit.standing()
    }

    /// Removes a response from the spectra again. It is transformed again, as its spectrum is not stored.
    ///
    /// # Errors
    /// As [`Self::take_response`].
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
