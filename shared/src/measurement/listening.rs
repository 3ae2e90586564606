//! Looks for mains hum in the record of a hit, some channels at a time.

use super::Measurement;
use super::averaging::HitMemory;
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::layout::TestProfile;
use crate::signal::{
    HAMMER, HitAnalysis, Hum, HumFit, HumSearch, PRE_TRIGGER_SCANS, RECORD_SCANS, RealFft,
};

/// Channels that are searched in one step.
const CHANNELS: usize = 5;
/// Largest share of the peak, of the force or of the largest response, that hum may leave behind.
const MOST_LEFT: f32 = 0.01;

/// Progress of the search.
#[derive(Clone, Debug)]
pub(super) enum HumProgress<R> {
    /// The channels before `next` are searched.
    Searching { search: HumSearch<R>, next: usize },
    /// There is hum; its amplitudes in the channels before `next` are known.
    Fitting { fit: HumFit<R>, next: usize },
    /// The search is over.
    Done(Option<Hum<R>>),
    /// There is hum that cannot be taken out.
    Unsteady(Diagnostic),
}

impl<R: RealFft> Measurement<'_, R> {
    /// Starts a search in the current record.
    pub(super) fn begin_listening(&self) -> HumProgress<R> {
        let (adc, test) = (self.adc_in_use(), self.test());
        if test.profile == TestProfile::Suspension {
            // The decimation takes out the harmonics of 50 and 60 Hz.
            return HumProgress::Done(None);
        }
        let analysis = HitAnalysis::new(&adc, &self.calibration, &test, PRE_TRIGGER_SCANS);
        match analysis.hum_search(RECORD_SCANS) {
            Some(search) => HumProgress::Searching { search, next: 0 },
            None => HumProgress::Done(None),
        }
    }

    /// One step of the search; reports hum when it is over.
    pub(super) fn listen(&mut self, listening: HumProgress<R>) -> HumProgress<R> {
        let count = self.adc_in_use().responses() + 1;
        let end_of = |next: usize| (next + CHANNELS).min(count);
        match listening {
            HumProgress::Searching { mut search, next } if next < count => {
                let end = end_of(next);
                let (record, _, HitMemory { scratch, .. }) = self.memory.of_hit();
                (next..end).for_each(|channel| search.add(record, channel, scratch));
                HumProgress::Searching { search, next: end }
            }
            HumProgress::Searching { search, .. } => match search.start_fit() {
                Some(fit) => HumProgress::Fitting { fit, next: 0 },
                None => HumProgress::Done(None),
            },
            HumProgress::Fitting { mut fit, next } if next < count => {
                let end = end_of(next);
                let (record, _, HitMemory { scratch, .. }) = self.memory.of_hit();
                (next..end).for_each(|channel| fit.add(record, channel, scratch));
                HumProgress::Fitting { fit, next: end }
            }
            HumProgress::Fitting { fit, .. } if !fit.is_there_before() => HumProgress::Done(None),
            HumProgress::Fitting { fit, .. } => match self.left_of_hum(&fit) {
                Some(unsteady) => HumProgress::Unsteady(unsteady),
                None => {
                    self.report_hum(fit.hum());
                    HumProgress::Done(Some(*fit.hum()))
                }
            },
            over @ (HumProgress::Done(_) | HumProgress::Unsteady(_)) => over,
        }
    }

    /// The channel in which too much is left of the hum when it is taken out.
    fn left_of_hum(&self, fit: &HumFit<R>) -> Option<Diagnostic> {
        let adc = self.adc_in_use();
        let hit = self.last_hit.as_ref()?;
        let share = |channel: usize, left: f32| {
            left / if channel == HAMMER { hit.peak_force } else { hit.peak_acceleration }
        };
        let left = (0..=adc.responses()).map(|channel| {
            let per_code = self.calibration.per_code(&adc, channel).abs();
            (channel, fit.left(channel).to_f32() * per_code)
        });
        let (channel, most) = left.max_by(|a, b| share(a.0, a.1).total_cmp(&share(b.0, b.1)))?;
        let subject = Subject::channel(channel);
        let unsteady = Diagnostic::about(Code::HumUnsteady, Severity::Error, subject, most);
        (share(channel, most) > MOST_LEFT).then_some(unsteady)
    }

    /// Reports hum with its loudest channel.
    fn report_hum(&mut self, hum: &Hum<R>) {
        let adc = self.adc_in_use();
        let amplitude = |channel: usize| {
            hum.amplitude(channel).to_f32() * self.calibration.per_code(&adc, channel).abs()
        };
        let loudest = (1..=adc.responses()).max_by(|&a, &b| amplitude(a).total_cmp(&amplitude(b)));
        let channel = loudest.filter(|&k| amplitude(k) > 0.0).unwrap_or(HAMMER);
        let subject = Subject::channel(channel);
        let diagnostic =
            Diagnostic::about(hum.code, Severity::Warning, subject, amplitude(channel));
        // One channel is named: the loudest of all hits.
        match self.diagnostics.iter_mut().find(|known| known.code == hum.code) {
            Some(known) if known.value >= diagnostic.value => {}
            Some(known) => *known = diagnostic,
            None => self.push_diagnostic(diagnostic),
        }
    }
}
