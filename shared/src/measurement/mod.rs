//! A measurement from scans to a result: a state machine without inputs and outputs of its own.
//!
//! Whoever drives it asks for a [`Wish`], does it, and reports what came of it. The operator's commands come in
//! between at any time. The machine waits for nothing and knows no flash, link, screen or clock; each call does
//! a bounded piece of work.
//!
//! ```text
//!               start, command                     wish ──▶ Rest:  until a command comes
//!                     │                                     Scans: sampling_started, feed, lost, stopped
//! set_layout ──▶ Measurement ──▶ hits, status, result       Work:  work
//!                     │                                     Keep:  keep the result; stored, not_stored
//!                 Memory (lent)
//!
//! scans ─▶ capture ─▶ grade ─▶ spectra ─▶ average ─▶ mass lines ─▶ identify ─▶ result
//! ```
//! A rig drives it in single precision, a Monte Carlo study in double precision.
//!
//! | module | subject |
//! | --- | --- |
//! | [`campaign`] | which degree of freedom is hit next, and what a verdict leads to |
//! | [`averaging`] | one hit DOF from its hits to its mass lines |
//! | `hits` | from scans to an averaged hit |
//! | `closing` | from averaged hits to mass lines, and from these to the answers |

pub mod averaging;
pub mod campaign;
mod closing;
mod hits;
mod memory;
mod result;

pub use memory::Memory;
pub use result::{BlockResult, MeasuredDof, TestResult};

use heapless::Deque;

use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::{Applicability, DofMassLines, Method, Methods};
use crate::layout::{Layout, RIG_HITS, RIG_SENSORS, assumed_body, check_settings};
use crate::signal::{AdcProperties, Calibration, RECORD_SCANS, RealFft, Record, SPECTRUM_LINES};
use crate::units::ScanIndex;
use averaging::DofSpectra;
use campaign::{Campaign, CampaignProgress, Command, CommandError, Object, Phase, Start, Step};
use hits::Task;

/// A layout of a rig in a precision.
pub type TestLayout<R> = Layout<R, RIG_SENSORS, RIG_HITS>;

/// Graded hits that wait to be fetched.
const EVENTS: usize = 4;
/// Losses of scans in a row, without a block between them, that a converter is given up after.
pub const LOSSES_TO_STOP: u8 = 3;

/// What is to be done next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Nothing until a command comes.
    Rest,
    /// Sample: start the sampler, say so with [`Measurement::sampling_started`], and feed it with scans until the
    /// wish is another one.
    Scans,
    /// Time to compute: [`Measurement::work`].
    Work,
    /// Keep [`Measurement::result`], then report [`Measurement::stored`] or [`Measurement::not_stored`].
    Keep,
}

/// What a rig is doing: one thing at a time.
#[derive(Clone, Debug)]
enum Activity<R> {
    /// Nothing.
    Idle,
    /// Its layout or calibration is being replaced.
    Changing,
    /// It fills the record with what the channels read without a hit.
    Reading,
    /// It passes all scans on, through the record as a ring.
    Streaming(Streamed),
    /// It carries out a campaign.
    Measuring(Campaign, Task<R>),
}

/// How far a stream of scans has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Streamed {
    /// Index of the scan after the last one taken.
    pub end: u64,
    /// Scans taken without a gap.
    pub held: u64,
}

/// What the record holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Recorded {
    /// Nothing whole.
    Nothing,
    /// The hit of this number.
    Hit(u32),
    /// What the channels read without a hit.
    Reading,
    /// Nothing: the converter stopped while it was to be a reading without a hit.
    ReadingFailed,
}

/// A hit that was graded. A later one of the same number takes its place: the hit was good by itself and was
/// withdrawn after it had been compared with the other hits at its DOF.
#[derive(Clone, Debug, PartialEq)]
pub struct GradedHit {
    /// Counts the hits, from 1.
    pub number: u32,
    /// Index of the DOF that was hit.
    pub dof: u8,
    /// True when nothing was found that rejects it.
    pub good: bool,
    /// Scan of the trigger.
    pub scan: u64,
    /// Peak force, N.
    pub peak_force: f32,
    /// Largest acceleration of any channel, m/s².
    pub peak_acceleration: f32,
    /// What the grading found.
    pub findings: Diagnostics,
}

/// Why a campaign was not started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartError {
    /// Layout or calibration are being replaced.
    Busy,
    /// There is no layout.
    NoLayout,
    /// The layout has an error: [`Measurement::check`].
    LayoutRefused,
    /// There is no room for its result.
    NoRoom,
    /// Something else is going on.
    WrongPhase,
}

