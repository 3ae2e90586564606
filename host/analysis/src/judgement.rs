//! Whether a result can be used: one verdict for each result, from typed concerns.
//!
//! | verdict | when |
//! | --- | --- |
//! | [`Verdict::Good`] | there is no concern |
//! | [`Verdict::UseWithCare`] | warnings, methods that differ, or data that contradict the error budget within the limits below |
//! | [`Verdict::DoNotUse`] | no body has these properties; the preferred method has no answer from the same data; the data contradict the layout beyond [`Consistency::contradicts_layout`], or a single mistake explains that they do; no body on its suspension fits the responses, or none without a small fault that shows |
//!
//! The verdict is computed here and nowhere else; sentences about it decide nothing.

use crate::score_tests::{ScoreTest, ScoreTests};
use crate::single_fault::{Examination, Outcome, Suspect};
use crate::suspension::Comparison;
use massline_result::{Doubt, FindingCode, Verdict};
use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::identify::agreement::Outcome as Agreed;
use massline_shared::identify::maximum_likelihood::BudgetScales;
use massline_shared::identify::{Consistency, Estimate, Method, is_of_data};

/// χ² of the stated budget over its degrees of freedom from which a single mistake that explains the data is decisive.
/// Below it one of the hundreds of mistakes that are tried may fit by chance: of healthy tests as rough as stated, one
/// in a thousand exceeds the limit of chance, and none comes to this.
pub const DECISIVE_CONTRADICTION: f64 = 4.0;

/// Something that puts an answer in doubt.
#[derive(Clone, Debug, PartialEq)]
pub enum Concern {
    /// No body has these ten properties.
    Unphysical,
    /// A method that is preferred to the answer's has none from the same data, for this reason.
    PreferredMethodFailed(Method, Diagnostic),
    /// The data contradict the layout and its error budget beyond the limit.
    Contradicted(Consistency<f64>),
    /// A single mistake, or one of several that the data cannot tell apart, explains data that contradict the layout.
    SingleMistake {
        /// The mistakes, the most likely first.
        suspects: Vec<Suspect>,
        /// Whether the data contradict the layout so far that this is decisive.
        is_decisive: bool,
    },
    /// Errors of the stated kinds that are larger than stated by these factors explain the data.
    LargerErrors(BudgetScales<f64>),
    /// The data contradict the stated budget, and neither a single mistake nor larger errors explain that; `None` where
    /// the layout has no fit at all.
    Unexplained(Option<Consistency<f64>>),
    /// A small fault, or one of several that the data cannot tell apart, shows in them.
    SmallFault {
        /// The faults, the most significant first.
        tests: Vec<ScoreTest>,
        /// Whether no body on its suspension fits the responses without it.
        is_decisive: bool,
    },
    /// No body on its suspension fits the responses.
    ModelMisfit,
    /// A flexible mode above the band puts every method off but the global fit, and this answer is not by the global
    /// fit.
    FlexibleMode,
    /// The methods differ by more than chance.
    MethodsDiffer,
    /// This method differs from the others by more than chance, and the answer is by this method.
    MethodOff(Method),
    /// The answer has no standard deviations.
    UncertaintyUnknown,
    /// A warning or an error about the test or the answer.
    Warning(Diagnostic),
    /// What is missing, or values that look like another unit than is stated, with a sentence.
    Stated(FindingCode, String),
}

impl Concern {
    /// What it makes of the result.
    pub fn verdict(&self) -> Verdict {
        match self {
            Self::Unphysical
            | Self::PreferredMethodFailed(..)
            | Self::Contradicted(_)
            | Self::SingleMistake { is_decisive: true, .. }
            | Self::SmallFault { is_decisive: true, .. }
            | Self::Unexplained(None)
            | Self::ModelMisfit => Verdict::DoNotUse,
            _ => Verdict::UseWithCare,
        }
    }

