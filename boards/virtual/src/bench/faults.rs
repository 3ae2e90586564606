//! Mistakes that a person makes in setting up a test, as text: `flip:2y`, `swap:1,2`, `hit:2:4`.
//!
//! An error is small and affects everything (see [`super::errors`]); a *fault* is one gross mistake.
//! Sensors and hits are counted from 1, in the order of the layout.
//!
//! | text | what is wrong |
//! | --- | --- |
//! | `flip:2y` | the y axis of sensor 2 is reversed |
//! | `swap:1,2` | the cables of sensors 1 and 2 are swapped |
//! | `swap:2x,2z` | the wires of two axes of sensor 2 are swapped |
//! | `rotate:3:z90` | sensor 3 is glued turned about its z axis by 90° (also 180, -90) |
//! | `hit:2:4` | the second hit DOF is hit at node 4, in its own direction |
//! | `reverse:2` | the second hit DOF is hit from the other side |
//! | `scale:1.1` | all sensors read 10 % too much |

use std::fmt;
use std::str::FromStr;

use massline_shared::layout::{Axis, HostLayout};
use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use serde::Deserialize;

use super::{Bench, BenchError};

/// Allowed factors of `scale`; with others a rig measures nothing useful.
const SCALE: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// One mistake; here sensors and hits are counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub enum Fault {
    /// An axis of a sensor is reversed.
    Flip {
        /// The sensor.
        sensor: usize,
        /// Its axis.
        axis: Axis,
    },
    /// The cables of two sensors are swapped.
    SwapSensors([usize; 2]),
    /// The wires of two axes of a sensor are swapped.
    SwapAxes {
        /// The sensor.
        sensor: usize,
        /// Its axes.
        axes: [Axis; 2],
    },
    /// A sensor is glued turned about one of its axes.
    Rotate {
        /// The sensor.
        sensor: usize,
        /// The axis that it is turned about.
        axis: Axis,
        /// The angle in quarter turns.
        quarters: i8,
    },
    /// The hits at a DOF land on another node.
    HitNode {
        /// The DOF.
        hit: usize,
        /// The node where they land.
        node: u16,
    },
    /// The hits at a DOF push in the opposite direction.
    HitReversed {
        /// The DOF.
        hit: usize,
    },
    /// All sensor readings are multiplied by this factor.
    Scale(f64),
}

/// The text does not describe a fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is no fault: write flip:2y, swap:1,2, swap:2x,2z, rotate:3:z90, hit:2:4, reverse:2 or \
     scale:1.1 (0.1 to 10), sensors and hits counted from 1"
)]
pub struct FaultError(String);

impl TryFrom<String> for Fault {
    type Error = FaultError;

    fn try_from(text: String) -> Result<Self, FaultError> {
        text.parse()
    }
}

impl FromStr for Fault {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, FaultError> {
        read(text.trim()).ok_or_else(|| FaultError(text.to_owned()))
    }
}

fn read(text: &str) -> Option<Fault> {
    let (kind, rest) = text.split_once(':')?;
    match kind {
        "flip" => {
            let (sensor, axis) = axis_of_sensor(rest)?;
            Some(Fault::Flip { sensor, axis })
        }
        "swap" => {
            let (a, b) = rest.split_once(',')?;
            if let (Some(a), Some(b)) = (number(a), number(b)) {
                return (a != b).then_some(Fault::SwapSensors([a, b]));
            }
            let ((sensor, a), (other, b)) = (axis_of_sensor(a)?, axis_of_sensor(b)?);
            (sensor == other && a != b).then_some(Fault::SwapAxes { sensor, axes: [a, b] })
        }
        "rotate" => {
            let (sensor, turn) = rest.split_once(':')?;
            let quarters = match turn.get(1..)? {
                "90" | "+90" => 1,
                "180" | "-180" | "+180" => 2,
                "-90" | "270" => -1,
                _ => return None,
            };
            Some(Fault::Rotate { sensor: number(sensor)?, axis: axis(turn.get(..1)?)?, quarters })
        }
        "hit" => {
            let (hit, node) = rest.split_once(':')?;
            Some(Fault::HitNode { hit: number(hit)?, node: node.trim().parse().ok()? })
        }
        "reverse" => Some(Fault::HitReversed { hit: number(rest)? }),
        "scale" => {
            let factor: f64 = rest.trim().parse().ok()?;
            SCALE.contains(&factor).then_some(Fault::Scale(factor))
        }
        _ => None,
    }
}

/// Parses `2y` into the sensor, counted from 0, and its axis.
fn axis_of_sensor(text: &str) -> Option<(usize, Axis)> {
    let text = text.trim();
    let at = text.len().checked_sub(1)?;
    let (sensor, letter) = text.split_at_checked(at)?;
    Some((number(sensor)?, axis(letter)?))
}

fn axis(text: &str) -> Option<Axis> {
    match text {
        "x" | "X" => Some(Axis::X),
        "y" | "Y" => Some(Axis::Y),
        "z" | "Z" => Some(Axis::Z),
        _ => None,
    }
}

/// Converts a number counted from 1 to an index from 0.
fn number(text: &str) -> Option<usize> {
    text.trim().parse::<usize>().ok()?.checked_sub(1)
}

fn letter(axis: Axis) -> char {
    ['x', 'y', 'z'][axis.index()]
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Flip { sensor, axis } => write!(f, "flip:{}{}", sensor + 1, letter(axis)),
            Self::SwapSensors([a, b]) => write!(f, "swap:{},{}", a + 1, b + 1),
            Self::SwapAxes { sensor, axes: [a, b] } => {
                let n = sensor + 1;
                write!(f, "swap:{n}{},{n}{}", letter(a), letter(b))
            }
            Self::Rotate { sensor, axis, quarters } => {
                let degrees = 90 * i32::from(quarters);
                write!(f, "rotate:{}:{}{degrees}", sensor + 1, letter(axis))
            }
            Self::HitNode { hit, node } => write!(f, "hit:{}:{node}", hit + 1),
            Self::HitReversed { hit } => write!(f, "reverse:{}", hit + 1),
            Self::Scale(factor) => write!(f, "scale:{factor}"),
        }
    }
}

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
            | Fault::Rotate { sensor, .. } => sensor + 1,
            Fault::SwapSensors([a, b]) => a.max(b) + 1,
            _ => 0,
        };
        let (hits, node) = match *fault {
            Fault::HitNode { hit, node } => (hit + 1, Some(node)),
            Fault::HitReversed { hit } => (hit + 1, None),
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_reads_back_what_it_shows() {
        for text in [
            "flip:2y",
            "swap:1,2",
            "swap:2x,2z",
            "rotate:3:z90",
            "rotate:1:x180",
            "rotate:1:y-90",
            "hit:2:4",
            "reverse:1",
            "scale:1.1",
        ] {
            assert_eq!(text.parse::<Fault>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn text_that_names_no_fault_is_refused() {
        for text in [
            "",
            "flip",
            "flip:0x",
            "flip:2w",
            "flip:é",
            "swap:1,1",
            "swap:1x,2y",
            "swap:1x,1x",
            "rotate:1:z45",
            "rotate:1:é90",
            "hit:1:",
            "reverse:0",
            "scale:0",
            "scale:nan",
            "scale:1e30",
            "drop:1",
        ] {
            assert!(text.parse::<Fault>().is_err(), "{text}");
        }
    }
}
