//! Mass-normalised shapes from residues, and which force excites which mode.

use nalgebra::Vector6;

use crate::layout::{balanced_force, balanced_motion};
use crate::linalg::LeastSquares;
use crate::real::Real;

/// Largest number of steps of Gauss and Newton; three or four are usual.
const MOST_STEPS: usize = 30;

/// Norm Indicator of a mode under one force, `|diag(1, 1, 1, L, L, L) A|`: how much of the mode the force shows.
///
/// `residue` is `A = φ (φᵀ f)` at the origin, in the units of [a in m/s²; α in rad/s²] for 1 N; `length` is L in m.
/// Almeida, Maia and Urgueira give the idea (figure 6) and no formula; this one is of theory, section 7.
pub fn norm_indicator<R: Real>(residue: &Vector6<R>, length: R) -> R {
    balanced_motion(residue, length).norm()
}

/// The [Norm Indicator](norm_indicator) from the mass-normalised shape of a mode instead of a residue, under a force
/// `f = [F; T]`: `|S φ| |φᵀ f|`.
pub fn norm_indicator_of_shape<R: Real>(shape: &Vector6<R>, force: &Vector6<R>, length: R) -> R {
    norm_indicator(&(shape * shape.dot(force)), length)
}

/// The force with the largest [Norm Indicator](norm_indicator) of a mode, given the mode's residues under all forces;
/// zero without forces.
pub fn best_force<R: Real>(residues: &[Vector6<R>], length: R) -> usize {
    let indicators = residues.iter().map(|residue| norm_indicator(residue, length)).enumerate();
    let best = indicators.reduce(|best, next| if next.1 > best.1 { next } else { best });
    best.map_or(0, |(force, _)| force)
}

/// Mass-normalised shape `φ = A / √(fᵀ A)` from the residue of one force `f = [F; T]` of 1 N about the origin; no
/// sensor has to sit at the driving point. `None` when the force does not excite the mode, or the residue has the wrong
/// sign.
///
/// ```
/// # use massline_shared::modes::shape_of_force;
/// # use massline_shared::nalgebra::Vector6;
/// let shape = Vector6::new(0.1, 0.2, 0.0, 0.0, 0.5, -0.3);
/// let force = Vector6::new(1.0, 0.0, 0.0, 0.0, 0.2, 0.0);
/// let residue = shape * shape.dot(&force);
/// assert!((shape_of_force(&residue, &force).unwrap() - shape).norm() < 1e-15);
/// assert!(shape_of_force(&-residue, &force).is_none());
/// ```
pub fn shape_of_force<R: Real>(residue: &Vector6<R>, force: &Vector6<R>) -> Option<Vector6<R>> {
    let square = force.dot(residue);
    let shape = residue / square.sqrt();
    (square > R::zero() && shape.iter().all(|v| v.finite())).then_some(shape)
}

/// Mass-normalised shape that fits the residues of all forces best: the minimum of `Σ |S (Aⱼ − φ (φᵀ fⱼ))|²` with
/// `S = diag(1, 1, 1, L, L, L)`, from the shape of the [best force](best_force) and with its sign (theory, section 7).
/// `None` when no force excites the mode or the steps do not end.
pub fn shape_of_forces<R: Real>(
    residues: &[Vector6<R>],
    forces: &[Vector6<R>],
    length: R,
) -> Option<Vector6<R>> {
    let best = best_force(residues, length);
    let mut shape =
        balanced_motion(&shape_of_force(residues.get(best)?, forces.get(best)?)?, length);
    for _step in 0..MOST_STEPS {
        let mut equations = LeastSquares::<R, 6>::new();
        for (residue, force) in residues.iter().zip(forces) {
            let force = balanced_force(force, length);
            let excited = shape.dot(&force);
            let left = balanced_motion(residue, length) - shape * excited;
            for (i, left) in left.iter().enumerate() {
                let mut row: [R; 6] = (force * shape[i]).into();
                row[i] += excited;
                equations.push(row, *left);
            }
        }
        let step = equations.solve()?;
        shape += step;
        if step.norm() <= shape.norm() * R::default_epsilon() * R::of(8.0) {
            break;
        }
    }
    shape.iter().all(|v| v.finite()).then(|| balanced_force(&shape, length))
}

#[cfg(test)]
mod tests {
    use super::*;

    const LENGTH: f64 = 0.19;

    fn forces() -> [Vector6<f64>; 3] {
        [
            Vector6::new(1.0, 0.0, 0.0, 0.0, 0.1, -0.2),
            Vector6::new(0.0, 1.0, 0.0, -0.1, 0.0, 0.1),
            Vector6::new(0.0, 0.0, 1.0, 0.2, -0.1, 0.0),
        ]
    }

    #[test]
    fn exact_residues_of_all_forces_give_the_shape() {
        let shape = Vector6::new(0.2, -0.05, 0.01, 0.4, 0.1, -0.6);
        let residues = forces().map(|force| shape * shape.dot(&force));
        let estimate = shape_of_forces(&residues, &forces(), LENGTH).unwrap();
        // A shape has no sign.
        let difference = (estimate - shape).norm().min((estimate + shape).norm());
        assert!(difference < 1e-14, "{estimate}");
    }

    #[test]
    fn the_best_force_is_the_one_that_drives_the_mode_along_itself() {
        // A translation along y, which only the second force drives.
        let shape = Vector6::new(0.0, 0.24, 0.0, 0.0, 0.0, 0.0);
        let residues = forces().map(|force| shape * shape.dot(&force));
        assert_eq!(best_force(&residues, LENGTH), 1);
        assert_eq!(norm_indicator(&residues[0], LENGTH), 0.0);
        assert_eq!(best_force::<f64>(&[], LENGTH), 0);
    }

    #[test]
    fn a_mode_that_no_force_excites_has_no_shape() {
        let residues = [Vector6::zeros(); 3];
        assert!(shape_of_forces(&residues, &forces(), LENGTH).is_none());
        assert!(shape_of_forces::<f64>(&[], &[], LENGTH).is_none());
    }
}
