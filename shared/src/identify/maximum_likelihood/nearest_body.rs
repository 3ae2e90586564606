//! The step to the best physical body, where the best fit is none.
//!
//! A body is physical when its pseudo-inertia P is positive definite (Wensing, Kim & Slotine 2018), and P is linear in
//! the inertial parameters. The quadratic model of χ² is minimized together with the barrier `−μ ln det P`, which grows
//! beyond all bounds at the boundary of the physical bodies, by Newton's method, while its weight μ falls (Boyd &
//! Vandenberghe, Convex Optimization, 11.3). The step goes where the data say little; raising an eigenvalue alone would
//! make another body of a slender one, because moments of inertia that are known well would change with it.

use nalgebra::{Matrix4, SMatrix, SVector};

use super::damped_step::damped_step;
use crate::body::{RigidBody, second_moments, tensor};
use crate::linalg::{cholesky, forward_substitute};
use crate::real::Real;

/// Part of the largest second moment to which the others are raised for a start.
const RAISED: f64 = 0.05;
/// The weight of the barrier at the end. Half of χ² is above its smallest value at a body by less than four times this.
const LEAST_WEIGHT: f64 = 1e-3;
/// By what the weight falls.
const FALL: f64 = 0.1;
/// Largest number of Newton steps under one weight; three are usual.
const MOST_STEPS: usize = 12;
/// Newton's method ends before a step that lowers the sum by less than this part of the weight.
const SHORT: f64 = 0.01;
/// Number of halvings of a step that leaves the bodies or does not lower the sum.
const MOST_HALVINGS: usize = 20;
/// Damping of Newton's method, in roundings.
const ROUNDINGS: f64 = 32.0;
/// A step lowers the sum by at least this part of what its slope promises.
const LOWERED: f64 = 0.1;

/// The step from `phi` along which the quadratic model with this information and gradient falls to its smallest value
/// at a physical body. `None` when the information is not positive definite, or a number leaves its range.
pub(super) fn step_to_body<R: Real>(
    phi: &SVector<R, 10>,
    information: &SMatrix<R, 10, 10>,
    gradient: &SVector<R, 10>,
    damping: R,
    levels: &SVector<R, 10>,
) -> Option<SVector<R, 10>> {
    let none = SVector::zeros();
    let free = damped_step(information, gradient, damping, levels)?;
    if Barrier::at(&(phi + free)).is_some() {
        return Some(free);
    }
    let mut information = *information;
    for k in 0..10 {
        information[(k, k)] += damping * levels[k];
    }
    let cost =
        |step: &SVector<R, 10>| step.dot(&(information * step)) * R::of(0.5) - gradient.dot(step);
    let mut step = match Barrier::at(phi) {
        Some(_) => none,
        None => raised(&RigidBody::from_phi(phi)?)?.phi() - phi,
    };
    let least = R::of(LEAST_WEIGHT);
    let mut weight = (cost(&step) - cost(&free)).max(least);
    loop {
        for _ in 0..MOST_STEPS {
            let barrier = Barrier::at(&(phi + step))?;
            let (slope, curvature) = barrier.derivatives();
            let slope = gradient - information * step + slope * weight;
            let curvature = information + curvature * weight;
            // In single precision the curvature alone may not be positive definite by its rounding errors.
            let rounding = R::default_epsilon() * R::of(ROUNDINGS);
            let change = damped_step(&curvature, &slope, rounding, &curvature.diagonal())?;
            let promised = slope.dot(&change);
            if promised < R::of(SHORT) * weight {
                break;
            }
            let sum = cost(&step) + barrier.value() * weight;
            let mut part = R::one();
            let lower = (0..MOST_HALVINGS).find_map(|_| {
                let next = step + change * part;
                let barrier = Barrier::at(&(phi + next));
                let value = barrier.map(|barrier| cost(&next) + barrier.value() * weight);
                let most = sum - R::of(LOWERED) * part * promised;
                part *= R::of(0.5);
                value.is_some_and(|value| value <= most).then_some(next)
            });
            // No step lowers the sum within the precision.
            let Some(next) = lower else { break };
            step = next;
        }
        if weight <= least {
            return Some(step);
        }
        weight = (weight * R::of(FALL)).max(least);
    }
}

/// A physical body near one that is none, for a start without equations.
pub(super) fn raised<R: Real>(body: &RigidBody<R>) -> Option<RigidBody<R>> {
    body.made_consistent(R::of(RAISED))
}

/// `−ln det P` at a body: P is `[Σ, h; hᵀ, m]` with the second moments Σ about the origin and the first moments h.
struct Barrier<R>(
    /// The lower triangle L of `P = L Lᵀ`.
    Matrix4<R>,
);

impl<R: Real> Barrier<R> {
    /// The barrier at these inertial parameters; `None` when they are those of no body.
    fn at(phi: &SVector<R, 10>) -> Option<Self> {
        cholesky(&pseudo_inertia(phi)).map(Self)
    }

    fn value(&self) -> R {
        self.0.diagonal().iter().fold(R::zero(), |sum, v| sum - v.ln() * R::of(2.0))
    }

