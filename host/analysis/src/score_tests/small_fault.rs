//! The small faults that a result is tested for, and what each does to a layout.

use massline_result::{FaultUnit, FindingCode};
use massline_shared::capacity::Unbounded;
use massline_shared::identify::DofMassLines;
use massline_shared::layout::{Axis, HostLayout};
use nalgebra::{Matrix3, Vector3};

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
    /// The gain of a channel is another than the layout says.
    ChannelGainOff {
        /// The sensor.
        sensor: usize,
        /// The channel's axis of the sensor.
        axis: Axis,
    },
    /// The axes of a sensor are turned, rad.
    SensorTurned {
        /// The sensor.
        sensor: usize,
    },
    /// The force at a DOF is another than the hammer says.
    HitForceOff {
        /// The DOF.
        hit: usize,
    },
    /// All forces are other than the hammer says, which shows where a mass is known.
    HammerGainOff,
}

/// A change of a layout by a size.
pub(crate) type Change = Box<dyn Fn(&mut HostLayout, f64)>;

/// The deviate that a fault has to exceed: 3.57 standard deviations of a size of either sign, which chance makes once in
/// three thousand tests.
const USUAL: f64 = 3.31;
/// The same of a fault that is rare, of which there are many: four standard deviations, once in eighteen thousand.
const RARE: f64 = 3.72;
/// Number of faults that a test with three sensors and as many hits is tested for, with which these limits were measured.
const AMONG: f64 = 26.0;
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

    /// Every fault that a global fit is tested for. A turned sensor, a gain and a force are what the search for a single
    /// mistake finds in mass lines.
    pub(crate) fn of_suspension(layout: &HostLayout) -> impl Iterator<Item = Self> {
        let (sensors, hits) = (layout.sensors.len(), layout.hits.len());
        let of_hits = layout.hits.iter().map(|hit| hit.dof.node);
        let mut nodes: Vec<u16> = layout.sensors.iter().map(|s| s.node).chain(of_hits).collect();
        nodes.sort_unstable();
        nodes.dedup();
        let nodes = nodes
            .into_iter()
            .flat_map(|node| Axis::ALL.map(|axis| Self::NodeMisplaced { node, axis }));
        let gains = (0..sensors)
            .flat_map(|sensor| Axis::ALL.map(|axis| Self::ChannelGainOff { sensor, axis }));
        let turned = (0..sensors).map(|sensor| Self::SensorTurned { sensor });
        let of_hits = (0..hits).flat_map(|hit| [Self::HitLeans { hit }, Self::HitForceOff { hit }]);
        let chips = layout.senses_gravity().then_some(Self::ChipsAboveMarks);
        let common = [Self::HitsTurned, Self::HammerGainOff].into_iter().chain(chips);
        nodes.chain(gains).chain(turned).chain(of_hits).chain(common)
    }

    /// The standard normal deviate beyond which the data show the fault, where so many faults are tested.
    pub(crate) fn limit(self, tested: usize) -> f64 {
        let limit = match self {
            Self::ChannelDrifts { .. } => RARE,
            _ => USUAL,
        };
        // Of more tests, more exceed a limit by chance: the tail of the normal distribution falls with z²/2.
        f64::hypot(limit, (2.0 * (tested as f64 / AMONG).max(1.0).ln()).sqrt())
    }

    /// The largest standard deviation of its size with which it is tested, for sensors with this characteristic length,
    /// m, on an object of this mass, kg.
    pub(crate) fn largest(self, length: f64, mass: f64) -> f64 {
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
            Self::ChannelGainOff { .. } => FindingCode::ChannelGainOff,
            Self::SensorTurned { .. } => FindingCode::SensorTurned,
            Self::HitForceOff { .. } => FindingCode::HitForceOff,
            Self::HammerGainOff => FindingCode::HammerGainOff,
        }
    }

    /// The unit of its size.
    pub fn unit(self) -> FaultUnit {
        match self {
            Self::NodeMisplaced { .. } | Self::ChipsAboveMarks => FaultUnit::Meters,
            Self::HitLeans { .. } | Self::HitsTurned | Self::SensorTurned { .. } => {
                FaultUnit::Radians
            }
            Self::HammerDrifts
            | Self::ChannelDrifts { .. }
            | Self::ChannelGainOff { .. }
            | Self::HitForceOff { .. }
            | Self::HammerGainOff => FaultUnit::Relative,
            Self::MarksLoaded => FaultUnit::Kilograms,
        }
    }

    /// What it does to a layout, in each of its directions; nothing where no layout describes it.
    pub(crate) fn changes_of_layout(self, layout: &HostLayout) -> Vec<Change> {
        let one = |change: Change| vec![change];
        match self {
            Self::NodeMisplaced { node, axis } => {
                one(Box::new(move |layout, size| move_node(layout, node, axis.index(), size)))
            }
            Self::ChipsAboveMarks => one(Box::new(|layout, size| {
                for sensor in layout.sensors.iter_mut() {
                    let above = sensor.axes[2];
                    sensor.position.iter_mut().zip(above).for_each(|(p, z)| *p += z * size);
                }
            })),
            Self::HitLeans { hit } => {
                let direction = layout.hits.get(hit).map(|hit| Vector3::from(hit.direction));
                direction.into_iter().flat_map(|direction| leaning(hit, direction)).collect()
            }
            Self::HitsTurned => UNITS.map(all_hits_turned).into(),
            Self::ChannelGainOff { sensor, axis } => one(Box::new(move |layout, size| {
                if let Some(sensor) = layout.sensors.get_mut(sensor) {
                    let row = &mut sensor.axes[axis.index()];
                    *row = row.map(|part| part * (1.0 + size));
                }
            })),
            Self::SensorTurned { sensor } => {
                UNITS.map(|about| sensor_turned(sensor, about.into())).into()
            }
            Self::HitForceOff { hit } => one(Box::new(move |layout, size| {
                if let Some(hit) = layout.hits.get_mut(hit) {
                    hit.direction = hit.direction.map(|part| part * (1.0 + size));
                }
            })),
            Self::HammerGainOff => one(Box::new(|layout, size| {
                for hit in layout.hits.iter_mut() {
                    hit.direction = hit.direction.map(|part| part * (1.0 + size));
                }
            })),
            Self::HammerDrifts | Self::ChannelDrifts { .. } | Self::MarksLoaded => Vec::new(),
        }
    }
}

