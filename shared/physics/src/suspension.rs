//! The six modes of the rigid object on its cords.
//!
//! A cord is a spring along its length; its tension also restores the object sideways, as in a pendulum.
//! When the object turns, the attachment points of the cords and the centre of mass move on arcs, which
//! adds a geometric stiffness: a force `F` at `p` contributes `(F·p) I − (F pᵀ + p Fᵀ)/2` to the
//! stiffness of the small rotation. A mount given as a spring along the three body axes is taken as
//! measured on the hanging object, which includes all of this: with at least one such mount, nothing is
//! added for tension and weight.

use massline_shared::body::RigidBody;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix3x6, Matrix6, Vector3, Vector6};
use serde::Deserialize;

/// How the object hangs.
#[derive(Clone, Debug, PartialEq)]
pub enum Suspension {
    /// On cords.
    Cords {
        /// The cords.
        cords: Vec<Cord>,
        /// Fraction of critical damping of each of the six modes.
        damping_ratio: f64,
    },
    /// On a suspension that is given only by its frequencies.
    Frequencies {
        /// Translations of the centre of mass along x, y, z, then rotations about the principal axes in
        /// ascending order of moment, Hz.
        hz: [f64; 6],
        /// Fraction of critical damping of each of the six modes.
        damping_ratio: f64,
    },
}

/// A cord between the object and the ceiling.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[suspension.cord]]")]
pub struct Cord {
    /// Its attachment point on the object, body frame, m.
    pub point_m: [f64; 3],
    /// Direction from the object to the ceiling, body frame, of any length.
    #[serde(default = "up")]
    pub direction: [f64; 3],
    /// Stiffness along the cord, N/m.
    pub axial_n_per_m: Option<f64>,
    /// Length between object and ceiling under load, m; tension over length is the lateral stiffness.
    #[serde(default = "quarter_meter")]
    pub length_m: f64,
    /// In place of the three keys above: stiffness along the body axes, N/m.
    pub spring_n_per_m: Option<[f64; 3]>,
}

/// A mode of the suspended rigid object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RigidMode {
    /// Undamped angular frequency, rad/s.
    pub omega: f64,
    /// Fraction of critical damping.
    pub damping_ratio: f64,
    /// Translation of the origin and rotation, mass-normalised.
    pub shape: Vector6<f64>,
}

/// Why an object does not hang as described.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SuspensionError {
    /// No set of tensions balances the weight in the orientation that the file describes.
    #[error(
        "the cords cannot hold the object in this attitude: {0:.1} % of its weight is left over"
    )]
    NotInBalance(f64),
    /// The equilibrium needs a cord that pushes.
    #[error("cord {0} (counted from 1) would have to push with {1:.2} N to hold the object")]
    PushingCord(usize, f64),
    /// The object can move away without a restoring force.
    #[error("the suspension does not restrain the object: a mode has no restoring force")]
    Underconstrained,
}

/// Frequencies and shapes of the object on its suspension, in ascending order of frequency.
///
/// # Errors
/// When the object is not in equilibrium or a mode has no restoring force.
pub fn rigid_modes(
    body: &RigidBody<f64>,
    suspension: &Suspension,
    gravity: &Vector3<f64>,
) -> Result<[RigidMode; 6], SuspensionError> {
    rigid_modes_with_springs(body, suspension, gravity, &[])
}

/// As [`rigid_modes`], with further springs between the object and the ground: the point of each in the
/// body frame, m, and its stiffness in every direction, N/m. They are free of force at rest.
///
/// # Errors
/// As [`rigid_modes`].
pub fn rigid_modes_with_springs(
    body: &RigidBody<f64>,
    suspension: &Suspension,
    gravity: &Vector3<f64>,
    springs: &[(Vector3<f64>, f64)],
) -> Result<[RigidMode; 6], SuspensionError> {
    let mass = body.mass_matrix();
    let (mut stiffness, damping_ratio) = match suspension {
        Suspension::Frequencies { hz, damping_ratio } => {
            let modes = modes_of(body, hz, *damping_ratio);
            if springs.is_empty() {
                return Ok(modes);
            }
            (stiffness_of(&mass, &modes), *damping_ratio)
        }
        Suspension::Cords { cords, damping_ratio } => {
            (cord_stiffness(body, cords, gravity)?, *damping_ratio)
        }
    };
    for (point, n_per_m) in springs {
        let motion = point_motion(point);
        stiffness += motion.transpose() * motion * *n_per_m;
    }
    solve(&mass, &stiffness, damping_ratio)
}

