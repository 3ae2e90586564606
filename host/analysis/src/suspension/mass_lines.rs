//! The methods that use mass lines, among the others.

use massline_shared::capacity::Unbounded;
use massline_shared::identify::{
    DofMassLines, Estimate, Method, Perturbation, inertia_restraint, random_signs,
};
use massline_shared::layout::{HOST_SENSORS, HostLayout};
use nalgebra::SVector;

use super::linear_fit::LinearFit;

/// Places of noise of mass lines begin here, so that it is not that of the lines of the suspension band.
const FIRST_PLACE: usize = 1 << 24;

/// Mass lines that methods have answered.
#[derive(Clone, Debug)]
pub struct MassLineAnswers<'a> {
    /// The layout with the error budget that the best answer has learned.
    pub budget: HostLayout,
    /// The answers.
    pub estimates: &'a [Estimate<f64>],
    lines: &'a [DofMassLines<f64, Unbounded>],
    /// How the equations of inertia restraint are weighted.
    settings: inertia_restraint::InertiaRestraintSettings<f64>,
    /// About the answer by maximum likelihood, where there is one.
    fit: Option<LinearFit>,
}

impl<'a> MassLineAnswers<'a> {
    /// Answers to these lines, of which inertia restraint weights its equations as `settings` say.
    pub fn new(
        estimates: &'a [Estimate<f64>],
        lines: &'a [DofMassLines<f64, Unbounded>],
        budget: HostLayout,
        settings: inertia_restraint::InertiaRestraintSettings<f64>,
    ) -> Self {
        let fitted = estimates.iter().find(|e| e.method == Method::MaximumLikelihood);
        let fit = fitted.and_then(|e| LinearFit::about(&e.body, &budget, lines));
        Self { budget, estimates, lines, settings, fit }
    }

    /// The answer of a method to perturbed data.
    pub(super) fn perturbed(
        &self,
        method: Method,
        perturbation: &Perturbation<'_, f64, Unbounded>,
    ) -> Option<SVector<f64, 10>> {
        let lines = self.noisy(perturbation.draw);
        let layout = perturbation.layout;
        match method {
            Method::InertiaRestraint => {
                let answer = inertia_restraint::solve(layout, &lines, self.settings).ok()?;
                Some(answer.theta())
            }
            Method::MaximumLikelihood => self.fit.as_ref()?.theta(layout, &lines),
            _ => None,
        }
    }

    fn noisy(&self, draw: Option<u32>) -> Vec<DofMassLines<f64, Unbounded>> {
        let mut dofs = self.lines.to_vec();
        let Some(draw) = draw else { return dofs };
        for (hit, lines) in &mut dofs {
            let values = lines.accelerance.iter_mut().zip(&lines.noise).enumerate();
            for (channel, (value, sigma)) in values {
                let place = FIRST_PLACE + 3 * HOST_SENSORS * *hit + channel;
                *value += sigma * f64::from(random_signs(draw, place)[0]);
            }
        }
        dofs
    }
}
