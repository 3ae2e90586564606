//! Evaluates score tests at the minimum of a fit: visits the residuals of all hit DOFs, and says how significant the
//! scores are.

use super::fit::Fit;
use super::fit_problem::FitProblem;
use super::model::Model;
use super::normal_equations::{NormalEquations, Rows};
use super::pulls::UnknownValues;
use super::score::{Score, ScoreOutcome};
use super::undetermined;
use crate::capacity::Capacity;
use crate::diagnosis::Diagnostics;
use crate::identify::{DofMassLines, MassLines};
use crate::real::Real;
use crate::responses::Responses;

impl<R: Real> Fit<R> {
    /// Calls `act` with the rows and the weighted residual of each hit DOF; returns the unknowns at the minimum.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    pub(super) fn visit<C: Capacity>(
        &self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &NormalEquations<'_, R>,
        unknowns: &UnknownValues<R, C>,
        mut act: impl FnMut(&MassLines<R, C>, &Rows<'_, R, C>, &Responses<R, C>),
    ) -> Result<(), Diagnostics> {
        let object = self.object().ok_or_else(undetermined)?;
        let body = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
        let model = Model::new(problem.layout, &problem.balance, &body).ok_or_else(undetermined)?;
        for (place, (index, lines)) in dofs.iter().enumerate() {
            let errors = equations.hit_errors(place);
            let terms = problem.terms(&model, *index, lines, &errors).ok_or_else(undetermined)?;
            problem.with_rows(&model, &terms, |rows| {
                let left = terms.weight.times(&unknowns.left(rows));
                act(lines, rows, &left);
            });
        }
        Ok(())
    }

    /// Size and significance of a change, from completed equations.
    pub(super) fn tested<C: Capacity>(
        &self,
        score: &Score<R, C>,
        unknowns: &UnknownValues<R, C>,
        equations: &mut NormalEquations<'_, R>,
    ) -> ScoreOutcome<R> {
        let solved = equations.solve(|right| {
            right.iter_mut().zip(score.right.iter()).for_each(|(to, value)| *to = value);
        });
        let explained = score.right.iter().zip(solved).fold(R::zero(), |sum, (b, x)| sum + b * *x);
        let information = score.information - explained;
        let size = score.score / information;
        // The change would also explain a part of the nuisance parameters, from whose size the scale is learned.
        let (mut pulls, mut left) = (R::zero(), R::zero());
        for (u, moved) in unknowns.sensors.iter().flatten().zip(solved) {
            let without = *u - *moved * size;
            pulls += *u * *u;
            left += without * without;
        }
        let significance = self.significance(score.score / information.sqrt(), left / pulls);
        ScoreOutcome { size, significance }
    }

    /// A score in standard deviations. Where the constant scale was learned, the scale without the change counts: the
    /// squares of the pulls become smaller by the factor `left`. Such a score has Student's distribution; returned
    /// is the normal score of about the same probability (Wallace 1959).
    fn significance(&self, score: R, left: R) -> R {
        let Some(learned) = self.learned.filter(|l| l.constant_log_variance > R::zero()) else {
            return score;
        };
        let freedom = 0.5 / learned.constant_log_variance.to_f64();
        let student = (score * score / left.min(R::one())).to_f64();
        let normal = libm::sqrt(freedom * libm::log1p(student / freedom));
        R::of(libm::copysign(
            normal * (8.0 * freedom + 1.0) / (8.0 * freedom + 3.0),
            score.to_f64(),
        ))
    }
}