    /// What it is about.
    pub fn code(&self) -> FindingCode {
        match self {
            Self::Unphysical => Code::NotPhysicallyConsistent.into(),
            Self::PreferredMethodFailed(..) => FindingCode::PreferredMethodFailed,
            Self::Contradicted(_) => FindingCode::Contradicted,
            Self::SingleMistake { .. } => FindingCode::SingleMistake,
            Self::LargerErrors(_) => Code::ErrorsLargerThanStated.into(),
            Self::Unexplained(_) => Code::NoSingleFaultExplains.into(),
            Self::SmallFault { tests, .. } => {
                tests.first().map_or(FindingCode::SingleMistake, |test| test.fault.code())
            }
            Self::ModelMisfit => Code::ModelDoesNotFit.into(),
            Self::FlexibleMode => Code::FlexibleModeAboveBand.into(),
            Self::MethodsDiffer => FindingCode::MethodsDiffer,
            Self::MethodOff(_) => FindingCode::MethodOff,
            Self::UncertaintyUnknown => FindingCode::UncertaintyUnknown,
            Self::Warning(diagnostic) => diagnostic.code.into(),
            Self::Stated(code, _) => *code,
        }
    }
}

/// What a result is judged by.
#[derive(Clone, Debug)]
pub struct Evidence<'a> {
    /// The answer.
    pub answer: &'a Estimate<f64>,
    /// The search for a single mistake, where one was done.
    pub examination: Option<&'a Examination>,
    /// The tests for small faults, where they were made.
    pub score_tests: Option<&'a ScoreTests>,
    /// How the methods agree, where several answer.
    pub comparison: Option<&'a Comparison>,
    /// The methods without an answer, each with its reasons.
    pub refusals: Vec<(Method, Diagnostic)>,
    /// Findings about the test.
    pub diagnostics: Vec<Diagnostic>,
    /// What is missing, and values that look like another unit than is stated, with a sentence each.
    pub stated: Vec<(FindingCode, String)>,
}

impl<'a> Evidence<'a> {
    /// An answer alone.
    pub fn of(answer: &'a Estimate<f64>) -> Self {
        Self {
            answer,
            examination: None,
            score_tests: None,
            comparison: None,
            refusals: Vec::new(),
            diagnostics: Vec::new(),
            stated: Vec::new(),
        }
    }

    /// Everything that puts the answer in doubt, the gravest first.
    pub fn judge(&self) -> Judgement {
        // What explains the others stands before them.
        let (mistake, contradiction): (Vec<_>, Vec<_>) = self
            .examination
            .and_then(examined)
            .into_iter()
            .partition(|concern| matches!(concern, Concern::SingleMistake { .. }));
        let mut concerns = mistake;
        concerns.extend(self.small_fault());
        if !self.answer.body.is_physically_consistent() {
            concerns.push(Concern::Unphysical);
        }
        concerns.extend(self.preferred_method());
        concerns.extend(contradiction);
        concerns.extend(self.contradiction());
        concerns.extend(self.comparison.and_then(|comparison| self.disagreement(comparison)));
        if !self.answer.has_complete_uncertainty() {
            concerns.push(Concern::UncertaintyUnknown);
        }
        let stated = self.stated.iter().cloned();
        concerns.extend(stated.map(|(code, text)| Concern::Stated(code, text)));
        for warning in self.warnings() {
            if !concerns.iter().any(|concern| *concern == Concern::Warning(warning)) {
                concerns.push(Concern::Warning(warning));
            }
        }
        // A stable sort: of equally grave concerns the first stays first.
        concerns.sort_by_key(|concern| std::cmp::Reverse(concern.verdict()));
        Judgement { concerns }
    }

    /// Data that contradict the error budget beyond the limit, by the stated budget of the nominal layout or, where
    /// that was not examined, by what the answer itself leaves.
    fn contradiction(&self) -> Option<Concern> {
        let of_answer = || self.answer.stated_consistency(&self.diagnostics);
        let consistency =
            self.examination.map_or_else(of_answer, |examination| examination.plain)?;
        consistency.contradicts_layout().then_some(Concern::Contradicted(consistency))
    }

    /// A small fault that shows, unless a mistake explains the data altogether or nothing does: then much shows.
    fn small_fault(&self) -> Option<Concern> {
        let is_apart = self.examination.is_some_and(|examination| {
            matches!(examination.outcome, Outcome::Suspected(_) | Outcome::Unexplained)
        });
        let shown = self.score_tests.filter(|_| !is_apart)?.shown();
        let is_decisive = self.doubt() == Some(Doubt::Misfit);
        let tests: Vec<ScoreTest> = shown.into_iter().cloned().collect();
        (!tests.is_empty()).then_some(Concern::SmallFault { tests, is_decisive })
    }