/// Stiffness of a suspension with these six modes: `M (Σ ω² φ φᵀ) M`.
pub(super) fn stiffness_of(mass: &Matrix6<f64>, modes: &[RigidMode; 6]) -> Matrix6<f64> {
    of_modes(mass, modes, |mode| mode.omega * mode.omega)
}

/// The matrix that is diagonal in these modes: `M (Σ coefficient(mode) φ φᵀ) M`.
pub(super) fn of_modes(
    mass: &Matrix6<f64>,
    modes: &[RigidMode; 6],
    coefficient: impl Fn(&RigidMode) -> f64,
) -> Matrix6<f64> {
    let sum: Matrix6<f64> =
        modes.iter().map(|mode| mode.shape * mode.shape.transpose() * coefficient(mode)).sum();
    mass * sum * mass
}

/// Translation of a point as a function of the translation of the origin and the rotation.
fn point_motion(point: &Vector3<f64>) -> Matrix3x6<f64> {
    let mut motion = Matrix3x6::zeros();
    motion.fixed_view_mut::<3, 3>(0, 0).fill_with_identity();
    motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&-point.cross_matrix());
    motion
}

/// Stiffness about the origin of the object on cords.
fn cord_stiffness(
    body: &RigidBody<f64>,
    cords: &[Cord],
    gravity: &Vector3<f64>,
) -> Result<Matrix6<f64>, SuspensionError> {
    let measured = cords.iter().any(|c| c.spring_n_per_m.is_some());
    let weight = if measured { Vector3::zeros() } else { gravity * body.mass };
    let tensions = tensions(body, cords, &weight)?;
    let mut k = Matrix6::zeros();
    let mut turning = geometric(&weight, &body.center_of_mass);
    for (cord, tension) in cords.iter().zip(tensions) {
        let point = Vector3::from(cord.point_m);
        let motion = point_motion(&point);
        let local = match cord.spring_n_per_m {
            Some(spring) => Matrix3::from_diagonal(&spring.into()),
            None => {
                let along = Vector3::from(cord.direction).normalize();
                let axial = along * along.transpose();
                turning += geometric(&(along * tension), &point);
                axial * cord.axial_n_per_m.unwrap_or_default()
                    + (Matrix3::identity() - axial) * (tension / cord.length_m)
            }
        };
        k += motion.transpose() * local * motion;
    }
    let mut rotations = k.fixed_view_mut::<3, 3>(3, 3);
    rotations += turning;
    Ok(k)
}

/// Tension of every cord; the solution of least norm when the equilibrium does not determine it.
fn tensions(
    body: &RigidBody<f64>,
    cords: &[Cord],
    weight: &Vector3<f64>,
) -> Result<Vec<f64>, SuspensionError> {
    if *weight == Vector3::zeros() {
        return Ok(vec![0.0; cords.len()]);
    }
    let mut balance = DMatrix::zeros(6, cords.len());
    for (mut column, cord) in balance.column_iter_mut().zip(cords) {
        let along = Vector3::from(cord.direction).normalize();
        column.fixed_rows_mut::<3>(0).copy_from(&along);
        column.fixed_rows_mut::<3>(3).copy_from(&Vector3::from(cord.point_m).cross(&along));
    }
    let torque = body.center_of_mass.cross(weight);
    let load = DVector::from_iterator(6, weight.iter().chain(&torque).map(|v| -v));
    let inverse =
        balance.clone().pseudo_inverse(1e-9).map_err(|_| SuspensionError::Underconstrained)?;
    let tensions = inverse * &load;
    let scale = load.norm();
    let left_over = (balance * &tensions - &load).norm();
    if left_over > 0.01 * scale {
        return Err(SuspensionError::NotInBalance(100.0 * left_over / scale));
    }
    match tensions.iter().position(|&t| t < -1e-6 * scale) {
        Some(i) => Err(SuspensionError::PushingCord(i + 1, -tensions[i])),
        None => Ok(tensions.iter().copied().collect()),
    }
}

