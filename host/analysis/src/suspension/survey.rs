//! What small changes of data and layout do to the answers.

use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::agreement::{Agreement, Answers, Propagation, ask, changes};
use massline_shared::identify::suspension::{Answer, ModeDeviations, judged_estimate};
use massline_shared::identify::{Estimate, METHODS, Method, Perturbation};
use massline_shared::layout::HostLayout;
use massline_shared::modes::{Modes, Reduction};
use nalgebra::{SVector, Vector3};

use super::methods::{ModalAnswers, Variant, answer};
use super::{GlobalAnswer, HostFit, MassLineAnswers};
use crate::parallel::pieces;

/// A method that small changes of data and layout are put through.
#[derive(Clone, Copy)]
pub enum SurveyedAnswer<'a> {
    /// One that uses the suspension modes.
    Modal(Variant),
    /// The global fit.
    Global(&'a GlobalAnswer),
    /// One that uses mass lines.
    MassLines(Method, &'a MassLineAnswers<'a>),
}

/// What small changes of the data and the layout do to answers and modes.
pub struct Survey {
    propagation: Propagation<f64, METHODS>,
    pub(super) deviations: ModeDeviations<f64>,
}

/// What a small change makes of modes and answers.
struct ChangeEffect {
    modes: Option<Modes<f64>>,
    thetas: Answers<f64, METHODS>,
    /// The change is a draw of noise.
    is_noise: bool,
}

impl ChangeEffect {
    fn by(
        change: &Perturbation<'_, f64, Unbounded>,
        fit: Option<&HostFit<'_>>,
        asked: &[SurveyedAnswer<'_>],
        memory: &mut Reduction<f64>,
    ) -> Self {
        let modes = fit.and_then(|fit| fit.changed(change, memory));
        let mut thetas = [None; METHODS];
        for (to, asked) in thetas.iter_mut().zip(asked) {
            *to = match asked {
                SurveyedAnswer::Modal(variant) => {
                    fit.zip(modes.as_ref()).and_then(|(fit, modes)| {
                        let result = answer(fit, change.layout, variant, memory, modes);
                        result.ok().map(|answer| answer.body.theta())
                    })
                }
                SurveyedAnswer::Global(global) => fit.map(|fit| global.perturbed(fit, change)),
                SurveyedAnswer::MassLines(method, answers) => answers.perturbed(*method, change),
            };
        }
        Self { modes, thetas, is_noise: change.draw.is_some() }
    }
}

impl Survey {
    /// A survey of nothing: no covariance is known.
    pub(super) fn none() -> Self {
        Self {
            propagation: Propagation::empty(),
            deviations: ModeDeviations::new(Vector3::zeros()),
        }
    }

    /// Puts the changes through these methods, at most [`METHODS`] of them. Without a modal fit, only those that use
    /// mass lines answer.
    pub fn of(
        layout: &HostLayout,
        fit: Option<&HostFit<'_>>,
        asked: &[SurveyedAnswer<'_>],
        mut progress: impl FnMut(u32, u32) + Send,
    ) -> Self {
        let memory = || Box::new(Reduction::new());
        let count = changes(layout);
        let progress = |done: u64| progress(done as u32, count);
        let effects = pieces(count.into(), None, &|| false, progress, memory, |memory, change| {
            ask(layout, change as u32, |perturbation| {
                ChangeEffect::by(perturbation, fit, asked, memory)
            })
        });
        let reference = fit.map_or_else(Vector3::zeros, HostFit::reference);
        let mut deviations = ModeDeviations::new(reference);
        for ChangeEffect { modes, is_noise, .. } in effects.iter().flatten() {
            if let Some(modes) = modes {
                deviations.add(&modes.modes, *is_noise);
            }
        }
        let thetas = effects.into_iter().map(|effect| Some(effect?.thetas));
        Self { propagation: Propagation::of(thetas), deviations }
    }

    /// The answers with their covariances, and their places here from `first` on. Any that the changes leave nothing of
    /// are no longer applicable.
    pub fn estimates(
        &self,
        modal: &mut ModalAnswers,
        first: usize,
        length: f64,
    ) -> Vec<(usize, Estimate<f64>)> {
        let mut estimates = Vec::new();
        for (place, (variant, answer)) in (first..).zip(&modal.answers) {
            match self.estimate(place, variant, answer, length) {
                Ok(mut estimate) => {
                    let warning = modal.warned.filter(|(method, _)| *method == variant.method);
                    // There is room for sixteen diagnostics; this is the second at most.
                    estimate.diagnostics.extend(warning.map(|(_, warning)| warning));
                    estimates.push((place, estimate));
                }
                Err(reasons) => modal.not_applicable.push((variant.method, reasons)),
            }
        }
        estimates
    }

    /// The answer with the covariance of the method at this place.
    ///
    /// # Errors
    /// `unstable_under_noise`, `property_undetermined` for one whose uncertainty says that there is no answer, and
    /// `not_physically_consistent` for a negative moment of inertia.
    pub fn estimate(
        &self,
        place: usize,
        variant: &Variant,
        answer: &Answer<f64>,
        length: f64,
    ) -> Result<Estimate<f64>, Diagnostics> {
        judged_estimate(variant.method, answer, place, &self.propagation, length)
    }

    /// Standard deviations of the answer at this place; `None` for one that is not stable.
    pub fn sigma(&self, place: usize) -> Option<SVector<f64, 10>> {
        let stable = self.propagation.unstable(place).is_none();
        stable.then(|| self.propagation.of_method(place).diagonal().map(f64::sqrt))
    }

    /// How these answers agree, by their places.
    pub fn agreement(
        &self,
        answers: &[Option<SVector<f64, 10>>; METHODS],
    ) -> Option<Agreement<f64>> {
        Agreement::of(answers, &self.propagation)
    }
}
