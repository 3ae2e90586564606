//! Resolves the file as written to sensors and hits in the body frame.

use std::ops::Range;

use massline_shared::STANDARD_GRAVITY;
use massline_shared::layout::{
    Axis, CalibratedGains, Dof, DofError, HOST_HITS, HOST_SENSORS, Hit, HitUncertainty, HostLayout,
    Sensor, SensorUncertainty, Sign, TestSettings,
};
use nalgebra::{Matrix3, Vector3};
use toml::Spanned;

use super::budget::{Uncertainty, replace_stated};
use super::entry::{RawHit, RawSensor};
use super::error::{Fault, LayoutFileError, Place};
use super::known::{attached, priors, sensor_mass};
use super::policy::policy;
use super::raw::{RawLayout, RawNode, RawReference, RawStatements};
use super::source::Source;
use super::tensor::tensor_fault;
use super::test_settings::{places, target, test};
use super::values::RawAxes;
use super::{LayoutFile, Node, Reference, SensorDetails, Statements};
use crate::units::GRAVITY_ON_EARTH;

/// How far an axis may be from unit length or orthogonality: the rounding error of four typed digits.
const AXIS_TOLERANCE: f64 = 1e-3;
/// The body frame.
const IDENTITY: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Checks that a layout to measure with has sensors and hits.
pub(super) fn is_complete(raw: &RawLayout, source: &Source<'_>) -> Result<(), LayoutFileError> {
    let missing = [("sensors", raw.sensors.is_none()), ("hits", raw.hits.is_none())];
    match missing.into_iter().find(|(_, missing)| *missing) {
        Some((key, _)) => Err(source.fault(0..0, key, Fault::Missing)),
        None => Ok(()),
    }
}

/// Checks everything and resolves nodes and axes.
pub(super) fn resolve(raw: RawLayout, source: &Source<'_>) -> Result<LayoutFile, LayoutFileError> {
    let nodes = nodes(&raw.node, source)?;
    let uncertainty = Uncertainty::of(&raw.uncertainty, source)?;
    let title = text(raw.title.as_ref(), "title", source)?;
    let statements = statements(raw.report.as_ref(), source)?;
    let mut layout = HostLayout {
        title: cut(&title),
        gravity: gravity(raw.gravity.as_ref(), source)?,
        test: TestSettings { policy: policy(&raw.policy), ..test(&raw.test, source)? },
        apparatus: uncertainty.apparatus,
        calibrated_hammer: uncertainty.calibrated_hammer,
        learn_budget: uncertainty.learn,
        target: target(&raw.target, source)?,
        priors: priors(&raw.prior, source)?,
        ..HostLayout::default()
    };
    let sensor_entries = raw.sensors.as_deref().unwrap_or_default();
    let hit_entries = raw.hits.as_deref().unwrap_or_default();
    let mut sensors = Vec::new();
    let mut masses = Vec::new();
    for entry in sensor_entries {
        let (sensor, details) = sensor(entry, &nodes, &uncertainty, source)?;
        let mass = sensor_mass(entry.get_ref().0.attached_mass_kg, &entry.span(), source)?;
        masses.push(mass);
        if layout.sensors.iter().any(|s| s.node == sensor.node) {
            let node = i64::from(sensor.node);
            let fault = Fault::TwoSensorsOnOneNode { node };
            return Err(source.fault(entry.span(), "sensors", fault));
        }
        if layout.sensors.len() == HOST_SENSORS {
            let count = sensor_entries.len();
            let fault = Fault::TooMany { what: "sensors", count, most: HOST_SENSORS };
            return Err(source.fault(entry.span(), "sensors", fault));
        }
        layout.sensors.push(sensor);
        sensors.push(details);
    }
    for entry in hit_entries {
        let hit = hit(entry, &nodes, &uncertainty.hit, source)?;
        if layout.hits.iter().any(|h| h.dof == hit.dof) {
            let fault = Fault::DuplicatedHit { dof: hit.dof.to_string() };
            return Err(source.fault(entry.span(), "hits", fault));
        }
        if layout.hits.len() == HOST_HITS {
            let count = hit_entries.len();
            let fault = Fault::TooMany { what: "hits", count, most: HOST_HITS };
            return Err(source.fault(entry.span(), "hits", fault));
        }
        layout.hits.push(hit);
    }
    let weighed = layout.sensors.iter().zip(&masses).filter_map(|(s, mass)| Some((s, (*mass)?)));
    layout.attached = attached(&raw.attached, weighed, source)?;
    let reference = raw.reference.as_ref().map(|r| reference(r, source)).transpose()?;
    let places = places(&raw.test, source);
    let text = source.text.to_owned();
    Ok(LayoutFile {
        title,
        layout,
        nodes,
        sensors,
        uncertainty,
        reference,
        statements,
        text,
        set_aside: Vec::new(),
        places,
    })
}