/// What has been counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Scans taken.
    pub scans: u64,
    /// Scans lost.
    pub scans_lost: u64,
    /// Times that scans were lost.
    pub overruns: u32,
    /// Triggers.
    pub triggers: u32,
    /// Hits aborted because scans of their record were lost.
    pub hits_aborted: u32,
    /// Graded hits that nobody fetched in time.
    pub events_dropped: u32,
}

/// A measurement over memory that is lent to it.
pub struct Measurement<'m, R> {
    adc: AdcProperties,
    calibration: Calibration,
    layout: Option<TestLayout<R>>,
    activity: Activity<R>,
    /// The campaign that ended last, while nothing has taken its place.
    ended: Option<Campaign>,
    recorded: Recorded,
    /// Index of the DOF whose hits are averaged in the spectra.
    averaged: Option<u8>,
    /// Fingerprint of the record graded last.
    last_record: Option<u32>,
    /// The hit graded last in this campaign.
    last_hit: Option<GradedHit>,
    hits: u32,
    armings: u32,
    campaigns: u32,
    /// Losses of scans in a row.
    losses: u8,
    events: Deque<GradedHit, EVENTS>,
    block: Option<BlockResult>,
    diagnostics: Diagnostics,
    counts: Counts,
    memory: &'m mut Memory<R>,
}

impl<'m, R: RealFft> Measurement<'m, R> {
    /// Nothing is measured yet; without a layout, and with the calibration of the data sheets.
    pub fn new(adc: AdcProperties, memory: &'m mut Memory<R>) -> Self {
        Self {
            adc,
            calibration: Calibration::default(),
            layout: None,
            activity: Activity::Idle,
            ended: None,
            recorded: Recorded::Nothing,
            averaged: None,
            last_record: None,
            last_hit: None,
            hits: 0,
            armings: 0,
            campaigns: 0,
            losses: 0,
            events: Deque::new(),
            block: None,
            diagnostics: Diagnostics::new(),
            counts: Counts::default(),
            memory,
        }
    }

    /// What is to be done next.
    pub fn wish(&self) -> Wish {
        match &self.activity {
            Activity::Idle | Activity::Changing => Wish::Rest,
            Activity::Reading | Activity::Streaming(_) => Wish::Scans,
            Activity::Measuring(campaign, task) => match (campaign.step(), task) {
                (_, Task::Capture { .. }) | (Step::AwaitHit { .. }, Task::None) => Wish::Scans,
                (_, Task::Grade { .. }) => Wish::Work,
                (Step::Rest | Step::AwaitHit { .. }, _) => Wish::Rest,
                (Step::Identify, Task::Identified) => Wish::Keep,
                _ => Wish::Work,
            },
        }
    }

    /// Does a bounded piece of the computing that is wanted. On a rig at most a million instructions.
    pub fn work(&mut self) {
        let Activity::Measuring(mut campaign, task) = self.take_activity() else { return };
        let task = match (campaign.step(), task) {
            (_, Task::Grade { trigger }) => self.grade_hit(&mut campaign, trigger),
            (Step::Analyse { dof }, task) => self.average_hit(&mut campaign, dof, task),
            (Step::CloseDof { dof }, _) => {
                self.close_dof(dof);
                campaign.dof_closed();
                Task::None
            }
            (Step::Identify, task) => self.identify(&campaign, task),
            (Step::Rest | Step::AwaitHit { .. }, task) => task,
        };
        self.activity = Activity::Measuring(campaign, task);
    }

    // Layout and calibration.

    /// Reserves layout and calibration for a change that takes time: until [`Self::end_change`] nothing is
    /// started.
    ///
    /// # Errors
    /// [`StartError::WrongPhase`] unless nothing is measured, [`StartError::Busy`] during another change.
    pub fn begin_change(&mut self) -> Result<(), StartError> {
        match self.activity {
            Activity::Idle => {
                self.activity = Activity::Changing;
                Ok(())
            }
            Activity::Changing => Err(StartError::Busy),
            _ => Err(StartError::WrongPhase),
        }
    }

    /// Ends a change.
    pub fn end_change(&mut self) {
        if let Activity::Changing = self.activity {
            self.activity = Activity::Idle;
        }
    }

