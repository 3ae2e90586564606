//! Mistakes described in the terms of a layout.

use massline_shared::diagnosis::Code;
use massline_shared::identify::HALF_WIDTH_95;
use massline_shared::identify::single_fault::{AxisMap, SingleFault};
use massline_shared::layout::{AXIS_LETTERS, Axis, HostLayout, Sign};

use massline_analysis::single_fault::{FaultSize, Mistake, SizedFault, SizedMistake, Suspect};

use super::{deviation, meaning, with_interval};

/// The stable name of a kind of mistake.
pub(super) fn code(mistake: &Mistake) -> Code {
    match mistake {
        Mistake::Listed(fault) => code_of_listed(fault),
        Mistake::Sized(sized) => match sized.fault {
            SizedFault::ChannelGain { .. }
            | SizedFault::SensorGain { .. }
            | SizedFault::HitGain { .. } => Code::GainSuspect,
            SizedFault::CommonGain => Code::CommonScale,
            SizedFault::NodeCoordinate { .. } => Code::CoordinateSuspect,
            SizedFault::HitDisplaced { .. } => Code::HitBesideNode,
        },
    }
}

/// The stable name of a kind of mistake without a size.
pub(super) fn code_of_listed(fault: &SingleFault<f64>) -> Code {
    match fault {
        SingleFault::SensorAxes { .. } => Code::SensorAxesSuspect,
        SingleFault::CablesSwapped { .. } => Code::CablesSwapped,
        SingleFault::NodesSwapped { .. } => Code::NodesSwapped,
        SingleFault::HitAtNode { .. } => Code::HitAtWrongNode,
        SingleFault::HitReversed { .. } => Code::HitReversed,
    }
}

/// Describes a mistake without a size in a clause.
pub(super) fn clause(fault: &SingleFault<f64>, layout: &HostLayout) -> String {
    match fault {
        SingleFault::SensorAxes { sensor, reads } => {
            format!("{} {}", sensor_name(*sensor, layout), axes_clause(reads))
        }
        SingleFault::CablesSwapped { sensors: [a, b] } => {
            format!("the cables of sensors {} and {} are swapped", a + 1, b + 1)
        }
        SingleFault::NodesSwapped { nodes: [a, b], .. } => {
            format!("the positions of nodes {a} and {b} are swapped")
        }
        SingleFault::HitAtNode { hit, node, .. } => {
            format!("{} landed on node {node}", hit_name(*hit, layout))
        }
        SingleFault::HitReversed { hit } => {
            format!("{} came from the other side", hit_name(*hit, layout))
        }
    }
}

/// Describes the mistake in a clause, with the fitted value.
pub fn suspect_clause(suspect: &Suspect, layout: &HostLayout) -> String {
    match &suspect.mistake {
        Mistake::Listed(fault) => clause(fault, layout),
        Mistake::Sized(sized) => sized_clause(sized, layout),
    }
}

/// What the size of a mistake smells of.
pub(super) fn meaning(sized: &SizedMistake, layout: &HostLayout) -> Option<&'static str> {
    match (sized.fault, sized.size) {
        (SizedFault::NodeCoordinate { node, axis }, FaultSize::Displacement(moved)) => {
            meaning::of_coordinate(written_coordinate(node, axis, layout)?, moved)
        }
        (_, FaultSize::Gain(gain)) => meaning::of_gain(gain),
        _ => None,
    }
}

fn written_coordinate(node: u16, axis: Axis, layout: &HostLayout) -> Option<f64> {
    let sensors = layout.sensors.iter().map(|sensor| (sensor.node, sensor.position));
    let hits = layout.hits.iter().map(|hit| (hit.dof.node, hit.position));
    let place = sensors.chain(hits).find(|(other, _)| *other == node);
    place.map(|(_, position)| position[axis.index()])
}

