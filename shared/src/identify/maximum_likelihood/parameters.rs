//! The parameters of a fit: the inertial parameters, free or held to the physical bodies, or log-Cholesky parameters,
//! which admit nothing else, on the way from a crude start.

use nalgebra::{SMatrix, SVector};

use super::damped_step::damped_step;
use super::fit_problem::FitProblem;
use super::nearest_body::{raised, step_to_body};
use crate::body::{LogCholesky, RigidBody};
use crate::capacity::Capacity;
use crate::real::Real;

/// Longest step in log-Cholesky parameters, which are logarithms and lengths over L.
const LONGEST_STEP: f64 = 1.0;
/// The ten parameters that the fit varies.
#[derive(Clone, Copy, Debug)]
pub(super) enum Parameters<R> {
    /// phi of the object, balanced.
    Free(SVector<R, 10>),
    /// phi of the object, balanced, from which steps lead to physical bodies only: the free minimum is none.
    Bounded(SVector<R, 10>),
    /// Log-Cholesky parameters, on the way from a crude start.
    OnTheWay(LogCholesky<R>),
}

impl<R: Real> Parameters<R> {
    /// phi of the object, balanced.
    pub(super) fn phi(&self) -> SVector<R, 10> {
        match self {
            Self::Free(phi) | Self::Bounded(phi) => *phi,
            Self::OnTheWay(body) => body.body().phi(),
        }
    }

    /// Derivative of phi with respect to the parameters; `None` when they are phi itself.
    pub(super) fn slopes(&self) -> Option<SMatrix<R, 10, 10>> {
        match self {
            Self::Free(_) | Self::Bounded(_) => None,
            Self::OnTheWay(body) => Some(body.dphi()),
        }
    }

    /// The parameters after a step; `None` when the step is too long.
    pub(super) fn moved(&self, step: &SVector<R, 10>) -> Option<Self> {
        match self {
            Self::Free(phi) => Some(Self::Free(phi + step)),
            Self::Bounded(phi) => Some(Self::Bounded(phi + step)),
            Self::OnTheWay(LogCholesky(z)) => {
                let is_short = step.norm() <= R::of(LONGEST_STEP);
                is_short.then_some(Self::OnTheWay(LogCholesky(z + step)))
            }
        }
    }

    /// Scales of the damping. Free parameters have different units, so each gets its own (Marquardt);
    /// log-Cholesky parameters are comparable, and near the boundary of the physical bodies some of them
    /// carry no information (Levenberg).
    fn levels(&self, information: &SMatrix<R, 10, 10>) -> SVector<R, 10> {
        match self {
            Self::OnTheWay(_) => SVector::from_element(information.trace() * R::of(0.1)),
            Self::Free(_) | Self::Bounded(_) => information.diagonal(),
        }
    }

    /// The step to the minimum of the quadratic model of the cost; `None` when it has none.
    pub(super) fn step(
        &self,
        information: &SMatrix<R, 10, 10>,
        gradient: &SVector<R, 10>,
        damping: R,
    ) -> Option<SVector<R, 10>> {
        let levels = self.levels(information);
        match self {
            Self::Bounded(phi) => step_to_body(phi, information, gradient, damping, &levels),
            _ => damped_step(information, gradient, damping, &levels),
        }
    }

    /// True when only physical bodies are admitted.
    pub(super) fn are_physical(&self) -> bool {
        !matches!(self, Self::Free(_))
    }

    /// Log-Cholesky parameters of a crude start; `whole` is the object with the attached bodies.
    pub(super) fn on_the_way<C: Capacity>(
        problem: &FitProblem<'_, R, C>,
        whole: &RigidBody<R>,
    ) -> Option<Self> {
        let object = RigidBody::from_phi(&(whole.phi() - problem.attached_sum()));
        // The attached bodies may be heavier than an inaccurate start.
        let object = object.filter(|object| object.mass > R::zero()).unwrap_or(*whole);
        Some(Self::OnTheWay(LogCholesky::from_body(&raised(&object)?)?))
    }
}
