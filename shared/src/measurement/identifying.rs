//! Computes the estimates from all mass lines, step by step, and names what they show.
//!
//! ```text
//!             ┌── after a DOF that is not the last ──▶ methods ─▶ precision ─▶ search ─▶ ask, or next DOF
//! CloseDof ───┤
//!             └── after the last one, or at the target ──▶ methods ─▶ precision ─▶ search ─▶ store
//! ```
//! In the suspension profile there is nothing to compute: the lines are the result, from which the program computes
//! modes and estimates. The second search is done only when the target is missed; it is among the DOFs that have been
//! hit.

use super::campaign::{Campaign, Object, Outcome, Step};
use super::hits::Task;
use super::precision::CampaignPrecision;
use super::{BlockResult, Measurement};
use crate::calibration::block::{BlockError, BlockMass, ForceRatio, force_ratio};
use crate::design::{FurtherHitSearch, HitCandidates, Precision};
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::identify::{IdentifySettings, Method, Observations, Progress};
use crate::signal::RealFft;

/// Relative standard deviation assumed for a mass that is typed in: that of a kitchen scale.
const MASS_SIGMA: f64 = 1e-3;

impl<R: RealFft> Measurement<'_, R> {
    /// Runs one step of the identification.
    pub(super) fn identify(&mut self, campaign: &Campaign, task: Task<R>) -> Task<R> {
        match task {
            Task::Identify => self.step_methods(campaign, HitCandidates::Measured),
            Task::Search(search) => self.step_search(campaign, search),
            Task::Identified => Task::Identified,
            _ => {
                self.name_unfinished_dofs(campaign);
                if let Object::Block { mass } = campaign.started().object {
                    self.memory.answers.begin([]);
                    self.block = Some(self.weigh(mass));
                    return Task::Identified;
                }
                if self.is_long() {
                    // The result is the stored lines.
                    self.memory.answers.begin([]);
                    return Task::Identified;
                }
                self.memory.answers.begin(Method::of_mass_lines());
                Task::Identify
            }
        }
    }

    /// Runs one step of the estimate after a DOF.
    pub(super) fn estimate(&mut self, campaign: &mut Campaign, task: Task<R>) -> Task<R> {
        match task {
            Task::Identify => self.step_methods(campaign, HitCandidates::Following),
            Task::Search(search) => self.step_search(campaign, search),
            Task::Identified => {
                let reached = |known: &CampaignPrecision<R>| {
                    known.precision.as_ref().is_some_and(Precision::is_reached)
                };
                campaign.estimated(self.precision.as_ref().is_some_and(reached));
                Task::None
            }
            _ => {
                if self.is_long() {
                    // The methods need all modes, and a force that excites each.
                    campaign.estimated(false);
                    return Task::None;
                }
                self.memory.answers.begin(Method::of_mass_lines());
                Task::Identify
            }
        }
    }

    /// Runs one step of the methods; then compares the answer with the target.
    fn step_methods(&mut self, campaign: &Campaign, candidates: HitCandidates) -> Task<R> {
        let Some(layout) = &self.layout else { return Task::Identified };
        let memory = &mut *self.memory;
        let observed = Observations::of_mass_lines(layout, &memory.mass_lines);
        let settings = IdentifySettings::default();
        let identification = &mut memory.answers;
        let step = identification.step(&observed, &settings, &mut memory.scratch);
        if step == Progress::Going {
            return Task::Identify;
        }
        let estimates = identification.estimates();
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
    fn step_search(&mut self, campaign: &Campaign, mut search: FurtherHitSearch<R>) -> Task<R> {
        let Some(layout) = &self.layout else { return Task::Identified };
        let memory = &mut *self.memory;
        if search.step(layout, &memory.mass_lines, &mut memory.scratch) == Progress::Going {
            return Task::Search(search);
        }
        if let Some(known) = &mut self.precision {
            known.further = search.best_hit();
        }
        self.estimated(campaign)
    }

    /// After the last step: the result gets its notes.
    fn estimated(&mut self, campaign: &Campaign) -> Task<R> {
        if campaign.step() == Step::Identify {
            self.explain_refusals();
            self.note_target(campaign);
        }
        Task::Identified
    }

    /// Reports why methods have no answer: as an error only for the best method, and only when no other
    /// method has an answer.
    fn explain_refusals(&mut self) {
        let answers = &self.memory.answers;
        let answered = !answers.estimates().is_empty();
        for (place, (_, reasons)) in answers.refusals().iter().enumerate().rev() {
            let severity = if answered || place > 0 { Severity::Warning } else { Severity::Error };
            for reason in reasons {
                let reason = Diagnostic { severity, ..*reason };
                super::note(&mut self.diagnostics, reason);
            }
        }
    }

    fn name_unfinished_dofs(&mut self, campaign: &Campaign) {
        for (dof, progress) in campaign.dofs().iter().enumerate() {
            let accepted = f32::from(progress.accepted);
            let code = match progress.outcome {
                Outcome::Skipped => Code::DofSkipped,
                Outcome::Early => Code::DofFinishedEarly,
                Outcome::Open | Outcome::Complete | Outcome::NotNeeded => continue,
            };
            self.push_diagnostic(Diagnostic::about(
                code,
                Severity::Warning,
                Subject::hit(dof),
                accepted,
            ));
        }
    }

    /// The hammer's gain against the sensors, from the hits on a block of known mass.
    fn weigh(&self, mass: f32) -> BlockResult {
        let layout = self.layout.as_ref().ok_or(BlockError::DirectionsMissing)?;
        let lines = self.memory.mass_lines.iter().map(|(_, lines)| lines);
        if lines.clone().any(|lines| lines.scatter.is_zero()) {
            return Err(BlockError::TooFewHits);
        }
        let mass = R::of(f64::from(mass));
        let block = BlockMass { mass, sigma: mass * R::of(MASS_SIGMA) };
        let ForceRatio { ratio, sigma, departure } =
            force_ratio(lines, layout.sensors.len(), block)?;
        let departure = (departure.0.to_f32(), departure.1.to_f32());
        Ok(ForceRatio { ratio: ratio.to_f32(), sigma: sigma.to_f32(), departure })
    }
}
