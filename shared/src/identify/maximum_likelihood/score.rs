//! Score tests (Rao 1948) of faults that no error of the budget describes: whether the residuals of a fit contain a
//! given change of the accelerances. They need no further fit (theory, section 12).

use heapless::Vec;

use super::normal_equations::Rows;
use super::pulls::UnknownValues;
use crate::capacity::Capacity;
use crate::real::Real;
use crate::responses::Responses;

/// Sums over the DOFs for one change of the accelerances, of unknown size.
pub(super) struct Score<R: Real, C: Capacity> {
    pub(super) score: R,
    /// Before the unknowns explain a part.
    pub(super) information: R,
    /// The right side of the equations for a residual of this change.
    pub(super) right: UnknownValues<R, C>,
}

/// The outcome of a score test.
#[derive(Clone, Copy, Debug)]
pub(super) struct ScoreOutcome<R> {
    /// Size of the change.
    pub(super) size: R,
    /// The size in standard deviations.
    pub(super) significance: R,
}

/// A response that seems to contain the hammer, with the constant, (m/s²)/N.
pub(super) type SuspectedResponse<R> = (usize, ScoreOutcome<R>);

/// Responses that are tested together; more would need more of the firmware's deepest stack.
pub(super) const TOGETHER: usize = 5;

/// Scores of one change for some responses, each with the number of the response.
pub(super) type ScoresOfResponses<R, C> = Vec<(usize, Score<R, C>), TOGETHER>;

impl<R: Real, C: Capacity> Score<R, C> {
    pub(super) fn none(unknowns: &UnknownValues<R, C>) -> Self {
        Self { score: R::zero(), information: R::zero(), right: unknowns.zeros() }
    }

    /// Sums without a DOF for the first [`TOGETHER`] of these responses.
    pub(super) fn of_responses(
        unknowns: &UnknownValues<R, C>,
        responses: impl Iterator<Item = usize>,
        scores: &mut ScoresOfResponses<R, C>,
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
        rows: &Rows<'_, R, C>,
        change: &Responses<R, C>,
        left: &Responses<R, C>,
    ) {
        let weighted = rows.weight.times(change);
        self.add_weighted(rows, &weighted, change.dot(left), change.dot(&weighted));
    }

    /// Adds a change of a single response.
    pub(super) fn add_response(
        &mut self,
        rows: &Rows<'_, R, C>,
        (response, change): (usize, R),
        left: &Responses<R, C>,
    ) {
        let mut weighted = rows.weight.column(response);
        weighted *= change;
        self.add_weighted(rows, &weighted, change * left[response], change * weighted[response]);
    }

    fn add_weighted(
        &mut self,
        rows: &Rows<'_, R, C>,
        weighted: &Responses<R, C>,
        score: R,
        information: R,
    ) {
        self.score += score;
        self.information += information;
        let UnknownValues { sensors, shared } = &mut self.right;
        rows.add_products(weighted, sensors.as_flattened_mut(), shared);
    }
}

impl<R: Real> ScoreOutcome<R> {
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