    /// What puts the methods off.
    fn doubt(&self) -> Option<Doubt> {
        self.comparison.and_then(|comparison| comparison.doubt)
    }

    /// The method that would have been preferred to the answer's, where the data themselves are why it has none.
    fn preferred_method(&self) -> Option<Concern> {
        let place = |method: Method| Method::ALL.iter().position(|other| *other == method);
        let is_better = |method: Method| place(method) < place(self.answer.method);
        let same_data =
            |method: Method| method.entry().observes == self.answer.method.entry().observes;
        let failed = self.refusals.iter().find(|(method, reason)| {
            is_better(*method) && same_data(*method) && is_of_data(reason.code)
        });
        failed.map(|(method, reason)| Concern::PreferredMethodFailed(*method, *reason))
    }

    /// How the answer stands among those of the other methods.
    fn disagreement(&self, comparison: &Comparison) -> Option<Concern> {
        match comparison.doubt {
            // A body fits but for a small fault that shows.
            Some(Doubt::Misfit) if self.small_fault().is_some() => return None,
            Some(Doubt::Misfit) => return Some(Concern::ModelMisfit),
            Some(Doubt::FlexibleMode) if self.answer.method != Method::GlobalFit => {
                return Some(Concern::FlexibleMode);
            }
            _ => {}
        }
        let agreement = comparison.agreement.as_ref()?;
        let place = comparison.methods.iter().position(|m| *m == Some(self.answer.method));
        if place.is_some_and(|place| agreement.outliers.contains(&place)) {
            return Some(Concern::MethodOff(self.answer.method));
        }
        (agreement.outcome() == Agreed::Differ).then_some(Concern::MethodsDiffer)
    }

    /// Warnings and errors about the test and the answer. Why another method has no answer is its own affair.
    fn warnings(&self) -> impl Iterator<Item = Diagnostic> + '_ {
        let diagnostics = self.answer.diagnostics.iter().chain(&self.diagnostics);
        let is_reason = |diagnostic: &Diagnostic| {
            let same = |(_, reason): &(Method, Diagnostic)| {
                (reason.code, reason.subject) == (diagnostic.code, diagnostic.subject)
            };
            self.refusals.iter().any(same)
        };
        diagnostics
            .filter(move |diagnostic| {
                diagnostic.severity > Severity::Note
                    && !is_of_other_form(diagnostic.code)
                    && !self.is_explained(diagnostic.code)
                    && !self.is_said_of_the_body(diagnostic.code)
                    && !self.is_relied_on(diagnostic.code)
                    && !self.is_said_of_the_layout(diagnostic.code)
                    && !self.is_said_of_the_fault(diagnostic.code)
                    && !is_reason(diagnostic)
            })
            .copied()
    }

    /// True for a warning that says of the answer what [`Concern::Unphysical`] says.
    fn is_said_of_the_body(&self, code: Code) -> bool {
        code == Code::NotPhysicallyConsistent && !self.answer.body.is_physically_consistent()
    }

    /// True for a warning that says of the data what [`Concern::Contradicted`] says.
    fn is_said_of_the_layout(&self, code: Code) -> bool {
        code == Code::DataInconsistentWithBudget && self.contradiction().is_some()
    }

    /// True for a warning that says of the fit what a decisive [`Concern::SmallFault`] says.
    fn is_said_of_the_fault(&self, code: Code) -> bool {
        code == Code::ModelDoesNotFit
            && self.doubt() == Some(Doubt::Misfit)
            && self.small_fault().is_some()
    }

    /// True for what the fit takes for a part of the hammer's signal where a mistake explains the data.
    fn is_explained(&self, code: Code) -> bool {
        let suspected = self
            .examination
            .is_some_and(|examination| matches!(examination.outcome, Outcome::Suspected(_)));
        suspected && matches!(code, Code::HammerInResponse | Code::MultiplexerKeepsVoltage)
    }

    /// True for a warning about a flexible mode beside an answer by the one method that takes it into account.
    fn is_relied_on(&self, code: Code) -> bool {
        code == Code::FlexibleModeShows
            && self.doubt() == Some(Doubt::FlexibleMode)
            && self.answer.method == Method::GlobalFit
    }
}

