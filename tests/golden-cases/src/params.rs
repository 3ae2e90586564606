//! `p_`: transformations of the ten inertial parameters.

use massline_shared::Real;
use massline_shared::body::{LogCholesky, RigidBody};
use nalgebra::{SVector, Vector3};

use crate::Check;

pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let body = RigidBody::from_theta(&SVector::from(check.input_array::<10>("theta")?));
    let shift = Vector3::from(check.input_array::<3>("shift")?);
    check.numbers("phi", body.phi().as_slice());
    check.matrix("M0", &body.mass_matrix());
    check.matrix("dtheta_dphi", &body.dtheta_dphi());
    check.matrix("pseudo_inertia", &body.pseudo_inertia());
    let logarithmic = LogCholesky::from_body(&body)?;
    check.numbers("logchol", logarithmic.0.as_slice());
    check.matrix("dphi_dlogchol", &logarithmic.dphi());
    let principal = body.principal()?;
    check.numbers("principal_moments", principal.moments.as_slice());
    check.matrix("principal_axes", &principal.axes);
    check.numbers("phi_shifted", body.shifted_to(&shift).phi().as_slice());
    check.numbers("physical_margin", &[body.physical_margin()?]);
    Some(())
}