/// Free text without control characters; empty where there is none.
fn text(
    raw: Option<&Spanned<String>>,
    key: &str,
    source: &Source<'_>,
) -> Result<String, LayoutFileError> {
    let Some(raw) = raw else { return Ok(String::new()) };
    let text = raw.get_ref();
    match text.chars().find(|c| c.is_control()) {
        Some(character) => {
            Err(source.fault(raw.span(), key, Fault::ControlCharacter { found: character }))
        }
        None => Ok(text.clone()),
    }
}

fn statements(
    raw: Option<&RawStatements>,
    source: &Source<'_>,
) -> Result<Statements, LayoutFileError> {
    let Some(raw) = raw else { return Ok(Statements::default()) };
    let text = |raw: &Option<Spanned<String>>, key| text(raw.as_ref(), key, source);
    Ok(Statements {
        object: text(&raw.object, "report.object")?,
        support: text(&raw.support, "report.support")?,
        hammer: text(&raw.hammer, "report.hammer")?,
        sensors: text(&raw.sensors, "report.sensors")?,
        operator: text(&raw.operator, "report.operator")?,
        place: text(&raw.place, "report.place")?,
        remarks: text(&raw.remarks, "report.remarks")?,
    })
}

/// As much of a title as a rig has room for, in whole letters.
fn cut<const N: usize>(title: &str) -> heapless::String<N> {
    let mut short = heapless::String::new();
    // It ends at the first letter that does not fit.
    let _ = title.chars().try_for_each(|c| short.push(c));
    short
}

fn gravity(
    raw: Option<&Spanned<[f64; 3]>>,
    source: &Source<'_>,
) -> Result<Option<[f64; 3]>, LayoutFileError> {
    let Some(raw) = raw else { return Ok(None) };
    let vector = *raw.get_ref();
    source.finite(raw.span(), "gravity", &vector)?;
    let magnitude = Vector3::from(vector).norm();
    if GRAVITY_ON_EARTH.contains(&magnitude) {
        return Ok(Some(vector));
    }
    let hint = match magnitude {
        0.0 => "; leave it out where no sensor senses gravity",
        _ if GRAVITY_ON_EARTH.contains(&(magnitude * STANDARD_GRAVITY)) => {
            "; this looks like g: multiply it by 9.80665"
        }
        _ if GRAVITY_ON_EARTH.contains(&(magnitude / 1000.0)) => {
            "; this looks like mm/s²: divide it by 1000"
        }
        _ => "",
    };
    Err(source.fault(raw.span(), "gravity", Fault::GravityLength { magnitude, hint }))
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
        nodes.push(Node {
            id,
            position: *node.position_m.get_ref(),
            axes,
            can_carry_sensor: node.can_carry_sensor.unwrap_or(true),
            can_hit: can_hit(id, node.can_hit.as_deref(), source)?,
        });
    }
    Ok(nodes)
}