    /// Takes a layout into use; what was said and measured under an earlier one is forgotten. Only while
    /// nothing is measured.
    pub fn set_layout(&mut self, layout: TestLayout<R>) {
        self.ended = None;
        self.diagnostics.clear();
        self.averaged = None;
        self.last_hit = None;
        self.block = None;
        self.memory.forget_campaign();
        self.layout = Some(layout);
    }

    /// The layout in use.
    pub fn layout(&self) -> Option<&TestLayout<R>> {
        self.layout.as_ref()
    }

    /// Takes a calibration into use. Only while nothing is measured.
    pub fn set_calibration(&mut self, calibration: Calibration) {
        self.calibration = calibration;
        // What a block has said was about the calibration of before.
        self.block = None;
    }

    /// The calibration in force.
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// The converter.
    pub fn adc(&self) -> &AdcProperties {
        &self.adc
    }

    /// The converter with only those channels that the layout has sensors for.
    pub fn adc_in_use(&self) -> AdcProperties {
        let sensors = self.layout.as_ref().map_or(0, |layout| layout.sensors.len());
        let responses = self.adc.responses().min(3 * sensors);
        AdcProperties { channels: responses as u8 + 1, ..self.adc }
    }

    /// What is to be said about a layout: errors when no method of a rig could give an answer, or when the
    /// converter cannot do it. The object is not known yet: any body about the sensors and hits tells what
    /// can be determined.
    pub fn check(&self, layout: &TestLayout<R>) -> Diagnostics {
        let sensors = layout.sensors.iter().map(|sensor| sensor.position);
        let places = sensors.chain(layout.hits.iter().map(|hit| hit.position));
        let methods: Methods = Method::of_mass_lines().collect();
        let body = assumed_body(None, places);
        let mut diagnostics = Applicability::new(layout, &body, &methods).diagnostics;
        let rate = R::of(f64::from(self.adc.rate.0));
        for found in check_settings(&layout.test, rate, RECORD_SCANS, SPECTRUM_LINES) {
            note(&mut diagnostics, found);
        }
        if layout.sensors.len() * 3 > self.adc.responses() {
            let channels = self.adc.responses() as f32;
            let missing = Diagnostic::whole(Code::SettingOutOfRange, Severity::Error, channels);
            note(&mut diagnostics, missing);
        }
        diagnostics
    }

    // The campaign.

    /// Starts a campaign; a paused one is forgotten. `force` begins although the layout has an error that only
    /// takes the answer away; `room` says that there is room for its result.
    ///
    /// # Errors
    /// Why it was not started; nothing has changed then.
    pub fn start(&mut self, start: Start, force: bool, room: bool) -> Result<(), StartError> {
        if let Activity::Changing = self.activity {
            return Err(StartError::Busy);
        }
        let layout = self.layout.as_ref().ok_or(StartError::NoLayout)?;
        let mut findings = self.check(layout);
        if let Object::Block { .. } = start.object {
            // Hits through the centre of mass determine no ten properties, and need not.
            findings.retain(|found| !can_be_forced(found));
            note(&mut findings, Diagnostic::whole(Code::BlockTest, Severity::Note, 0.0));
        }
        let refuses = |found: &Diagnostic| found.is_error() && !(force && can_be_forced(found));
        if findings.iter().any(refuses) {
            return Err(StartError::LayoutRefused);
        }
        if !room {
            return Err(StartError::NoRoom);
        }
        match &self.activity {
            Activity::Idle => {}
            Activity::Measuring(campaign, _) if campaign.gives_way() => {}
            _ => return Err(StartError::WrongPhase),
        }
        let campaign = Campaign::new(layout.hits.len(), layout.test.hits_per_dof, start);
        self.begin(campaign.map_err(|_| StartError::NoLayout)?, findings);
        Ok(())
    }