    /// The negative gradient `tr(P⁻¹ Eₖ)` and the curvature `tr(P⁻¹ Eₖ P⁻¹ Eₗ)`.
    fn derivatives(&self) -> (SVector<R, 10>, SMatrix<R, 10, 10>) {
        let mut inverse = Matrix4::identity();
        for mut column in inverse.column_iter_mut() {
            let mut right = column.clone_owned();
            forward_substitute(&self.0, &mut right);
            column.copy_from(&right);
        }
        // L⁻¹ Eₖ L⁻ᵀ; P is linear, so that Eₖ is the P of a unit of one parameter.
        let turned: [Matrix4<R>; 10] = core::array::from_fn(|k| {
            inverse * pseudo_inertia(&SVector::ith(k, R::one())) * inverse.transpose()
        });
        let slope = SVector::from_fn(|k, _| turned[k].trace());
        (slope, SMatrix::from_fn(|i, j| turned[i].dot(&turned[j])))
    }
}

/// P of the inertial parameters `[m, m c, J about the origin]`, of a body or not.
fn pseudo_inertia<R: Real>(phi: &SVector<R, 10>) -> Matrix4<R> {
    let second_moments = second_moments(&tensor(&phi.fixed_rows::<6>(4).into_owned()));
    Matrix4::from_fn(|i, j| match (i, j) {
        (3, 3) => phi[0],
        (3, k) | (k, 3) => phi[1 + k],
        _ => second_moments[(i, j)],
    })
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::*;

    fn body(moments: [f64; 3], center_of_mass: [f64; 3]) -> RigidBody<f64> {
        RigidBody {
            mass: 3.0,
            center_of_mass: Vector3::from(center_of_mass),
            inertia: Matrix3::from_diagonal(&Vector3::from(moments)),
        }
    }

    #[test]
    fn the_derivatives_are_those_of_the_barrier() {
        let phi = body([0.02, 0.03, 0.045], [0.1, -0.2, 0.3]).phi();
        let at = |phi: &SVector<f64, 10>| Barrier::at(phi).expect("a body");
        let (slope, curvature) = at(&phi).derivatives();
        for k in 0..10 {
            let difference = 1e-6;
            let moved = |by: f64| {
                let mut moved = phi;
                moved[k] += by;
                at(&moved)
            };
            let (ahead, behind) = (moved(difference), moved(-difference));
            let measured = (behind.value() - ahead.value()) / (2.0 * difference);
            // The third derivatives are those of ln at an eigenvalue of 0.0025: 2 / 0.0025³.
            assert!(
                (slope[k] - measured).abs() < 1e-3 + 1e-5 * measured.abs(),
                "{k}: {} {measured}",
                slope[k]
            );
            let change = (behind.derivatives().0 - ahead.derivatives().0) / (2.0 * difference);
            let error = (curvature.column(k) - change).norm();
            assert!(error < 1e-4 * curvature.column(k).norm(), "{k}: {error}");
        }
    }

    #[test]
    fn a_step_ends_at_a_body_and_changes_what_the_data_do_not_tell() {
        let impossible = body([0.001, 0.30, 0.31], [0.0; 3]);
        // J_xx is known to 1e-5 kg m², everything else to 1e-3 of its unit.
        let mut information = SMatrix::<f64, 10, 10>::identity() * 1e6;
        information[(4, 4)] = 1e10;
        let none = SVector::zeros();
        let step =
            step_to_body(&impossible.phi(), &information, &none, 0.0, &none).expect("a step");
        let physical = RigidBody::from_phi(&(impossible.phi() + step)).expect("a body");
        assert!(physical.is_physically_consistent());
        // A hundredth of what J_xx is known to; the cheapest way leads over the two large moments.
        assert!(step[4].abs() < 1e-6, "{step}");
        assert!((step[5] - 0.0045).abs() < 1e-4 && (step[6] + 0.0045).abs() < 1e-4, "{step}");
    }

    #[test]
    fn a_rod_is_found_again_however_thin_it_is() {
        // A rod of a hundredth has second moments of 1e-4 of the largest, a thousand times what single precision
        // resolves.
        [0.1, 0.03, 0.01, 0.003].into_iter().for_each(rod_is_found::<f64>);
        [0.1, 0.03, 0.01].into_iter().for_each(rod_is_found::<f32>);
    }

    fn rod_is_found<R: Real>(thickness: f64) {
        let across = thickness * thickness / 4.0;
        let rod = body([across, 0.25 + across / 2.0, 0.25 + across / 2.0], [0.1, 0.01, -0.02]);
        let mut information = SMatrix::<f64, 10, 10>::identity() * 1e4;
        information[(4, 4)] = 1e4 / (across * across);
        // Off by three standard deviations each.
        let off = SVector::<f64, 10>::from_fn(|k, _| {
            let sign = if k % 2 == 0 { 3.0 } else { -3.0 };
            sign / information[(k, k)].sqrt()
        });
        let phi = (rod.phi() + off).map(R::of);
        let none = SVector::zeros();
        let step = step_to_body(&phi, &information.map(R::of), &none, R::zero(), &none);
        let step = step.unwrap_or_else(|| panic!("no step at {thickness}"));
        let physical = RigidBody::from_phi(&(phi + step)).expect("a body");
        assert!(physical.is_physically_consistent(), "{thickness}");
        // The rod itself is a body, so the best one is no farther; the barrier may cost four times its weight, and
        // single precision a thousandth of the whole.
        let cost = |step: &SVector<f64, 10>| step.dot(&(information * step));
        let (step_cost, most) = (cost(&step.map(|v| v.to_f32().into())), cost(&off));
        assert!(
            step_cost < most * 1.001 + 8.0 * LEAST_WEIGHT,
            "{thickness}: {step_cost} of {most}"
        );
    }
}
