//! The small faults that a result is tested for.

use massline_result::{FaultUnit, FindingCode};
use massline_shared::body::RigidBody;
use massline_shared::capacity::Unbounded;
use massline_shared::identify::DofMassLines;
use massline_shared::layout::{AttachedBody, Axis, HostLayout};
use massline_shared::responses::Responses;
use nalgebra::{DMatrix, DVector, SVector, Vector3};

use super::left_over::LeftOver;
use crate::single_fault::used_nodes;

/// A fault that is small enough to pass for an error of the budget. Sensors and hits are indices of the layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SmallFault {
    /// A coordinate of a node is wrong, and with it those of the sensor and the hits on it; true minus written, m.
    NodeMisplaced {
        /// The node.
        node: u16,
        /// The coordinate, body frame.
        axis: Axis,
    },
    /// The gain of the hammer drifts, as much over the test as the size says.
    HammerDrifts,
    /// The gain of a channel drifts.
    ChannelDrifts {
        /// The sensor.
        sensor: usize,
        /// The channel's axis of the sensor.
        axis: Axis,
    },
    /// All hits at a DOF lean the same way, rad.
    HitLeans {
        /// The DOF.
        hit: usize,
    },
    /// All hits are turned alike about an axis, rad.
    HitsTurned,
    /// The chips of all sensors lie above their marks along their z axes, m.
    ChipsAboveMarks,
    /// Each mark carries a pad or the like while it is hit, kg.
    MarksLoaded,
}

/// The deviate that a fault has to exceed: 3.57 standard deviations of a size of either sign, which chance makes once in
/// three thousand tests.
const USUAL: f64 = 3.31;
/// The same of a fault that is rare, of which there are many: four standard deviations, once in eighteen thousand.
const RARE: f64 = 3.72;
/// Number of faults that a test with three sensors and as many hits is tested for, with which these limits were measured.
const AMONG: f64 = 26.0;
/// Displacement, m, and turn, rad, over which readings are differentiated. They are linear in both.
const DIFFERENCE: f64 = 1e-4;

impl SmallFault {
    /// Every fault that a test with these measured hits is tested for.
    pub(super) fn all(
        layout: &HostLayout,
        lines: &[DofMassLines<f64, Unbounded>],
    ) -> impl Iterator<Item = Self> {
        let nodes = used_nodes(layout, lines)
            .into_iter()
            .flat_map(|node| Axis::ALL.map(|axis| Self::NodeMisplaced { node, axis }));
        let sensors = 0..layout.sensors.len();
        let channels =
            sensors.flat_map(|sensor| Axis::ALL.map(|axis| Self::ChannelDrifts { sensor, axis }));
        let hits: Vec<_> = lines.iter().map(|&(hit, _)| Self::HitLeans { hit }).collect();
        let has_chips = layout.senses_gravity();
        let chips = has_chips.then_some(Self::ChipsAboveMarks);
        let common =
            [Self::HammerDrifts, Self::HitsTurned, Self::MarksLoaded].into_iter().chain(chips);
        nodes.chain(channels).chain(hits).chain(common)
    }

    /// The standard normal deviate beyond which the data show the fault, where so many faults are tested.
    pub(super) fn limit(self, tested: usize) -> f64 {
        let limit = match self {
            Self::ChannelDrifts { .. } => RARE,
            _ => USUAL,
        };
        // Of more tests, more exceed a limit by chance: the tail of the normal distribution falls with z²/2.
        f64::hypot(limit, (2.0 * (tested as f64 / AMONG).max(1.0).ln()).sqrt())
    }

    /// The largest standard deviation of its size with which it is tested, for sensors with this characteristic length,
    /// m, on an object of this mass, kg.
    pub(super) fn largest(self, length: f64, mass: f64) -> f64 {
        match self.unit() {
            FaultUnit::Meters => 0.5 * length,
            FaultUnit::Kilograms => 0.3 * mass,
            FaultUnit::Radians | FaultUnit::Relative => 0.3,
        }
    }

    /// The stable name of its kind.
    pub fn code(self) -> FindingCode {
        match self {
            Self::NodeMisplaced { .. } => FindingCode::NodeMisplaced,
            Self::HammerDrifts => FindingCode::HammerDrifts,
            Self::ChannelDrifts { .. } => FindingCode::ChannelDrifts,
            Self::HitLeans { .. } => FindingCode::HitLeans,
            Self::HitsTurned => FindingCode::HitsTurned,
            Self::ChipsAboveMarks => FindingCode::ChipsAboveMarks,
            Self::MarksLoaded => FindingCode::MarksLoaded,
        }
    }

    /// The unit of its size.
    pub fn unit(self) -> FaultUnit {
        match self {
            Self::NodeMisplaced { .. } | Self::ChipsAboveMarks => FaultUnit::Meters,
            Self::HitLeans { .. } | Self::HitsTurned => FaultUnit::Radians,
            Self::HammerDrifts | Self::ChannelDrifts { .. } => FaultUnit::Relative,
            Self::MarksLoaded => FaultUnit::Kilograms,
        }
    }