const UNITS: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn move_node(layout: &mut HostLayout, node: u16, axis: usize, size: f64) {
    let sensors = layout.sensors.iter_mut().filter(|sensor| sensor.node == node);
    sensors.for_each(|sensor| sensor.position[axis] += size);
    let hits = layout.hits.iter_mut().filter(|hit| hit.dof.node == node);
    hits.for_each(|hit| hit.position[axis] += size);
}

fn turn(direction: &mut [f64; 3], change: &Vector3<f64>) {
    direction.iter_mut().zip(change.iter()).for_each(|(d, change)| *d += change);
}

/// A hit that leans towards the two axes that it does not lie along most.
fn leaning(hit: usize, direction: Vector3<f64>) -> impl Iterator<Item = Change> {
    let along = direction.iamax();
    (0..3).filter(move |axis| *axis != along).map(move |axis| -> Change {
        let unit = Vector3::from(UNITS[axis]);
        let across = (unit - direction * direction.dot(&unit)).normalize();
        Box::new(move |layout, size| {
            if let Some(hit) = layout.hits.get_mut(hit) {
                turn(&mut hit.direction, &(across * size));
            }
        })
    })
}

fn all_hits_turned(about: [f64; 3]) -> Change {
    let about = Vector3::from(about);
    Box::new(move |layout, size| {
        for hit in layout.hits.iter_mut() {
            let change = about.cross(&Vector3::from(hit.direction)) * size;
            turn(&mut hit.direction, &change);
        }
    })
}

/// A sensor whose axes are turned about one of themselves.
fn sensor_turned(sensor: usize, about: Vector3<f64>) -> Change {
    Box::new(move |layout, size| {
        if let Some(sensor) = layout.sensors.get_mut(sensor) {
            let turned =
                (Matrix3::identity() - (about * size).cross_matrix()) * sensor.axes_matrix();
            sensor.axes = std::array::from_fn(|row| turned.row(row).transpose().into());
        }
    })
}
