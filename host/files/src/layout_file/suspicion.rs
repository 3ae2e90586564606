//! Values that are possible but look like those of another unit.

use massline_shared::layout::{UncertaintyKey, UncertaintyUnit};
use nalgebra::{Matrix3, Vector3};

use super::LayoutFile;
use super::tensor::tensor_fault;

/// Objects on cords are not larger, m.
const LARGEST_M: f64 = 5.0;
/// Nodes that are farther apart are millimetres rather than inches or centimetres, which would be an object of 2 m and
/// more.
const MILLIMETRES: f64 = 80.0;
/// A mass of less in the cube of the nodes' extent, kg/m³, is that of no object: a rod of 3 m and 1 kg has 0.04.
const LIGHTEST: f64 = 0.01;
/// A mass of more there, kg/m³: osmium has 2.3e4, and nodes may lie on a tenth of the object.
const HEAVIEST: f64 = 2.3e7;
/// Density of air, kg/m³. An object that would be lighter in the space that it fills is none: one of 8000 kg/m³ has 0.1
/// when inches are taken for metres, and a sparse frame of tubes has 10.
const AIR: f64 = 1.2;
/// Factor by which the size of an object and that of its inertia do not differ.
const APART: f64 = 10.0;
/// The centre of mass is not farther from the mean of the nodes, in extents of the nodes.
const FARTHEST: f64 = 5.0;
/// Standard deviations of angles are not larger, rad.
const LARGEST_ANGLE: f64 = 1.0;

/// Ten properties as far as they are known, in the order of `RigidBody::theta` but about the centre of mass.
pub type KnownProperties = [Option<f64>; 10];

impl LayoutFile {
    /// What looks like values in another unit, and the fix; for people.
    pub fn suspicions(&self) -> Vec<String> {
        let mut prior = [None; 10];
        for known in &self.layout.priors {
            if let Some(value) = prior.get_mut(usize::from(known.property)) {
                *value = Some(known.value);
            }
        }
        let reference = self.reference.as_ref().map_or([None; 10], |body| body.properties());
        let bodies = [("[reference]", reference), ("[prior]", prior)];
        let positions: Vec<_> = self.nodes.iter().map(|node| node.position).collect();
        let of_bodies = bodies
            .iter()
            .flat_map(|(name, properties)| size_suspicions(&positions, name, properties));
        let extent = extent(&positions);
        let (unit, example) = match extent > MILLIMETRES {
            true => ("millimetres", "0.2 for 200 mm"),
            false => ("inches or centimetres", "0.2032 for 8 in, 0.2 for 20 cm"),
        };
        let of_nodes = (extent > LARGEST_M).then(|| {
            format!(
                "the nodes are up to {extent:.0} m apart: positions are in metres, and these look like {unit}; write \
                 {example}"
            )
        });
        let expected = self.reference.as_ref().and_then(|reference| reference.inertia_kg_m2);
        let impossible = expected.and_then(|inertia| tensor_fault(&Matrix3::from(inertia)));
        let impossible = impossible.map(|fault| format!("[reference]: {fault}"));
        of_nodes
            .into_iter()
            .chain(impossible)
            .chain(of_bodies)
            .chain(self.uncertainty_suspicions(extent))
            .collect()
    }

    /// True when `[reference]` looks like values in another unit, or is the inertia of no body.
    pub fn is_reference_doubtful(&self) -> bool {
        let positions: Vec<_> = self.nodes.iter().map(|node| node.position).collect();
        self.reference.is_some_and(|reference| {
            let inertia = reference.inertia_kg_m2.map(Matrix3::from);
            inertia.is_some_and(|inertia| tensor_fault(&inertia).is_some())
                || !size_suspicions(&positions, "[reference]", &reference.properties()).is_empty()
        })
    }

    /// What looks like degrees or millimetres among the uncertainties.
    fn uncertainty_suspicions(&self, extent: f64) -> Vec<String> {
        let suspicion = |(key, sigma): (&UncertaintyKey, f64)| match key.unit {
            UncertaintyUnit::Radians if sigma > LARGEST_ANGLE => Some(format!(
                "{} = {sigma} is a standard deviation of {:.0}°: angles are in radians; write {:.3} for {sigma}°",
                key.name,
                sigma.to_degrees(),
                sigma.to_radians()
            )),
            UncertaintyUnit::Meters if extent > 0.0 && sigma > extent => Some(format!(
                "{} = {sigma} is more than the {extent:.3} m between the nodes: positions are in metres; write {:.4} \
                 for {sigma} mm",
                key.name,
                sigma * 1e-3
            )),
            _ => None,
        };
        self.uncertainty.sigmas().filter_map(suspicion).collect()
    }
}

