//! Commands of the operator: campaigns, readings of the channels without a hit, streams of scans.

use super::campaign::{
    Campaign, CampaignProgress, Command, CommandError, DofProgress, Object, Start, Step,
};
use super::hits::Task;
use super::stored_lines::StoredLines;
use super::{
    Activity, MeasuredDof, Measurement, Memory, NextAction, RecordContent, StreamProgress, note,
};
use crate::capacity::Rig;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::DofMassLines;
use crate::real::Real;
use crate::signal::RealFft;
use crate::signal::self_test::SelfTest;

/// Data of a finished DOF, by which a campaign is restored.
#[derive(Clone, Debug, PartialEq)]
pub enum DofData<R: Real> {
    /// Its mass lines.
    MassLines(DofMassLines<R, Rig>),
    /// What is known of its stored lines, in the suspension profile.
    Lines(StoredLines<R>),
}

/// What is restored of a finished DOF.
pub type RestoredDof<R> = (MeasuredDof<R>, DofData<R>);

/// Why a campaign was not started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartError {
    /// Layout or calibration is being replaced, or a result deleted.
    Busy,
    /// There is no layout.
    NoLayout,
    /// The layout has an error: [`Measurement::check`].
    LayoutRefused,
    /// A block of known mass is weighed by mass lines, and the layout has the suspension profile.
    BlockNeedsMassLines,
    /// There is no room for the result.
    NoRoom,
    /// The rig is busy with something else.
    WrongPhase,
}

impl core::fmt::Display for StartError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Busy => "layout or calibration is being replaced, or a result deleted",
            Self::NoLayout => "there is no layout",
            Self::LayoutRefused => "the layout has an error",
            Self::BlockNeedsMassLines => {
                "a block of known mass is weighed by mass lines, and the layout has the suspension profile"
            }
            Self::NoRoom => "there is no room for the result",
            Self::WrongPhase => "the rig is busy with something else",
        })
    }
}

impl core::error::Error for StartError {}