    /// Takes up a campaign that a cut of the power has ended: paused, with what was measured of its finished
    /// DOFs. A finished DOF whose mass lines are not there is measured again; mass lines of one that is not
    /// finished are left out.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] unless nothing is measured, [`CommandError::NoDofs`] when it is none of
    /// this layout.
    pub fn resume(
        &mut self,
        mut progress: CampaignProgress,
        dofs: impl IntoIterator<Item = (MeasuredDof<R>, DofMassLines<R, RIG_SENSORS>)>,
        measured: impl Fn(usize) -> bool,
        diagnostics: Diagnostics,
    ) -> Result<(), CommandError> {
        if !matches!(self.activity, Activity::Idle) {
            return Err(CommandError::WrongPhase);
        }
        if self.layout.as_ref().is_none_or(|layout| layout.hits.len() != progress.dofs.len()) {
            return Err(CommandError::NoDofs);
        }
        self.memory.forget_campaign();
        for (details, lines) in dofs {
            let finished = progress.dofs.get(lines.0).is_some_and(|dof| dof.is_finished());
            if finished {
                self.memory.keep_dof(details, lines);
            }
        }
        for (index, dof) in progress.dofs.iter_mut().enumerate() {
            let there = self.memory.mass_lines.iter().any(|(of, _)| *of == index);
            if measured(index) && !there {
                *dof = campaign::DofProgress::OPEN;
            }
        }
        self.take_up(Campaign::resume(progress)?, diagnostics);
        Ok(())
    }

    /// Executes a command of the operator.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] when it has no meaning now; nothing has changed then.
    pub fn command(&mut self, command: Command) -> Result<(), CommandError> {
        let Activity::Measuring(campaign, task) = &mut self.activity else {
            return Err(CommandError::WrongPhase);
        };
        let dof = campaign.dof();
        campaign.command(command)?;
        // A record that is being taken is dropped: whatever was wanted has changed.
        if let Task::Capture { .. } | Task::Grade { .. } = task {
            *task = Task::None;
        }
        match command {
            Command::Redo => {
                self.averaged = None;
                self.memory.forget_dof(dof);
            }
            // What had interrupted the campaign is tried again.
            Command::Resume => self.diagnostics.retain(|found| !found.interrupts()),
            Command::Abort => self.activity = Activity::Idle,
            _ => {}
        }
        Ok(())
    }

    /// What has been finished of the campaign; `None` unless one is running.
    pub fn progress(&self) -> Option<CampaignProgress> {
        self.running().and_then(Campaign::progress)
    }

    /// The result is kept under this number.
    pub fn stored(&mut self, number: u32) {
        let Activity::Measuring(mut campaign, _) = self.take_activity() else { return };
        campaign.identified(number);
        self.ended = Some(campaign);
    }

    /// The result could not be kept: the campaign is interrupted, and `Resume` tries again.
    pub fn not_stored(&mut self) {
        if let Activity::Measuring(campaign, _) = &mut self.activity {
            campaign.not_stored();
            let code = Code::ResultNotStored;
            note(&mut self.diagnostics, Diagnostic::whole(code, Severity::Error, 0.0));
        }
    }

    fn begin(&mut self, campaign: Campaign, diagnostics: Diagnostics) {
        self.memory.forget_campaign();
        self.take_up(campaign, diagnostics);
    }

    fn take_up(&mut self, campaign: Campaign, diagnostics: Diagnostics) {
        self.campaigns = self.campaigns.wrapping_add(1);
        self.ended = None;
        self.last_hit = None;
        self.block = None;
        self.diagnostics = diagnostics;
        self.activity = Activity::Measuring(campaign, Task::None);
    }

    // What else the channels are read for.

    /// Wants the record filled with what the channels read without a hit.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] unless nothing is measured.
    pub fn take_reading(&mut self) -> Result<(), CommandError> {
        self.leave_idle(Activity::Reading)
    }

    /// Wants no reading any longer.
    pub fn drop_reading(&mut self) {
        if let Activity::Reading = self.activity {
            self.activity = Activity::Idle;
        }
    }

    /// Wants all scans passed on, or no longer.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] unless nothing is measured.
    pub fn set_stream(&mut self, on: bool) -> Result<(), CommandError> {
        match (&self.activity, on) {
            (Activity::Streaming(_), true) => Ok(()),
            (Activity::Streaming(_), false) => {
                self.activity = Activity::Idle;
                Ok(())
            }
            (_, true) => self.leave_idle(Activity::Streaming(Streamed::default())),
            (_, false) => Ok(()),
        }
    }

    fn leave_idle(&mut self, activity: Activity<R>) -> Result<(), CommandError> {
        if !matches!(self.activity, Activity::Idle) {
            return Err(CommandError::WrongPhase);
        }
        self.recorded = Recorded::Nothing;
        self.activity = activity;
        Ok(())
    }

    // What there is to see.

    /// What is shown of the rig.
    pub fn phase(&self) -> Phase {
        self.campaign().map_or(Phase::Idle, Campaign::phase)
    }

    /// The campaign that is running, else the one that ended last.
    pub fn campaign(&self) -> Option<&Campaign> {
        self.running().or(self.ended.as_ref())
    }

