//! The progress of a campaign for the operator: a bar on a terminal, a line for each hit.

use indicatif::ProgressBar;
use massline_protocol::event::HitEvent;
use massline_protocol::message::{Reason, Status};
use massline_shared::layout::{RigLayout, TestProfile};
use massline_shared::measurement::campaign::{Command, Phase};

use crate::output::Output;
use crate::{Error, Result};
use massline_client::campaign::{explain_refusal, phase_name};
use massline_report::words::{HitAssessment, swing_words};

/// Shows the progress of one campaign.
pub struct Progress<'o> {
    output: &'o mut Output,
    bar: ProgressBar,
    layout: RigLayout,
    dofs: Vec<String>,
    hits_per_dof: u32,
    /// The arming and phase for which the operator has been prompted.
    prompted: Option<(u32, u8)>,
    prompts: Prompts,
    /// Number of rejected hits in a row.
    rejected: u32,
    /// Seconds for which the object rings yet in its record.
    rings_s: Option<u64>,
}

/// A bench that taps by itself is given up after this many rejected hits in a row.
const MOST_REJECTED: u32 = 50;

/// What the operator is prompted to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Prompts {
    /// Nothing, because the bench taps by itself.
    Nothing,
    /// To hit.
    Hits,
    /// To hit, and to give verdicts on the hits that wait for one.
    HitsAndVerdicts,
}

impl<'o> Progress<'o> {
    /// Progress of a campaign with this layout.
    pub fn new(output: &'o mut Output, label: &str, layout: &RigLayout, prompts: Prompts) -> Self {
        let hits_per_dof = u32::from(layout.test.hits_per_dof);
        let dofs: Vec<_> = layout.hits.iter().map(|hit| hit.dof.to_string()).collect();
        let bar = output.bar(u64::from(hits_per_dof) * dofs.len() as u64, label);
        let layout = layout.clone();
        Self {
            output,
            bar,
            layout,
            dofs,
            hits_per_dof,
            prompted: None,
            prompts,
            rejected: 0,
            rings_s: None,
        }
    }

    /// The name of the DOF with this index.
    pub fn dof(&self, index: usize) -> &str {
        self.dofs.get(index).map_or("?", String::as_str)
    }

    /// Prints a line for the operator.
    pub fn line(&mut self, text: &str) {
        self.output.note(text);
    }

    /// Shows a new status.
    pub fn status(&mut self, status: &Status) {
        let accepted: u64 = status.accepted.iter().map(|&n| u64::from(n)).sum();
        self.bar.set_position(accepted);
        let dof = usize::from(status.dof);
        let here = status.accepted.get(dof).copied().unwrap_or(0);
        let phase = Phase::try_from(status.phase).ok();
        let place = format!("{} {here}/{}", self.dof(dof), self.hits_per_dof);
        self.bar.set_message(format!("{place} {}", phase_name(status.phase)));
        let prompt = (status.armings, status.phase);
        if self.prompts == Prompts::Nothing || self.prompted == Some(prompt) {
            return;
        }
        let long = self.layout.test.profile == TestProfile::Suspension;
        match phase {
            Some(Phase::Armed) if long => {
                let name = self.dof(dof).to_owned();
                self.line(&format!("when it hangs still, hit {name} ({place})"));
            }
            Some(Phase::Armed) => self.line(&format!("hit {} now ({place})", self.dof(dof))),
            Some(Phase::Confirming) if self.prompts == Prompts::HitsAndVerdicts => {
                self.line("accept this hit? a yes, r no");
            }
            _ => return,
        }
        self.prompted = Some(prompt);
    }

    /// The object rings for so many seconds yet, or not any more: said once, and counted down beside the bar.
    pub fn ringing(&mut self, left_s: Option<u64>) {
        if self.rings_s == left_s {
            return;
        }
        let begins = self.rings_s.is_none();
        self.rings_s = left_s;
        if let Some(left) = left_s {
            let text = format!("ringing, {left} s left");
            self.bar.set_message(text.clone());
            if begins {
                self.line(&format!("{text}: do not touch it"));
            }
        }
    }

    /// Gives up a bench whose taps are all rejected.
    ///
    /// # Errors
    /// `always_rejected`.
    pub fn refuse_rejections(&self, dof: usize) -> Result<()> {
        if self.rejected < MOST_REJECTED {
            return Ok(());
        }
        let name = self.dof(dof);
        let text = format!(
            "{MOST_REJECTED} hits in a row at {name} were rejected; look at what is said of them, at the taps and \
             faults of the bench and at [test] of the layout"
        );
        Err(Error::undetermined("always_rejected", text))
    }

    /// Reports that the rig refused a command.
    pub fn refused(&mut self, command: Command, reason: Reason) {
        self.line(&explain_refusal(command, reason));
    }

    /// Shows a graded hit.
    pub fn hit(&mut self, hit: &HitEvent) {
        self.rejected = if hit.good || hit.is_undone() { 0 } else { self.rejected + 1 };
        let assessment = HitAssessment::of(hit, &self.layout);
        let toned = self.output.toned(assessment.verdict, assessment.tone);
        let verdict = assessment.to_string().replacen(assessment.verdict, &toned, 1);
        let swing = hit
            .swing
            .as_ref()
            .map_or_else(String::new, |swing| format!("  {}", swing_words(swing)));
        let line = format!(
            "hit {:3}  {:7}  {:6.1} N  {:6.1} m/s²{swing}  {verdict}",
            hit.number,
            self.dof(usize::from(hit.dof)),
            hit.peak_force,
            hit.peak_acceleration,
        );
        self.line(&line);
    }
}

impl Drop for Progress<'_> {
    fn drop(&mut self) {
        self.bar.finish_and_clear();
    }
}
