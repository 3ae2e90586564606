//! After each closed DOF: how precise the answer would be now, and which further hit would help most.
//!
//! ```text
//!             ┌── after a DOF that is not the last ──▶ methods ─▶ precision ─▶ search ─▶ ask, or next DOF
//! CloseDof ───┤
//!             └── after the last one, or at the target ──▶ methods ─▶ precision ─▶ search ─▶ store
//! ```
//! The second search is done only when the target is missed; it is among the DOFs that have been hit.

use super::Measurement;
use super::campaign::{Campaign, Outcome, Step};
use super::hits::Task;
use crate::design::{FurtherHit, FurtherHitSearch, HitCandidates, Precision};
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::identify::{IdentifySettings, Method, Observations, Progress};
use crate::signal::RealFft;

/// The precision after the last closed DOF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CampaignPrecision<R> {
    /// Number of DOFs with mass lines.
    pub dofs: u8,
    /// The intervals; `None` when more DOFs are needed for an answer.
    pub precision: Option<Precision<R>>,
    /// The hit that would narrow the interval of the worst property most; `None` when none helps.
    pub further: Option<FurtherHit<R>>,
}

impl<R: RealFft> Measurement<'_, R> {
    /// The precision after the last closed DOF; `None` before the first.
    pub fn precision(&self) -> Option<&CampaignPrecision<R>> {
        self.precision.as_ref()
    }

    /// Runs one step of the estimate after a DOF.
    pub(super) fn estimate(&mut self, campaign: &mut Campaign, task: Task<R>) -> Task<R> {
        match task {
            Task::Identify => self.step_methods(campaign, HitCandidates::Unmeasured),
            Task::Search(search) => self.step_search(campaign, search),
            Task::Identified => {
                let reached = |known: &CampaignPrecision<R>| {
                    known.precision.as_ref().is_some_and(Precision::is_reached)
                };
                campaign.estimated(self.precision.as_ref().is_some_and(reached));
                Task::None
            }
            _ => {
                self.memory.identification.begin(Method::of_mass_lines());
                Task::Identify
            }
        }
    }

    /// Runs one step of the methods; then compares the answer with the target.
    // Not inlined: the firmware has room for one copy of the methods.
    #[inline(never)]
    pub(super) fn step_methods(
        &mut self,
        campaign: &Campaign,
        candidates: HitCandidates,
    ) -> Task<R> {
        let Some(layout) = &self.layout else { return Task::Identified };
        let memory = &mut *self.memory;
        let observed = Observations::of_mass_lines(layout, &memory.mass_lines);
        let settings = IdentifySettings::default();
        let step = memory.identification.step(&observed, &settings, &mut memory.scratch);
        if step == Progress::Going {
            return Task::Identify;
        }
        let estimates = memory.identification.estimates();
        let length = layout.characteristic_length();
        let precision = Precision::of(estimates, layout.target, length);
        let dofs = memory.mass_lines.len() as u8;
        self.precision = Some(CampaignPrecision { dofs, precision, further: None });
        let searches = match campaign.step() {
            Step::Identify => layout.target.is_set(),
            _ => true,
        };
        match (precision, estimates.first()) {
            (Some(precision), Some(best)) if searches && !precision.is_reached() => {
                let (lines, sensors) = (&memory.mass_lines, layout.sensors.len());
                let search = FurtherHitSearch::new(&precision, best, lines, sensors, candidates);
                Task::Search(search)
            }
            _ => self.estimated(campaign),
        }
    }

    /// Evaluates one bound of the search for a further hit.
    #[inline(never)]
    pub(super) fn step_search(
        &mut self,
        campaign: &Campaign,
        mut search: FurtherHitSearch<R>,
    ) -> Task<R> {
        let Some(layout) = &self.layout else { return Task::Identified };
        let memory = &mut *self.memory;
        if search.step(layout, &memory.mass_lines, &mut memory.scratch) == Progress::Going {
            return Task::Search(search);
        }
        if let Some(known) = &mut self.precision {
            known.further = search.found();
        }
        self.estimated(campaign)
    }

    /// After the last step: the result gets its notes.
    fn estimated(&mut self, campaign: &Campaign) -> Task<R> {
        if campaign.step() == Step::Identify {
            self.explain_refusals();
            self.check_linearity();
            self.note_target(campaign);
        }
        Task::Identified
    }

    /// Notes in the result whether the target was reached, and what to hit again if it was not.
    fn note_target(&mut self, campaign: &Campaign) {
        let unneeded = campaign.dofs().iter().filter(|dof| dof.outcome == Outcome::NotNeeded);
        let saved = unneeded.count() * usize::from(campaign.wanted());
        if saved > 0 {
            let (code, saved) = (Code::StoppedAtTarget, saved as f32);
            self.push_diagnostic(Diagnostic::whole(code, Severity::Note, saved));
        }
        let Some(CampaignPrecision { precision: Some(precision), further, .. }) = self.precision
        else {
            return;
        };
        let (property, ratio) = precision.worst();
        if !precision.target.is_set() || ratio <= R::one() {
            return;
        }
        let subject = Subject::property(property);
        let missed = Diagnostic::about(Code::TargetMissed, Severity::Note, subject, ratio.to_f32());
        self.push_diagnostic(missed);
        if let Some(FurtherHit { dof, half_width, .. }) = further {
            let left = (half_width / precision.half_widths[property]).to_f32();
            let subject = Subject::hit(dof);
            let again = Diagnostic::about(Code::HitAgain, Severity::Note, subject, 1.0 - left);
            self.push_diagnostic(again);
        } else {
            self.push_diagnostic(Diagnostic::whole(Code::HitsDoNotHelp, Severity::Note, 0.0));
        }
    }
}
