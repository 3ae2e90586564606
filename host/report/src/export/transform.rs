//! Results in other frames and units, with their covariance.
//!
//! A frame is placed by the estimate, or by a node, and is then fixed to the object. At the estimated centre of mass
//! the centre of mass is therefore zero plus or minus its standard deviation, and along the estimated principal axes so
//! are the products of inertia.

use massline_shared::body::{RigidBody, elements, scale, tensor};
use nalgebra::{Matrix3, Vector3, Vector6};

use super::frame::{Frame, Placement};
use super::subject::{ExportedResult, Matrix10};
use super::units::UnitSystem;
use massline_result::{Error, Result};

impl ExportedResult {
    /// The same result in another frame.
    ///
    /// # Errors
    /// Exit 2 when the node is not known, exit 3 when the inertia has no principal axes.
    pub fn in_frame(self, frame: Frame) -> Result<Self> {
        let com = self.body.center_of_mass;
        let (origin, axes) = match frame {
            Frame::Body => return Ok(self),
            Frame::CenterOfMass => (com, Matrix3::identity()),
            Frame::Principal => {
                let principal = self.body.principal().ok_or_else(|| {
                    Error::undetermined("not_finite", "the inertia has no principal axes")
                })?;
                (com, principal.axes.transpose())
            }
            Frame::Node(number) => {
                let node = self.test.nodes.iter().find(|node| node.id == number);
                let node = node.ok_or_else(|| unknown_node(number, &self))?;
                let axes = node.axes.ok_or_else(|| unknown_axes(number, &self))?;
                let axes = Matrix3::from_fn(|i, j| axes[i][j]);
                (Vector3::from(node.position), axes)
            }
        };
        let mut body = rotated(&self.body.shifted_to(&origin), &axes);
        if origin == com {
            body.center_of_mass = Vector3::zeros();
        }
        if let (Frame::Principal, Some(principal)) = (frame, self.body.principal()) {
            // Without the rounding of the rotation.
            body.inertia = Matrix3::from_diagonal(&principal.moments);
        }
        let mut exported = self.mapped(&rotation_of_ten(&axes), body);
        exported.placement = Placement { frame, origin, axes };
        Ok(exported)
    }

    /// The same SI result in other units.
    pub fn in_units(self, units: UnitSystem) -> Self {
        if units == UnitSystem::Si {
            return self;
        }
        let (.., mass, length) = units.entry();
        let size = scale(mass, length);
        let body = RigidBody::from_theta(&self.theta().component_div(&size));
        let map = Matrix10::from_diagonal(&size.map(|size| 1.0 / size));
        let mut exported = self.mapped(&map, body);
        exported.placement.origin /= length;
        exported.units = units;
        exported
    }
}

/// The body relative to axes with the same origin, which are the rows of `axes`.
fn rotated(body: &RigidBody<f64>, axes: &Matrix3<f64>) -> RigidBody<f64> {
    RigidBody {
        mass: body.mass,
        center_of_mass: axes * body.center_of_mass,
        inertia: symmetric(&(axes * body.inertia * axes.transpose())),
    }
}

/// Without the rounding by which the two halves of a rotated tensor differ.
fn symmetric(matrix: &Matrix3<f64>) -> Matrix3<f64> {
    tensor(&elements(matrix))
}

/// The change of the ten properties with a rotation, 10 × 10. A shift of the origin changes none of their errors.
fn rotation_of_ten(axes: &Matrix3<f64>) -> Matrix10 {
    let mut map = Matrix10::identity();
    map.fixed_view_mut::<3, 3>(1, 1).copy_from(axes);
    for k in 0..6 {
        let mut unit = Vector6::zeros();
        unit[k] = 1.0;
        let turned = axes * tensor(&unit) * axes.transpose();
        map.fixed_view_mut::<6, 1>(4, 4 + k).copy_from(&elements(&turned));
    }
    map
}

fn unknown_axes(number: u16, exported: &ExportedResult) -> Error {
    let message = format!(
        "{} does not hold the local axes of node {number}: give the layout of the test with --layout",
        exported.test.source
    );
    Error::input("unknown_axes", message)
}

fn unknown_node(number: u16, exported: &ExportedResult) -> Error {
    let known: Vec<String> = exported.test.nodes.iter().map(|node| node.id.to_string()).collect();
    let message = if known.is_empty() {
        format!(
            "{} does not hold the positions of nodes: give the layout of the test with --layout for --frame {number}",
            exported.test.source
        )
    } else {
        format!("there is no node {number}; the layout has {}", known.join(", "))
    };
    Error::input("unknown_node", message)
}

#[cfg(test)]
mod tests {
    use super::super::tests::exported;
    use super::*;

