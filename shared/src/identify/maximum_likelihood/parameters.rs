//! What a fit varies: the inertial parameters freely, or log-Cholesky parameters, which are physical bodies only.

use nalgebra::{SMatrix, SVector};

use super::fit_problem::FitProblem;
use crate::Real;
use crate::body::{LogCholesky, RigidBody};

/// Longest step in log-Cholesky parameters, which are logarithms and lengths over L.
const LONGEST_STEP: f64 = 1.0;
/// Part of the largest to which the eigenvalues of `½ tr(J) I − J` are raised at a restart.
pub(super) const RAISED: f64 = 0.05;

/// The ten that are varied.
#[derive(Clone, Copy, Debug)]
pub(super) enum Parameters<R> {
    /// phi of the object, balanced.
    Free(SVector<R, 10>),
    /// Only physical bodies: on the way from a crude start, and where the free minimum is none.
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

    /// `∂phi` over the parameters; `None` when they are phi itself.
    pub(super) fn slopes(&self) -> Option<SMatrix<R, 10, 10>> {
        match self {
            Self::Free(_) => None,
            Self::Consistent { body, .. } => Some(body.dphi()),
        }
    }

    /// The parameters after a step; `None` when it is too long.
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

    /// What the damping is relative to: of free properties each has its own unit (Marquardt); the
    /// log-Cholesky parameters are comparable, and near the edge of what is physical some have no
    /// information left (Levenberg).
    pub(super) fn levels(&self, information: &SMatrix<R, 10, 10>) -> SVector<R, 10> {
        if self.is_held() {
            SVector::from_element(information.trace() * R::of(0.1))
        } else {
            information.diagonal()
        }
    }

    /// True when only physical bodies are looked at.
    pub(super) fn is_held(&self) -> bool {
        matches!(self, Self::Consistent { .. })
    }

    /// Those of a crude start, `whole` the object with all that hangs on it.
    pub(super) fn on_the_way<const S: usize, const H: usize>(
        problem: &FitProblem<'_, R, S, H>,
        whole: &RigidBody<R>,
    ) -> Option<Self> {
        let object = RigidBody::from_phi(&(whole.phi() - problem.attached_sum()));
        // What hangs on the object may outweigh a start that is far off.
        let object = object.filter(|object| object.mass > R::zero()).unwrap_or(*whole);
        let body = LogCholesky::from_body(&object.made_consistent(R::of(RAISED))?)?;
        Some(Self::Consistent { body, on_the_way: true })
    }
}
