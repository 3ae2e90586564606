//! Looks for mains hum in the record of a hit, some channels at a time.

use super::Measurement;
use crate::diagnosis::{Diagnostic, Severity, Subject};
use crate::signal::{
    HAMMER, HitAnalysis, Hum, HumSearch, PRE_TRIGGER_SCANS, RECORD_SCANS, RealFft,
};

/// Channels that are searched in one step.
const CHANNELS: usize = 5;

/// Progress of the search.
#[derive(Clone, Debug)]
pub(super) enum Listening<R> {
    /// The channels before `next` are searched for the fundamental.
    Fundamental { search: HumSearch<R>, next: usize },
    /// There is hum; the harmonics of the channels before `next` are known.
    Harmonics { hum: Hum<R>, next: usize },
    /// The search is over.
    Done(Option<Hum<R>>),
}

impl<R: RealFft> Measurement<'_, R> {
    /// Starts a search in the current record.
    pub(super) fn begin_listening(&self) -> Listening<R> {
        let (adc, test) = (self.adc_in_use(), self.test());
        let analysis = HitAnalysis::new(&adc, &self.calibration, &test, PRE_TRIGGER_SCANS);
        match analysis.hum_search(RECORD_SCANS) {
            Some(search) => Listening::Fundamental { search, next: 0 },
            None => Listening::Done(None),
        }
    }

    /// One step of the search; reports hum when it is over.
    pub(super) fn listen(&mut self, listening: Listening<R>) -> Listening<R> {
        let count = self.adc_in_use().responses() + 1;
        let end_of = |next: usize| (next + CHANNELS).min(count);
        match listening {
            Listening::Fundamental { mut search, next } if next < count => {
                let end = end_of(next);
                (next..end).for_each(|channel| search.add(channel, self.memory.readings(channel)));
                Listening::Fundamental { search, next: end }
            }
            Listening::Fundamental { search, .. } => match search.found() {
                Some(hum) => Listening::Harmonics { hum, next: 0 },
                None => Listening::Done(None),
            },
            Listening::Harmonics { mut hum, next } if next < count => {
                let end = end_of(next);
                for channel in next..end {
                    hum.add_harmonics(channel, self.memory.readings(channel));
                }
                Listening::Harmonics { hum, next: end }
            }
            Listening::Harmonics { hum, .. } => {
                self.report_hum(&hum);
                Listening::Done(Some(hum))
            }
            done @ Listening::Done(_) => done,
        }
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
        let found = Diagnostic::about(hum.code, Severity::Warning, subject, amplitude(channel));
        // One channel is named: the loudest of all hits.
        match self.diagnostics.iter_mut().find(|known| known.code == hum.code) {
            Some(known) if known.value >= found.value => {}
            Some(known) => *known = found,
            None => self.push_diagnostic(found),
        }
    }
}
