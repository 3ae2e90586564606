//! What all methods say together.

use massline_result::Doubt;
use massline_shared::identify::agreement::Agreement;
use massline_shared::identify::{Estimate, METHODS, Method};
use nalgebra::SVector;

use super::{MassLineAnswers, Survey, SurveyedAnswer};

/// What all methods say together.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// The methods with an answer, by their places in the agreement.
    pub methods: [Option<Method>; METHODS],
    /// Standard deviations of their answers under the same changes of data and layout, at the same places.
    pub sigmas: [Option<SVector<f64, 10>>; METHODS],
    /// How they agree; `None` with fewer than two of them, and where they are known to differ.
    pub agreement: Option<Agreement<f64>>,
    /// Why they are known to be off, so that nothing is combined.
    pub doubt: Option<Doubt>,
}

impl Comparison {
    /// Compares the answers that a survey has asked about, given by their places there. Where they are known to be off,
    /// nothing is combined.
    pub(super) fn of<'e>(
        survey: &Survey,
        answers: impl IntoIterator<Item = (usize, &'e Estimate<f64>)>,
        doubt: Option<Doubt>,
    ) -> Self {
        let mut thetas = [None; METHODS];
        let mut comparison = Self { doubt, ..Self::default() };
        for (place, estimate) in answers {
            comparison.methods[place] = Some(estimate.method);
            comparison.sigmas[place] = survey.sigma(place);
            thetas[place] = doubt.is_none().then(|| estimate.theta());
        }
        comparison.agreement = survey.agreement(&thetas);
        comparison
    }
}

/// How the answers to mass lines alone agree. `progress` is told how many of all changes are done.
pub fn compare(answers: &MassLineAnswers<'_>, progress: impl FnMut(u32, u32) + Send) -> Comparison {
    let asked: Vec<SurveyedAnswer<'_>> =
        answers.estimates.iter().map(|e| SurveyedAnswer::MassLines(e.method, answers)).collect();
    let survey = if asked.len() < 2 {
        Survey::none()
    } else {
        Survey::of(&answers.budget, None, &asked, progress)
    };
    Comparison::of(&survey, answers.estimates.iter().enumerate(), None)
}