impl<R: RealFft> Measurement<'_, R> {
    /// Starts a campaign and discards a paused one. With `force` the campaign starts even if the layout has
    /// an error that only prevents an estimate; `room` states whether there is room for the result.
    ///
    /// # Errors
    /// The reason why the campaign was not started; nothing has changed then.
    pub fn start(&mut self, start: Start, force: bool, room: bool) -> Result<(), StartError> {
        if let Activity::Changing = self.activity {
            return Err(StartError::Busy);
        }
        let layout = self.layout.as_ref().ok_or(StartError::NoLayout)?;
        let mut findings = self.check(layout);
        if let Object::Block { .. } = start.object {
            if self.is_long() {
                return Err(StartError::BlockNeedsMassLines);
            }
            // Hits through the centre of mass do not determine the ten properties, and need not for a block
            // test.
            findings.retain(|finding| !can_be_forced(finding));
            note(&mut findings, Diagnostic::whole(Code::BlockTest, Severity::Note, 0.0));
        }
        let refuses =
            |finding: &Diagnostic| finding.is_error() && !(force && can_be_forced(finding));
        if findings.iter().any(refuses) {
            return Err(StartError::LayoutRefused);
        }
        if !room {
            return Err(StartError::NoRoom);
        }
        match &self.activity {
            Activity::Idle => {}
            Activity::Measuring(campaign, _) if campaign.can_be_replaced() => {}
            _ => return Err(StartError::WrongPhase),
        }
        let campaign = Campaign::new(layout.hits.len(), layout.test.hits_per_dof, start);
        self.begin(campaign.map_err(|_| StartError::NoLayout)?, findings);
        Ok(())
    }

    /// Restores a campaign after a power failure: paused, with the data of its finished DOFs. A finished DOF
    /// for which `measured` is true but whose data are missing is measured again; data of a DOF
    /// that is not finished, or of the other profile, are ignored.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] unless the rig is idle, [`CommandError::NoDofs`] when the campaign does
    /// not fit the layout.
    pub fn resume(
        &mut self,
        progress: CampaignProgress,
        dofs: impl IntoIterator<Item = RestoredDof<R>>,
        measured: impl Fn(usize) -> bool,
        diagnostics: Diagnostics,
    ) -> Result<(), CommandError> {
        if !matches!(self.activity, Activity::Idle) {
            return Err(CommandError::WrongPhase);
        }
        if self.layout.as_ref().is_none_or(|layout| layout.hits.len() != progress.dofs.len()) {
            return Err(CommandError::NoDofs);
        }
        self.memory.discard_campaign();
        let finished =
            |index: usize| progress.dofs.get(index).is_some_and(DofProgress::is_finished);
        for (details, data) in dofs {
            match data {
                DofData::MassLines(lines) if finished(lines.0) && !self.is_long() => {
                    self.memory.store_dof(details, lines);
                }
                DofData::Lines(lines) if finished(lines.dof.into()) && self.is_long() => {
                    self.memory.keep_lines(details, lines);
                }
                DofData::MassLines(_) | DofData::Lines(_) => {}
            }
        }
        let mut progress = progress;
        for (index, dof) in progress.dofs.iter_mut().enumerate() {
            if measured(index) && !self.has_data(index) {
                *dof = DofProgress::OPEN;
            }
        }
        self.take_up(Campaign::resume(progress)?, diagnostics);
        Ok(())
    }

    /// True when mass lines or lines of the DOF with this index are stored.
    pub fn has_data(&self, index: usize) -> bool {
        self.memory.mass_lines.iter().any(|(dof, _)| *dof == index)
            || self.memory.lines.iter().any(|lines| usize::from(lines.dof) == index)
    }

    /// Executes a command of the operator.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] when the command is not possible in this phase, and the reason why there is no hit
    /// to undo; nothing has changed then.
    pub fn command(&mut self, command: Command) -> Result<(), CommandError> {
        let Activity::Measuring(campaign, task) = &mut self.activity else {
            return Err(CommandError::WrongPhase);
        };
        if command == Command::Undo {
            self.last_accepted.check()?;
        }
        let identifies = campaign.step() == Step::Identify;
        if let (true, Task::Identified) = (identifies, &*task) {
            // The result is being stored.
            return Err(CommandError::WrongPhase);
        }
        let (dof, accepted) = (campaign.dof(), campaign.accepted());
        campaign.command(command)?;
        // A record that is being taken is discarded, since the command may have changed what is wanted; and a
        // computation that is interrupted begins anew.
        if identifies || matches!(task, Task::Capture { .. } | Task::Grade { .. }) {
            *task = Task::None;
        }
        let computes = !matches!(campaign.step(), Step::Rest | Step::AwaitHit { .. });
        if accepted > 0 && matches!(command, Command::Skip | Command::Redo) {
            self.drop_diagnostics_of_dof();
        }
        match command {
            Command::Skip => {
                self.last_accepted.forget();
                // It may be the hit that was advised.
                if let Some(known) = &mut self.precision {
                    known.further = None;
                }
            }
            Command::Redo => {
                self.averaged = None;
                self.last_accepted.forget();
                self.memory.discard_dof(dof);
            }
            // The rig tries again what had interrupted the campaign.
            Command::Resume => self.diagnostics.retain(|diagnostic| !diagnostic.interrupts()),
            Command::Abort => self.activity = Activity::Idle,
            _ => {}
        }
        if computes {
            self.restore_record();
        }
        Ok(())
    }

    /// Checkpoint of the finished DOFs; `None` unless a campaign is running.
    pub fn progress(&self) -> Option<CampaignProgress> {
        self.running().and_then(Campaign::progress)
    }

    /// Reports that the result is stored with this number.
    pub fn stored(&mut self, number: u32) {
        if self.next_action() != NextAction::Store {
            return;
        }
        let Activity::Measuring(mut campaign, _) = self.take_activity() else { return };
        campaign.identified(number);
        self.ended = Some(campaign);
    }

    /// Reports that the result could not be stored: the campaign is interrupted, and `Resume` tries again.
    pub fn not_stored(&mut self) {
        if let Activity::Measuring(campaign, _) = &mut self.activity {
            campaign.not_stored();
            let code = Code::ResultNotStored;
            note(&mut self.diagnostics, Diagnostic::whole(code, Severity::Error, 0.0));
        }
    }

    fn begin(&mut self, campaign: Campaign, diagnostics: Diagnostics) {
        self.memory.discard_campaign();
        self.take_up(campaign, diagnostics);
    }

    fn take_up(&mut self, campaign: Campaign, diagnostics: Diagnostics) {
        self.campaigns = self.campaigns.wrapping_add(1);
        self.ended = None;
        self.last_hit = None;
        self.block = None;
        self.precision = None;
        self.last_accepted.forget();
        self.diagnostics = diagnostics;
        self.activity = Activity::Measuring(campaign, Task::None);
        self.take_gains();
    }

    /// Starts to fill the record with readings of the channels without a hit.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] unless the rig is idle.
    pub fn take_reading(&mut self) -> Result<(), CommandError> {
        self.leave_idle(Activity::Reading)
    }

    /// Cancels the reading.
    pub fn drop_reading(&mut self) {
        if let Activity::Reading = self.activity {
            self.activity = Activity::Idle;
        }
    }

    /// Measures a channel of the reading for a self-test.
    pub fn test_channel(&mut self, test: &mut SelfTest<R>, channel: usize) {
        let Memory { record, scratch, .. } = &mut *self.memory;
        test.add(record, channel, scratch);
    }

    /// Starts or stops the stream of all scans.
    ///
    /// # Errors
    /// [`CommandError::WrongPhase`] unless the rig is idle.
    pub fn set_stream(&mut self, on: bool) -> Result<(), CommandError> {
        match (&self.activity, on) {
            (Activity::Streaming(_), true) => Ok(()),
            (Activity::Streaming(_), false) => {
                self.activity = Activity::Idle;
                Ok(())
            }
            (_, true) => self.leave_idle(Activity::Streaming(StreamProgress::default())),
            (_, false) => Ok(()),
        }
    }

    fn leave_idle(&mut self, activity: Activity<R>) -> Result<(), CommandError> {
        if !matches!(self.activity, Activity::Idle) {
            return Err(CommandError::WrongPhase);
        }
        self.recorded = RecordContent::Nothing;
        self.activity = activity;
        Ok(())
    }
}

/// True for a finding about the layout that only prevents an estimate. A setting that the rig cannot use is
/// never forced.
fn can_be_forced(diagnostic: &Diagnostic) -> bool {
    let never = [Code::SettingOutOfRange, Code::LayoutNotFinite, Code::AxesNotOrthonormal];
    !never.contains(&diagnostic.code)
}