    /// The changes of all readings per unit of its size, one column for each of its directions; `None` where a reading
    /// cannot be computed.
    pub(super) fn changes(self, left_over: &LeftOver<'_>) -> Option<DMatrix<f64>> {
        let layout = &left_over.layout;
        let slope = |act: &dyn Fn(&mut HostLayout, f64)| {
            let moved = |size: f64| {
                let mut moved = layout.clone();
                act(&mut moved, size);
                left_over.readings(&moved)
            };
            Some((moved(DIFFERENCE)? - moved(-DIFFERENCE)?) / (2.0 * DIFFERENCE))
        };
        let units = [Vector3::x(), Vector3::y(), Vector3::z()];
        let columns: Option<Vec<DVector<f64>>> = match self {
            Self::NodeMisplaced { node, axis } => {
                [slope(&|layout, size| move_node(layout, node, axis.index(), size))]
                    .into_iter()
                    .collect()
            }
            Self::HammerDrifts => [drift(left_over, -1.0, None)].into_iter().collect(),
            Self::ChannelDrifts { sensor, axis } => {
                let response = 3 * sensor + axis.index();
                [drift(left_over, 1.0, Some(response))].into_iter().collect()
            }
            Self::HitLeans { hit } => {
                let direction = Vector3::from(layout.hits.get(hit)?.direction);
                let across = units.map(|unit| unit - direction * direction.dot(&unit));
                let along = direction.iamax();
                (0..3)
                    .filter(|axis| *axis != along)
                    .map(|axis| {
                        slope(&|layout, size| {
                            if let Some(hit) = layout.hits.get_mut(hit) {
                                turn(&mut hit.direction, &(across[axis].normalize() * size));
                            }
                        })
                    })
                    .collect()
            }
            Self::HitsTurned => units
                .iter()
                .map(|about| {
                    slope(&|layout, size| {
                        for hit in layout.hits.iter_mut() {
                            let change = about.cross(&Vector3::from(hit.direction)) * size;
                            turn(&mut hit.direction, &change);
                        }
                    })
                })
                .collect(),
            Self::ChipsAboveMarks => [slope(&|layout, size| {
                for sensor in layout.sensors.iter_mut() {
                    let above = sensor.axes[2];
                    sensor.position.iter_mut().zip(above).for_each(|(p, z)| *p += z * size);
                }
            })]
            .into_iter()
            .collect(),
            Self::MarksLoaded => {
                [left_over.column(|_, hit| load(left_over, hit))].into_iter().collect()
            }
        };
        Some(DMatrix::from_columns(&columns?))
    }
}

fn turn(direction: &mut [f64; 3], change: &Vector3<f64>) {
    direction.iter_mut().zip(change.iter()).for_each(|(d, change)| *d += change);
}

fn move_node(layout: &mut HostLayout, node: u16, axis: usize, size: f64) {
    let sensors = layout.sensors.iter_mut().filter(|sensor| sensor.node == node);
    sensors.for_each(|sensor| sensor.position[axis] += size);
    let hits = layout.hits.iter_mut().filter(|hit| hit.dof.node == node);
    hits.for_each(|hit| hit.position[axis] += size);
}

/// The change of the readings of a DOF with a mass at its mark, per kg.
fn load(left_over: &LeftOver<'_>, hit: usize) -> Option<Responses<f64, Unbounded>> {
    let layout = &left_over.layout;
    let mark = layout.hits.get(hit)?.position;
    let step = DIFFERENCE * left_over.whole.mass;
    let with = |mass: f64| {
        let pad = SVector::from(AttachedBody::point(mass, 0.0, mark).phi);
        layout.accelerance(&RigidBody::from_phi(&(left_over.whole.phi() + pad))?, hit)
    };
    let change = &with(step)? - &with(-step)?;
    Some(&change / (2.0 * step))
}

/// The change of the readings with a gain that changes by one from the first hit of the test to the last, in the order
/// of the DOFs: of one response, or of all.
fn drift(left_over: &LeftOver<'_>, sign: f64, response: Option<usize>) -> Option<DVector<f64>> {
    let hits: f64 = left_over.lines.iter().map(|(_, lines)| f64::from(lines.hits.max(1))).sum();
    let before = |place: usize| {
        let earlier = left_over.lines.iter().take(place);
        earlier.map(|(_, lines)| f64::from(lines.hits.max(1))).sum::<f64>()
    };
    left_over.column(|place, hit| {
        let own = f64::from(left_over.lines.get(place)?.1.hits.max(1));
        // From −1/2 to 1/2.
        let time = (before(place) + 0.5 * own) / hits - 0.5;
        let mut readings = left_over.layout.accelerance(&left_over.whole, hit)?;
        for (k, reading) in readings.iter_mut().enumerate() {
            *reading *=
                if response.is_none_or(|response| response == k) { sign * time } else { 0.0 };
        }
        Some(readings)
    })
}
