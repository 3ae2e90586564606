//! From the file as written to sensors and hits in the body frame.

use std::ops::Range;

use massline_shared::layout::{
    Dof, HOST_HITS, HOST_SENSORS, Hit, HostLayout, Sensor, TestSettings,
};
use nalgebra::{Matrix3, Vector3};
use toml::Spanned;

use super::error::{Fault, LayoutFileError, Place};
use super::raw::{RawAxes, RawHit, RawLayout, RawNode, RawReference, RawSensor, RawTest};
use super::{
    HitDetails, Known, LayoutFile, Node, Reference, SensorDetails, SensorUncertainty, Uncertainty,
};

/// How far an axis may be from unit length or orthogonality: what four typed digits cause.
const AXIS_TOLERANCE: f64 = 1e-3;
/// How far the tensor may be from symmetry, relative to its trace: what six typed digits cause.
const SYMMETRY_TOLERANCE: f64 = 1e-5;
/// Bytes of a title.
const TITLE_BYTES: usize = 48;
/// The body frame.
const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// The text that spans point into.
pub(super) struct Source<'a> {
    pub(super) file: &'a str,
    pub(super) text: &'a str,
}

impl Source<'_> {
    fn fault(&self, span: Range<usize>, key: &str, fault: Fault) -> LayoutFileError {
        let place = Place::of(self.file, self.text, Some(span), key);
        LayoutFileError::Fault { place, fault }
    }

    fn finite(&self, span: Range<usize>, key: &str, values: &[f64]) -> Result<(), LayoutFileError> {
        match values.iter().find(|v| !v.is_finite()) {
            Some(&value) => Err(self.fault(span, key, Fault::NotFinite { value })),
            None => Ok(()),
        }
    }

    fn within(
        &self,
        value: &Spanned<f64>,
        key: &str,
        good: impl Fn(f64) -> bool,
        wanted: &'static str,
    ) -> Result<f64, LayoutFileError> {
        let v = *value.get_ref();
        self.finite(value.span(), key, &[v])?;
        if good(v) {
            Ok(v)
        } else {
            Err(self.fault(value.span(), key, Fault::OutOfRange { value: v, wanted }))
        }
    }
}

/// Checks everything and resolves nodes and axes.
pub(super) fn resolve(raw: RawLayout, source: &Source<'_>) -> Result<LayoutFile, LayoutFileError> {
    let nodes = nodes(&raw.node, source)?;
    let uncertainty = uncertainty(&raw, source)?;
    let mut layout = HostLayout {
        title: title(raw.title.as_ref(), source)?,
        gravity: gravity(raw.gravity.as_ref(), source)?,
        sensors: heapless::Vec::new(),
        hits: heapless::Vec::new(),
        test: test(raw.test.as_ref(), source)?,
    };
    let mut sensors = Vec::new();
    for entry in raw.sensors.get_ref() {
        let (sensor, details) = sensor(entry, &nodes, &uncertainty, source)?;
        if layout.sensors.iter().any(|s| s.node == sensor.node) {
            let node = i64::from(sensor.node);
            let fault = Fault::TwoSensorsOnOneNode { node };
            return Err(source.fault(entry.span(), "sensors", fault));
        }
        layout.sensors.push(sensor).map_err(|_| {
            let count = raw.sensors.get_ref().len();
            let fault = Fault::TooMany { what: "sensors", count, most: HOST_SENSORS };
            source.fault(entry.span(), "sensors", fault)
        })?;
        sensors.push(details);
    }
    let mut hits = Vec::new();
    for entry in raw.hits.get_ref() {
        let (hit, details) = hit(entry, &nodes, &uncertainty, source)?;
        if layout.hits.iter().any(|h| h.dof == hit.dof) {
            let fault = Fault::DuplicatedHit { dof: hit.dof.to_string() };
            return Err(source.fault(entry.span(), "hits", fault));
        }
        layout.hits.push(hit).map_err(|_| {
            let count = raw.hits.get_ref().len();
            let fault = Fault::TooMany { what: "hits", count, most: HOST_HITS };
            source.fault(entry.span(), "hits", fault)
        })?;
        hits.push(details);
    }
    let prior_mass_kg = prior(&raw, source)?;
    let reference = raw.reference.as_ref().map(|r| reference(r, source)).transpose()?;
    Ok(LayoutFile { layout, nodes, sensors, hits, uncertainty, prior_mass_kg, reference })
}

