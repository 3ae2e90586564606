//! The parameters of a fit: the inertial parameters, or log-Cholesky parameters, which admit physical bodies
//! only.

use nalgebra::{SMatrix, SVector};

use super::fit_problem::FitProblem;
use crate::Real;
use crate::body::{LogCholesky, RigidBody};

/// Longest step in log-Cholesky parameters, which are logarithms and lengths over L.
const LONGEST_STEP: f64 = 1.0;
/// Fraction of the largest eigenvalue of `½ tr(J) I − J` to which the others are raised at a restart.
pub(super) const RAISED: f64 = 0.05;

/// The ten parameters that the fit varies.
#[derive(Clone, Copy, Debug)]
pub(super) enum Parameters<R> {
    /// phi of the object, balanced.
    Free(SVector<R, 10>),
    /// Log-Cholesky parameters, which admit physical bodies only: on the way from a crude start, and when the
    /// free minimum is not a physical body.
    Consistent { body: LogCholesky<R>, on_the_way: bool },
}

impl<R: Real> Parameters<R> {
    /// phi of the object, balanced.
    pub(super) fn phi(&self) -> SVector<R, 10> {
        match self {
            Self::Free(phi) => *phi,
            Self::Consistent { body, .. } => body.body().phi(),
        }
    }

    /// Derivative of phi with respect to the parameters; `None` when they are phi itself.
    pub(super) fn slopes(&self) -> Option<SMatrix<R, 10, 10>> {
        match self {
            Self::Free(_) => None,
            Self::Consistent { body, .. } => Some(body.dphi()),
        }
    }

    /// The parameters after a step; `None` when the step is too long.
    pub(super) fn moved(&self, step: &SVector<R, 10>) -> Option<Self> {
        match self {
            Self::Free(phi) => Some(Self::Free(phi + step)),
            Self::Consistent { body: LogCholesky(z), on_the_way } => {
                let body = LogCholesky(z + step);
                (step.norm() <= R::of(LONGEST_STEP))
                    .then_some(Self::Consistent { body, on_the_way: *on_the_way })
            }
        }
    }

    /// Scales of the damping. Free parameters have different units, so each gets its own (Marquardt);
    /// log-Cholesky parameters are comparable, and near the boundary of the physical bodies some of them
    /// carry no information (Levenberg).
    pub(super) fn levels(&self, information: &SMatrix<R, 10, 10>) -> SVector<R, 10> {
        if self.is_consistent() {
            SVector::from_element(information.trace() * R::of(0.1))
        } else {
            information.diagonal()
        }
    }

    /// True when only physical bodies are admitted.
    pub(super) fn is_consistent(&self) -> bool {
        matches!(self, Self::Consistent { .. })
    }

    /// Log-Cholesky parameters of a crude start; `whole` is the object with the attached bodies.
    pub(super) fn on_the_way<const S: usize, const H: usize>(
        problem: &FitProblem<'_, R, S, H>,
        whole: &RigidBody<R>,
    ) -> Option<Self> {
        let object = RigidBody::from_phi(&(whole.phi() - problem.attached_sum()));
        // The attached bodies may be heavier than an inaccurate start.
        let object = object.filter(|object| object.mass > R::zero()).unwrap_or(*whole);
        let body = LogCholesky::from_body(&object.made_consistent(R::of(RAISED))?)?;
        Some(Self::Consistent { body, on_the_way: true })
    }
}
