//! Processes scans into averaged hits: capture, grading, averaging, comparison with the repeat hits.

use super::averaged_hit::AveragedHit;
use super::averaging::{self, Change, ExpectedHit, HitAverager, ProcessingSettings};
use super::campaign::{Campaign, Phase, Step};
use super::capturing::HitCapture;
use super::listening::HumProgress;
use super::long_hit::LongHitAverager;
use super::{
    Activity, GradedHit, LOSSES_TO_STOP, Measurement, NextAction, RecordContent, ScanIndex,
    StreamProgress, note,
};
use crate::design::FurtherHitSearch;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::identify::ScatterAccumulator;
use crate::layout::{HitPolicy, HitTreatment, RIG_SENSORS, TestProfile};
use crate::real::Real;
use crate::signal::{
    CaptureState, FftError, FullRateExtremes, HitAgreement, HitReport, RECORD_SCANS, RealFft, Scan,
    grade, grade_long,
};
use crate::units::Newtons;

/// Progress within the current step of the campaign.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one at a time, and no allocator")]
pub(super) enum Task<R: Real> {
    /// The step has not begun.
    None,
    /// The sampler runs; `trigger` is the scan of the trigger once it has fired.
    Capture { capture: HitCapture, trigger: Option<ScanIndex> },
    /// The record is complete.
    Grade { trigger: ScanIndex, extremes: Option<FullRateExtremes> },
    /// The record is searched for hum.
    Listen(HumProgress<R>),
    /// The responses before `next` are averaged, or removed if the hit is undone.
    Average { hit: AveragedHit<R>, next: usize },
    /// The hit is an outlier: the responses before `next` have been removed again.
    Withdraw { hit: AveragedHit<R>, next: usize, why: Diagnostic },
    /// The driver stores the lines of the DOF.
    StoreLines,
    /// The identification methods are running.
    Identify,
    /// A further hit is searched for.
    Search(FurtherHitSearch<R>),
    /// The estimate is complete.
    Identified,
}