fn title(
    raw: Option<&Spanned<String>>,
    source: &Source<'_>,
) -> Result<heapless::String<TITLE_BYTES>, LayoutFileError> {
    let Some(raw) = raw else { return Ok(heapless::String::new()) };
    heapless::String::try_from(raw.get_ref().as_str()).map_err(|_| {
        let fault = Fault::TextTooLong { bytes: raw.get_ref().len(), most: TITLE_BYTES };
        source.fault(raw.span(), "title", fault)
    })
}

fn gravity(
    raw: Option<&Spanned<[f64; 3]>>,
    source: &Source<'_>,
) -> Result<Option<[f64; 3]>, LayoutFileError> {
    let Some(raw) = raw else { return Ok(None) };
    source.finite(raw.span(), "gravity", raw.get_ref())?;
    Ok(Some(*raw.get_ref()))
}

fn nodes(raw: &[RawNode], source: &Source<'_>) -> Result<Vec<Node>, LayoutFileError> {
    let mut nodes: Vec<Node> = Vec::new();
    for node in raw {
        let number = *node.id.get_ref();
        let id = u16::try_from(number).ok().filter(|&id| id > 0).ok_or_else(|| {
            source.fault(node.id.span(), "node.id", Fault::NodeNumber { node: number })
        })?;
        if let Some(first) = nodes.iter().position(|n| n.id == id) {
            let span = raw.get(first).map(|n| n.id.span());
            let first = Place::of(source.file, source.text, span, "").line;
            let fault = Fault::DuplicatedNode { node: number, first };
            return Err(source.fault(node.id.span(), "node.id", fault));
        }
        source.finite(node.position_m.span(), "node.position_m", node.position_m.get_ref())?;
        let axes = match &node.axes {
            None => IDENTITY,
            Some(axes) => orthonormal(axes.get_ref(), &IDENTITY, |fault| {
                source.fault(axes.span(), "node.axes", fault)
            })?,
        };
        nodes.push(Node { id, position: *node.position_m.get_ref(), axes });
    }
    Ok(nodes)
}

/// x, y and z = x × y from x and y, which are given in the frame `within`.
fn orthonormal(
    axes: &RawAxes,
    within: &[[f64; 3]; 3],
    error: impl Fn(Fault) -> LayoutFileError,
) -> Result<[[f64; 3]; 3], LayoutFileError> {
    let [x, y] = axes.map(Vector3::from);
    for (axis, v) in [('x', x), ('y', y)] {
        if let Some(&value) = v.iter().find(|v| !v.is_finite()) {
            return Err(error(Fault::NotFinite { value }));
        }
        let length = v.norm();
        if (length - 1.0).abs() > AXIS_TOLERANCE {
            return Err(error(Fault::AxisNotUnit { axis, length }));
        }
    }
    if x.dot(&y).abs() > AXIS_TOLERANCE {
        return Err(error(Fault::AxesNotOrthogonal { degrees: x.angle(&y).to_degrees() }));
    }
    let x = x.normalize();
    let y = (y - x * x.dot(&y)).normalize();
    let z = x.cross(&y);
    let frame = within.map(Vector3::from);
    Ok([x, y, z].map(|v| (frame[0] * v.x + frame[1] * v.y + frame[2] * v.z).into()))
}

fn node<'a>(
    number: i64,
    nodes: &'a [Node],
    span: Range<usize>,
    key: &str,
    source: &Source<'_>,
) -> Result<&'a Node, LayoutFileError> {
    nodes.iter().find(|n| i64::from(n.id) == number).ok_or_else(|| {
        let known = if nodes.is_empty() {
            "none".to_owned()
        } else {
            nodes.iter().map(|n| n.id.to_string()).collect::<Vec<_>>().join(", ")
        };
        source.fault(span, key, Fault::UnknownNode { node: number, known })
    })
}

/// A standard deviation or mass of an entry: `value` when given, else `default`.
fn amount(
    value: Option<f64>,
    default: f64,
    span: &Range<usize>,
    key: &str,
    source: &Source<'_>,
) -> Result<f64, LayoutFileError> {
    let Some(value) = value else { return Ok(default) };
    source.finite(span.clone(), key, &[value])?;
    if value < 0.0 {
        let fault = Fault::OutOfRange { value, wanted: "zero or a positive number" };
        return Err(source.fault(span.clone(), key, fault));
    }
    Ok(value)
}

