//! The frequency responses of a layout, and the mass lines that are fitted to them.

use massline_shared::FrequencyResponses;
use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::identify::MassLines;
use massline_shared::layout::{HostLayout, TestProfile, TestSettings};
use massline_shared::mass_line::{
    BasisRow, Bin, FitSettings, MassLineError, ResponseFits, find_band, window_correlation,
};
use nalgebra::Complex;

use super::pair::Pair;
use super::reading::{Reading, Response};
use super::selection::Selection;
use crate::{Error, Result};
use massline_analysis::identification::MeasuredLines;
use massline_files::uff::{Frf, NodeDirection, Quantity, UffFile};

/// The frequency responses of a layout: hit by hit, sensor by sensor, axis by axis.
pub(super) struct LayoutResponses {
    hits: Vec<Vec<Response>>,
    /// What was understood of the file.
    pub(super) reading: Reading,
}

/// The mass lines of a layout, and their band.
pub(super) struct FittedLines {
    pub(super) lines: MeasuredLines,
    pub(super) band_hz: [f64; 2],
    /// Warnings about responses without a plateau over the band.
    pub(super) diagnostics: Vec<Diagnostic>,
}

/// The accelerances of all responses at the bins of a band.
#[derive(Clone)]
pub(super) struct LinesOfBand {
    pub(super) frequencies: Vec<f64>,
    /// Accelerances, ordered by bin, then channel, then hit.
    pub(super) accelerance: Vec<Complex<f64>>,
    pub(super) channels: usize,
    pub(super) hits: usize,
    pub(super) decay: f64,
    pub(super) correlation: f64,
}

impl LinesOfBand {
    /// The accelerances in the form that the solvers need.
    pub(super) fn responses(&self) -> Result<FrequencyResponses<'_, f64>> {
        let Self { frequencies, accelerance, channels, hits, .. } = self;
        let responses = FrequencyResponses::new(frequencies, accelerance, *channels, *hits);
        let responses =
            responses.ok_or_else(|| Error::input("frf_missing", "a response has too few bins"))?;
        Ok(responses.windowed(self.decay, self.correlation))
    }
}

/// The bins of a mass line reach over at least this ratio of frequencies, where the band does.
const OCTAVE: f64 = 2.0;

/// The band of mass lines that a layout states; `None` to find it from the responses. A layout for a rig in the
/// suspension profile states the band of the modes, and mass lines get the default one.
pub(super) fn stated_band(test: &TestSettings<f64>) -> Option<[f64; 2]> {
    match test.profile {
        TestProfile::MassLine => test.band_hz,
        TestProfile::Suspension => Some(TestSettings::<f64>::default_band()),
    }
}

impl LayoutResponses {
    /// Finds the function of every sensor axis and hit. Bins without a number are left out outside the band of the mass
    /// lines and that of the suspension modes.
    pub(super) fn of(
        layout: &HostLayout,
        uff: &UffFile,
        quantity: Option<Quantity>,
        suspension_band_hz: [f64; 2],
    ) -> Result<Self> {
        let selection = Selection::new(layout, uff);
        let mut reading = Reading::of(uff, &selection);
        let mut responses = Vec::new();
        for pair in Pair::all(layout) {
            let response = response(&selection, quantity, &pair, &mut reading)?;
            responses.push(response);
        }
        let [low, high] = suspension_band_hz;
        let band = match stated_band(&layout.test) {
            Some(band) => [low.min(band[0]), high.max(band[1])],
            None => [low, f64::INFINITY],
        };
        reading.leave_out_without_number(&mut responses, band)?;
        let mut responses = responses.into_iter();
        let channels = 3 * layout.sensors.len();
        let hits =
            layout.hits.iter().map(|_| responses.by_ref().take(channels).collect()).collect();
        Ok(Self { hits, reading })
    }

    /// The mass lines of every hit of the layout; `decay` is σ of the exponential window used for the
    /// responses, 1/s.
    pub(super) fn mass_lines(&self, layout: &HostLayout, decay: f64) -> Result<FittedLines> {
        let band_hz = match stated_band(&layout.test) {
            Some(band) => band,
            None => self.find_band(decay)?,
        };
        self.check_reach(band_hz)?;
        let correlation = self.correlation(decay);
        let terms = layout.test.terms;
        let fitting = FitSettings { band: band_hz, decay, terms, correlation, lag_sigma: 0.0 };
        let mut fitted_lines = FittedLines { lines: Vec::new(), band_hz, diagnostics: Vec::new() };
        let mut stiffest = None;
        for (dof, responses) in self.hits.iter().enumerate() {
            let mut fits = ResponseFits::<f64, Unbounded>::zeros(responses.len());
            for (channel, response) in responses.iter().enumerate() {
                fits.set(channel, &response.fit(&fitting)?);
            }
            fitted_lines.diagnostics.extend(fits.unsteady().map(|(channel, part)| {
                let subject = Subject::response(dof, channel);
                Diagnostic::about(Code::NoPlateau, Severity::Warning, subject, part as f32)
            }));
            let suspension = fits.suspension_in_band(band_hz);
            stiffest = suspension.into_iter().chain(stiffest).reduce(f64::max);
            let hits = u16::from(layout.test.hits_per_dof);
            let band_shift = fits.band_shift(band_hz);
            let lines = MassLines::without_scatter(fits.accelerance).with_noise(fits.noise);
            fitted_lines.lines.push((dof, MassLines { hits, band_shift, ..lines }));
        }
        if let Some(suspension) = stiffest {
            let (code, value) = (Code::SuspensionInBand, suspension as f32);
            fitted_lines.diagnostics.push(Diagnostic::whole(code, Severity::Warning, value));
        }
        Ok(fitted_lines)
    }

