//! The readings of a sensor for a motion of the body, and the force and torque of a hit.
//!
//! The motion is `x₀ = [a_O; α]`, the acceleration of a reference point and the angular acceleration;
//! products of velocities are neglected. Theory, section 2.

use nalgebra::{Complex, ComplexField, Matrix3, SMatrix, Vector3, Vector6};

use super::{Hit, Layout, Sensor};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::linalg::skew;
use crate::real::Real;
use crate::responses::{ResponseRows, Responses};

impl<R: Real> Sensor<R> {
    /// Axes of the sensor as rows: `Rᵀ` of theory, section 1.
    pub fn axes_matrix(&self) -> Matrix3<R> {
        Matrix3::from_fn(|i, j| self.axes[i][j])
    }

    /// `Rᵀ [I, −[p − r]ₓ]`: the readings for the motion `[a_r; α]` with the reference point `r`.
    pub fn response_rows(&self, reference: &Vector3<R>) -> SMatrix<R, 3, 6> {
        let axes = self.axes_matrix();
        let arm = Vector3::from(self.position) - reference;
        let mut rows = SMatrix::<R, 3, 6>::zeros();
        rows.fixed_view_mut::<3, 3>(0, 0).copy_from(&axes);
        rows.fixed_view_mut::<3, 3>(0, 3).copy_from(&-(axes * skew(&arm)));
        rows
    }

    /// `Rᵀ [0, −[g]ₓ]`, which is divided by `s²` and added to [`Sensor::response_rows`]: a tilt reads as an
    /// acceleration. Zero for a sensor that does not sense gravity.
    pub fn gravity_rows(&self, gravity: &Vector3<R>) -> SMatrix<R, 3, 6> {
        let mut rows = SMatrix::<R, 3, 6>::zeros();
        if self.senses_gravity {
            let tilt = -(self.axes_matrix() * skew(gravity));
            rows.fixed_view_mut::<3, 3>(0, 3).copy_from(&tilt);
        }
        rows
    }
}

impl<R: Real> Hit<R> {
    /// `f₀ = [d; (q − r) × d]`: force and torque about the point `r` of a unit force along the hit.
    pub fn unit_force(&self, reference: &Vector3<R>) -> Vector6<R> {
        unit_force(&self.position.into(), &self.direction.into(), reference)
    }
}

/// `f₀ = [d; (q − r) × d]`: force and torque about `r` of a force of 1 N at `q` along the unit vector `d`.
pub fn unit_force<R: Real>(q: &Vector3<R>, d: &Vector3<R>, r: &Vector3<R>) -> Vector6<R> {
    let t = (q - r).cross(d);
    Vector6::new(d.x, d.y, d.z, t.x, t.y, t.z)
}

/// The motion `[x; θ]`, or the acceleration `[a; α]`, of the point of a body that is `arm` away: `[x + θ × arm; θ]`.
pub fn motion_at<R: Real>(motion: &Vector6<R>, arm: &Vector3<R>) -> Vector6<R> {
    let rotation = motion.fixed_rows::<3>(3).into_owned();
    let moved = motion.fixed_rows::<3>(0) + rotation.cross(arm);
    let mut motion = *motion;
    motion.fixed_rows_mut::<3>(0).copy_from(&moved);
    motion
}

/// A motion in balanced variables, `diag(1, 1, 1, L, L, L) x`, which make rotations comparable with translations.
pub fn balanced_motion<R: Real, T: ComplexField<RealField = R>>(
    motion: &Vector6<T>,
    length: R,
) -> Vector6<T> {
    scaled_last_three(motion, length)
}

/// Force and torque in balanced variables, `diag(1, 1, 1, 1/L, 1/L, 1/L) f`; also a motion from balanced variables.
pub fn balanced_force<R: Real, T: ComplexField<RealField = R>>(
    force: &Vector6<T>,
    length: R,
) -> Vector6<T> {
    scaled_last_three(force, R::one() / length)
}