/// The DOFs of a node that a hammer can reach; all six when the file does not restrict them.
fn can_hit(
    node: u16,
    raw: Option<&[Spanned<String>]>,
    source: &Source<'_>,
) -> Result<Vec<Dof>, LayoutFileError> {
    let Some(raw) = raw else {
        let dofs = |sign| Axis::ALL.map(|axis| Dof { node, sign, axis });
        return Ok([dofs(Sign::Plus), dofs(Sign::Minus)].concat());
    };
    let read = |direction: &Spanned<String>| {
        format!("{node}:{}", direction.get_ref().trim()).parse().map_err(|_| {
            let fault = Fault::Direction { text: direction.get_ref().clone() };
            source.fault(direction.span(), "node.can_hit", fault)
        })
    };
    raw.iter().map(read).collect()
}

/// The axes x, y and z = x × y, computed from x and y in the frame `within`.
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

fn sensor(
    entry: &Spanned<RawSensor>,
    nodes: &[Node],
    general: &Uncertainty,
    source: &Source<'_>,
) -> Result<(Sensor<f64>, SensorDetails), LayoutFileError> {
    let Uncertainty { sensor: general, calibrated, .. } = general;
    let RawSensor(raw) = entry.get_ref();
    let span = entry.span();
    let node = node(raw.node, nodes, span.clone(), "sensors", source)?;
    let axes = match &raw.axes {
        None => node.axes,
        Some(axes) => {
            orthonormal(axes, &IDENTITY, |fault| source.fault(span.clone(), "sensors.axes", fault))?
        }
    };
    let mut uncertainty = *general;
    for (sigma, key) in uncertainty.values_mut().zip(SensorUncertainty::<f64>::KEYS) {
        replace_stated(sigma, raw.uncertainty.get(key.name), "sensors.uncertainty", key, source)?;
    }
    let is_stated = |name| raw.uncertainty.get(name).is_some();
    let details = SensorDetails { calibration: raw.calibration.clone() };
    let sensor = Sensor {
        node: node.id,
        position: node.position,
        axes,
        senses_gravity: raw.senses_gravity.unwrap_or(true),
        uncertainty,
        calibrated: CalibratedGains {
            gain: calibrated.gain && !is_stated("gain"),
            cross_axis: calibrated.cross_axis && !is_stated("cross_axis"),
        },
    };
    Ok((sensor, details))
}

fn hit(
    entry: &Spanned<RawHit>,
    nodes: &[Node],
    general: &HitUncertainty<f64>,
    source: &Source<'_>,
) -> Result<Hit<f64>, LayoutFileError> {
    let RawHit(raw) = entry.get_ref();
    let span = entry.span();
    let dof: Dof = raw
        .dof
        .parse()
        .map_err(|error| source.fault(span.clone(), "hits", dof_fault(&raw.dof, error)))?;
    let node = node(i64::from(dof.node), nodes, span.clone(), "hits", source)?;
    let axes = match &raw.axes {
        None => node.axes,
        Some(axes) => {
            orthonormal(axes, &IDENTITY, |fault| source.fault(span.clone(), "hits.axes", fault))?
        }
    };
    let direction = axes[dof.axis.index()].map(|v| {
        // Avoids −0, because directions are compared and printed.
        v * dof.sign.factor() + 0.0
    });
    let mut uncertainty = *general;
    for (sigma, key) in uncertainty.values_mut().zip(HitUncertainty::<f64>::KEYS) {
        replace_stated(sigma, raw.uncertainty.get(key.name), "hits.uncertainty", key, source)?;
    }
    Ok(Hit { dof, position: node.position, direction, uncertainty })
}

fn dof_fault(text: &str, error: DofError) -> Fault {
    match error {
        DofError::NoSign => Fault::NoSign { text: text.trim().replace(':', ":±") },
        DofError::Malformed => Fault::Dof { text: text.to_owned() },
    }
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
        // That no body has it is a suspicion: what is expected does not decide whether there is an answer.
        if let Some(fault @ Fault::NotSymmetric) = tensor_fault(&tensor) {
            return Err(source.fault(j.span(), key, fault));
        }
    }
    Ok(Reference {
        mass_kg,
        center_of_mass_m: raw.center_of_mass_m.as_ref().map(|c| *c.get_ref()),
        inertia_kg_m2: raw.inertia_kg_m2.as_ref().map(|j| *j.get_ref()),
    })
}