    /// Part of the readings in a band that are nearer to a quarter of a period from the force than to its phase.
    pub(super) fn quadrature_share(&self, [low, high]: [f64; 2]) -> f64 {
        let points = self.hits.iter().flatten().flat_map(|response| &response.points);
        let inside = points.filter(|(f, _)| low <= *f && *f <= high);
        let (beside, total) = inside.fold((0_usize, 0_usize), |(beside, total), (_, h)| {
            (beside + usize::from(h.im.abs() > h.re.abs()), total + 1)
        });
        if total > 0 { beside as f64 / total as f64 } else { 0.0 }
    }

    /// Refuses responses of which only a corner lies in a wide band: the terms of the mass line are then not told
    /// apart.
    fn check_reach(&self, band_hz: [f64; 2]) -> Result<()> {
        let [low, high] = band_hz;
        for response in self.hits.iter().flatten() {
            let inside =
                || response.points.iter().map(|(f, _)| *f).filter(|f| low <= *f && *f <= high);
            let ends = inside().next().zip(inside().next_back());
            let Some((first, last)) = ends.filter(|_| high >= OCTAVE * low) else { continue };
            if last < OCTAVE * first {
                let text = format!(
                    "the frequency response of {} (dataset {}) has bins only from {first} to {last} Hz of the mass \
                     lines' band, {low} to {high} Hz; change test.band_hz or export bins over at least an octave of it",
                    response.name, response.dataset
                );
                return Err(Error::input("band_too_narrow", text));
            }
        }
        Ok(())
    }

    /// All bins of the band.
    pub(super) fn spectrum_bins(
        &self,
        layout: &HostLayout,
        band_hz: [f64; 2],
        decay: f64,
    ) -> Result<LinesOfBand> {
        let frequencies = self.common_frequencies()?;
        let inside: Vec<usize> = (0..frequencies.len())
            .filter(|&k| band_hz[0] <= frequencies[k] && frequencies[k] <= band_hz[1])
            .collect();
        let of_line = |&k: &usize| {
            let channels = 0..self.hits.first().map_or(0, Vec::len);
            channels
                .flat_map(move |channel| self.hits.iter().map(move |hit| hit[channel].points[k].1))
        };
        Ok(LinesOfBand {
            accelerance: inside.iter().flat_map(of_line).collect(),
            frequencies: inside.iter().map(|&k| frequencies[k]).collect(),
            channels: 3 * layout.sensors.len(),
            hits: self.hits.len(),
            decay,
            correlation: self.correlation(decay),
        })
    }

    /// The band between suspension and elastic modes, from all responses together.
    fn find_band(&self, decay: f64) -> Result<[f64; 2]> {
        let frequencies = self.common_frequencies()?;
        let mut squares = vec![0.0; frequencies.len()];
        for response in self.hits.iter().flatten() {
            for (sum, (_, h)) in squares.iter_mut().zip(&response.points) {
                *sum += h.norm_sqr();
            }
        }
        let band = find_band(&squares, |line| frequencies[line], decay);
        band.map(|band| band.ends).ok_or_else(|| {
            Error::input(
                "band_not_found",
                "the responses show no band between suspension and elastic modes; set test.band_hz",
            )
        })
    }

    /// The correlation of neighbouring bins that the window causes; the length of the record follows from the
    /// spacing of the bins.
    fn correlation(&self, decay: f64) -> f64 {
        let points = self.hits.iter().flatten().map(|response| &response.points);
        let spacing = points.filter_map(|points| match points.as_slice() {
            [(first, _), .., (last, _)] => Some((last - first) / (points.len() - 1) as f64),
            _ => None,
        });
        let closest = spacing.filter(|s| *s > 0.0).fold(f64::INFINITY, f64::min);
        window_correlation(decay, closest.recip())
    }

    /// The accelerances bin by bin: hit by hit, response by response.
    pub(super) fn accelerances(&self) -> impl Iterator<Item = Vec<Vec<Complex<f64>>>> + '_ {
        let of_response = |response: &Response| response.points.iter().map(|(_, h)| *h).collect();
        self.hits.iter().map(move |responses| responses.iter().map(of_response).collect())
    }

    /// The frequencies that all responses must share.
    pub(super) fn common_frequencies(&self) -> Result<Vec<f64>> {
        let frequencies =
            |response: &Response| response.points.iter().map(|(f, _)| *f).collect::<Vec<_>>();
        let mut responses = self.hits.iter().flatten();
        let first = responses.next().map(frequencies).unwrap_or_default();
        match responses.find(|response| frequencies(response) != first) {
            None => Ok(first),
            Some(other) => Err(Error::input(
                "frequencies_differ",
                format!(
                    "the frequency response of {} (dataset {}) has other bins than the first; export all \
                     with the same bins, or set test.band_hz and use --method ml or irm",
                    other.name, other.dataset
                ),
            )),
        }
    }
}

