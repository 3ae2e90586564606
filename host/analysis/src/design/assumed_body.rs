//! The body that a layout is checked with while nothing has been measured.

use massline_shared::body::RigidBody;
use massline_shared::layout::assumed_body;
use nalgebra::{SVector, Vector3};

use massline_files::layout_file::{LayoutFile, Reference};

/// The body that a layout is checked with before its responses are solved, and a sentence that names its origin: the
/// mass of `[prior]` or 1 kg near the centroid of the nodes, with the inertia `m L² I`. What `[reference]` states is to
/// be compared with the answer and must not decide whether there is one.
pub fn assumed_for_solving(file: &LayoutFile) -> (RigidBody<f64>, String) {
    let prior = prior_mass(file);
    let body = assumed_body(prior, file.nodes.iter().map(|node| node.position));
    let mass = if prior.is_some() { "the mass of [prior]" } else { "an assumed mass of 1 kg" };
    let text = format!(
        "the layout was checked with {mass}, an assumed centre of mass near the centroid of the nodes and an assumed \
         inertia m L² I, L being the extent of the nodes"
    );
    (body, text)
}

fn prior_mass(file: &LayoutFile) -> Option<f64> {
    file.layout.priors.iter().find(|p| p.property == 0).map(|known| known.value)
}

/// The body that a design is checked with, and a sentence that names its origin: what `[reference]` states, for the
/// rest the mass of `[prior]` or 1 kg, near the centroid of the nodes, with the inertia `m L² I`. A `[reference]` that
/// looks like values in another unit is left out.
pub fn body_for_checks(file: &LayoutFile) -> (RigidBody<f64>, String) {
    let none = Reference { mass_kg: None, center_of_mass_m: None, inertia_kg_m2: None };
    let stated = file.reference.filter(|_| !file.is_reference_doubtful());
    let reference = stated.unwrap_or(none);
    if let Some(ten) = reference.complete() {
        let body = RigidBody::from_theta(&SVector::from(ten));
        return (body, "the layout was checked with the body of [reference]".into());
    }
    let prior = file.layout.priors.iter().find(|p| p.property == 0).map(|known| known.value);
    let mass = reference.mass_kg.or(prior);
    let nodes = file.nodes.iter().map(|node| node.position);
    let mut body = assumed_body(mass, nodes);
    let mass_from = match (reference.mass_kg, prior) {
        (Some(_), _) => "the mass of [reference]",
        (None, Some(_)) => "the mass of [prior]",
        (None, None) => "an assumed mass of 1 kg",
    };
    let center_from = match reference.center_of_mass_m {
        Some(center) => {
            body.center_of_mass = Vector3::from(center);
            "the centre of mass of [reference]"
        }
        None => "an assumed centre of mass near the centroid of the nodes",
    };
    let more = match (file.reference, stated) {
        (Some(_), None) => "put the units of positions and [reference] right",
        _ => "give [reference]",
    };
    let text = format!(
        "the layout was checked with {mass_from}, {center_from} and an assumed inertia m L² I, L being the \
         extent of the nodes; {more} to check it with the body itself"
    );
    (body, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reference_in_another_unit_is_not_what_a_design_is_checked_with() {
        let example = include_str!("../../../examples/three-bar-test-1.toml");
        let sound = LayoutFile::parse(example, "l").expect("a layout");
        let (body, whose) = body_for_checks(&sound);
        assert!(whose.ends_with("with the body of [reference]"), "{whose}");
        let mut doubtful = sound.clone();
        let reference = doubtful.reference.as_mut().expect("a reference");
        // g mm²
        reference.inertia_kg_m2 =
            reference.inertia_kg_m2.map(|rows| rows.map(|row| row.map(|v| v * 1e9)));
        let (assumed, whose) = body_for_checks(&doubtful);
        assert!(whose.contains("put the units of positions and [reference] right"), "{whose}");
        assert!(assumed.inertia.trace() < 1e3 * body.inertia.trace());
    }
}