/// What looks like another unit in these properties of the object, which `name` states, beside its nodes at these
/// positions, m.
pub fn size_suspicions(
    positions: &[[f64; 3]],
    name: &str,
    properties: &KnownProperties,
) -> Vec<String> {
    let extent = extent(positions);
    let [mass, cx, cy, cz, jxx, jyy, jzz, ..] = *properties;
    let mass = mass.filter(|mass| *mass > 0.0);
    let mut suspicions = Vec::new();
    // One node has no extent, and larger ones have been named.
    if !(extent > 0.0 && extent.is_finite()) {
        return suspicions;
    }
    let density = mass.map(|mass| mass / extent.powi(3));
    if let Some(mass) = mass
        && density.is_some_and(|density| !(LIGHTEST..HEAVIEST).contains(&density))
        && extent <= LARGEST_M
    {
        suspicions.push(format!(
            "{name} describes a body of {mass:.3} kg on nodes {extent:.3} m apart: check that positions are in metres \
             (1 in is 0.0254 m, 1 cm is 0.01 m) and masses in kg"
        ));
    }
    let trace = jxx.zip(jyy).zip(jzz).map(|((xx, yy), zz)| xx + yy + zz);
    let radius = trace.zip(mass).map(|(trace, mass)| (trace / (2.0 * mass)).sqrt());
    if let Some(radius) =
        radius.filter(|r| !(1.0 / APART..APART).contains(&(r / extent)) && !r.is_nan())
    {
        suspicions.push(format!(
            "{name} describes a body with a radius of gyration of {radius:.3e} m on nodes {extent:.3e} m apart: check \
             that positions are in m, masses in kg and inertias in kg m² (1 kg mm² is 1e-6 kg m², 1 g mm² is 1e-9)"
        ));
    }
    // An inertia in another unit has been named.
    let inertia = known_inertia(properties);
    if suspicions.is_empty()
        && let Some(density) =
            mass.zip(inertia).and_then(|(mass, inertia)| mean_density(mass, &inertia))
        && density < AIR
    {
        suspicions.push(format!(
            "{name} describes a body of {density:.1e} kg/m³, which is lighter than air: check that positions are in metres (1 in \
             is 0.0254 m, 1 cm is 0.01 m) and masses in kg"
        ));
    }
    let center = cx.zip(cy).zip(cz).map(|((x, y), z)| Vector3::new(x, y, z));
    let distance = center.map(|center| (center - mean(positions)).norm());
    if let Some(distance) = distance.filter(|distance| *distance > FARTHEST * extent) {
        suspicions.push(format!(
            "{name} describes a body whose centre of mass lies {distance:.3} m from nodes that are {extent:.3} m \
             apart: check that positions and centre are in metres (1 mm is 0.001 m)"
        ));
    }
    suspicions
}

/// The inertia tensor, where it is known altogether.
fn known_inertia(properties: &KnownProperties) -> Option<Matrix3<f64>> {
    let [.., xx, yy, zz, xy, xz, yz] = *properties;
    let (xx, yy, zz, xy, xz, yz) = (xx?, yy?, zz?, xy?, xz?, yz?);
    Some(Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz))
}

/// The density of the even ellipsoid with this mass and inertia, kg/m³; `None` for a body without volume.
fn mean_density(mass: f64, inertia: &Matrix3<f64>) -> Option<f64> {
    let moments = inertia.symmetric_eigenvalues();
    // J₁ = m (b² + c²)/5.
    let squares = moments.map(|moment| 2.5 * (moments.sum() - 2.0 * moment) / mass);
    let volume = 4.0 / 3.0 * std::f64::consts::PI * squares.product().sqrt();
    (squares.min() > 0.0).then_some(mass / volume)
}

fn mean(positions: &[[f64; 3]]) -> Vector3<f64> {
    let sum: Vector3<f64> = positions.iter().map(|position| Vector3::from(*position)).sum();
    sum / positions.len().max(1) as f64
}

/// The largest distance between two nodes, m.
fn extent(positions: &[[f64; 3]]) -> f64 {
    let distance = |a: &[f64; 3], b: &[f64; 3]| (Vector3::from(*a) - Vector3::from(*b)).norm();
    let pairs =
        positions.iter().enumerate().flat_map(|(k, a)| positions[..k].iter().map(move |b| (a, b)));
    pairs.map(|(a, b)| distance(a, b)).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests;