fn scaled_last_three<R: Real, T: ComplexField<RealField = R>>(
    six: &Vector6<T>,
    factor: R,
) -> Vector6<T> {
    let mut six = six.clone();
    six.iter_mut().skip(3).for_each(|value| *value = value.clone().scale(factor));
    six
}

impl<R: Real, C: Capacity> Layout<R, C> {
    /// Mean of the sensor positions, m; the origin without sensors.
    pub fn sensor_centroid(&self) -> Vector3<R> {
        let mut sum = Vector3::zeros();
        for s in self.sensors.iter() {
            sum += Vector3::from(s.position);
        }
        sum / R::of(self.sensors.len().max(1) as f64)
    }

    /// `L`: root mean square distance of the sensors from their centroid, m. It makes rotations
    /// comparable with translations. One metre when all sensors are in one point.
    pub fn characteristic_length(&self) -> R {
        let centroid = self.sensor_centroid();
        let mut sum = R::zero();
        for s in self.sensors.iter() {
            sum += (Vector3::from(s.position) - centroid).norm_squared();
        }
        let length = (sum / R::of(self.sensors.len().max(1) as f64)).sqrt();
        if length > R::zero() { length } else { R::one() }
    }

    /// True when a sensor senses gravity.
    pub fn senses_gravity(&self) -> bool {
        self.sensors.iter().any(|sensor| sensor.senses_gravity)
    }

    /// True when a sensor senses gravity and its direction is not given.
    pub fn lacks_gravity(&self) -> bool {
        self.gravity.is_none() && self.senses_gravity()
    }

    /// `G`: the stacked readings of all sensors for the motion `[a_r; α]`; three rows per sensor, zero beyond
    /// the last.
    pub fn response_matrix(&self, reference: &Vector3<R>) -> ResponseRows<R, C, 6> {
        self.stacked(|sensor| sensor.response_rows(reference))
    }

    /// The gravity part that is divided by `s²` and added to [`Layout::response_matrix`]; zero when no
    /// gravity is given.
    pub fn gravity_matrix(&self) -> ResponseRows<R, C, 6> {
        let gravity = Vector3::from(self.gravity.unwrap_or([R::zero(); 3]));
        self.stacked(|sensor| sensor.gravity_rows(&gravity))
    }

    /// `G(s) = G + G_g / s²` with the Laplace variable `s = σ + iω`, rad/s.
    pub fn response_matrix_at(
        &self,
        reference: &Vector3<R>,
        s: Complex<R>,
    ) -> ResponseRows<Complex<R>, C, 6> {
        let (rigid, gravity) = (self.response_matrix(reference), self.gravity_matrix());
        let inverse = Complex::new(R::one(), R::zero()) / (s * s);
        ResponseRows(core::array::from_fn(|j| {
            rigid.0[j].zip_map(&gravity.0[j], |rigid: R, gravity: R| {
                Complex::new(rigid + inverse.re * gravity, inverse.im * gravity)
            })
        }))
    }

    /// One row of [`Layout::response_matrix_at`] about the origin, as a column; zero for a channel that
    /// does not exist.
    pub fn response_row_at(&self, channel: usize, s: Complex<R>) -> Vector6<Complex<R>> {
        let Some(sensor) = self.sensors.get(channel / 3) else { return Vector6::zeros() };
        let rigid = sensor.response_rows(&Vector3::zeros());
        let gravity = sensor.gravity_rows(&Vector3::from(self.gravity.unwrap_or([R::zero(); 3])));
        let inverse = Complex::new(R::one(), R::zero()) / (s * s);
        let axis = channel % 3;
        Vector6::from_fn(|j, _| {
            let g = gravity[(axis, j)];
            Complex::new(rigid[(axis, j)] + inverse.re * g, inverse.im * g)
        })
    }