/// A judged result.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Judgement {
    /// What puts the answer in doubt, the gravest first.
    pub concerns: Vec<Concern>,
}

impl Judgement {
    /// The verdict: that of the gravest concern.
    pub fn verdict(&self) -> Verdict {
        self.concerns.iter().map(Concern::verdict).max().unwrap_or(Verdict::Good)
    }
}

/// What an examination makes of data that contradict the stated budget.
fn examined(examination: &Examination) -> Option<Concern> {
    let reduced = examination.plain.map_or(f64::INFINITY, |consistency| consistency.reduced());
    match &examination.outcome {
        Outcome::NothingSuspicious => None,
        Outcome::Suspected(suspects) => Some(Concern::SingleMistake {
            suspects: suspects.clone(),
            is_decisive: reduced > DECISIVE_CONTRADICTION,
        }),
        Outcome::LargerErrors(scales) => Some(Concern::LargerErrors(*scales)),
        Outcome::Unexplained => Some(Concern::Unexplained(examination.plain)),
    }
}

/// True for which form of damping does not fit: the method with that form is refused.
pub fn is_of_other_form(code: Code) -> bool {
    matches!(code, Code::DampingNotStructural | Code::DampingNotViscous)
}

#[cfg(test)]
mod tests {
    use massline_shared::body::RigidBody;
    use massline_shared::diagnosis::Diagnostics;
    use massline_shared::identify::single_fault::SingleFault;
    use nalgebra::{SMatrix, SVector};

    use super::*;
    use crate::score_tests::SmallFault;
    use crate::single_fault::Mistake;

    /// A sound answer.
    fn estimate() -> Estimate<f64> {
        let theta = [2.0, 0.1, 0.2, 0.3, 0.03, 0.02, 0.04, 0.0, 0.0, 0.001];
        Estimate {
            method: Method::MaximumLikelihood,
            body: RigidBody::from_theta(&SVector::from(theta)),
            covariance: Some(SMatrix::identity()),
            condition: 8.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        }
    }

    fn warning(code: Code) -> Diagnostic {
        Diagnostic::whole(code, Severity::Warning, 1.0)
    }

    fn examination(chi_squared: f64, outcome: Outcome) -> Examination {
        let plain = Some(Consistency { chi_squared, degrees_of_freedom: 17 });
        Examination {
            plain,
            outcome,
            runner_up: None,
            tested: 100,
            untried: Vec::new(),
            hidden: None,
        }
    }

    #[test]
    fn an_answer_without_concerns_is_good() {
        let judgement = Evidence::of(&estimate()).judge();
        assert_eq!((judgement.verdict(), judgement.concerns.len()), (Verdict::Good, 0));
    }

    #[test]
    fn no_body_has_the_properties_of_an_unphysical_answer() {
        let mut estimate = estimate();
        estimate.body.inertia[(0, 0)] = -0.03;
        assert_eq!(Evidence::of(&estimate).judge().verdict(), Verdict::DoNotUse);
    }

    #[test]
    fn a_warning_asks_for_care_and_a_note_does_not() {
        let estimate = estimate();
        let with = |diagnostic| {
            let diagnostics = vec![diagnostic];
            Evidence { diagnostics, ..Evidence::of(&estimate) }.judge()
        };
        let judgement = with(warning(Code::NoPlateau));
        assert_eq!(judgement.verdict(), Verdict::UseWithCare);
        assert_eq!(judgement.concerns[0].code(), Code::NoPlateau);
        let note = Diagnostic { severity: Severity::Note, ..warning(Code::NoPlateau) };
        assert_eq!(with(note).verdict(), Verdict::Good);
    }

    #[test]
    fn data_that_contradict_the_budget_beyond_the_limit_are_not_to_be_used() {
        let estimate = estimate();
        // χ² of a bench twice as rough as stated, 4 times 17, and of one four times as rough, 16 times 17.
        for (chi_squared, expected) in [(68.0, Verdict::Good), (272.0, Verdict::DoNotUse)] {
            let examination = examination(chi_squared, Outcome::NothingSuspicious);
            let evidence = Evidence { examination: Some(&examination), ..Evidence::of(&estimate) };
            assert_eq!(evidence.judge().verdict(), expected, "{chi_squared}");
        }
    }

