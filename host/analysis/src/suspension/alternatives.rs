//! Other explanations of readings that a body on viscously damped springs does not explain: each is tried, and the one
//! that explains them is what is wrong.

use massline_shared::FrequencyResponses;
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::identify::global_fit::{Damping, GlobalFitSettings};
use massline_shared::layout::HostLayout;
use massline_shared::modes::Reduction;
use nalgebra::Complex;

use super::{GlobalAnswer, HostFit};

/// Most hits that are left out one by one.
const MOST_LEFT_OUT: usize = 6;
/// Decrease of χ² from which other readings are explained better: what a fit leaves over the noise scatters by 0.2 %
/// between tests, which is 35 of 8730 readings.
const OF_OTHER_READINGS: f64 = 70.0;
/// Least part of the lines that has to be left without the disturbed ones.
const LEAST_LEFT: f64 = 0.75;

/// A test whose readings want an explanation.
#[derive(Clone, Copy)]
pub(super) struct UnexplainedTest<'a, 'f> {
    pub(super) layout: &'a HostLayout,
    pub(super) fit: &'a HostFit<'f>,
    pub(super) readings: &'a FrequencyResponses<'a, f64>,
    /// Where the fits start.
    pub(super) start: &'a RigidBody<f64>,
    /// The damping of the suspension.
    pub(super) damping: Damping,
}

impl UnexplainedTest<'_, '_> {
    /// The global fit with structural damping, where that explains the readings.
    pub(super) fn structural(&self) -> Option<GlobalAnswer> {
        let settings =
            GlobalFitSettings { damping: Damping::Structural, ..GlobalFitSettings::default() };
        let answer =
            GlobalAnswer::of_real_converter(self.layout, self.readings, self.start, &settings)
                .ok()?;
        self.is_whole(&answer).then_some(answer)
    }

    /// The global fit without the lines that hum or the like disturbs, where the others are explained, with a warning
    /// that states the frequency.
    pub(super) fn undisturbed(&self) -> Option<GlobalAnswer> {
        let frequencies = self.readings.frequencies();
        let disturbed = self.fit.disturbed_lines();
        let first = *frequencies.get(*disturbed.first()?)?;
        let kept: Vec<usize> =
            (0..frequencies.len()).filter(|line| !disturbed.contains(line)).collect();
        if (kept.len() as f64) < LEAST_LEFT * frequencies.len() as f64 {
            return None;
        }
        let part = self.lines(&kept);
        let settings = GlobalFitSettings::default();
        let responses = part.responses()?;
        let mut answer =
            GlobalAnswer::of_real_converter(self.layout, &responses, self.start, &settings).ok()?;
        if !self.is_whole(&answer) {
            return None;
        }
        answer.lines = kept;
        let warning = Diagnostic::whole(Code::LinesDisturbed, Severity::Warning, first as f32);
        // There is room for sixteen diagnostics.
        let _ = answer.solution.estimate.diagnostics.push(warning);
        Some(answer)
    }

    /// The readings at these lines.
    pub(super) fn lines(&self, lines: &[usize]) -> Part {
        Part::of(self.readings, lines, &all(self.readings.hits()))
    }

    /// The finding about a hit without which the others are explained, and what the global fit then leaves over their
    /// own noise. `pulled` is the one that the global fit pulls most.
    pub(super) fn hit(
        &self,
        pulled: Option<usize>,
        only_pulled: bool,
    ) -> Option<(f64, Diagnostic)> {
        let hits = self.layout.hits.len();
        let has_errors =
            self.layout.hits.iter().any(|hit| hit.uncertainty.of_mean(1) != (0.0, 0.0));
        let tried: Vec<usize> = match pulled {
            Some(hit) => vec![hit],
            None if hits > MOST_LEFT_OUT || only_pulled && has_errors => Vec::new(),
            None => (0..hits).collect(),
        };
        let without = |hit: usize| {
            let mut layout = self.layout.clone();
            layout.hits.remove(hit);
            let kept: Vec<usize> = (0..hits).filter(|other| *other != hit).collect();
            let lines = all(self.readings.frequencies().len());
            let part = Part::of(self.readings, &lines, &kept);
            let readings = part.responses()?;
            let fit = HostFit::new(&layout, &readings, &mut Reduction::new()).ok()?;
            let answer = self.solved(&layout, &readings, 1)?;
            (answer.solution.extra_terms == 0 && answer.explains(&fit))
                .then(|| (answer.left_over(&fit), hit))
        };
        let (left, hit) =
            tried.into_iter().filter_map(without).min_by(|a, b| a.0.total_cmp(&b.0))?;
        let (code, subject) = (Code::HitContradictsOthers, Subject::hit(hit));
        Some((left, Diagnostic::about(code, Severity::Error, subject, 0.0)))
    }

    /// True when a fit of other readings leaves so much less than this one that noise would hardly make it.
    pub(super) fn is_much_less(&self, left: f64, than: f64) -> bool {
        ((than / left).powi(2) - 1.0) * self.independent_readings() > OF_OTHER_READINGS
    }

    /// True for a fit that explains the readings without extra terms.
    pub(super) fn is_whole(&self, answer: &GlobalAnswer) -> bool {
        answer.solution.extra_terms == 0 && answer.explains(self.fit)
    }

    /// The global fit under another layout, or of other readings.
    pub(super) fn solved(
        &self,
        layout: &HostLayout,
        readings: &FrequencyResponses<'_, f64>,
        most_extra_terms: usize,
    ) -> Option<GlobalAnswer> {
        let damping = self.damping;
        let settings =
            GlobalFitSettings { most_extra_terms, damping, ..GlobalFitSettings::default() };
        GlobalAnswer::of_even_noise(layout, readings, self.start, &settings).ok()
    }
}

fn all(count: usize) -> Vec<usize> {
    (0..count).collect()
}

/// Some lines and hits of the readings.
pub(super) struct Part {
    frequencies: Vec<f64>,
    accelerance: Vec<Complex<f64>>,
    channels: usize,
    hits: usize,
    decay: f64,
    correlation: f64,
}

impl Part {
    fn of(readings: &FrequencyResponses<'_, f64>, lines: &[usize], hits: &[usize]) -> Self {
        let channels = readings.channels();
        let frequencies = lines.iter().map(|line| readings.frequencies()[*line]).collect();
        let of_line = |line: &usize| {
            let line = *line;
            (0..channels).flat_map(move |channel| {
                hits.iter().map(move |hit| readings.at(line, channel, *hit))
            })
        };
        Self {
            frequencies,
            accelerance: lines.iter().flat_map(of_line).collect(),
            channels,
            hits: hits.len(),
            decay: readings.decay,
            correlation: readings.correlation,
        }
    }

    pub(super) fn responses(&self) -> Option<FrequencyResponses<'_, f64>> {
        let Self { frequencies, accelerance, channels, hits, decay, correlation } = self;
        let responses = FrequencyResponses::new(frequencies, accelerance, *channels, *hits)?;
        Some(responses.windowed(*decay, *correlation))
    }
}