fn sized_clause(sized: &SizedMistake, layout: &HostLayout) -> String {
    let meaning = meaning(sized, layout).map_or(String::new(), |meaning| format!(" ({meaning}?)"));
    match (sized.fault, sized.size) {
        (SizedFault::NodeCoordinate { node, axis }, FaultSize::Displacement(moved)) => {
            let letter = AXIS_LETTERS[axis.index()];
            let written = written_coordinate(node, axis, layout).unwrap_or_default();
            format!(
                "{letter} of node {node} is {} mm, not {:.1} mm{meaning}",
                with_interval(1e3 * (written + moved.value), 1e3 * moved.sigma),
                1e3 * written,
            )
        }
        (SizedFault::HitDisplaced { hit }, FaultSize::Displacements(moved)) => {
            let parts: Vec<String> = moved
                .iter()
                .zip(AXIS_LETTERS)
                .filter(|(part, _)| part.sigma > 0.0)
                .map(|(part, letter)| {
                    format!(
                        "{letter} {} mm",
                        deviation(1e3 * part.value, HALF_WIDTH_95 * 1e3 * part.sigma)
                    )
                })
                .collect();
            format!("{} landed beside its node: {}", hit_name(hit, layout), parts.join(", "))
        }
        (SizedFault::CommonGain, FaultSize::Gain(gain)) => format!(
            "all accelerances are {} times what [prior] expects{meaning}: the hammer, the sensors or [prior] is wrong",
            with_interval(gain.value, gain.sigma)
        ),
        (fault, FaultSize::Gain(gain)) => {
            let subject = match fault {
                SizedFault::ChannelGain { sensor, axis } => {
                    let letter = AXIS_LETTERS[axis.index()];
                    format!("channel {letter} of {}", sensor_name(sensor, layout))
                }
                SizedFault::SensorGain { sensor } => sensor_name(sensor, layout),
                SizedFault::HitGain { hit } => hit_name(hit, layout),
                SizedFault::CommonGain
                | SizedFault::NodeCoordinate { .. }
                | SizedFault::HitDisplaced { .. } => String::new(),
            };
            let value = with_interval(gain.value, gain.sigma);
            format!("{subject} reads {value} times what it should{meaning}")
        }
        // A coordinate and a point have no other size.
        _ => String::new(),
    }
}

fn sensor_name(sensor: usize, layout: &HostLayout) -> String {
    match layout.sensors.get(sensor) {
        Some(s) => format!("sensor {} (on node {})", sensor + 1, s.node),
        None => format!("sensor {}", sensor + 1),
    }
}

pub(super) fn hit_name(hit: usize, layout: &HostLayout) -> String {
    match layout.hits.get(hit) {
        Some(h) => format!("hit {} ({})", hit + 1, h.dof),
        None => format!("hit {}", hit + 1),
    }
}

fn axes_clause(reads: &AxisMap) -> String {
    let kept = |k: usize| reads.0[k] == (Sign::Plus, Axis::ALL[k]);
    let changed: Vec<usize> = (0..3).filter(|&k| !kept(k)).collect();
    match changed[..] {
        [k] => format!("has its {} axis reversed", AXIS_LETTERS[k]),
        _ if *reads == AxisMap::REVERSED => "has all three axes reversed".into(),
        [a, b] if reads.0[a] == (Sign::Plus, Axis::ALL[b]) && !reads.is_turn() => {
            format!("has the wires of {} and {} swapped", AXIS_LETTERS[a], AXIS_LETTERS[b])
        }
        [a, b] => {
            // The unchanged axis is the axis of rotation, and the next axis shows the direction.
            let about = 3 - a - b;
            let next = (about + 1) % 3;
            let degrees = match reads.0[next] {
                (Sign::Minus, axis) if axis.index() == next => "180",
                (Sign::Plus, _) => "+90",
                (Sign::Minus, _) => "-90",
            };
            format!("is turned about its {} axis by {degrees}°", AXIS_LETTERS[about])
        }
        _ => {
            let read = reads.0.map(|(sign, axis)| {
                let minus = if sign == Sign::Minus { "-" } else { "" };
                format!("{minus}{}", AXIS_LETTERS[axis.index()])
            });
            format!("is turned: its x, y, z read {}", read.join(", "))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_described_as_a_person_would() {
        use {Axis::*, Sign::*};
        for (reads, expected) in [
            ([(Plus, X), (Minus, Y), (Plus, Z)], "has its y axis reversed"),
            ([(Minus, X), (Minus, Y), (Minus, Z)], "has all three axes reversed"),
            ([(Plus, Z), (Plus, Y), (Plus, X)], "has the wires of x and z swapped"),
            ([(Plus, Y), (Minus, X), (Plus, Z)], "is turned about its z axis by +90°"),
            ([(Minus, Y), (Plus, X), (Plus, Z)], "is turned about its z axis by -90°"),
            ([(Plus, X), (Plus, Z), (Minus, Y)], "is turned about its x axis by +90°"),
            ([(Minus, Z), (Plus, Y), (Plus, X)], "is turned about its y axis by +90°"),
            ([(Minus, X), (Plus, Y), (Minus, Z)], "is turned about its y axis by 180°"),
            ([(Plus, Y), (Plus, Z), (Plus, X)], "is turned: its x, y, z read y, z, x"),
        ] {
            assert_eq!(axes_clause(&AxisMap(reads)), expected);
        }
    }

    #[test]
    fn no_two_mistakes_with_axes_have_the_same_words() {
        let mut clauses: Vec<String> = AxisMap::mistakes().map(|map| axes_clause(&map)).collect();
        clauses.sort();
        clauses.dedup();
        assert_eq!(clauses.len(), AxisMap::mistakes().count());
    }
}
