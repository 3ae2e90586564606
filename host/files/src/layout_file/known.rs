//! The tables `[prior]` and `[[attached]]`: prior knowledge, and bodies that hang on the object.

use std::ops::Range;
use std::sync::LazyLock;

use massline_shared::body::RigidBody;
use massline_shared::layout::{AttachedBody, MAX_ATTACHED, Prior, Sensor};
use nalgebra::{Matrix3, Vector3};
use serde::Deserialize;
use serde::de::MapAccess;
use toml::Spanned;

use super::error::{Fault, LayoutFileError};
use super::keyed::{KeyedTable, TableKeys};
use super::source::Source;
use super::tensor::tensor_fault;
use super::values::{RawKnown, RawMass};

/// Relative standard deviation of an attached mass that is given as a plain number.
const ATTACHED_SIGMA: f64 = 0.05;
/// Smallest relative standard deviation of prior knowledge about a mass or a moment of inertia: what the solvers
/// resolve beside the readings.
const LEAST_SIGMA: f64 = 1e-6;

/// A body that hangs on the object but does not belong to it.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields, expecting = "a table [[attached]]")]
pub(super) struct RawAttached {
    /// Mass, kg.
    #[cfg_attr(feature = "schema", schemars(with = "RawKnown"))]
    pub(super) mass_kg: Spanned<RawKnown>,
    /// Centre of mass in the body frame, m.
    #[cfg_attr(feature = "schema", schemars(with = "[f64; 3]"))]
    pub(super) center_of_mass_m: Spanned<[f64; 3]>,
    /// Inertia tensor about its own centre of mass, kg m², J_xy = −∫xy dm. Default: a point mass.
    #[cfg_attr(feature = "schema", schemars(with = "[[f64; 3]; 3]"))]
    #[serde(default)]
    pub(super) inertia_kg_m2: Option<Spanned<[[f64; 3]; 3]>>,
}

/// A key of `[prior]`.
#[derive(Clone, Copy)]
pub(super) struct PriorKey {
    pub(super) name: &'static str,
    /// What it says, with its unit.
    #[cfg_attr(not(feature = "schema"), expect(dead_code, reason = "it is for the schema alone"))]
    pub(super) meaning: &'static str,
    /// True for what is more than zero.
    is_positive: bool,
}

const fn prior_key(name: &'static str, meaning: &'static str, is_positive: bool) -> PriorKey {
    PriorKey { name, meaning, is_positive }
}

/// Every key of `[prior]`, in the order of the ten properties.
pub(super) const PRIOR_KEYS: [PriorKey; 10] = [
    prior_key("mass_kg", "Mass, kg.", true),
    prior_key("cx_m", "Centre of mass, x, m.", false),
    prior_key("cy_m", "Centre of mass, y, m.", false),
    prior_key("cz_m", "Centre of mass, z, m.", false),
    prior_key("Jxx_kg_m2", "Inertia about the centre of mass, xx, kg m².", true),
    prior_key("Jyy_kg_m2", "Inertia about the centre of mass, yy, kg m².", true),
    prior_key("Jzz_kg_m2", "Inertia about the centre of mass, zz, kg m².", true),
    prior_key("Jxy_kg_m2", "Inertia about the centre of mass, xy, kg m².", false),
    prior_key("Jxz_kg_m2", "Inertia about the centre of mass, xz, kg m².", false),
    prior_key("Jyz_kg_m2", "Inertia about the centre of mass, yz, kg m².", false),
];

/// The keys of `[prior]`: the ten properties.
pub(super) struct PriorKeys;

impl TableKeys for PriorKeys {
    type Value = Spanned<RawKnown>;
    const WRITTEN: &'static str = "a table [prior]";

    fn names() -> &'static [&'static str] {
        static NAMES: LazyLock<Vec<&str>> =
            LazyLock::new(|| PRIOR_KEYS.map(|key| key.name).to_vec());
        &NAMES
    }

    fn read<'de, A: MapAccess<'de>>(
        _: &'static str,
        map: &mut A,
    ) -> Result<Spanned<RawKnown>, A::Error> {
        map.next_value()
    }
}

/// The `[prior]` table.
pub(super) fn priors(
    raw: &KeyedTable<PriorKeys>,
    source: &Source<'_>,
) -> Result<heapless::Vec<Prior<f64>, 10>, LayoutFileError> {
    let mut priors = heapless::Vec::new();
    for (property, PriorKey { name, is_positive: positive, .. }) in (0..).zip(PRIOR_KEYS) {
        let Some(entry) = raw.get(name) else { continue };
        let key = format!("prior.{name}");
        let RawKnown { value, sigma } = *entry.get_ref();
        check_known(entry, &key, positive, source)?;
        if positive && sigma < LEAST_SIGMA * value {
            let wanted = "a sigma of a millionth of the value at least: no scale is better";
            return Err(source.fault(
                entry.span(),
                &key,
                Fault::OutOfRange { value: sigma, wanted },
            ));
        }
        // Cannot fail: there are at most ten entries, one per property.
        let _ = priors.push(Prior { property, value, sigma });
    }
    Ok(priors)
}

