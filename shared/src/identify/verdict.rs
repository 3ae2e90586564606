//! Whether an answer can be used, by what a rig knows of it.
//!
//! The program knows more, because it compares methods and searches for single mistakes. Its verdict takes precedence.

use super::{Consistency, Estimate, Method};
use crate::diagnosis::{Code, Diagnostic, Severity};
use crate::real::Real;

/// χ² of the stated budget over its degrees of freedom from which an answer is not to be used: errors of three times
/// their stated standard deviations. A bench that is twice as rough as stated has 4, on which the learning of the
/// budget is tested.
const MOST_CONTRADICTION: f64 = 9.0;

/// Standard normal deviate that χ² must exceed as well: with few degrees of freedom chance alone makes χ² several times
/// as large as expected. It exceeds this in three of a million tests.
const BEYOND_CHANCE: f64 = 4.5;

/// Whether a result can be used, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// Nothing puts the answer in doubt.
    Good,
    /// The answer can be used by somebody who has read the concerns.
    UseWithCare,
    /// The answer is contradicted, or belongs to no body.
    DoNotUse,
}

impl Verdict {
    /// The verdict on the best answer of a test of mass lines. `campaign` are the findings of the campaign;
    /// `is_complete` is false when a method has no answer, for a reason that is among them.
    ///
    /// ```
    /// # use massline_shared::body::RigidBody;
    /// # use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
    /// # use massline_shared::identify::{Consistency, Estimate, Method, Verdict};
    /// # use nalgebra::{SMatrix, SVector};
    /// let theta = [2.0, 0.1, 0.2, 0.3, 0.03, 0.02, 0.04, 0.0, 0.0, 0.001];
    /// let answer = Estimate {
    ///     method: Method::MaximumLikelihood,
    ///     body: RigidBody::from_theta(&SVector::from(theta)),
    ///     covariance: Some(SMatrix::identity()),
    ///     condition: 8.0,
    ///     consistency: Some(Consistency { chi_squared: 17.0, degrees_of_freedom: 17 }),
    ///     learned: None,
    ///     diagnostics: Diagnostics::new(),
    /// };
    /// assert_eq!(Verdict::on(&answer, &[], true), Verdict::Good);
    /// let warning = Diagnostic::whole(Code::NoPlateau, Severity::Warning, 0.0);
    /// assert_eq!(Verdict::on(&answer, &[warning], true), Verdict::UseWithCare);
    /// // χ² of errors four times as large as stated.
    /// let contradicted = Consistency { chi_squared: 272.0, degrees_of_freedom: 17 };
    /// let answer = Estimate { consistency: Some(contradicted), ..answer };
    /// assert_eq!(Verdict::on(&answer, &[], true), Verdict::DoNotUse);
    /// ```
    pub fn on<R: Real>(answer: &Estimate<R>, campaign: &[Diagnostic], is_complete: bool) -> Self {
        let is_contradicted =
            answer.stated_consistency(campaign).is_some_and(|stated| stated.contradicts_layout());
        let is_preferred = answer.method == Method::MaximumLikelihood;
        let preferred_failed =
            !is_preferred && campaign.iter().any(|finding| is_of_data(finding.code));
        // To which method a reason belongs is not known.
        let is_reason = |finding: &Diagnostic| {
            let same =
                |other: &Diagnostic| (other.code, other.subject) == (finding.code, finding.subject);
            !is_complete && campaign.iter().any(same)
        };
        let puts_in_doubt =
            |finding: &Diagnostic| finding.severity > Severity::Note && !is_reason(finding);
        if !answer.body.is_physically_consistent() || is_contradicted || preferred_failed {
            Self::DoNotUse
        } else if !answer.has_complete_uncertainty()
            || answer.diagnostics.iter().chain(campaign).any(puts_in_doubt)
        {
            Self::UseWithCare
        } else {
            Self::Good
        }
    }
}

impl<R: Real> Consistency<R> {
    /// True when χ² of the stated budget is so large that the answer is not to be used.
    pub fn contradicts_layout(&self) -> bool {
        self.reduced() > R::of(MOST_CONTRADICTION) && self.equivalent_z() > R::of(BEYOND_CHANCE)
    }
}

impl<R: Real> Estimate<R> {
    /// True when the standard deviations cover all that they should: not the scatter between hits only.
    pub fn has_complete_uncertainty(&self) -> bool {
        let is_scatter = |finding: &Diagnostic| finding.code == Code::SigmaCoversScatterOnly;
        self.covariance.is_some() && !self.diagnostics.iter().any(is_scatter)
    }

    /// χ² of the stated budget. An answer that has learned its budget keeps it in a finding, of its own or of the
    /// campaign.
    pub fn stated_consistency(&self, campaign: &[Diagnostic]) -> Option<Consistency<R>> {
        let mut findings = self.diagnostics.iter().chain(campaign);
        let stated = findings.find(|finding| finding.code == Code::DataInconsistentWithBudget);
        self.consistency.map(|consistency| match stated {
            Some(finding) => Consistency {
                chi_squared: R::of(f64::from(finding.value))
                    * R::of(f64::from(consistency.degrees_of_freedom)),
                ..consistency
            },
            None => consistency,
        })
    }
}

/// True for a reason that lies in the data, not in what a method needs: the method was tried and has failed.
pub fn is_of_data(code: Code) -> bool {
    matches!(code, Code::NotConverged | Code::MassNotPositive | Code::NotPhysicallyConsistent)
}
