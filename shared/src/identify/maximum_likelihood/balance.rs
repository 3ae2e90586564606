//! Balanced variables: lengths in units of L about the sensors' centroid.
//!
//! In these variables angular accelerations are multiplied by L, torques and first moments divided by L,
//! inertias divided by L² (theory, section 1), and accelerances unchanged. The whole fit uses them, since
//! single precision would not suffice otherwise.

use nalgebra::{SMatrix, SVector, Vector3};

use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::layout::{AttachedBody, Layout, Prior};
use crate::real::Real;

/// Smallest standard deviation of a prior in balanced units: a smaller one would leave single precision no
/// room for anything else.
const LEAST_SIGMA: f64 = 1e-6;

/// Origin and unit of length of the balanced variables.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::identify) struct Balance<R> {
    pub(in crate::identify) origin: Vector3<R>,
    pub(in crate::identify) length: R,
}

impl<R: Real> Balance<R> {
    pub(in crate::identify) fn of<C: Capacity>(layout: &Layout<R, C>) -> Self {
        Self { origin: layout.sensor_centroid(), length: layout.characteristic_length() }
    }

    pub(in crate::identify) fn point(&self, position: &[R; 3]) -> Vector3<R> {
        (Vector3::from(*position) - self.origin) / self.length
    }

    pub(in crate::identify) fn body(&self, body: &RigidBody<R>) -> RigidBody<R> {
        RigidBody {
            mass: body.mass,
            center_of_mass: (body.center_of_mass - self.origin) / self.length,
            inertia: body.inertia / (self.length * self.length),
        }
    }

    pub(in crate::identify) fn body_back(&self, body: &RigidBody<R>) -> RigidBody<R> {
        RigidBody {
            mass: body.mass,
            center_of_mass: body.center_of_mass * self.length + self.origin,
            inertia: body.inertia * (self.length * self.length),
        }
    }

    /// phi of an attached body; `None` when it has no mass.
    pub(in crate::identify) fn attached(
        &self,
        attached: &AttachedBody<R>,
    ) -> Option<SVector<R, 10>> {
        let body = RigidBody::from_phi(&SVector::from(attached.phi))?;
        Some(self.body(&body).phi())
    }

    /// Value and standard deviation of a prior; `None` for a property that does not exist.
    pub(in crate::identify) fn prior(&self, prior: &Prior<R>) -> Option<(usize, R, R)> {
        let k = usize::from(prior.property);
        let scale = *self.theta_scale().get(k)?;
        let from = if (1..4).contains(&k) { self.origin[k - 1] } else { R::zero() };
        let sigma = (prior.sigma / scale).max(R::of(LEAST_SIGMA));
        Some((k, (prior.value - from) / scale, sigma))
    }

    /// Covariance of theta in SI units from the balanced one.
    pub(in crate::identify) fn covariance_back(
        &self,
        balanced: &SMatrix<R, 10, 10>,
    ) -> SMatrix<R, 10, 10> {
        let scale = self.theta_scale();
        SMatrix::from_fn(|i, j| {
            // The two halves differ by rounding.
            (balanced[(i, j)] + balanced[(j, i)]) * R::of(0.5) * scale[i] * scale[j]
        })
    }

    /// [1, L, L, L, L² × 6].
    pub(in crate::identify) fn theta_scale(&self) -> SVector<R, 10> {
        SVector::from_fn(|k, _| match k {
            0 => R::one(),
            1..4 => self.length,
            _ => self.length * self.length,
        })
    }
}