impl<R: RealFft> Measurement<'_, R> {
    /// Reports that the sampler has started, as [`NextAction::Sample`] requires; scans follow. No effect when the
    /// next action has changed meanwhile.
    pub fn sampling_started(&mut self) {
        if self.next_action() != NextAction::Sample {
            return;
        }
        self.save_record();
        let profile = self.profile();
        if let Activity::Measuring(campaign, task) = &mut self.activity {
            self.memory.record.begin_wait();
            let test = self.layout.as_ref().map(|layout| &layout.test);
            let level = Newtons(test.map_or(0.0, |test| test.trigger_n.to_f32()));
            let capture = HitCapture::new(&self.adc, &self.calibration, level, profile);
            *task = Task::Capture { capture, trigger: None };
            campaign.armed();
            self.armings = self.armings.wrapping_add(1);
        } else {
            self.memory.record.clear();
        }
    }

    /// Takes consecutive scans; `first` is the index of the first of them. Scans after a change of the next action
    /// are ignored.
    pub fn feed(&mut self, first: ScanIndex, scans: &[Scan]) {
        self.losses = 0;
        self.counts.scans += scans.len() as u64;
        let record = &mut self.memory.record;
        match &mut self.activity {
            Activity::Idle | Activity::Changing => {}
            Activity::Reading => {
                scans.iter().for_each(|scan| record.push(scan));
                if record.len() >= RECORD_SCANS {
                    self.recorded = RecordContent::Reading;
                    self.activity = Activity::Idle;
                }
            }
            Activity::Streaming(streamed) => {
                scans.iter().for_each(|scan| record.push(scan));
                let count = scans.len() as u64;
                *streamed = StreamProgress { end: first.0 + count, held: streamed.held + count };
            }
            Activity::Measuring(..) => {
                for (scan, index) in scans.iter().zip(first.0..) {
                    if !self.capture(scan, ScanIndex(index)) {
                        break;
                    }
                }
            }
        }
    }

    /// Adds a scan to the record; false when no more are wanted.
    fn capture(&mut self, scan: &Scan, index: ScanIndex) -> bool {
        let Activity::Measuring(campaign, task) = &mut self.activity else { return false };
        let Task::Capture { capture, trigger } = task else { return false };
        match capture.feed(&mut self.memory.record, scan, index) {
            CaptureState::Waiting => {}
            CaptureState::Filling if trigger.is_some() => {}
            CaptureState::Filling => {
                *trigger = Some(index);
                self.last_accepted.overwritten();
                self.recorded = RecordContent::Nothing;
                self.counts.triggers += 1;
                campaign.triggered();
            }
            CaptureState::Complete { trigger_scan } => {
                *task = Task::Grade { trigger: trigger_scan, extremes: capture.extremes() };
                return false;
            }
            CaptureState::Broken => {
                self.lost(1);
                if self.next_action() == NextAction::Sample {
                    self.sampling_started();
                }
                return false;
            }
        }
        true
    }

    /// Reports that `scans` consecutive scans were lost and that the sampler has restarted. Before the
    /// trigger this costs only another arming.
    pub fn lost(&mut self, scans: u32) {
        self.counts.scans_lost += u64::from(scans);
        self.counts.overruns += 1;
        self.losses = self.losses.saturating_add(1);
        match &mut self.activity {
            Activity::Idle | Activity::Changing => {}
            // A stream continues after the gap.
            Activity::Streaming(streamed) => *streamed = StreamProgress::default(),
            _ if self.losses >= LOSSES_TO_STOP => self.stopped(),
            Activity::Reading => self.memory.record.clear(),
            Activity::Measuring(campaign, task) => {
                let trigger = match task {
                    Task::Capture { trigger, .. } => *trigger,
                    _ => None,
                };
                *task = Task::None;
                if campaign.phase() == Phase::Armed {
                    return;
                }
                campaign.record_lost();
                let dof = campaign.dof();
                self.counts.hits_aborted += 1;
                let mut findings = Diagnostics::new();
                let lost = Diagnostic::whole(Code::ScansLost, Severity::Error, scans as f32);
                note(&mut findings, lost);
                let report = HitReport { findings, ..HitReport::default() };
                self.report_hit(dof, trigger.unwrap_or_default(), report);
            }
        }
    }

    /// Reports that the converter does not respond: a campaign is interrupted, anything else ends.
    pub fn stopped(&mut self) {
        // The user may repair the converter and resume.
        self.losses = 0;
        match &mut self.activity {
            Activity::Idle | Activity::Changing => return,
            Activity::Reading => {
                self.recorded = RecordContent::ReadingFailed;
                self.activity = Activity::Idle;
                return;
            }
            Activity::Streaming(_) => self.activity = Activity::Idle,
            Activity::Measuring(campaign, task) => {
                *task = Task::None;
                campaign.interrupted();
            }
        }
        self.push_diagnostic(Diagnostic::whole(Code::SamplerStopped, Severity::Error, 0.0));
    }

    /// Grades the record.
    pub(super) fn grade_hit(
        &mut self,
        campaign: &mut Campaign,
        trigger: ScanIndex,
        extremes: Option<&FullRateExtremes>,
    ) -> Task<R> {
        let test = self.test().cast();
        let (adc, last) = (self.adc_in_use(), self.last_record);
        let (record, calibration) = (&self.memory.record, &self.calibration);
        let report = match extremes {
            Some(extremes) => {
                grade_long(record, (trigger, extremes), &adc, calibration, &test, last)
            }
            None => grade(record, &adc, calibration, &test, last),
        };
        self.last_record = Some(report.fingerprint);
        let good = report.good();
        let number = self.report_hit(campaign.dof(), trigger, report);
        self.recorded = RecordContent::Hit(number);
        campaign.graded(good);
        Task::None
    }

    /// Reports a hit and returns its number.
    fn report_hit(&mut self, dof: usize, trigger: ScanIndex, report: HitReport) -> u32 {
        self.hits = self.hits.wrapping_add(1);
        let hit = GradedHit {
            number: self.hits,
            dof: dof as u8,
            good: report.good(),
            scan: trigger.0,
            peak_force: report.peak_force.0,
            peak_acceleration: report.peak_acceleration.0,
            swing: report.swing,
            findings: report.findings,
        };
        self.last_hit = Some(hit.clone());
        self.report(hit);
        self.hits
    }

    /// Averages one part of the current record: the force, then each response, then the comparison with the repeat
    /// hits. An outlier is removed again when the policy requires it. A hit that is undone is removed part by part in
    /// the same way.
    pub(super) fn average_hit(
        &mut self,
        campaign: &mut Campaign,
        dof: usize,
        task: Task<R>,
    ) -> Task<R> {
        // The memory has the length of the record, so no transform fails.
        self.try_average_hit(campaign, dof, task).unwrap_or_else(|_| {
            campaign.withdrawn();
            self.finish_undo(campaign, None);
            Task::None
        })
    }

    fn try_average_hit(
        &mut self,
        campaign: &mut Campaign,
        dof: usize,
        task: Task<R>,
    ) -> Result<Task<R>, FftError> {
        let responses = self.adc_in_use().responses();
        let undoes = campaign.step() == Step::Undo;
        Ok(match task {
            Task::Average { mut hit, next } if next < responses => {
                let (record, spectra, memory) = self.memory.of_hit();
                hit.take_response(next, record, memory, spectra)?;
                Task::Average { hit, next: next + 1 }
            }
            Task::Average { hit, .. } if undoes => {
                self.finish_undo(campaign, Some(&hit));
                Task::None
            }
            Task::Average { hit, .. } => self.join(campaign, dof, hit),
            Task::Withdraw { hit, next, why } if next < responses => {
                let (record, spectra, memory) = self.memory.of_hit();
                hit.remove_response(next, record, memory, spectra)?;
                Task::Withdraw { hit, next: next + 1, why }
            }
            Task::Withdraw { why, .. } => {
                campaign.withdrawn();
                self.report_again(why);
                Task::None
            }
            Task::Listen(HumProgress::Done(hum)) => {
                if !undoes && campaign.accepted() == 0 {
                    self.open_dof(dof);
                }
                let (adc, test) = (self.adc_in_use(), self.test());
                let settings =
                    ProcessingSettings { adc: &adc, calibration: &self.calibration, test: &test };
                let expected = ExpectedHit { hum, scatter: self.expected_scatter(dof) };
                let change = if undoes { Change::Remove } else { Change::Add };
                let trigger = ScanIndex(self.last_hit.as_ref().map_or(0, |hit| hit.scan));
                let (record, spectra, memory) = self.memory.of_hit();
                let to = (change, spectra);
                let hit = match test.profile {
                    TestProfile::MassLine => AveragedHit::MassLine(HitAverager::begin(
                        settings, record, expected, memory, to,
                    )?),
                    TestProfile::Suspension => AveragedHit::Long(LongHitAverager::begin(
                        settings,
                        (record, trigger),
                        memory,
                        to,
                    )),
                };
                Task::Average { hit, next: 0 }
            }
            // A hit that is undone was not unsteady when it was accepted.
            Task::Listen(HumProgress::Unsteady(_)) if undoes => {
                self.finish_undo(campaign, None);
                Task::None
            }
            Task::Listen(HumProgress::Unsteady(why)) => {
                campaign.withdrawn();
                self.report_again(why);
                Task::None
            }
            Task::Listen(listening) => Task::Listen(self.listen(listening)),
            _ => {
                if !undoes {
                    self.keep_before_hit(campaign.accepted());
                }
                Task::Listen(self.begin_listening())
            }
        })
    }

    /// Compares the averaged hit with its repeat hits. A hit without mass lines of its own does not
    /// contribute to the scatter.
    fn join(&mut self, campaign: &mut Campaign, dof: usize, hit: AveragedHit<R>) -> Task<R> {
        let policy = self.test().policy;
        let standing = match &hit {
            AveragedHit::MassLine(hit) => self.join_mass_lines(hit, policy),
            AveragedHit::Long(hit) => hit.standing(self.memory.known_line_scatter()),
        };
        let treatment = standing.treatment(policy);
        let about = |code: Code, severity: Severity, distance: R| {
            Diagnostic::about(code, severity, Subject::hit(dof), distance.to_f32())
        };
        match standing {
            // The DOF starts again with the next hit, or with this one.
            HitAgreement::Inconsistent(distance) if treatment == HitTreatment::Reject => {
                campaign.drop_inconsistent_pair();
                self.drop_diagnostics_of_dof();
                self.drop_averages(about(Code::HitsDisagree, Severity::Error, distance));
            }
            HitAgreement::OthersInconsistent(distance) if treatment == HitTreatment::Reject => {
                campaign.drop_hits_before();
                self.drop_diagnostics_of_dof();
                self.drop_averages(about(Code::HitsDisagree, Severity::Warning, distance));
            }
            _ => {
                if let Some((code, distance)) = standing.finding() {
                    let why = about(code, treatment.severity(), distance);
                    if treatment == HitTreatment::Reject {
                        self.memory.spectra.remove_force(&self.memory.force);
                        return Task::Withdraw { hit, next: 0, why };
                    }
                    self.push_diagnostic(why);
                    self.report_again(why);
                }
                self.last_accepted.accept(dof);
                campaign.analysed();
            }
        }
        Task::None
    }

    /// Forgets the averages of the DOF, and says why.
    fn drop_averages(&mut self, why: Diagnostic) {
        self.averaged = None;
        self.last_accepted.forget();
        self.report_again(why);
    }

    /// Compares the mass lines of a hit with those of its repeat hits, and adds them unless it disagrees.
    fn join_mass_lines(&mut self, hit: &HitAverager<R>, policy: HitPolicy) -> HitAgreement<R> {
        let Some(own) = hit.mass_lines(&self.calibration) else { return HitAgreement::Agrees };
        let elsewhere = averaging::known_scatter(&self.memory.mass_lines);
        let others =
            self.memory.single_hits.get_or_insert_with(|| ScatterAccumulator::new(RIG_SENSORS));
        let force = hit.squared_force(&self.memory.record, &own, others);
        averaging::join(others, &own, force, elsewhere, policy)
    }

    /// Reports the current hit again, after what was found when it had passed its own grading; an error rejects it.
    pub(super) fn report_again(&mut self, finding: Diagnostic) {
        let Some(mut hit) = self.last_hit.take() else { return };
        hit.good &= !finding.is_error();
        note(&mut hit.findings, finding);
        self.last_hit = Some(hit.clone());
        self.report(hit);
    }

    /// Discards the hits of the previous DOF and starts this one.
    fn open_dof(&mut self, dof: usize) {
        self.memory.spectra.clear();
        self.memory.single_hits = None;
        self.averaged = Some(dof as u8);
    }
}
