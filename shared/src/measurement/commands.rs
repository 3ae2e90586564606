//! What the operator wants: campaigns, readings of the channels without a hit, streams of scans.

use super::campaign::{self, Campaign, CampaignProgress, Command, CommandError, Object, Start};
use super::hits::Task;
use super::{Activity, MeasuredDof, Measurement, Recorded, Streamed, Wish, note};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::DofMassLines;
use crate::layout::RIG_SENSORS;
use crate::signal::RealFft;

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

impl core::fmt::Display for StartError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Busy => "layout or calibration are being replaced",
            Self::NoLayout => "there is no layout",
            Self::LayoutRefused => "the layout has an error",
            Self::NoRoom => "there is no room for the result",
            Self::WrongPhase => "something else is going on",
        })
    }
}

impl core::error::Error for StartError {}

impl<R: RealFft> Measurement<'_, R> {
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
        if self.wish() != Wish::Keep {
            return;
        }
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
}

/// True for a fact of the layout that only takes the answer away; a setting that a rig cannot work with is
/// never forced.
fn can_be_forced(diagnostic: &Diagnostic) -> bool {
    let never = [Code::SettingOutOfRange, Code::LayoutNotFinite, Code::AxesNotOrthonormal];
    !never.contains(&diagnostic.code)
}