    /// Accelerance of every response under the hit with this index, for a body without suspension: one column
    /// of `G M₀⁻¹ F₀`, (m/s²)/N. `None` when the hit does not exist or the body has no inertia.
    ///
    /// Theory, section 2.
    ///
    /// ```
    /// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
    /// let layout = frame::layout();
    /// let readings = layout.accelerance(&frame::body(), 0).unwrap();
    /// // Driven along y at node 1, the sensor there moves along y.
    /// assert!(readings[1] > 0.0);
    /// assert!(layout.accelerance(&frame::body(), 3).is_none());
    /// ```
    pub fn accelerance(&self, body: &RigidBody<R>, hit: usize) -> Option<Responses<R, C>> {
        let origin = Vector3::zeros();
        let motion = body.acceleration(&self.hits.get(hit)?.unit_force(&origin))?;
        Some(self.response_matrix(&origin).times(&motion))
    }

    fn stacked(&self, rows: impl Fn(&Sensor<R>) -> SMatrix<R, 3, 6>) -> ResponseRows<R, C, 6> {
        let mut matrix = ResponseRows::zeros(self.sensors.len());
        for (i, sensor) in self.sensors.iter().enumerate() {
            matrix.set_sensor(i, &rows(sensor));
        }
        matrix
    }
}

/// Apparent displacement of every sensor at `ω` (rad/s) because it senses gravity: `−g/ω²`, m.
///
/// Theory, section 2.
///
/// ```
/// # use massline_shared::layout::sensor_shift;
/// # use massline_shared::nalgebra::Vector3;
/// let gravity = Vector3::new(0.0, 0.0, -9.80665);
/// let shift: Vector3<f64> = sensor_shift(&gravity, std::f64::consts::TAU * 10.0);
/// assert!((shift.z - 2.48e-3).abs() < 0.01e-3); // up by 2.48 mm at 10 Hz
/// ```
pub fn sensor_shift<R: Real>(gravity: &Vector3<R>, omega: R) -> Vector3<R> {
    -(gravity / (omega * omega))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::bar_layout;

    #[test]
    fn gravity_shows_every_sensor_displaced() {
        let layout = bar_layout();
        let g = Vector3::from(layout.gravity.unwrap());
        let omega = 30.0;
        let s = Complex::new(0.0, omega);
        let with = layout.response_matrix_at(&Vector3::zeros(), s);
        let mut moved = layout.clone();
        for sensor in moved.sensors.iter_mut() {
            let p = Vector3::from(sensor.position) + sensor_shift(&g, omega);
            sensor.position = p.into();
        }
        let without = moved.response_matrix(&Vector3::zeros());
        // The tolerance covers rounding: theory, section 2 states the identity.
        for (with, without) in with.0.iter().zip(&without.0) {
            assert!((&with.map(|v| v.re) - without).norm() < 1e-14);
            assert!(with.iter().all(|v| v.im.abs() < 1e-15));
        }
    }

    #[test]
    fn a_sensor_that_feels_no_gravity_has_no_such_rows() {
        let mut layout = bar_layout();
        layout.sensors[1].senses_gravity = false;
        let g = layout.gravity_matrix();
        let of_sensor = |i: usize| {
            g.0.iter().map(|column| Vector3::from(column.of_sensor(i)).norm()).sum::<f64>()
        };
        assert_eq!(of_sensor(1), 0.0);
        assert!(of_sensor(0) > 9.0);
    }

    #[test]
    fn the_reference_point_moves_force_and_motion_together() {
        let layout = bar_layout();
        let body = crate::layout::tests::bar_body();
        let r = Vector3::new(0.1, -0.2, 0.3);
        let here = layout.accelerance(&body, 0).unwrap();
        let motion = body.shifted_to(&r).acceleration(&layout.hits[0].unit_force(&r)).unwrap();
        let shifted_accelerance = layout.response_matrix(&r).times(&motion);
        // The tolerance covers rounding of accelerances of about 3 (m/s²)/N.
        assert!((&here - &shifted_accelerance).norm() < 1e-13);
        assert!(layout.accelerance(&body, 3).is_none());
    }

    #[test]
    fn sensors_in_one_point_have_the_length_of_a_metre() {
        let mut layout = bar_layout();
        layout.sensors.truncate(1);
        assert_eq!(layout.characteristic_length(), 1.0);
        layout.sensors.clear();
        assert_eq!(layout.characteristic_length(), 1.0);
    }
}