fn geometric(force: &Vector3<f64>, point: &Vector3<f64>) -> Matrix3<f64> {
    let outer = force * point.transpose();
    Matrix3::identity() * force.dot(point) - (outer + outer.transpose()) * 0.5
}

/// Solves `K φ = ω² M φ` by the Cholesky factor of `M`.
fn solve(
    mass: &Matrix6<f64>,
    stiffness: &Matrix6<f64>,
    damping_ratio: f64,
) -> Result<[RigidMode; 6], SuspensionError> {
    let factor = mass.cholesky().ok_or(SuspensionError::Underconstrained)?.l();
    let inverse = factor.try_inverse().ok_or(SuspensionError::Underconstrained)?;
    let standard = inverse * stiffness * inverse.transpose();
    let eigen = ((standard + standard.transpose()) * 0.5)
        .try_symmetric_eigen(f64::EPSILON, 1000)
        .ok_or(SuspensionError::Underconstrained)?;
    let largest = eigen.eigenvalues.max();
    if !largest.is_finite() || eigen.eigenvalues.min() <= 1e-9 * largest {
        return Err(SuspensionError::Underconstrained);
    }
    let mut modes: [RigidMode; 6] = std::array::from_fn(|i| RigidMode {
        omega: eigen.eigenvalues[i].sqrt(),
        damping_ratio,
        shape: inverse.transpose() * eigen.eigenvectors.column(i),
    });
    modes.sort_by(|a, b| a.omega.total_cmp(&b.omega));
    Ok(modes)
}

/// Three translations of the centre of mass along the body axes, then a rotation about each principal
/// axis, with the given frequencies.
fn modes_of(body: &RigidBody<f64>, hz: &[f64; 6], damping_ratio: f64) -> [RigidMode; 6] {
    let principal = body.inertia.symmetric_eigen();
    std::array::from_fn(|i| {
        let mut shape = Vector6::zeros();
        if i < 3 {
            shape[i] = body.mass.sqrt().recip();
        } else {
            let axis = principal.eigenvectors.column(i - 3) / principal.eigenvalues[i - 3].sqrt();
            shape.fixed_rows_mut::<3>(0).copy_from(&body.center_of_mass.cross(&axis));
            shape.fixed_rows_mut::<3>(3).copy_from(&axis);
        }
        RigidMode { omega: hz[i] * std::f64::consts::TAU, damping_ratio, shape }
    })
}

fn up() -> [f64; 3] {
    [0.0, 0.0, 1.0]
}

