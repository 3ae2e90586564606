//! What every method of identification answers with.

use nalgebra::{SMatrix, SVector, Vector3};

use crate::Real;
use crate::body::RigidBody;
use crate::diagnosis::Diagnostics;

/// The ten properties with what is known of their quality.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate<R> {
    /// The body, in the body frame of the layout.
    pub body: RigidBody<R>,
    /// Covariance of [`RigidBody::theta`]; `None` when it cannot be told.
    pub covariance: Option<SMatrix<R, 10, 10>>,
    /// Rank of the balanced regression matrix: ten.
    pub rank: usize,
    /// Condition of the balanced regression matrix.
    pub condition: R,
    /// Condition of the balanced response matrix.
    pub response_condition: R,
    /// Root mean square of the residuals of the balanced equations, a force on a unit force.
    pub rms: R,
    /// What is to be said about the answer; no errors.
    pub diagnostics: Diagnostics,
}

impl<R: Real> Estimate<R> {
    /// [m, c, J about the centre of mass].
    pub fn theta(&self) -> SVector<R, 10> {
        self.body.theta()
    }

    /// Standard deviations of [`Estimate::theta`].
    pub fn sigma(&self) -> Option<SVector<R, 10>> {
        self.covariance.map(|c| c.diagonal().map(|v| v.max(R::zero()).sqrt()))
    }

    /// Standard deviations of the principal moments, ascending moments, kg m².
    pub fn principal_moment_sigmas(&self) -> Option<Vector3<R>> {
        Some(self.body.principal()?.moment_sigmas(self.covariance.as_ref()?))
    }
}
