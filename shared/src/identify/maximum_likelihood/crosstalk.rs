//! Finds a response that contains a part of the hammer's signal, as through a multiplexer that does not settle.
//!
//! Such a part adds a constant to the accelerances of that response, whatever is hit, which no body and no error of
//! the budget does. The score test (Rao 1948) needs no further fit (theory, section 12).

use heapless::Vec;

use super::fit::Fit;
use super::fit_problem::FitProblem;
use super::model::Model;
use super::normal_equations::{NormalEquations, Rows};
use super::pulls::UnknownValues;
use super::undetermined;
use crate::Real;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::identify::DofMassLines;
use crate::responses::Responses;

/// A constant is significant beyond this number of standard deviations. Nine responses are tested, so chance
/// exceeds it in one of five hundred tests.
const SIGNIFICANT: f64 = 3.7;

/// Sums over the DOFs for one response.
struct Score<R, const S: usize> {
    score: R,
    /// Before the unknowns explain a part.
    information: R,
    /// The right side of the equations for a residual of this constant.
    right: UnknownValues<R, S>,
}

impl<R: Real, const S: usize> Score<R, S> {
    fn none(unknowns: &UnknownValues<R, S>) -> Self {
        Self { score: R::zero(), information: R::zero(), right: unknowns.zeros() }
    }

    /// Sums without a DOF for every response.
    // Not inlined, for the firmware's deepest stack.
    #[inline(never)]
    fn begin(unknowns: &UnknownValues<R, S>, scores: &mut Vec<[Self; 3], S>) {
        for _ in &unknowns.sensors {
            // There is room for all sensors.
            let _ = scores.push(core::array::from_fn(|_| Self::none(unknowns)));
        }
    }

    /// Adds a hit DOF, whose weighted residual is `left`.
    fn add(&mut self, rows: &Rows<'_, R, S>, response: usize, left: &Responses<R, S>) {
        let weighted = rows.weight.column(response);
        self.score += left[response];
        self.information += weighted[response];
        let UnknownValues { sensors, shared } = &mut self.right;
        rows.add_products(&weighted, sensors.as_flattened_mut(), shared);
    }
}

impl<R: Real> Fit<R> {
    /// Tests every response, from completed equations, and reports the most significant constant.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    // Not inlined, for the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn test_crosstalk<const S: usize, const H: usize>(
        &mut self,
        problem: &FitProblem<'_, R, S, H>,
        dofs: &[DofMassLines<R, S>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<(), Diagnostics> {
        let sensors = problem.layout.sensors.len();
        let Some(unknowns) = UnknownValues::<R, S>::of(sensors, equations.solution()) else {
            return Err(undetermined());
        };
        let object = self.object().ok_or_else(undetermined)?;
        let body = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
        let Some(model) = Model::new(problem.layout, &problem.balance, &body) else {
            return Err(undetermined());
        };
        let mut scores = Vec::new();
        Score::begin(&unknowns, &mut scores);
        let scores = scores.as_flattened_mut();
        for (place, (index, lines)) in dofs.iter().enumerate() {
            let errors = equations.hit_errors(place);
            let Some(terms) = problem.terms(&model, *index, lines, &errors) else {
                return Err(undetermined());
            };
            problem.with_rows(&model, &terms, |rows| {
                let left = terms.weight.times(&unknowns.left(rows));
                for (response, score) in scores.iter_mut().enumerate() {
                    score.add(rows, response, &left);
                }
            });
        }
        let mut largest = (R::of(SIGNIFICANT), None);
        for (response, score) in scores.iter().enumerate() {
            let (value, significance) = self.constant_of(score, &unknowns, equations);
            if significance > largest.0 {
                largest = (significance, Some((response, value)));
            }
        }
        if let Some((response, value)) = largest.1 {
            let (code, subject) = (Code::HammerInResponse, Subject::channel(1 + response));
            let found = Diagnostic::about(code, Severity::Warning, subject, value.to_f32());
            // There are only a handful of diagnostics.
            let _ = self.diagnostics.push(found);
        }
        Ok(())
    }

    /// The constant of a response, (m/s²)/N, and its significance, standard deviations.
    fn constant_of<const S: usize>(
        &self,
        score: &Score<R, S>,
        unknowns: &UnknownValues<R, S>,
        equations: &mut NormalEquations<'_, R>,
    ) -> (R, R) {
        let solved = equations.solve(|right| {
            right.iter_mut().zip(score.right.iter()).for_each(|(to, value)| *to = value);
        });
        let explained = score.right.iter().zip(solved).fold(R::zero(), |sum, (b, x)| sum + b * *x);
        let information = score.information - explained;
        let value = score.score / information;
        // The constant would also explain a part of the nuisance parameters, from whose size the scale is learned.
        let (mut pulls, mut left) = (R::zero(), R::zero());
        for (u, moved) in unknowns.sensors.iter().flatten().zip(solved) {
            let without = *u - *moved * value;
            pulls += *u * *u;
            left += without * without;
        }
        (value, self.significance(score.score / information.sqrt(), left / pulls))
    }

    /// A score in standard deviations. Where the constant scale was learned, the scale without the constant counts:
    /// the squares of the pulls become smaller by the factor `left`. Such a score has Student's distribution;
    /// returned is the normal score of about the same probability (Wallace 1959).
    fn significance(&self, score: R, left: R) -> R {
        let Some(learned) = self.learned.filter(|l| l.constant_log_variance > R::zero()) else {
            return score.abs();
        };
        let freedom = 0.5 / learned.constant_log_variance.to_f64();
        let student = (score * score / left.min(R::one())).to_f64();
        let normal = libm::sqrt(freedom * libm::log1p(student / freedom));
        R::of(normal * (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0))
    }
}

#[cfg(test)]
mod tests;
