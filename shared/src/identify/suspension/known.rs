//! Priors as linear equations in the inertial parameters.

use heapless::Vec;
use nalgebra::Vector3;

use crate::capacity::Capacity;
use crate::layout::Layout;
use crate::real::Real;

/// Most known properties: the mass and the centre of mass. The moments of inertia about it are not linear in the
/// inertial parameters.
const MOST_KNOWN: usize = 4;

/// A linear equation for `phi = [m, m c, J]` about the reference point, with the attached bodies: `row · phi = value`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownProperty<R> {
    /// The coefficients.
    pub row: [R; 10],
    /// The right side.
    pub value: R,
    /// Standard deviation of the right side.
    pub sigma: R,
}

/// The priors of a layout on mass and centre of mass; that on the centre of mass times `mass`, the expected mass, is
/// that of `m c`.
pub(super) fn known_properties<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    reference: &Vector3<R>,
    mass: R,
) -> Vec<KnownProperty<R>, MOST_KNOWN> {
    let mut attached = [R::zero(); 10];
    for body in &layout.attached {
        attached.iter_mut().zip(body.phi).for_each(|(sum, v)| *sum += v);
    }
    let mut known = Vec::new();
    for prior in &layout.priors {
        let property = usize::from(prior.property);
        let mut row = [R::zero(); 10];
        let (value, sigma) = match property {
            0 => {
                row[0] = R::one();
                (prior.value + attached[0], prior.sigma)
            }
            1..4 => {
                // m c of the object is (m c) − c m, and about the reference point m c = (m c)' + m r.
                let along = reference[property - 1];
                row[property] = R::one();
                row[0] = along - prior.value;
                let hung = attached[property] - prior.value * attached[0];
                (hung, prior.sigma * mass)
            }
            _ => continue,
        };
        // There is room for the four of them; a second one on the same property is left out.
        let _ = known.push(KnownProperty { row, value, sigma });
    }
    known
}