fn quarter_meter() -> f64 {
    0.25
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Bench;
    use crate::body::block;

    fn vertical(x: f64, y: f64, z: f64, axial: f64, length: f64) -> Cord {
        Cord {
            point_m: [x, y, z],
            direction: [0.0, 0.0, 1.0],
            axial_n_per_m: Some(axial),
            length_m: length,
            spring_n_per_m: None,
        }
    }

    const GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.80665);

    #[test]
    fn a_block_on_four_cords_swings_as_a_pendulum_and_bounces_as_a_spring() {
        let body = block(2.0, Vector3::zeros(), [0.2, 0.3, 0.1], &Matrix3::identity());
        let cords = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
            .map(|(x, y)| vertical(0.1 * x, 0.15 * y, 0.0, 100.0, 0.25))
            .to_vec();
        let modes = rigid_modes(&body, &Suspension::Cords { cords, damping_ratio: 0.01 }, &GRAVITY)
            .unwrap();
        // Attached in the plane of the centre of mass, where closed forms hold: the pendulum, the
        // torsional pendulum, and the springs with T/l laterally.
        let (swing, bounce) = (9.80665 / 0.25, 400.0 / 2.0);
        let yaw = 9.80665 / 0.25 * 2.0 * (0.1_f64.powi(2) + 0.15_f64.powi(2)) / body.inertia.m33;
        let roll = 400.0 * 0.15_f64.powi(2) / body.inertia.m11;
        let pitch = 400.0 * 0.1_f64.powi(2) / body.inertia.m22;
        let mut expected = [swing, swing, bounce, yaw, roll, pitch].map(f64::sqrt);
        expected.sort_by(f64::total_cmp);
        for (mode, omega) in modes.iter().zip(expected) {
            // Tolerance: rounding of a well-conditioned 6 × 6 eigenproblem.
            assert!((mode.omega / omega - 1.0).abs() < 1e-9, "{} {omega}", mode.omega);
        }
    }

    #[test]
    fn a_body_hung_above_its_centre_of_mass_rocks_as_a_compound_pendulum() {
        // Two short stiff cords on the y axis, 0.1 m above the centre: the springs do not resist rotation
        // about y, and only weight times lever restores it.
        let body = block(2.0, Vector3::new(0.0, 0.0, -0.1), [0.1, 0.1, 0.1], &Matrix3::identity());
        let cords = vec![vertical(0.0, 0.1, 0.0, 1e7, 1e-4), vertical(0.0, -0.1, 0.0, 1e7, 1e-4)];
        let modes = rigid_modes(&body, &Suspension::Cords { cords, damping_ratio: 0.01 }, &GRAVITY)
            .unwrap();
        let about_pivot = body.inertia.m22 + 2.0 * 0.01;
        let expected = (2.0 * 9.80665 * 0.1 / about_pivot).sqrt();
        // The cords are 0.1 mm long, 1/1000 of the lever, which bounds the deviation.
        assert!((modes[0].omega / expected - 1.0).abs() < 2e-3, "{}", modes[0].omega);
    }

    #[test]
    fn modes_are_mass_normalised_and_orthogonal() {
        let bench = Bench::named("default").unwrap();
        let modes = rigid_modes(&bench.body, &bench.suspension, &bench.gravity).unwrap();
        let m = bench.body.mass_matrix();
        for (i, a) in modes.iter().enumerate() {
            for (j, b) in modes.iter().enumerate() {
                let product = a.shape.dot(&(m * b.shape));
                let expected = f64::from(u8::from(i == j));
                assert!((product - expected).abs() < 1e-10);
            }
        }
    }

    #[test]
    fn the_default_frame_hangs_between_one_and_three_and_a_half_hertz() {
        let bench = Bench::named("default").unwrap();
        let modes = rigid_modes(&bench.body, &bench.suspension, &bench.gravity).unwrap();
        for mode in modes {
            let hz = mode.omega / std::f64::consts::TAU;
            assert!((1.0..3.5).contains(&hz), "{hz}");
        }
    }

    #[test]
    fn frequencies_that_are_asked_for_come_out() {
        let bench = Bench::named("default").unwrap();
        let hz = [1.0, 1.5, 2.0, 2.5, 3.0, 3.5];
        let modes = modes_of(&bench.body, &hz, 0.02);
        let m = bench.body.mass_matrix();
        for (mode, hz) in modes.iter().zip(hz) {
            assert_eq!(mode.omega, hz * std::f64::consts::TAU);
            assert!((mode.shape.dot(&(m * mode.shape)) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn cords_beside_the_centre_of_mass_are_refused() {
        let body = block(2.0, Vector3::zeros(), [0.2, 0.3, 0.1], &Matrix3::identity());
        let cords = vec![vertical(0.1, 0.0, 0.0, 100.0, 0.2)];
        let suspension = Suspension::Cords { cords, damping_ratio: 0.01 };
        let error = rigid_modes(&body, &suspension, &GRAVITY).unwrap_err();
        assert!(matches!(error, SuspensionError::NotInBalance(_)), "{error}");
    }

    #[test]
    fn a_cord_that_would_have_to_push_is_refused() {
        let body = block(2.0, Vector3::zeros(), [0.2, 0.3, 0.1], &Matrix3::identity());
        let cords = vec![
            vertical(0.05, 0.1, 0.0, 100.0, 0.2),
            vertical(0.1, 0.1, 0.0, 100.0, 0.2),
            vertical(0.05, -0.1, 0.0, 100.0, 0.2),
        ];
        let suspension = Suspension::Cords { cords, damping_ratio: 0.01 };
        let error = rigid_modes(&body, &suspension, &GRAVITY).unwrap_err();
        assert!(matches!(error, SuspensionError::PushingCord(2, _)), "{error}");
    }
}
