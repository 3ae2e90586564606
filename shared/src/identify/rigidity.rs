//! Checks whether the readings of all sensors fit one rigid motion.
//!
//! Nine readings of three triaxial sensors come from six motions, so three combinations of them must vanish:
//! the distances between the sensors do not change. These combinations reveal a sensor that is rotated, has a
//! wrong gain or has come loose, unless the fault is in the three readings normal to the plane of the
//! sensors: those have no redundancy, and such a fault looks like a rotation.

use nalgebra::Vector3;

use super::ResponseInverse;
use crate::capacity::Capacity;
use crate::layout::Layout;
use crate::real::Real;
use crate::responses::Responses;

/// With a residual above this, a sensor does not move with the others.
///
/// Sensors with 1 % cross-axis sensitivity, 0.5 % gain error, 1 mm position error and 10 mrad rotation leave
/// 1 %; a reversed axis or swapped cables leave 20 % and more.
pub const RIGIDITY_LIMIT: f64 = 0.08;

/// The part of each sensor in the residual of the best rigid motion, `|(A − G G⁺ A)_i| / |A|`, of the mass
/// lines `accelerance` of one hit DOF, (m/s²)/N. `None` when the sensors do not determine all six motions, or
/// a number is not finite. G as in theory, section 2; G⁺ as in section 3.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::{RIGIDITY_LIMIT, rigid_residuals};
/// let layout = frame::layout();
/// let mut readings = layout.accelerance(&frame::body(), 0).unwrap();
/// let rigid = rigid_residuals(&layout, &readings).unwrap();
/// assert!(rigid.iter().all(|&part| part < 1e-12));
/// readings[3] = -readings[3]; // the x axis of the second sensor is reversed
/// let torn = rigid_residuals(&layout, &readings).unwrap();
/// assert!(torn.iter().any(|&part| part > RIGIDITY_LIMIT));
/// ```
pub fn rigid_residuals<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    accelerance: &Responses<R, C>,
) -> Option<C::Sensors<R>> {
    let response = layout.response_matrix(&Vector3::zeros());
    let inverse = ResponseInverse::new(&response, layout.characteristic_length())?;
    if inverse.rank < 6 {
        return None;
    }
    let used = layout.sensors.len();
    if accelerance.sensors() < used {
        return None;
    }
    let readings =
        Responses::from_fn(used, |k| if k < 3 * used { accelerance[k] } else { R::zero() });
    let size = readings.norm();
    let left = &readings - &response.times(&inverse.motion(&readings));
    if !(size.finite() && left.norm().finite() && size > R::zero()) {
        return None;
    }
    Some((0..used).map(|i| Vector3::from(left.of_sensor(i)).norm() / size).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::Rig;
    use crate::layout::tests::{bar_body, bar_layout};

    fn readings(hit: usize) -> Responses<f64, Rig> {
        bar_layout().accelerance(&bar_body(), hit).unwrap()
    }

    #[test]
    fn a_rigid_motion_leaves_nothing() {
        for hit in 0..3 {
            let left = rigid_residuals(&bar_layout(), &readings(hit)).unwrap();
            // The tolerance covers rounding.
            assert!(left.len() == 3 && left.iter().all(|&part| part < 1e-13), "{left:?}");
        }
    }

    #[test]
    fn a_reversed_axis_shows_in_the_plane_of_the_sensors_and_not_normal_to_it() {
        // The sensors of the frame's first test lie in the plane of x and y.
        for (axis, shows) in [(0, true), (1, true), (2, false)] {
            let worst = (0..3)
                .flat_map(|hit| {
                    let mut readings = readings(hit);
                    readings[3 + axis] = -readings[3 + axis];
                    rigid_residuals(&bar_layout(), &readings).unwrap()
                })
                .fold(0.0, f64::max);
            assert_eq!(worst > RIGIDITY_LIMIT, shows, "{axis}: {worst}");
            assert!(shows || worst < 1e-13);
        }
    }

    #[test]
    fn two_sensors_cannot_be_checked() {
        let mut layout = bar_layout();
        layout.sensors.pop();
        assert_eq!(rigid_residuals(&layout, &readings(0)), None);
        let nothing = Responses::<f64, Rig>::zeros(3);
        assert_eq!(rigid_residuals(&bar_layout(), &nothing), None);
        let wild = Responses::<f64, Rig>::repeat(3, f64::NAN);
        assert_eq!(rigid_residuals(&bar_layout(), &wild), None);
    }
}