impl Response {
    /// Fits the mass line of this response.
    fn fit(&self, fitting: &FitSettings<f64>) -> Result<ResponseFits<f64, Unbounded>> {
        let lines = self.points.iter().map(|&(frequency, _)| Bin { frequency, weight: 1.0 });
        let mut rows = vec![BasisRow::default(); self.points.len()];
        let h = |_, line: usize| self.points[line].1;
        ResponseFits::new(lines, fitting, 1, h, &mut rows).map_err(|error| {
            let [low, high] = fitting.band;
            let code = match error {
                MassLineError::BandTooNarrow => "band_too_narrow",
                MassLineError::NotFinite => "data_not_finite",
                _ => "uff_corrupt",
            };
            let inside = self.points.iter().filter(|(f, _)| low <= *f && *f <= high).count();
            let message = format!(
                "the frequency response of {} (dataset {}) has {inside} bins within {low} to {high} Hz: \
                 {error}; change test.band_hz or export more bins",
                self.name, self.dataset,
            );
            Error::input(code, message)
        })
    }
}

/// The response of one sensor axis to one hit.
fn response(
    selection: &Selection<'_>,
    quantity: Option<Quantity>,
    pair: &Pair,
    reading: &mut Reading,
) -> Result<Response> {
    let function = selection.find(pair)?;
    let (frf, understood) = function.converted(quantity)?;
    reading.add(&frf, &understood);
    let sign = sign(function.response) * sign(function.reference) * pair.hit.sign.factor();
    let (name, dataset) = (pair.name(), function.dataset);
    let points = points(&frf, sign);
    if points.iter().all(|(_, h)| h.norm_sqr() == 0.0) {
        let message = format!(
            "the frequency response of {name} (dataset {dataset}) is zero at every line: its channel is dead; check \
             the cable, or take the sensor or the hit out of the layout"
        );
        return Err(Error::input("channel_dead", message));
    }
    Ok(Response { name, dataset, points })
}

/// Frequencies and accelerances above 0 Hz, ascending.
fn points(frf: &Frf, sign: f64) -> Vec<(f64, Complex<f64>)> {
    let pairs = frf.frequency_hz.iter().copied().zip(frf.accelerance.iter().copied());
    // A receptance gives no accelerance at 0 Hz.
    let mut points: Vec<_> = pairs.filter(|(f, _)| *f != 0.0).map(|(f, h)| (f, h * sign)).collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

fn sign(place: NodeDirection) -> f64 {
    if place.direction < 0 { -1.0 } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_files::layout_file::LayoutFile;

    const LAYOUT: &str = include_str!("../../examples/three-bar-test-1.toml");
    /// σ of the window, 1/s, and length of the record, s.
    const DECAY: f64 = 10.0;
    const RECORD: f64 = 0.512;

    /// Equal responses: 2 (m/s²)/N above a suspension, with some noise.
    fn measured() -> (HostLayout, LayoutResponses) {
        let layout = LayoutFile::parse(LAYOUT, "test.toml").unwrap().layout;
        let points: Vec<_> = (1..100)
            .map(|k| {
                let frequency = f64::from(k) / RECORD;
                let s = Complex::new(DECAY, core::f64::consts::TAU * frequency);
                let noise = if k % 2 == 0 { 1e-6 } else { -1e-6 };
                (frequency, Complex::new(2.0, 0.0) + Complex::new(800.0, 0.0) / (s * s) + noise)
            })
            .collect();
        let response = || Response { name: String::new(), dataset: 1, points: points.clone() };
        let of_hit = || (0..9).map(|_| response()).collect();
        let hits = layout.hits.iter().map(|_| of_hit()).collect();
        (layout, LayoutResponses { hits, reading: Reading::default() })
    }

    /// With the σ of the window the fit is exact except for the noise of 1e-6; without it, the residual is a
    /// hundred times larger.
    #[test]
    fn an_exponential_window_is_taken_out_exactly() {
        let (layout, responses) = measured();
        let error = |decay: f64| {
            let lines = responses.mass_lines(&layout, decay).unwrap().lines;
            (lines[0].1.accelerance[0] - 2.0).abs()
        };
        assert!(error(DECAY) < 1e-6, "{}", error(DECAY));
        assert!(error(0.0) > 1e-4, "{}", error(0.0));
    }

    #[test]
    fn the_window_correlates_lines() {
        let (layout, responses) = measured();
        let sigma = responses.mass_lines(&layout, DECAY).unwrap().lines[0].1.noise[0];
        // 5.12 is σ T; theory, section 5.
        assert!((responses.correlation(DECAY) - window_correlation(DECAY, RECORD)).abs() < 1e-9);
        assert!((responses.correlation(DECAY) - 5.12_f64.sqrt()).abs() < 1e-3);
        assert!(sigma > 0.0);
    }
}
