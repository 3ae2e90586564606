// Test 1 of the three-bar frame (theory, section 11), which the examples of the documentation share.

use massline_shared::body::RigidBody;
use massline_shared::capacity::Fixed;
use massline_shared::identify::{DofMassLines, MassLines};
use massline_shared::layout::{Hit, Layout, Sensor};
use massline_shared::nalgebra::SVector;
use massline_shared::responses::Responses;

/// The properties that an identification has to find.
pub fn body() -> RigidBody<f64> {
    RigidBody::from_theta(&SVector::from([
        1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
    ]))
}

/// Sensors on nodes 1, 2 and 3; hits 1:+Y, 2:+Z and 4:+X; the default error budget.
pub fn layout() -> Layout<f64, Fixed<3, 4>> {
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut layout: Layout<f64, Fixed<3, 4>> = Layout { gravity: Some([0.0, 0.0, -9.80665]), ..Layout::default() };
    for (node, position) in [(1, [0.0; 3]), (2, [0.208, -0.199, 0.0]), (3, [0.208, 0.0, 0.0])] {
        layout.sensors.push(Sensor::new(node, position, axes)).unwrap();
    }
    for (dof, position, direction) in [
        ("1:+Y", [0.0; 3], [0.0, 1.0, 0.0]),
        ("2:+Z", [0.208, -0.199, 0.0], [0.0, 0.0, 1.0]),
        ("4:+X", [0.208, -0.199, 0.149], [1.0, 0.0, 0.0]),
    ] {
        layout.hits.push(Hit::new(dof.parse().unwrap(), position, direction)).unwrap();
    }
    layout
}

/// Exact mass lines of that body under a layout, as from five hits per DOF with 0.2 % noise.
pub fn mass_lines(layout: &Layout<f64, Fixed<3, 4>>) -> Vec<DofMassLines<f64, Fixed<3, 4>>> {
    let of_hit = |hit: usize| {
        let accelerance = layout.accelerance(&body(), hit).unwrap();
        let lines =
            MassLines::without_scatter(accelerance).with_noise(Responses::repeat(3, 0.002 / 1.23));
        (hit, MassLines { hits: 5, ..lines })
    };
    (0..layout.hits.len()).map(of_hit).collect()
}
