//! A part of the object on springs of its own, such as the tyre of a wheel.
//!
//! Object and part are two rigid bodies of six coordinates each. With the mass matrices `M − m` of the rest and `m`
//! of the part, the stiffness `K` of the suspension and that of the springs between them, `Ω² m`,
//!
//! ```text
//! | M − m  0 |       | K + Ω² m   −Ω² m |
//! |   0    m | ,     |   −Ω² m     Ω² m |
//! ```
//!
//! give twelve modes: six near those of the suspension, in which the part moves with the rest, and six near
//! `Ω / √(1 − share)`, in which it moves against it. Sensors and hits are on the rest.

use nalgebra::{Complex, Matrix6, SMatrix, SVector};
use serde::Deserialize;

use super::suspension::{RigidMode, SuspensionError, of_modes, stiffness_of};

/// A part of the object on springs of its own. It has this share of the mass and of the moments of inertia about
/// the object's centre of mass.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [sprung_part]")]
pub struct SprungPart {
    /// Share of the mass.
    pub share: f64,
    /// Frequency of all six of its modes while the rest of the object is held, Hz.
    pub frequency_hz: f64,
    /// Fraction of critical damping of these modes.
    pub damping_ratio: f64,
}

type Matrix12 = SMatrix<f64, 12, 12>;

impl SprungPart {
    /// Undamped angular frequency while the rest is held, rad/s.
    fn omega(&self) -> f64 {
        self.frequency_hz * std::f64::consts::TAU
    }

    /// Apparent mass of the part over its mass, at the Laplace variable `s`, 1/s: the transmissibility of its springs.
    pub(super) fn transmitted(&self, s: Complex<f64>) -> Complex<f64> {
        let springs = s * (2.0 * self.damping_ratio * self.omega()) + self.omega().powi(2);
        springs / (s * s + springs)
    }

    /// The twelve modes of an object with this part, in ascending order of frequency; the shapes are those of the
    /// rest.
    ///
    /// `loaded` is the mass matrix of the object with whatever else is fixed to the rest, `modes` are its modes when
    /// the part does not move on its springs, and `bare` is the mass matrix of which the part is a share. Each mode
    /// is damped by the diagonal of the modal damping matrix.
    ///
    /// # Errors
    /// When the part is heavier than the object, or a mode has no restoring force.
    pub(super) fn modes(
        &self,
        loaded: &Matrix6<f64>,
        modes: &[RigidMode; 6],
        bare: &Matrix6<f64>,
    ) -> Result<Vec<RigidMode>, SuspensionError> {
        let part = bare * self.share;
        let rest_factor = (loaded - part).cholesky().ok_or(SuspensionError::Underconstrained)?.l();
        let part_factor = part.cholesky().ok_or(SuspensionError::Underconstrained)?.l();
        let inverse = diagonal(&rest_factor, &part_factor)
            .try_inverse()
            .ok_or(SuspensionError::Underconstrained)?;
        let standard = |of_suspension: Matrix6<f64>, of_springs: Matrix6<f64>| {
            let matrix = inverse * joined(&of_suspension, &of_springs) * inverse.transpose();
            (matrix + matrix.transpose()) * 0.5
        };
        let stiffness = standard(stiffness_of(loaded, modes), part * self.omega().powi(2));
        let damping = standard(
            of_modes(loaded, modes, |mode| 2.0 * mode.damping_ratio * mode.omega),
            part * (2.0 * self.damping_ratio * self.omega()),
        );
        let eigen = stiffness
            .try_symmetric_eigen(f64::EPSILON, 10_000)
            .ok_or(SuspensionError::Underconstrained)?;
        if eigen.eigenvalues.min() <= 1e-9 * eigen.eigenvalues.max() {
            return Err(SuspensionError::Underconstrained);
        }
        let mut coupled: Vec<RigidMode> = (0..12)
            .map(|i| {
                let omega = eigen.eigenvalues[i].sqrt();
                let vector: SVector<f64, 12> = eigen.eigenvectors.column(i).into_owned();
                let shape = inverse.transpose() * vector;
                RigidMode {
                    omega,
                    damping_ratio: vector.dot(&(damping * vector)) / (2.0 * omega),
                    shape: shape.fixed_rows::<6>(0).into_owned(),
                }
            })
            .collect();
        coupled.sort_by(|a, b| a.omega.total_cmp(&b.omega));
        Ok(coupled)
    }
}

/// Two matrices on the diagonal.
fn diagonal(rest: &Matrix6<f64>, part: &Matrix6<f64>) -> Matrix12 {
    let mut matrix = Matrix12::zeros();
    matrix.fixed_view_mut::<6, 6>(0, 0).copy_from(rest);
    matrix.fixed_view_mut::<6, 6>(6, 6).copy_from(part);
    matrix
}

/// What acts between the rest and the ground, and between the rest and the part.
fn joined(of_suspension: &Matrix6<f64>, of_springs: &Matrix6<f64>) -> Matrix12 {
    let mut matrix = diagonal(&(of_suspension + of_springs), of_springs);
    matrix.fixed_view_mut::<6, 6>(0, 6).copy_from(&-of_springs);
    matrix.fixed_view_mut::<6, 6>(6, 0).copy_from(&-of_springs);
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sprung_part_counts_as_a_whole_far_below_its_frequency_and_not_at_all_far_above() {
        let part = SprungPart { share: 0.5, frequency_hz: 50.0, damping_ratio: 0.03 };
        let at = |hz: f64| part.transmitted(Complex::new(0.0, std::f64::consts::TAU * hz));
        // 1/(1 − (1/50)²) and 1/(1 − 100²) but for the damping.
        assert!((at(1.0) - 1.0004).norm() < 1e-4, "{}", at(1.0));
        assert!(at(5000.0).norm() < 1e-3, "{}", at(5000.0));
    }
}