fn check_known(
    entry: &Spanned<RawKnown>,
    key: &str,
    positive: bool,
    source: &Source<'_>,
) -> Result<(), LayoutFileError> {
    let RawKnown { value, sigma } = *entry.get_ref();
    source.finite(entry.span(), key, &[value, sigma])?;
    if positive && value <= 0.0 {
        let fault = Fault::OutOfRange { value, wanted: "a positive value" };
        return Err(source.fault(entry.span(), key, fault));
    }
    if sigma <= 0.0 {
        let wanted = "a positive sigma (one standard deviation)";
        return Err(source.fault(entry.span(), key, Fault::OutOfRange { value: sigma, wanted }));
    }
    Ok(())
}

/// The mass that a sensor adds to the object, kg, and its relative standard deviation.
pub(super) fn sensor_mass(
    raw: Option<RawMass>,
    span: &Range<usize>,
    source: &Source<'_>,
) -> Result<Option<(f64, f64)>, LayoutFileError> {
    let key = "sensors.attached_mass_kg";
    let (mass, sigma) = match raw {
        None => return Ok(None),
        Some(RawMass::Number(mass)) => (mass, ATTACHED_SIGMA * mass),
        Some(RawMass::Known(known)) => (known.value, known.sigma),
    };
    source.finite(span.clone(), key, &[mass, sigma])?;
    for value in [mass, sigma] {
        if value < 0.0 {
            let fault = Fault::OutOfRange { value, wanted: "zero or a positive mass in kg" };
            return Err(source.fault(span.clone(), key, fault));
        }
    }
    Ok((mass > 0.0).then(|| (mass, sigma / mass)))
}

/// The bodies of `[[attached]]` and, as one body, the masses of the sensors.
pub(super) fn attached<'a>(
    raw: &[RawAttached],
    sensors: impl Iterator<Item = (&'a Sensor<f64>, (f64, f64))>,
    source: &Source<'_>,
) -> Result<heapless::Vec<AttachedBody<f64>, MAX_ATTACHED>, LayoutFileError> {
    let mut bodies = heapless::Vec::new();
    if let Some(instruments) = together(sensors) {
        // Cannot fail: the list is empty so far.
        let _ = bodies.push(instruments);
    }
    for body in raw {
        let span = body.mass_kg.span();
        bodies.push(attached_body(body, source)?).map_err(|_| {
            let most = MAX_ATTACHED - 1;
            let fault = Fault::TooMany { what: "attached bodies", count: raw.len(), most };
            source.fault(span, "attached", fault)
        })?;
    }
    Ok(bodies)
}

/// Combines point masses to one body. Masses weighed on one scale have a common error, so their standard
/// deviations add up.
fn together<'a>(
    sensors: impl Iterator<Item = (&'a Sensor<f64>, (f64, f64))>,
) -> Option<AttachedBody<f64>> {
    let mut sum = AttachedBody { phi: [0.0; 10], relative_sigma: 0.0 };
    let mut sigma = 0.0;
    for (sensor, (mass, relative_sigma)) in sensors {
        let point = AttachedBody::point(mass, relative_sigma, sensor.position);
        for (to, from) in sum.phi.iter_mut().zip(point.phi) {
            *to += from;
        }
        sigma += mass * relative_sigma;
    }
    let mass = sum.phi[0];
    (mass > 0.0).then(|| AttachedBody { relative_sigma: sigma / mass, ..sum })
}

fn attached_body(
    raw: &RawAttached,
    source: &Source<'_>,
) -> Result<AttachedBody<f64>, LayoutFileError> {
    check_known(&raw.mass_kg, "attached.mass_kg", true, source)?;
    let center = &raw.center_of_mass_m;
    source.finite(center.span(), "attached.center_of_mass_m", center.get_ref())?;
    let mut inertia = Matrix3::zeros();
    if let Some(tensor) = &raw.inertia_kg_m2 {
        let key = "attached.inertia_kg_m2";
        source.finite(tensor.span(), key, tensor.get_ref().as_flattened())?;
        inertia = Matrix3::from(*tensor.get_ref()).transpose();
        if let Some(fault) = tensor_fault(&inertia) {
            return Err(source.fault(tensor.span(), key, fault));
        }
    }
    let RawKnown { value: mass, sigma } = *raw.mass_kg.get_ref();
    let body = RigidBody { mass, center_of_mass: Vector3::from(*center.get_ref()), inertia };
    Ok(AttachedBody { phi: body.phi().into(), relative_sigma: sigma / mass })
}