    #[test]
    fn tonne_and_millimetre_are_the_usual_factors() {
        let (from, to) = (exported(), exported().in_units(UnitSystem::TMm));
        let (si, fe) = (from.theta(), to.theta());
        // 1 kg = 1e-3 t, 1 m = 1e3 mm, 1 kg m² = 1e3 t mm².
        for (k, factor) in [(0, 1e-3), (1, 1e3), (4, 1e3), (7, 1e3)] {
            assert!((fe[k] / si[k] / factor - 1.0).abs() < 1e-14, "{k}");
            let variances = [&from, &to].map(|exported| exported.covariance().unwrap()[(k, k)]);
            assert!((variances[1] / variances[0] / factor / factor - 1.0).abs() < 1e-13, "{k}");
            let half_widths = [&from, &to].map(|exported| exported.half_widths().unwrap()[k]);
            assert!((half_widths[1] / half_widths[0] / factor - 1.0).abs() < 1e-13, "{k}");
        }
        assert_eq!(to.units.unit_of(4), "t mm^2");
    }

    #[test]
    fn at_the_centre_of_mass_only_the_centre_of_mass_changes() {
        let given = exported();
        let moved = given.clone().in_frame(Frame::CenterOfMass).unwrap();
        assert_eq!(moved.body.center_of_mass, Vector3::zeros());
        assert_eq!(moved.body.inertia, given.body.inertia);
        // The centre of mass is as uncertain as before: the frame is fixed where it was estimated.
        assert_eq!(moved.covariance(), given.covariance());
        assert_eq!(moved.placement.origin, given.body.center_of_mass);
    }

    #[test]
    fn every_interval_is_about_its_value_in_every_frame_and_unit() {
        let given = exported();
        let nodes = [Frame::Node(2), Frame::Node(4)];
        let frames = [Frame::Body, Frame::CenterOfMass, Frame::Principal].into_iter().chain(nodes);
        for frame in frames {
            for units in [UnitSystem::Si, UnitSystem::TMm] {
                let moved = given.clone().in_frame(frame).unwrap().in_units(units);
                let (theta, half) = (moved.theta(), moved.half_widths().unwrap());
                let [low, high] = moved.interval().unwrap();
                for k in 0..10 {
                    // Rounding of a few sums and products in double precision.
                    let rounding = 1e-12 * half[k];
                    assert!((high[k] - low[k] - 2.0 * half[k]).abs() < rounding, "{frame:?} {k}");
                    assert!((high[k] + low[k] - 2.0 * theta[k]).abs() < rounding, "{frame:?} {k}");
                }
            }
        }
    }

    #[test]
    fn along_principal_axes_the_products_are_zero_with_their_standard_deviations() {
        let given = exported();
        let principal = given.body.principal().unwrap();
        let moved = given.clone().in_frame(Frame::Principal).unwrap();
        assert_eq!(moved.body.inertia, Matrix3::from_diagonal(&principal.moments));
        let sigma = moved.sigma().unwrap();
        let expected = principal.moment_sigmas(&given.covariance().unwrap());
        for k in 0..3 {
            // Rounding of a few products in double precision.
            assert!((sigma[4 + k] / expected[k] - 1.0).abs() < 1e-9, "{k}");
            assert!(sigma[7 + k] > 0.0);
        }
    }

    #[test]
    fn node_axes_turn_the_products_and_their_covariance() {
        // The node's x is the body's y, its y is −x: with u = y, v = −x, Juv = −∫ u v dm = ∫ x y dm = −Jxy.
        let mut given = exported();
        given.test.nodes[1].axes = Some([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);
        let position = given.test.nodes[1].position;
        let moved = given.clone().in_frame(Frame::Node(2)).unwrap();
        let (from, to) = (given.theta(), moved.theta());
        let expected = [
            from[0],
            from[2] - position[1],
            position[0] - from[1],
            from[3] - position[2],
            from[5],
            from[4],
            from[6],
            -from[7],
            from[9],
            -from[8],
        ];
        for k in 0..10 {
            assert!((to[k] - expected[k]).abs() < 1e-15, "{k}: {} {}", to[k], expected[k]);
        }
        let (from, to) = (given.sigma().unwrap(), moved.sigma().unwrap());
        for (k, source) in [0, 2, 1, 3, 5, 4, 6, 7, 9, 8].into_iter().enumerate() {
            assert!((to[k] / from[source] - 1.0).abs() < 1e-12, "{k}");
        }
        // A swap of two axes carries the widths of the intervals along.
        let (from, to) = (given.half_widths().unwrap(), moved.half_widths().unwrap());
        assert!((to[5] / from[4] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn an_unknown_node_is_named_with_those_there_are() {
        let error = exported().in_frame(Frame::Node(9)).unwrap_err();
        assert_eq!((error.code(), error.exit_code()), ("unknown_node", 2));
        assert!(error.to_string().contains("has 1, 2, 3, 4"), "{error}");
        let mut blind = exported();
        blind.test.nodes[0].axes = None;
        let error = blind.clone().in_frame(Frame::Node(1)).unwrap_err();
        assert_eq!(error.code(), "unknown_axes");
        blind.test.nodes.clear();
        assert!(blind.in_frame(Frame::Node(1)).unwrap_err().to_string().contains("--layout"));
    }
}