    fn running(&self) -> Option<&Campaign> {
        match &self.activity {
            Activity::Measuring(campaign, _) => Some(campaign),
            _ => None,
        }
    }

    /// True when layout, calibration and results may be changed: nothing is measured.
    pub fn is_idle(&self) -> bool {
        matches!(self.activity, Activity::Idle | Activity::Changing)
    }

    /// True when nothing is sampled or computed: idle or paused.
    pub fn rests(&self) -> bool {
        let paused = |campaign: &Campaign| campaign.phase() == Phase::Paused;
        self.is_idle() || (self.running().is_some_and(paused) && self.wish() == Wish::Rest)
    }

    /// How far the stream of scans has come; `None` without one.
    pub fn streamed(&self) -> Option<Streamed> {
        match self.activity {
            Activity::Streaming(streamed) => Some(streamed),
            _ => None,
        }
    }

    /// True while a reading without a hit is being taken.
    pub fn reads(&self) -> bool {
        matches!(self.activity, Activity::Reading)
    }

    /// What the record holds.
    pub fn recorded(&self) -> Recorded {
        self.recorded
    }

    /// The record. It is whole when [`Self::recorded`] says so.
    pub fn record(&self) -> &Record {
        &self.memory.record
    }

    /// The averaged spectra and the index of their DOF.
    pub fn spectra(&self) -> Option<(u8, &DofSpectra<R>)> {
        Some((self.averaged?, &self.memory.spectra))
    }

    /// The hit graded last in this campaign.
    pub fn last_hit(&self) -> Option<&GradedHit> {
        self.last_hit.as_ref()
    }

    /// The next graded hit that has not been fetched.
    pub fn next_hit(&mut self) -> Option<GradedHit> {
        self.events.pop_front()
    }

    /// True when graded hits wait to be fetched.
    pub fn has_hits(&self) -> bool {
        !self.events.is_empty()
    }

    /// Hits graded.
    pub fn hits(&self) -> u32 {
        self.hits
    }

    /// Times that the hammer has been waited for.
    pub fn armings(&self) -> u32 {
        self.armings
    }

    /// Campaigns begun.
    pub fn campaigns(&self) -> u32 {
        self.campaigns
    }

    /// What has been counted.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What is to be said about the campaign.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// What has been measured and identified so far.
    pub fn result(&self) -> TestResult<'_, R> {
        TestResult {
            dofs: &self.memory.dofs,
            mass_lines: &self.memory.mass_lines,
            estimates: self.memory.identification.estimates(),
            refusals: self.memory.identification.refusals(),
            block: self.block,
            diagnostics: &self.diagnostics,
        }
    }

    // Between the parts.

    fn take_activity(&mut self) -> Activity<R> {
        core::mem::replace(&mut self.activity, Activity::Idle)
    }

    fn say(&mut self, diagnostic: Diagnostic) {
        note(&mut self.diagnostics, diagnostic);
    }

    /// Queues a graded hit; the oldest goes when nobody fetches them.
    fn report(&mut self, hit: GradedHit) {
        if self.events.is_full() {
            self.events.pop_front();
            self.counts.events_dropped += 1;
        }
        // There is room: one was taken out above.
        let _ = self.events.push_back(hit);
    }
}

/// True for a fact of the layout that only takes the answer away; a setting that a rig cannot work with is
/// never forced.
fn can_be_forced(diagnostic: &Diagnostic) -> bool {
    let never = [Code::SettingOutOfRange, Code::LayoutNotFinite, Code::AxesNotOrthonormal];
    !never.contains(&diagnostic.code)
}

/// Adds a diagnostic; of one that is there already the graver stays, of two as grave the one with the larger
/// number. In a full list an error takes the place of something lesser; anything else is left out.
pub fn note(list: &mut Diagnostics, diagnostic: Diagnostic) {
    let same = |d: &&mut Diagnostic| d.code == diagnostic.code && d.subject == diagnostic.subject;
    if let Some(known) = list.iter_mut().find(same) {
        let rank = |d: &Diagnostic| (d.severity, d.value.abs());
        if rank(&diagnostic) > rank(known) {
            *known = diagnostic;
        }
        return;
    }
    if list.push(diagnostic).is_ok() || !diagnostic.is_error() {
        return;
    }
    if let Some(lesser) = list.iter_mut().rev().find(|d| !d.is_error()) {
        *lesser = diagnostic;
    }
}

#[cfg(test)]
mod tests;
