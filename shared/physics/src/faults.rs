//! What the mistakes of a bench ([`Fault`]) do to its sensors, hits and cables.

use massline_shared::layout::HostLayout;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use crate::bench::{Bench, BenchError};
use crate::settings::Fault;

mod electric;

pub(super) use electric::{compresses, hum, rails};

/// How one sensor is mounted and wired, with the faults of the bench.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Mounting {
    /// Rotation of the nominal axes by the way it is glued.
    pub(super) turn: Matrix3<f64>,
    /// Effect of its wiring on its reading.
    pub(super) wires: Matrix3<f64>,
    /// The sensor whose channels it is plugged into.
    pub(super) plug: usize,
}

/// The mounting of a sensor with the faults of the bench.
pub(super) fn mounting(bench: &Bench, sensor: usize) -> Mounting {
    let mut mounting =
        Mounting { turn: Matrix3::identity(), wires: Matrix3::identity(), plug: sensor };
    for fault in &bench.faults {
        match *fault {
            Fault::Flip { sensor: s, axis } if s == sensor => {
                mounting.wires.row_mut(axis.index()).neg_mut();
            }
            Fault::SwapAxes { sensor: s, axes: [a, b] } if s == sensor => {
                mounting.wires.swap_rows(a.index(), b.index());
            }
            Fault::Rotate { sensor: s, axis, quarters } if s == sensor => {
                // The axes are turned with the sensor, so the reading is turned the opposite way.
                let mut about = Vector3::zeros();
                about[axis.index()] = 1.0;
                let angle = -std::f64::consts::FRAC_PI_2 * f64::from(quarters);
                let turn = Rotation3::from_axis_angle(&Unit::new_unchecked(about), angle);
                mounting.turn = turn.matrix() * mounting.turn;
            }
            Fault::SwapSensors([a, b]) if mounting.plug == a => mounting.plug = b,
            Fault::SwapSensors([a, b]) if mounting.plug == b => mounting.plug = a,
            Fault::Scale(factor) => mounting.wires *= factor,
            _ => {}
        }
    }
    mounting
}

/// The point that the hammer aims at for a hit DOF: node, position and direction, with the faults of the
/// bench.
pub(super) fn mark(
    bench: &Bench,
    layout: &HostLayout,
    dof: usize,
) -> Option<(u16, Vector3<f64>, Vector3<f64>)> {
    let hit = layout.hits.get(dof)?;
    let mut mark = (hit.dof.node, Vector3::from(hit.position), Vector3::from(hit.direction));
    for fault in &bench.faults {
        match *fault {
            Fault::HitNode { hit, node } if hit == dof => {
                (mark.0, mark.1) = (node, place(bench, layout, node)?);
            }
            Fault::HitReversed { hit } if hit == dof => mark.2.neg_mut(),
            _ => {}
        }
    }
    Some(mark)
}

/// The factor of the hammer's reading.
pub(super) fn hammer_scale(bench: &Bench) -> f64 {
    let factor = |fault: &Fault| match *fault {
        Fault::HammerScale(factor) => factor,
        _ => 1.0,
    };
    bench.faults.iter().map(factor).product()
}

/// Distance from the mark at which the hits at a DOF land because of faults, m.
pub(super) fn beside(bench: &Bench, dof: usize) -> f64 {
    let distance = |fault: &Fault| match *fault {
        Fault::HitBeside { hit, distance_m } if hit == dof => distance_m,
        _ => 0.0,
    };
    bench.faults.iter().map(distance).sum()
}

/// Mass of each sensor board because of faults, kg.
pub(super) fn board_mass(bench: &Bench) -> f64 {
    let mass = |fault: &Fault| match *fault {
        Fault::BoardMass { mass_kg } => mass_kg,
        _ => 0.0,
    };
    bench.faults.iter().map(mass).sum()
}

/// Point and stiffness, N/m, of every cable that pulls.
pub(super) fn cables(bench: &Bench, layout: &HostLayout) -> Vec<(Vector3<f64>, f64)> {
    let cable = |fault: &Fault| match *fault {
        Fault::Cable { node, stiffness_n_per_m } => {
            Some((place(bench, layout, node)?, stiffness_n_per_m))
        }
        _ => None,
    };
    bench.faults.iter().filter_map(cable).collect()
}

/// Position of a node: that of the layout, or else that of the bench.
fn place(bench: &Bench, layout: &HostLayout, node: u16) -> Option<Vector3<f64>> {
    let hit = layout.hits.iter().find(|h| h.dof.node == node).map(|h| h.position);
    let sensor = || layout.sensors.iter().find(|s| s.node == node).map(|s| s.position);
    let home = || bench.node(node).map(|n| n.position_m);
    hit.or_else(sensor).or_else(home).map(Vector3::from)
}

/// Refuses a fault about a sensor, hit or node that does not exist.
pub(super) fn check(bench: &Bench, layout: &HostLayout) -> Result<(), BenchError> {
    for fault in &bench.faults {
        let sensors = match *fault {
            Fault::Flip { sensor, .. }
            | Fault::SwapAxes { sensor, .. }
            | Fault::Rotate { sensor, .. }
            | Fault::SensorRail { sensor, .. }
            | Fault::Compression { sensor, .. } => sensor.saturating_add(1),
            Fault::SwapSensors([a, b]) => a.max(b).saturating_add(1),
            _ => 0,
        };
        let (hits, node) = match *fault {
            Fault::HitNode { hit, node } => (hit.saturating_add(1), Some(node)),
            Fault::HitReversed { hit } | Fault::HitBeside { hit, .. } => {
                (hit.saturating_add(1), None)
            }
            Fault::Cable { node, .. } => (0, Some(node)),
            _ => (0, None),
        };
        let refuse = |missing| BenchError::FaultWithoutSubject { fault: *fault, missing };
        if sensors > layout.sensors.len() {
            return Err(refuse("sensor"));
        }
        if hits > layout.hits.len() {
            return Err(refuse("hit"));
        }
        if node.is_some_and(|node| place(bench, layout, node).is_none()) {
            return Err(refuse("node"));
        }
    }
    Ok(())
}
