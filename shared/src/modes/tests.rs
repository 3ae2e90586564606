//! Modes of a body on springs, from responses that are computed from its mass and stiffness.

use nalgebra::{Complex, Matrix6, SymmetricEigen, Vector3, Vector6};
use std::vec::Vec;

use super::*;
use crate::layout::tests::{bar_body, bar_layout};

/// A body on springs with proportional damping.
struct SuspendedBody {
    shapes: Matrix6<f64>,
    omega: Vector6<f64>,
    damping_ratio: f64,
    forces: Vec<Vector6<f64>>,
    s: Vec<Complex<f64>>,
    sigma: Vec<[f64; 6]>,
    length: f64,
}

impl SuspendedBody {
    /// The bar with modes between 2 and 9 Hz.
    fn new() -> Self {
        let mass = bar_body().mass_matrix();
        let inverse = mass.cholesky().unwrap().l().try_inverse().unwrap();
        let at = |hz: f64| (core::f64::consts::TAU * hz).powi(2);
        // Three springs in points that are not on a line.
        let mut stiffness = Matrix6::zeros();
        for (point, n_per_m) in [
            ([0.0, 0.1, 0.05], [75.0, 50.0, 300.0]),
            ([0.3, -0.2, 0.0], [100.0, 150.0, 250.0]),
            ([0.2, 0.05, 0.2], [90.0, 125.0, 450.0]),
        ] {
            let arm = crate::linalg::skew(&Vector3::from(point));
            for axis in 0..3 {
                let mut row = Vector6::zeros();
                row[axis] = 1.0;
                (0..3).for_each(|k| row[3 + k] = -arm[(axis, k)]);
                stiffness += row * row.transpose() * n_per_m[axis];
            }
        }
        let eigen = SymmetricEigen::new(inverse * stiffness * inverse.transpose());
        let mut order: Vec<usize> = (0..6).collect();
        order.sort_by(|a, b| eigen.eigenvalues[*a].total_cmp(&eigen.eigenvalues[*b]));
        let shapes = inverse.transpose() * eigen.eigenvectors;
        let shapes = Matrix6::from_fn(|i, k| shapes[(i, order[k])]);
        let omega = Vector6::from_fn(|k, _| eigen.eigenvalues[order[k]].sqrt());
        assert!(omega[0] > at(0.5).sqrt() && omega[5] < at(12.0).sqrt(), "{omega}");
        let layout = bar_layout();
        Self {
            shapes,
            omega,
            damping_ratio: 0.012,
            forces: layout.hits.iter().map(|hit| hit.unit_force(&Vector3::zeros())).collect(),
            s: (4..=120)
                .map(|k| Complex::new(0.0, core::f64::consts::TAU * 0.125 * f64::from(k)))
                .collect(),
            sigma: std::vec![[1.0; 6]; 117],
            length: layout.characteristic_length(),
        }
    }

    fn motions(&self) -> Vec<Vector6<Complex<f64>>> {
        let mut motions = Vec::new();
        for &s in &self.s {
            for force in &self.forces {
                let mut motion = Vector6::from_element(Complex::new(0.0, 0.0));
                for k in 0..6 {
                    let shape: Vector6<f64> = self.shapes.column(k).into_owned();
                    let damping = s * (2.0 * self.damping_ratio * self.omega[k]);
                    let share =
                        s * s / (s * s + damping + self.omega[k].powi(2)) * shape.dot(force);
                    motion += shape.map(|v| share * v);
                }
                motions.push(motion);
            }
        }
        motions
    }

    fn responses<'a>(&'a self, motions: &'a [Vector6<Complex<f64>>]) -> OriginResponses<'a, f64> {
        let Self { s, sigma, forces, length, .. } = self;
        OriginResponses { s, motions, sigma: &sigma[..s.len()], forces, length: *length }
    }
}

#[test]
fn exact_responses_give_the_modes() {
    let hung = SuspendedBody::new();
    let motions = hung.motions();
    let modes = identify_modes(&hung.responses(&motions), SUSPENSION_MODES).unwrap().modes;
    for (k, mode) in modes.iter().enumerate() {
        let hz = hung.omega[k] / core::f64::consts::TAU;
        // The relocations end when no pole moves by 1e-9 of its magnitude.
        assert!((mode.frequency_hz / hz - 1.0).abs() < 1e-8, "{mode:?}");
        assert!((mode.damping_ratio - hung.damping_ratio).abs() < 1e-8, "{mode:?}");
        assert!(mode.complexity < 1e-6, "{mode:?}");
        let shape: Vector6<f64> = hung.shapes.column(k).into_owned();
        let difference = (mode.shape - shape).norm().min((mode.shape + shape).norm());
        assert!(difference < 1e-6 * shape.norm(), "{mode:?}");
    }
}

#[test]
fn responses_that_cannot_be_fitted_have_no_modes() {
    let mut hung = SuspendedBody::new();
    let mut motions = hung.motions();
    assert!(identify_modes(&hung.responses(&motions), 0).is_none());
    assert!(identify_modes(&hung.responses(&motions), MOST_PAIRS + 1).is_none());
    // A motion is missing.
    assert!(identify_modes(&hung.responses(&motions[1..]), 6).is_none());
    motions[20][3].im = f64::NAN;
    assert!(identify_modes(&hung.responses(&motions), 6).is_none());
    // No line, and fewer lines than unknowns.
    hung.s.truncate(10);
    let motions = hung.motions();
    assert!(identify_modes(&hung.responses(&motions), 6).is_none());
    hung.s.clear();
    assert!(identify_modes(&hung.responses(&[]), 6).is_none());
}

#[test]
fn the_order_is_that_of_the_modes_that_the_lines_show() {
    let mut hung = SuspendedBody::new();
    let mut state = 1_u32;
    let mut noise = || {
        // A linear congruential generator (Numerical Recipes), uniform.
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        0.002 * (f64::from(state >> 8) / f64::from(1 << 24) - 0.5)
    };
    let mut motions = hung.motions();
    motions.iter_mut().flatten().for_each(|z| *z += Complex::new(noise(), noise()));
    let (forces, whole) = (hung.forces.len(), hung.s.clone());
    // All lines, and those about some of the modes: fewer and fewer of them show.
    let mut orders = Vec::new();
    for lines in [117, 70, 45, 36] {
        hung.s = whole[..lines].to_vec();
        let responses = hung.responses(&motions[..lines * forces]);
        let order_fits = Orders::up_to(&responses, MOST_PAIRS);
        orders.push(order_fits.sufficient().unwrap().poles.len());
    }
    assert_eq!(orders[0], SUSPENSION_MODES);
    assert!(orders[3] < SUSPENSION_MODES, "{orders:?}");
}

#[test]
fn without_lines_there_is_no_order() {
    let mut hung = SuspendedBody::new();
    hung.s.clear();
    assert!(Orders::up_to(&hung.responses(&[]), MOST_PAIRS).sufficient().is_none());
}
