//! A fault as text, read and written.

use std::fmt;
use std::ops::RangeInclusive;
use std::str::FromStr;

use massline_shared::layout::Axis;

use super::Fault;
use crate::settings::{BOARD_MASS, MAINS_AMPLITUDE, OFFSET};

/// Allowed factors of `scale` and `hammer`; with others a rig measures nothing useful.
const SCALE: RangeInclusive<f64> = 0.1..=10.0;
/// Allowed rails of a buffer, m/s² or N.
const RAIL: RangeInclusive<f64> = 1e-3..=1e6;
/// Allowed stiffness of a cable, N/m.
const CABLE: RangeInclusive<f64> = 1e-3..=1e6;
/// Allowed distances of a node or a chip from its place, m.
const DISTANCE: RangeInclusive<f64> = -1.0..=1.0;
/// Allowed angles of hits, rad.
const ANGLE: RangeInclusive<f64> = 0.0..=0.5;
/// Allowed drifts of a gain.
const DRIFT: RangeInclusive<f64> = -0.9..=0.9;

/// The text does not describe a fault.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{0:?} is not a fault: write flip:2y, swap:1,2, swap:2x,2z, rotate:3:z90, hit:2:4, reverse:2, \
     scale:1.1 (0.1 to 10), hammer:0.97 (0.1 to 10), beside:2:0.005 (0 to 1 m), boards:0.005 (0 to 1 kg), \
     cable:2:400 (node, 0.001 to 1000000 N/m), rail:2y:50 (0.001 to 1000000 m/s²), rail:hammer:20 (0.001 \
     to 1000000 N), compress:2y, hum:0.005 (0 to 100 V), node:4z:0.01 (-1 to 1 m), lean:2:0.08 (0 to 0.5 rad), \
     turn:0.05 (0 to 0.5 rad), height:0.004 (-1 to 1 m), drift:hammer:0.05 or drift:2y:0.05 (-0.9 to 0.9), or \
     pad:0.01 (0 to 1 kg), sensors and hits counted from 1"
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
        "scale" => Some(Fault::Scale(within(rest, &SCALE)?)),
        "hammer" => Some(Fault::HammerScale(within(rest, &SCALE)?)),
        "beside" => {
            let (hit, distance) = rest.split_once(':')?;
            let distance_m = within(distance, &OFFSET)?;
            Some(Fault::HitBeside { hit: number(hit)?, distance_m })
        }
        "boards" => Some(Fault::BoardMass { mass_kg: within(rest, &BOARD_MASS)? }),
        "cable" => {
            let (node, stiffness) = rest.split_once(':')?;
            let stiffness_n_per_m = within(stiffness, &CABLE)?;
            Some(Fault::Cable { node: node.trim().parse().ok()?, stiffness_n_per_m })
        }
        "rail" => rail(rest),
        "compress" => {
            let (sensor, axis) = axis_of_sensor(rest)?;
            Some(Fault::Compression { sensor, axis })
        }
        "hum" => Some(Fault::Hum { amplitude_v: within(rest, &MAINS_AMPLITUDE)? }),
        "node" => {
            let (node, distance) = rest.split_once(':')?;
            let (index, axis) = axis_of_sensor(node)?;
            let node = u16::try_from(index + 1).ok()?;
            Some(Fault::NodeMisplaced { node, axis, distance_m: within(distance, &DISTANCE)? })
        }
        "lean" => {
            let (hit, angle) = rest.split_once(':')?;
            Some(Fault::HitLeans { hit: number(hit)?, angle_rad: within(angle, &ANGLE)? })
        }
        "turn" => Some(Fault::HitsTurned { angle_rad: within(rest, &ANGLE)? }),
        "height" => Some(Fault::ChipsAboveMarks { height_m: within(rest, &DISTANCE)? }),
        "drift" => {
            let (channel, change) = rest.split_once(':')?;
            let change = within(change, &DRIFT)?;
            if channel.trim() == "hammer" {
                return Some(Fault::HammerDrift { change });
            }
            let (sensor, axis) = axis_of_sensor(channel)?;
            Some(Fault::ChannelDrift { sensor, axis, change })
        }
        "pad" => Some(Fault::Pad { mass_kg: within(rest, &BOARD_MASS)? }),
        _ => None,
    }
}

/// Parses `2y:50` or `hammer:20`.
fn rail(text: &str) -> Option<Fault> {
    let (channel, limit) = text.split_once(':')?;
    let limit = within(limit, &RAIL)?;
    if channel.trim() == "hammer" {
        return Some(Fault::HammerRail { limit_n: limit });
    }
    let (sensor, axis) = axis_of_sensor(channel)?;
    Some(Fault::SensorRail { sensor, axis, limit_m_per_s2: limit })
}

