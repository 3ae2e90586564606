//! The test in space as data for the script that turns it: positions in m, in the body frame.

use serde::Serialize;

use crate::export::Exported;
use crate::picture::ellipsoid;
use crate::result_file::ResultFile;

/// What the script draws.
#[derive(Serialize)]
pub(super) struct Scene {
    /// Names and positions of the sensors.
    sensors: Vec<(String, [f64; 3])>,
    /// Names, positions and directions of the hits.
    hits: Vec<(String, [f64; 3], [f64; 3])>,
    /// Centre of mass, where there is an answer.
    center: Option<[f64; 3]>,
    /// Semi-axes of the homogeneous ellipsoid with the same inertia, where there is one.
    axes: Option<[[f64; 3]; 3]>,
}

impl Scene {
    /// The scene as JSON that can stand in a script element; `None` without a layout.
    pub fn of(source: &ResultFile, answer: Option<&Exported>) -> Option<String> {
        let layout = source.layout()?;
        let scene = Self {
            sensors: layout.sensors.iter().map(|of| (of.node.to_string(), of.position)).collect(),
            hits: layout
                .hits
                .iter()
                .map(|of| (of.dof.to_string(), of.position, of.direction))
                .collect(),
            center: answer.map(|of| of.body.center_of_mass.into()),
            axes: answer.and_then(|of| ellipsoid(&of.body)).map(|axes| axes.map(Into::into)),
        };
        // Numbers, and names of digits, letters and signs: no `<`.
        serde_json::to_string(&scene).ok()
    }
}