    #[test]
    fn what_a_rig_found_counts_where_its_layout_is_not_known() {
        let consistency = Some(Consistency { chi_squared: 17.0, degrees_of_freedom: 17 });
        let estimate = Estimate { consistency, ..estimate() };
        let verdict = |times| {
            let diagnostic =
                Diagnostic::whole(Code::DataInconsistentWithBudget, Severity::Warning, times);
            Evidence { diagnostics: vec![diagnostic], ..Evidence::of(&estimate) }.judge().verdict()
        };
        assert_eq!((verdict(4.0), verdict(22.1)), (Verdict::UseWithCare, Verdict::DoNotUse));
    }

    #[test]
    fn a_single_mistake_is_decisive_where_the_data_contradict_the_layout_clearly() {
        let estimate = estimate();
        let consistency = Consistency { chi_squared: 17.0, degrees_of_freedom: 17 };
        let mistake = Mistake::Listed(SingleFault::HitReversed { hit: 1 });
        let suspect = Suspect { mistake, consistency, corrected: None };
        // The limit of chance, 40.8, and three times that.
        for (chi_squared, expected) in [(42.0, Verdict::UseWithCare), (120.0, Verdict::DoNotUse)] {
            let suspected = Outcome::Suspected(vec![suspect.clone()]);
            let examination = examination(chi_squared, suspected);
            let evidence = Evidence { examination: Some(&examination), ..Evidence::of(&estimate) };
            let judgement = evidence.judge();
            assert_eq!(judgement.verdict(), expected, "{chi_squared}");
            assert_eq!(judgement.concerns[0].code(), FindingCode::SingleMistake);
        }
    }

    #[test]
    fn an_answer_in_place_of_a_better_method_that_failed_is_not_to_be_used() {
        let estimate = Estimate { method: Method::InertiaRestraint, ..estimate() };
        let refused = |code| {
            let refusals = vec![(Method::MaximumLikelihood, warning(code))];
            Evidence { refusals, ..Evidence::of(&estimate) }.judge().verdict()
        };
        assert_eq!(refused(Code::NotConverged), Verdict::DoNotUse);
        // What a method needs and the layout does not have says nothing about the data.
        assert_eq!(refused(Code::FewerThanThreeSensors), Verdict::Good);
    }

    #[test]
    fn a_small_fault_says_why_no_body_fits() {
        let fault = SmallFault::HitLeans { hit: 1 };
        let consistency = Consistency { chi_squared: 40.0, degrees_of_freedom: 2 };
        let test = ScoreTest {
            fault,
            sizes: Vec::new(),
            consistency,
            sigma: 0.03,
            shift: 1.0,
            found_shift: 5.0,
            limit: 3.5,
        };
        let tests = ScoreTests { tests: vec![test], band_shift: None };
        let comparison = Comparison { doubt: Some(Doubt::Misfit), ..Comparison::default() };
        let mut estimate = estimate();
        estimate.diagnostics.extend([warning(Code::ModelDoesNotFit)]);
        let codes = |tests, comparison| {
            let evidence = Evidence { score_tests: tests, comparison, ..Evidence::of(&estimate) };
            let judgement = evidence.judge();
            (judgement.verdict(), judgement.concerns.iter().map(Concern::code).collect::<Vec<_>>())
        };
        let (leans, misfit) = (FindingCode::HitLeans, Code::ModelDoesNotFit.into());
        assert_eq!(
            codes(Some(&tests), Some(&comparison)),
            (Verdict::DoNotUse, vec![leans]),
            "instead of the misfit"
        );
        assert_eq!(
            codes(None, Some(&comparison)),
            (Verdict::DoNotUse, vec![misfit, misfit]),
            "the misfit, and the warning of it"
        );
        let (verdict, _) = codes(Some(&tests), None);
        assert_eq!(verdict, Verdict::UseWithCare);
    }

    #[test]
    fn the_gravest_concern_stands_first() {
        let mut estimate = estimate();
        estimate.covariance = None;
        estimate.body.mass = -1.0;
        let judgement = Evidence::of(&estimate).judge();
        let codes: Vec<_> = judgement.concerns.iter().map(Concern::code).collect();
        assert_eq!(codes, [Code::NotPhysicallyConsistent.into(), FindingCode::UncertaintyUnknown]);
    }
}
