//! The test in space as data for the script that turns it: positions in m, in the body frame.

use massline_result::Estimate;
use serde::Serialize;

use crate::picture::{NamedNode, ellipsoid, nodes_without_sensor};
use crate::result_file::ResultFile;

/// What the script draws.
#[derive(Serialize)]
pub(super) struct Scene {
    /// Names and positions of the sensors.
    sensors: Vec<(String, [f64; 3])>,
    /// Names and positions of the nodes without a sensor.
    nodes: Vec<NamedNode>,
    /// Names, positions and directions of the hits.
    hits: Vec<(String, [f64; 3], [f64; 3])>,
    /// Centre of mass, where there is an answer.
    center: Option<[f64; 3]>,
    /// Semi-axes of the homogeneous ellipsoid with the same inertia, where there is one.
    axes: Option<[[f64; 3]; 3]>,
}

impl Scene {
    /// The scene as JSON that can stand in a script element; `None` without a layout.
    pub fn of(source: &ResultFile, answer: Option<&Estimate>) -> Option<String> {
        let layout = source.layout()?;
        let scene = Self {
            sensors: layout
                .sensors
                .iter()
                .map(|sensor| (sensor.node.to_string(), sensor.position))
                .collect(),
            nodes: nodes_without_sensor(source),
            hits: layout
                .hits
                .iter()
                .map(|hit| (hit.dof.to_string(), hit.position, hit.direction))
                .collect(),
            center: answer.map(|answer| answer.center_of_mass_m.value),
            axes: answer
                .and_then(|answer| ellipsoid(&answer.body()))
                .map(|axes| axes.map(Into::into)),
        };
        // Numbers, and names of digits, letters and signs: no `<`.
        serde_json::to_string(&scene).ok()
    }
}