fn sensor(
    entry: &Spanned<RawSensor>,
    nodes: &[Node],
    general: &Uncertainty,
    source: &Source<'_>,
) -> Result<(Sensor<f64>, SensorDetails), LayoutFileError> {
    let RawSensor(raw) = entry.get_ref();
    let span = entry.span();
    let node = node(raw.node, nodes, span.clone(), "sensors", source)?;
    let axes = match &raw.axes {
        None => node.axes,
        Some(axes) => {
            orthonormal(axes, &IDENTITY, |fault| source.fault(span.clone(), "sensors.axes", fault))?
        }
    };
    let own = raw.uncertainty.unwrap_or_default();
    let amount = |value, default, key| amount(value, default, &span, key, source);
    let position = own.sensor_position_m;
    let rotation = own.sensor_rotation_rad;
    let uncertainty = SensorUncertainty {
        position_m: amount(position, general.sensor_position_m, "sensors.uncertainty")?,
        rotation_rad: amount(rotation, general.sensor_rotation_rad, "sensors.uncertainty")?,
        gain: amount(own.gain, general.gain, "sensors.uncertainty")?,
        cross_axis: amount(own.cross_axis, general.cross_axis, "sensors.uncertainty")?,
    };
    let details = SensorDetails {
        calibration: raw.calibration.clone(),
        attached_mass_kg: amount(raw.attached_mass_kg, 0.0, "sensors.attached_mass_kg")?,
        uncertainty,
    };
    let sensor = Sensor {
        node: node.id,
        position: node.position,
        axes,
        senses_gravity: raw.senses_gravity.unwrap_or(true),
    };
    Ok((sensor, details))
}

fn hit(
    entry: &Spanned<RawHit>,
    nodes: &[Node],
    general: &Uncertainty,
    source: &Source<'_>,
) -> Result<(Hit<f64>, HitDetails), LayoutFileError> {
    let RawHit(raw) = entry.get_ref();
    let span = entry.span();
    let dof: Dof = raw
        .dof
        .parse()
        .map_err(|_| source.fault(span.clone(), "hits", Fault::Dof { text: raw.dof.clone() }))?;
    let node = node(i64::from(dof.node), nodes, span.clone(), "hits", source)?;
    let axes = match &raw.axes {
        None => node.axes,
        Some(axes) => {
            orthonormal(axes, &IDENTITY, |fault| source.fault(span.clone(), "hits.axes", fault))?
        }
    };
    let direction = axes[dof.axis.index()].map(|v| {
        // Not −0: a direction is compared and printed.
        v * dof.sign.factor() + 0.0
    });
    let own = raw.uncertainty.unwrap_or_default();
    let amount = |value, default| amount(value, default, &span, "hits.uncertainty", source);
    let details = HitDetails {
        position_m: amount(own.hit_position_m, general.hit_position_m)?,
        direction_rad: amount(own.hit_direction_rad, general.hit_direction_rad)?,
        node_position_m: amount(own.node_position_m, general.node_position_m)?,
        node_direction_rad: amount(own.node_direction_rad, general.node_direction_rad)?,
    };
    Ok((Hit { dof, position: node.position, direction }, details))
}

fn test(raw: Option<&RawTest>, source: &Source<'_>) -> Result<TestSettings<f64>, LayoutFileError> {
    let mut test = TestSettings::default();
    let Some(raw) = raw else { return Ok(test) };
    if let Some(hits) = &raw.hits_per_dof {
        test.hits_per_dof =
            u8::try_from(*hits.get_ref()).ok().filter(|&h| h > 0).ok_or_else(|| {
                let value = *hits.get_ref() as f64;
                let fault = Fault::OutOfRange { value, wanted: "a whole number from 1 to 255" };
                source.fault(hits.span(), "test.hits_per_dof", fault)
            })?;
    }
    if let Some(band) = &raw.band_hz {
        let [low, high] = *band.get_ref();
        source.finite(band.span(), "test.band_hz", &[low, high])?;
        if low <= 0.0 || high <= low {
            let value = if low <= 0.0 { low } else { high };
            let wanted = "[lowest, highest] frequency in Hz, 0 < lowest < highest";
            let fault = Fault::OutOfRange { value, wanted };
            return Err(source.fault(band.span(), "test.band_hz", fault));
        }
        test.band_hz = [low, high];
    }
    let positive = "a positive number";
    if let Some(v) = &raw.exponential_decay_per_s {
        let wanted = "zero (no window) or a positive number, 1/s";
        let key = "test.exponential_decay_per_s";
        test.exponential_decay = source.within(v, key, |v| v >= 0.0, wanted)?;
    }
    if let Some(v) = &raw.force_window_s {
        test.force_window_s = source.within(v, "test.force_window_s", |v| v > 0.0, positive)?;
    }
    if let Some(v) = &raw.trigger_n {
        test.trigger_n = source.within(v, "test.trigger_n", |v| v > 0.0, positive)?;
    }
    if let Some(v) = &raw.weakest_hit_n {
        test.weakest_hit_n = source.within(v, "test.weakest_hit_n", |v| v > 0.0, positive)?;
    }
    Ok(test)
}

