//! Subtracts the attached bodies from an estimate.

use nalgebra::SVector;

use super::Estimate;
use crate::body::RigidBody;
use crate::layout::AttachedBody;
use crate::linalg::congruence;
use crate::real::Real;

/// Subtracts the attached bodies from an estimate of the object with them. Their uncertainty is added to the
/// covariance.
///
/// # Errors
/// The remaining mass, when it is not positive.
pub(super) fn take_off<R: Real>(
    estimate: &mut Estimate<R>,
    attached: &[AttachedBody<R>],
) -> Result<(), R> {
    if attached.is_empty() {
        return Ok(());
    }
    let mut phi = estimate.body.phi();
    for body in attached {
        phi -= SVector::from(body.phi);
    }
    let Some(object) = RigidBody::from_phi(&phi).filter(|object| object.mass > R::zero()) else {
        return Err(phi[0]);
    };
    if let Some(covariance) = &mut estimate.covariance {
        congruence(&estimate.body.dphi_dtheta(), covariance);
        for body in attached {
            let by_mass = SVector::from(body.phi) * body.relative_sigma;
            covariance.ger(R::one(), &by_mass, &by_mass, R::one());
        }
        congruence(&object.dtheta_dphi(), covariance);
    }
    estimate.body = object;
    Ok(())
}
