//! What the mistakes of a bench ([`Fault`]) do to its sensors, hits and cables.

use massline_shared::layout::HostLayout;
use massline_shared::signal::CHANNELS;
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};

use crate::bench::{Bench, BenchError};
use crate::channels::Channels;
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
    mark.1 += misplaced(bench, mark.0);
    Some(mark)
}

/// How far from its written place a node lies, m.
pub(super) fn misplaced(bench: &Bench, at: u16) -> Vector3<f64> {
    let mut from_written = Vector3::zeros();
    for fault in &bench.faults {
        if let Fault::NodeMisplaced { node, axis, distance_m } = *fault
            && node == at
        {
            from_written[axis.index()] += distance_m;
        }
    }
    from_written
}

/// How far the chips of the sensors lie above their marks, m.
pub(super) fn chip_height(bench: &Bench) -> f64 {
    let height = |fault: &Fault| match *fault {
        Fault::ChipsAboveMarks { height_m } => height_m,
        _ => 0.0,
    };
    bench.faults.iter().map(height).sum()
}

/// The angle by which the hits at a DOF lean to a side of their own, rad.
pub(super) fn lean(bench: &Bench, dof: usize) -> f64 {
    let angle = |fault: &Fault| match *fault {
        Fault::HitLeans { hit, angle_rad } if hit == dof => angle_rad,
        _ => 0.0,
    };
    bench.faults.iter().map(angle).sum()
}

/// The angle by which all hits are turned about one axis, rad.
pub(super) fn common_turn(bench: &Bench) -> f64 {
    let angle = |fault: &Fault| match *fault {
        Fault::HitsTurned { angle_rad } => angle_rad,
        _ => 0.0,
    };
    bench.faults.iter().map(angle).sum()
}

/// Relative change of the gain of each channel from the first hit of the test to the last.
pub(super) fn drift(bench: &Bench) -> Channels {
    let mut drift = [0.0; CHANNELS];
    for fault in &bench.faults {
        match *fault {
            Fault::HammerDrift { change } => drift[0] += change,
            Fault::ChannelDrift { sensor, axis, change } => {
                drift[1 + 3 * sensor + axis.index()] += change;
            }
            _ => {}
        }
    }
    drift
}

/// Mass at the mark that is being hit, kg.
pub(super) fn pad_mass(bench: &Bench) -> f64 {
    let mass = |fault: &Fault| match *fault {
        Fault::Pad { mass_kg } => mass_kg,
        _ => 0.0,
    };
    bench.faults.iter().map(mass).sum()
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
            | Fault::ChannelDrift { sensor, .. }
            | Fault::Compression { sensor, .. } => sensor.saturating_add(1),
            Fault::SwapSensors([a, b]) => a.max(b).saturating_add(1),
            _ => 0,
        };
        let (hits, node) = match *fault {
            Fault::HitNode { hit, node } => (hit.saturating_add(1), Some(node)),
            Fault::HitReversed { hit }
            | Fault::HitBeside { hit, .. }
            | Fault::HitLeans { hit, .. } => (hit.saturating_add(1), None),
            Fault::Cable { node, .. } | Fault::NodeMisplaced { node, .. } => (0, Some(node)),
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
