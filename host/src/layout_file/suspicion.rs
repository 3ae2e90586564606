//! Values that are possible but look like those of another unit.

use nalgebra::Vector3;

use super::{LayoutFile, Node, Reference};

/// Objects on cords are not larger, m.
const LARGEST_M: f64 = 20.0;
/// Factor by which the size of the object and that of its expected inertia cannot differ.
const APART: f64 = 100.0;

impl LayoutFile {
    /// What looks like values in another unit, and the fix; for people.
    pub fn suspicion(&self) -> Option<String> {
        let extent = extent(&self.nodes);
        if extent > LARGEST_M {
            return Some(format!(
                "the nodes are up to {extent:.0} m apart: positions are in metres, and these look like \
                 millimetres; write 0.2 for 200 mm"
            ));
        }
        let radius = self.reference.as_ref().and_then(radius_of_gyration)?;
        let ratio = radius / extent;
        (extent > 0.0 && !(1.0 / APART..APART).contains(&ratio)).then(|| {
            format!(
                "[reference] describes a body with a radius of gyration of {radius:.3e} m on nodes {extent:.3e} m \
                 apart: check that positions are in m, mass_kg in kg and inertia_kg_m2 in kg m² (1 kg mm² is 1e-6 \
                 kg m²)"
            )
        })
    }
}

/// The largest distance between two nodes, m.
fn extent(nodes: &[Node]) -> f64 {
    let distance =
        |a: &Node, b: &Node| (Vector3::from(a.position) - Vector3::from(b.position)).norm();
    let pairs = nodes.iter().enumerate().flat_map(|(k, a)| nodes[..k].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| distance(a, b)).fold(0.0, f64::max)
}

/// `√(tr J/2m)` of the expected values, m.
fn radius_of_gyration(reference: &Reference) -> Option<f64> {
    let (mass, inertia) = (reference.mass_kg?, reference.inertia_kg_m2?);
    let trace: f64 = (0..3).map(|k| inertia[k][k]).sum();
    Some((trace / (2.0 * mass)).sqrt())
}
