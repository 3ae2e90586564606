//! After each closed DOF: how precise the answer would be now, and which further hit would help most.

use super::Measurement;
use super::campaign::{Campaign, Outcome};
use crate::design::{FurtherHit, Precision};
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
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

    /// Notes in the result whether the target was reached, and what to hit again if it was not.
    pub(super) fn note_target(&mut self, campaign: &Campaign) {
        let unneeded = campaign.dofs().iter().filter(|dof| dof.outcome == Outcome::NotNeeded);
        let saved = unneeded.count() * usize::from(campaign.hits_per_dof());
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