/// Parses a number that must lie in a range.
fn within(text: &str, range: &RangeInclusive<f64>) -> Option<f64> {
    text.trim().parse().ok().filter(|value| range.contains(value))
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

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Flip { sensor, axis } => write!(f, "flip:{}{}", sensor + 1, axis.letter()),
            Self::SwapSensors([a, b]) => write!(f, "swap:{},{}", a + 1, b + 1),
            Self::SwapAxes { sensor, axes: [a, b] } => {
                let n = sensor + 1;
                write!(f, "swap:{n}{},{n}{}", a.letter(), b.letter())
            }
            Self::Rotate { sensor, axis, quarters } => {
                let degrees = 90 * i32::from(quarters);
                write!(f, "rotate:{}:{}{degrees}", sensor + 1, axis.letter())
            }
            Self::HitNode { hit, node } => write!(f, "hit:{}:{node}", hit + 1),
            Self::HitReversed { hit } => write!(f, "reverse:{}", hit + 1),
            Self::Scale(factor) => write!(f, "scale:{factor}"),
            Self::HammerScale(factor) => write!(f, "hammer:{factor}"),
            Self::HitBeside { hit, distance_m } => write!(f, "beside:{}:{distance_m}", hit + 1),
            Self::BoardMass { mass_kg } => write!(f, "boards:{mass_kg}"),
            Self::Cable { node, stiffness_n_per_m } => {
                write!(f, "cable:{node}:{stiffness_n_per_m}")
            }
            Self::SensorRail { sensor, axis, limit_m_per_s2 } => {
                write!(f, "rail:{}{}:{limit_m_per_s2}", sensor + 1, axis.letter())
            }
            Self::HammerRail { limit_n } => write!(f, "rail:hammer:{limit_n}"),
            Self::Compression { sensor, axis } => {
                write!(f, "compress:{}{}", sensor + 1, axis.letter())
            }
            Self::Hum { amplitude_v } => write!(f, "hum:{amplitude_v}"),
            Self::NodeMisplaced { node, axis, distance_m } => {
                write!(f, "node:{node}{}:{distance_m}", axis.letter())
            }
            Self::HitLeans { hit, angle_rad } => write!(f, "lean:{}:{angle_rad}", hit + 1),
            Self::HitsTurned { angle_rad } => write!(f, "turn:{angle_rad}"),
            Self::ChipsAboveMarks { height_m } => write!(f, "height:{height_m}"),
            Self::HammerDrift { change } => write!(f, "drift:hammer:{change}"),
            Self::ChannelDrift { sensor, axis, change } => {
                write!(f, "drift:{}{}:{change}", sensor + 1, axis.letter())
            }
            Self::Pad { mass_kg } => write!(f, "pad:{mass_kg}"),
        }
    }
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
            "hammer:0.97",
            "beside:2:0.005",
            "boards:0.005",
            "cable:2:400",
            "rail:2y:50",
            "rail:hammer:20",
            "compress:2y",
            "hum:0.005",
            "node:4z:0.01",
            "node:12x:-0.01",
            "lean:2:0.08",
            "turn:0.05",
            "height:0.004",
            "drift:hammer:0.05",
            "drift:2y:-0.05",
            "pad:0.01",
        ] {
            assert_eq!(text.parse::<Fault>().unwrap().to_string(), text);
        }
    }

    #[test]
    fn the_refusal_of_a_text_gives_an_example_of_every_kind() {
        let refusal = "drop:1".parse::<Fault>().unwrap_err().to_string();
        for kind in [
            "flip", "swap", "rotate", "hit", "reverse", "scale", "hammer", "beside", "boards",
            "cable", "rail", "compress", "hum", "node", "lean", "turn", "height", "drift", "pad",
        ] {
            let example = refusal.split(' ').find(|word| word.starts_with(&format!("{kind}:")));
            let example = example.unwrap_or_else(|| panic!("{kind}: {refusal}"));
            assert!(example.trim_end_matches(',').parse::<Fault>().is_ok(), "{example}");
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
            "hammer:0",
            "beside:0:0.005",
            "beside:2:-0.005",
            "boards:nan",
            "boards:2",
            "cable:400",
            "cable:2:0",
            "rail:2y",
            "rail:2w:50",
            "rail:hammer:0",
            "rail:0y:50",
            "compress:2",
            "compress:hammer",
            "hum:-1",
            "node:4:0.01",
            "node:0z:0.01",
            "node:70000z:0.01",
            "node:4z:2",
            "lean:0:0.08",
            "lean:2:-0.08",
            "turn:nan",
            "height:2",
            "drift:0.05",
            "drift:hammer:-1",
            "drift:2w:0.05",
            "pad:-0.01",
        ] {
            assert!(text.parse::<Fault>().is_err(), "{text}");
        }
    }
}