fn uncertainty(raw: &RawLayout, source: &Source<'_>) -> Result<Uncertainty, LayoutFileError> {
    let mut all = Uncertainty::default();
    let Some(raw) = &raw.uncertainty else { return Ok(all) };
    let entries = [
        (&raw.hit_position_m, &mut all.hit_position_m, "uncertainty.hit_position_m"),
        (&raw.hit_direction_rad, &mut all.hit_direction_rad, "uncertainty.hit_direction_rad"),
        (&raw.sensor_position_m, &mut all.sensor_position_m, "uncertainty.sensor_position_m"),
        (&raw.sensor_rotation_rad, &mut all.sensor_rotation_rad, "uncertainty.sensor_rotation_rad"),
        (&raw.gain, &mut all.gain, "uncertainty.gain"),
        (&raw.cross_axis, &mut all.cross_axis, "uncertainty.cross_axis"),
        (&raw.hammer_gain, &mut all.hammer_gain, "uncertainty.hammer_gain"),
        (&raw.node_position_m, &mut all.node_position_m, "uncertainty.node_position_m"),
        (&raw.node_direction_rad, &mut all.node_direction_rad, "uncertainty.node_direction_rad"),
    ];
    for (from, to, key) in entries {
        if let Some(v) = from {
            *to = source.within(v, key, |v| v >= 0.0, "zero or a positive number")?;
        }
    }
    Ok(all)
}

fn prior(raw: &RawLayout, source: &Source<'_>) -> Result<Option<Known>, LayoutFileError> {
    let Some(raw) = &raw.prior else { return Ok(None) };
    let known = *raw.mass_kg.get_ref();
    let span = raw.mass_kg.span();
    source.finite(span.clone(), "prior.mass_kg", &[known.value, known.sigma])?;
    for value in [known.value, known.sigma] {
        if value <= 0.0 {
            let fault = Fault::OutOfRange { value, wanted: "positive numbers for value and sigma" };
            return Err(source.fault(span, "prior.mass_kg", fault));
        }
    }
    Ok(Some(Known { value: known.value, sigma: known.sigma }))
}

fn reference(raw: &RawReference, source: &Source<'_>) -> Result<Reference, LayoutFileError> {
    let mass_kg = match &raw.mass_kg {
        None => None,
        Some(v) => {
            Some(source.within(v, "reference.mass_kg", |v| v > 0.0, "a positive mass in kg")?)
        }
    };
    if let Some(c) = &raw.center_of_mass_m {
        source.finite(c.span(), "reference.center_of_mass_m", c.get_ref())?;
    }
    if let Some(j) = &raw.inertia_kg_m2 {
        let key = "reference.inertia_kg_m2";
        source.finite(j.span(), key, j.get_ref().as_flattened())?;
        let tensor = Matrix3::from(*j.get_ref()).transpose();
        if let Some(fault) = tensor_fault(&tensor) {
            return Err(source.fault(j.span(), key, fault));
        }
    }
    Ok(Reference {
        mass_kg,
        center_of_mass_m: raw.center_of_mass_m.as_ref().map(|c| *c.get_ref()),
        inertia_kg_m2: raw.inertia_kg_m2.as_ref().map(|j| *j.get_ref()),
    })
}

/// Why a tensor belongs to no body: `tr(J)/2·I − J` must be positive semidefinite.
fn tensor_fault(tensor: &Matrix3<f64>) -> Option<Fault> {
    let trace = tensor.trace();
    if (tensor - tensor.transpose()).amax() > SYMMETRY_TOLERANCE * trace.abs() {
        return Some(Fault::NotSymmetric);
    }
    let symmetric = (tensor + tensor.transpose()) * 0.5;
    let margin = Matrix3::identity() * (0.5 * trace) - symmetric;
    let moments = margin.try_symmetric_eigen(f64::EPSILON, 1000)?.eigenvalues;
    // A thin rod has an exact zero here, which typed digits make slightly negative.
    (trace <= 0.0 || moments.min() < -SYMMETRY_TOLERANCE * trace).then_some(Fault::NoBody)
}
