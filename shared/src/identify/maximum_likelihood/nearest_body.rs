//! The step to the best physical body, where the best fit is none.
//!
//! A body is physical when its pseudo-inertia P is positive definite (Wensing, Kim & Slotine 2018), that is when
//! `wᵀ P w = nᵀ φ` is positive for every w. Each φ that is not physical violates the one with the smallest eigenvalue of
//! the second moments about the centre of mass most: a plane that cuts it off. The quadratic model of χ² is minimized
//! within the planes found so far, by ascent of their multipliers one after the other (Hildreth 1957), until no further
//! plane cuts. The step goes where the data say little; raising an eigenvalue alone would make another body of a slender
//! one, because moments of inertia that are known well would change with it.

use nalgebra::{SMatrix, SVector, Vector3};

use super::damped_step::damped_step;
use crate::Real;
use crate::body::RigidBody;

/// Part of the largest second moment to which the others are at least held, that of a rod a hundred times as long as it is
/// thick: inside the boundary of the physical bodies by more than a rounding error of single precision.
const LEAST: f64 = 1e-5;
/// Part of the largest second moment to which the others are raised where no step leads to a body.
const RAISED: f64 = 0.05;
/// Largest number of planes; two are usual.
const MOST_PLANES: usize = 12;
/// Number of rounds over all planes.
const ROUNDS: usize = 30;

/// The step from `phi` along which the quadratic model with this information and gradient falls to its smallest value at a
/// physical body. `None` when the information is not positive definite, or no body is found.
// Not inlined, for the firmware's deepest stack.
#[inline(never)]
pub(super) fn step_to_body<R: Real>(
    phi: &SVector<R, 10>,
    information: &SMatrix<R, 10, 10>,
    gradient: &SVector<R, 10>,
    damping: R,
    levels: &SVector<R, 10>,
) -> Option<SVector<R, 10>> {
    let solve = |right: &SVector<R, 10>| damped_step(information, right, damping, levels);
    let mut step = solve(gradient)?;
    let mut planes = heapless::Vec::<Plane<R>, MOST_PLANES>::new();
    while let Some((normal, least)) = cutting_plane(&(phi + step))? {
        let direction = solve(&normal)?;
        let own = Plane { normal, direction, least, multiplier: R::zero() };
        planes.push(own).ok()?;
        for _ in 0..ROUNDS {
            for plane in &mut planes {
                let missing = plane.least - plane.normal.dot(&(phi + step));
                let change = missing / plane.normal.dot(&plane.direction);
                let change = change.max(-plane.multiplier);
                plane.multiplier += change;
                step += plane.direction * change;
            }
        }
    }
    Some(step)
}

/// A physical body near one that is none, for a start without equations.
pub(super) fn raised<R: Real>(body: &RigidBody<R>) -> Option<RigidBody<R>> {
    body.made_consistent(R::of(RAISED))
}

/// A plane `nᵀ φ = least` in the space of the inertial parameters, on whose one side there are no bodies.
struct Plane<R> {
    normal: SVector<R, 10>,
    /// `I⁻¹ n`.
    direction: SVector<R, 10>,
    least: R,
    multiplier: R,
}

/// The plane that cuts off these inertial parameters, and the value that its bodies have at least; no plane for a body.
/// `None` when the numbers are those of no plane.
fn cutting_plane<R: Real>(phi: &SVector<R, 10>) -> Option<Option<(SVector<R, 10>, R)>> {
    let body = RigidBody::from_phi(phi)?;
    let principal = body.principal()?;
    let [smallest, middle, largest] = principal.moments.into();
    let half = R::of(0.5);
    let least = (middle + largest - smallest) * half * R::of(LEAST);
    let margin = (smallest + middle - largest) * half;
    if body.mass <= R::zero() || least <= R::zero() {
        return None;
    }
    // Half of it is enough, as the planes that were found only nearly bound the bodies.
    let is_body = margin > least * half;
    Some((!is_body).then(|| (normal(&body, &principal.axes.column(2).into_owned()), least)))
}

/// The derivative of `wᵀ P w` with respect to the inertial parameters, for `w = (v, −v · c)`.
fn normal<R: Real>(body: &RigidBody<R>, v: &Vector3<R>) -> SVector<R, 10> {
    let (half, two) = (R::of(0.5), R::of(2.0));
    let last = -v.dot(&body.center_of_mass);
    let [x, y, z] = (*v).into();
    SVector::from([
        last * last,
        two * last * x,
        two * last * y,
        two * last * z,
        half - x * x,
        half - y * y,
        half - z * z,
        -two * x * y,
        -two * x * z,
        -two * y * z,
    ])
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    fn body(moments: [f64; 3]) -> RigidBody<f64> {
        RigidBody {
            mass: 3.0,
            center_of_mass: Vector3::new(0.1, -0.2, 0.3),
            inertia: Matrix3::from_diagonal(&Vector3::from(moments)),
        }
    }

    #[test]
    fn the_normal_is_the_derivative_of_the_smallest_eigenvalue() {
        let inertia = Matrix3::new(0.02, 0.001, 0.002, 0.001, 0.03, -0.003, 0.002, -0.003, 0.045);
        let body = RigidBody { inertia, ..body([0.0; 3]) };
        let margin = |phi: &SVector<f64, 10>| {
            RigidBody::from_phi(phi).and_then(|body| body.physical_margin()).expect("a body")
        };
        let axes = body.principal().expect("principal axes").axes;
        let normal = normal(&body, &axes.column(2).into_owned());
        let difference = 1e-6;
        for k in 0..10 {
            let moved = |by: f64| {
                let mut phi = body.phi();
                phi[k] += by;
                margin(&phi)
            };
            let slope = (moved(difference) - moved(-difference)) / (2.0 * difference);
            // The error of the difference is its square times a third derivative, below 1e4 here.
            assert!((normal[k] - slope).abs() < 1e-7, "{k}: {} {slope}", normal[k]);
        }
    }

    #[test]
    fn a_step_ends_at_a_body_and_changes_what_the_data_do_not_tell() {
        let center_of_mass = Vector3::zeros();
        let impossible = RigidBody { center_of_mass, ..body([0.001, 0.30, 0.31]) };
        // J_xx is known to 1e-5 kg m², everything else to 0.1 of its unit.
        let mut information = SMatrix::<f64, 10, 10>::identity() * 1e2;
        information[(4, 4)] = 1e10;
        let none = SVector::zeros();
        let step =
            step_to_body(&impossible.phi(), &information, &none, 0.0, &none).expect("a step");
        let physical = RigidBody::from_phi(&(impossible.phi() + step)).expect("a body");
        assert!(physical.is_physically_consistent());
        // A hundredth of what J_xx is known to; the cheapest way leads over the two large moments.
        assert!(step[4].abs() < 1e-7, "{step}");
        assert!((step[5] - 0.0045).abs() < 1e-4 && (step[6] + 0.0045).abs() < 1e-4, "{step}");
    }

    #[test]
    fn a_body_is_cut_off_by_no_plane() {
        assert!(cutting_plane(&body([0.2, 0.25, 0.3]).phi()).expect("numbers").is_none());
        assert!(cutting_plane(&(-body([0.2, 0.25, 0.3]).phi())).is_none());
    }
}
