//! The tables `[uncertainty]`, `[prior]` and `[[attached]]`: the error budget, prior knowledge, and bodies
//! that hang on the object.

use std::ops::Range;

use massline_shared::body::RigidBody;
use massline_shared::layout::{
    ApparatusUncertainty, Attached, CalibratedGains, HitUncertainty, MAX_ATTACHED, Prior, Sensor,
    SensorUncertainty, UncertaintyKey,
};
use nalgebra::{Matrix3, Vector3};
use toml::Spanned;

use super::error::{Fault, LayoutFileError};
use super::raw::{RawAttached, RawLayout, RawPrior};
use super::source::Source;
use super::tensor::tensor_fault;
use super::values::{RawKnown, RawMass};

/// Relative standard deviation of an attached mass that is given as a plain number.
const ATTACHED_SIGMA: f64 = 0.05;
/// Smallest relative standard deviation of prior knowledge about a mass or a moment of inertia: what the solvers
/// resolve beside the readings.
const LEAST_SIGMA: f64 = 1e-6;

/// The `[uncertainty]` table: default uncertainties of sensors and hits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uncertainty {
    /// Uncertainty of a sensor.
    pub sensor: SensorUncertainty<f64>,
    /// Uncertainty of a hit.
    pub hit: HitUncertainty<f64>,
    /// Uncertainty of hammer, converter and gravity.
    pub apparatus: ApparatusUncertainty<f64>,
    /// Which standard deviations of the sensors a calibration supplies, because the table states none.
    pub calibrated: CalibratedGains,
    /// True when a calibration supplies that of the hammer's gain.
    pub calibrated_hammer: bool,
    /// True when the data may correct the budget.
    pub learn: bool,
}

impl Uncertainty {
    pub(super) fn of(raw: &RawLayout, source: &Source<'_>) -> Result<Self, LayoutFileError> {
        let mut all = Self {
            sensor: SensorUncertainty::default(),
            hit: HitUncertainty::default(),
            apparatus: ApparatusUncertainty::default(),
            calibrated: CalibratedGains { gain: true, cross_axis: true },
            calibrated_hammer: true,
            learn: true,
        };
        let Some(raw) = &raw.uncertainty else { return Ok(all) };
        let is_stated = |name| raw.sigma(name).is_some();
        all.calibrated =
            CalibratedGains { gain: !is_stated("gain"), cross_axis: !is_stated("cross_axis") };
        all.calibrated_hammer = !is_stated("hammer_gain");
        all.learn = raw.learn().unwrap_or(all.learn);
        let sensor = all.sensor.values_mut().zip(SensorUncertainty::<f64>::KEYS);
        let hit = all.hit.values_mut().zip(HitUncertainty::<f64>::KEYS);
        let apparatus = all.apparatus.values_mut().zip(ApparatusUncertainty::<f64>::KEYS);
        for (to, key) in sensor.chain(hit).chain(apparatus) {
            replace_stated(to, raw.sigma(key.name), "uncertainty", key, source)?;
        }
        Ok(all)
    }

    /// Every key with its standard deviation.
    pub fn sigmas(&self) -> impl Iterator<Item = (&'static UncertaintyKey, f64)> {
        let rows = self.sensor.rows().chain(self.hit.rows()).chain(self.apparatus.rows());
        rows.map(|(key, sigma)| (key, *sigma))
    }
}

/// Replaces a standard deviation by the one that a table states.
pub(super) fn replace_stated(
    sigma: &mut f64,
    stated: Option<&Spanned<f64>>,
    table: &str,
    key: &UncertaintyKey,
    source: &Source<'_>,
) -> Result<(), LayoutFileError> {
    if let Some(stated) = stated {
        let key = format!("{table}.{}", key.name);
        *sigma = source.within(stated, &key, |v| v >= 0.0, "zero or a positive number")?;
    }
    Ok(())
}

/// The `[prior]` table.
pub(super) fn priors(
    raw: &RawLayout,
    source: &Source<'_>,
) -> Result<heapless::Vec<Prior<f64>, 10>, LayoutFileError> {
    let mut priors = heapless::Vec::new();
    let Some(raw) = &raw.prior else { return Ok(priors) };
    for (property, (entry, key, positive)) in (0..).zip(prior_entries(raw)) {
        let Some(entry) = entry else { continue };
        let RawKnown { value, sigma } = *entry.get_ref();
        check_known(entry, key, positive, source)?;
        if positive && sigma < LEAST_SIGMA * value {
            let wanted = "a sigma of a millionth of the value at least: no scale is better";
            return Err(source.fault(
                entry.span(),
                key,
                Fault::OutOfRange { value: sigma, wanted },
            ));
        }
        // Cannot fail: there are at most ten entries, one per property.
        let _ = priors.push(Prior { property, value, sigma });
    }
    Ok(priors)
}

/// The entries in the order of `theta`, their keys, and whether the value must be positive.
fn prior_entries(raw: &RawPrior) -> [(&Option<Spanned<RawKnown>>, &'static str, bool); 10] {
    [
        (&raw.mass_kg, "prior.mass_kg", true),
        (&raw.cx_m, "prior.cx_m", false),
        (&raw.cy_m, "prior.cy_m", false),
        (&raw.cz_m, "prior.cz_m", false),
        (&raw.Jxx_kg_m2, "prior.Jxx_kg_m2", true),
        (&raw.Jyy_kg_m2, "prior.Jyy_kg_m2", true),
        (&raw.Jzz_kg_m2, "prior.Jzz_kg_m2", true),
        (&raw.Jxy_kg_m2, "prior.Jxy_kg_m2", false),
        (&raw.Jxz_kg_m2, "prior.Jxz_kg_m2", false),
        (&raw.Jyz_kg_m2, "prior.Jyz_kg_m2", false),
    ]
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
) -> Result<heapless::Vec<Attached<f64>, MAX_ATTACHED>, LayoutFileError> {
    let mut all = heapless::Vec::new();
    if let Some(instruments) = together(sensors) {
        // Cannot fail: the list is empty so far.
        let _ = all.push(instruments);
    }
    for body in raw {
        let span = body.mass_kg.span();
        all.push(attached_body(body, source)?).map_err(|_| {
            let most = MAX_ATTACHED - 1;
            let fault = Fault::TooMany { what: "attached bodies", count: raw.len(), most };
            source.fault(span, "attached", fault)
        })?;
    }
    Ok(all)
}

/// Combines point masses to one body. Masses weighed on one scale have a common error, so their standard
/// deviations add up.
fn together<'a>(
    sensors: impl Iterator<Item = (&'a Sensor<f64>, (f64, f64))>,
) -> Option<Attached<f64>> {
    let mut sum = Attached { phi: [0.0; 10], relative_sigma: 0.0 };
    let mut sigma = 0.0;
    for (sensor, (mass, relative_sigma)) in sensors {
        let point = Attached::point(mass, relative_sigma, sensor.position);
        for (to, from) in sum.phi.iter_mut().zip(point.phi) {
            *to += from;
        }
        sigma += mass * relative_sigma;
    }
    let mass = sum.phi[0];
    (mass > 0.0).then(|| Attached { relative_sigma: sigma / mass, ..sum })
}

fn attached_body(raw: &RawAttached, source: &Source<'_>) -> Result<Attached<f64>, LayoutFileError> {
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
    Ok(Attached { phi: body.phi().into(), relative_sigma: sigma / mass })
}
