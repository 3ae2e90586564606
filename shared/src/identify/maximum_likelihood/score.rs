//! Score tests (Rao 1948) of faults that no error of the budget describes: whether the residuals of a fit contain a
//! given change of the accelerances. They need no further fit (theory, section 12).

use heapless::Vec;

use super::fit::Fit;
use super::fit_problem::FitProblem;
use super::model::Model;
use super::normal_equations::{NormalEquations, Rows};
use super::pulls::UnknownValues;
use super::undetermined;
use crate::Real;
use crate::diagnosis::Diagnostics;
use crate::identify::{DofMassLines, MassLines};
use crate::responses::Responses;

/// Sums over the DOFs for one change of the accelerances, of unknown size.
pub(super) struct Score<R, const S: usize> {
    score: R,
    /// Before the unknowns explain a part.
    information: R,
    /// The right side of the equations for a residual of this change.
    right: UnknownValues<R, S>,
}

/// The outcome of a score test.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tested<R> {
    /// Size of the change.
    pub(super) size: R,
    /// The size in standard deviations.
    pub(super) significance: R,
}

/// Responses that are tested together; more would need more of the firmware's deepest stack.
pub(super) const TOGETHER: usize = 5;

/// Scores of one change for some responses, each with the number of the response.
pub(super) type ScoresOfResponses<R, const S: usize> = Vec<(usize, Score<R, S>), TOGETHER>;

impl<R: Real, const S: usize> Score<R, S> {
    pub(super) fn none(unknowns: &UnknownValues<R, S>) -> Self {
        Self { score: R::zero(), information: R::zero(), right: unknowns.zeros() }
    }

    /// Sums without a DOF for the first [`TOGETHER`] of these responses.
    // Not inlined, for the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn of_responses(
        unknowns: &UnknownValues<R, S>,
        responses: impl Iterator<Item = usize>,
        scores: &mut ScoresOfResponses<R, S>,
    ) {
        scores.clear();
        for response in responses.take(TOGETHER) {
            // There is room for as many.
            let _ = scores.push((response, Self::none(unknowns)));
        }
    }

    /// Adds a change of a hit DOF, whose weighted residual is `left`.
    pub(super) fn add(
        &mut self,
        rows: &Rows<'_, R, S>,
        change: &Responses<R, S>,
        left: &Responses<R, S>,
    ) {
        let weighted = rows.weight.times(change);
        self.add_weighted(rows, &weighted, change.dot(left), change.dot(&weighted));
    }

    /// Adds a change of a single response.
    pub(super) fn add_response(
        &mut self,
        rows: &Rows<'_, R, S>,
        (response, change): (usize, R),
        left: &Responses<R, S>,
    ) {
        let weighted = rows.weight.column(response) * change;
        self.add_weighted(rows, &weighted, change * left[response], change * weighted[response]);
    }

    fn add_weighted(
        &mut self,
        rows: &Rows<'_, R, S>,
        weighted: &Responses<R, S>,
        score: R,
        information: R,
    ) {
        self.score += score;
        self.information += information;
        let UnknownValues { sensors, shared } = &mut self.right;
        rows.add_products(weighted, sensors.as_flattened_mut(), shared);
    }
}

impl<R: Real> Tested<R> {
    /// This test and another one of the same change, by other readings, together.
    pub(super) fn and(self, other: Self) -> Self {
        let information = |one: Self| {
            let inverse_sigma = one.significance / one.size;
            if inverse_sigma.finite() { inverse_sigma * inverse_sigma } else { R::zero() }
        };
        let [own, others] = [self, other].map(information);
        let size = (self.size * own + other.size * others) / (own + others);
        Self { size, significance: size * (own + others).sqrt() }
    }
}

impl<R: Real> Fit<R> {
    /// Calls `act` with the rows and the weighted residual of each hit DOF; returns the unknowns at the minimum.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    // Not inlined, for the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn visit<const S: usize, const H: usize>(
        &self,
        problem: &FitProblem<'_, R, S, H>,
        dofs: &[DofMassLines<R, S>],
        equations: &NormalEquations<'_, R>,
        unknowns: &UnknownValues<R, S>,
        mut act: impl FnMut(&MassLines<R, S>, &Rows<'_, R, S>, &Responses<R, S>),
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
    // Not inlined, for the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn tested<const S: usize>(
        &self,
        score: &Score<R, S>,
        unknowns: &UnknownValues<R, S>,
        equations: &mut NormalEquations<'_, R>,
    ) -> Tested<R> {
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
        Tested { size, significance }
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
