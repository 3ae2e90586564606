//! Mistakes whose size the data have to tell: a gain, a coordinate, a point beside its node.
//!
//! A gain is taken out of the readings, anything else is put into the layout, so the fit under a mistake is that of a
//! nominal test, however large the mistake is.

use massline_shared::EstimatedValue;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Unbounded;
use massline_shared::identify::single_fault::DECISIVE_CHI_SQUARED;
use massline_shared::identify::{DofMassLines, ForceTrend, MassLines};
use massline_shared::layout::{Axis, HostLayout, Prior};
use massline_shared::responses::{ResponseSquare, Responses};
use nalgebra::{Matrix2, Vector2, Vector3};

use super::FaultSize;

/// A mistake of unknown size; sensors and hits are indices of the layout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SizedFault {
    /// The gain of one channel is wrong.
    ChannelGain {
        /// The sensor.
        sensor: usize,
        /// The channel's axis of the sensor.
        axis: Axis,
    },
    /// The gain of all three channels of a sensor is wrong.
    SensorGain {
        /// The sensor.
        sensor: usize,
    },
    /// The readings of a DOF are wrong by one factor: its force was recorded with another gain.
    HitGain {
        /// The DOF.
        hit: usize,
    },
    /// The gain of everything is wrong. Hammer and sensors cannot be distinguished, and only prior knowledge of the
    /// object reveals the mistake.
    CommonGain,
    /// A coordinate of a node is wrong, for everything on it.
    NodeCoordinate {
        /// The node.
        node: u16,
        /// The coordinate, body frame.
        axis: Axis,
    },
    /// A DOF was hit beside its node, in its own direction.
    HitDisplaced {
        /// The DOF.
        hit: usize,
    },
}

/// The numbers that a mistake has; a mistake of one number has the first.
pub(super) type Size = Vector2<f64>;

/// A test under a mistake: its layout and its readings.
pub(super) type TestUnder = (HostLayout, Vec<DofMassLines<f64, Unbounded>>);

/// Shortest and longest step of a gain, relative to the gain before.
const GAIN_STEP: [f64; 2] = [-0.7, 3.0];
/// Displacement over which readings are differentiated, m. They are linear in the position of a sensor and of a hit.
const DIFFERENCE: f64 = 1e-4;

impl SizedFault {
    /// Every mistake of unknown size that could have been made in a test with these measured hits.
    pub(super) fn all(layout: &HostLayout, lines: &[DofMassLines<f64, Unbounded>]) -> Vec<Self> {
        let sensors = 0..layout.sensors.len();
        let mut faults: Vec<Self> = sensors
            .flat_map(|sensor| {
                let channels = Axis::ALL.map(|axis| Self::ChannelGain { sensor, axis });
                channels.into_iter().chain([Self::SensorGain { sensor }])
            })
            .collect();
        faults.extend(
            lines.iter().flat_map(|&(hit, _)| [Self::HitGain { hit }, Self::HitDisplaced { hit }]),
        );
        for node in used_nodes(layout, lines) {
            faults.extend(Axis::ALL.map(|axis| Self::NodeCoordinate { node, axis }));
        }
        faults.extend(known_scale(layout).map(|_| Self::CommonGain));
        faults
    }

    /// Number of unknowns.
    pub(super) fn unknowns(self) -> usize {
        if let Self::HitDisplaced { .. } = self { 2 } else { 1 }
    }

    /// True for a gain.
    pub(super) fn is_gain(self) -> bool {
        !matches!(self, Self::NodeCoordinate { .. } | Self::HitDisplaced { .. })
    }

    /// The size of no mistake.
    pub(super) fn none(self) -> Size {
        if self.is_gain() { Vector2::new(1.0, 0.0) } else { Vector2::zeros() }
    }

    /// True for a size that chance makes of no mistake: no fit that such a size improves says anything about the
    /// layout. `covariance` is that of the steps that [`Self::slopes`] measures.
    pub(super) fn is_nothing(self, size: &Size, covariance: &Matrix2<f64>) -> bool {
        let away = size - self.none();
        // The steps of a gain are relative to it.
        let away = if self.is_gain() { away / size.x } else { away };
        let distance = match self.unknowns() {
            1 => Some(away.x * away.x / covariance[(0, 0)]),
            _ => covariance.try_inverse().map(|inverse| away.dot(&(inverse * away))),
        };
        distance.is_none_or(|distance| distance < DECISIVE_CHI_SQUARED)
    }

    /// True when the mistake changes this reading of this DOF.
    pub(super) fn changes(self, layout: &HostLayout, (hit, response): (usize, usize)) -> bool {
        match self {
            Self::ChannelGain { sensor, axis } => response == 3 * sensor + axis.index(),
            Self::SensorGain { sensor } => response / 3 == sensor,
            Self::HitGain { hit: own } | Self::HitDisplaced { hit: own } => hit == own,
            Self::CommonGain => true,
            Self::NodeCoordinate { node, .. } => {
                layout.sensors.get(response / 3).is_some_and(|sensor| sensor.node == node)
                    || layout.hits.get(hit).is_some_and(|hit| hit.dof.node == node)
            }
        }
    }

    /// The test under this mistake.
    pub(super) fn corrected(
        self,
        size: &Size,
        layout: &HostLayout,
        lines: &[DofMassLines<f64, Unbounded>],
    ) -> Option<TestUnder> {
        let mut layout = layout.clone();
        let mut lines = lines.to_vec();
        match self {
            Self::NodeCoordinate { node, axis } => {
                let sensors = layout.sensors.iter_mut().filter(|sensor| sensor.node == node);
                sensors.for_each(|sensor| sensor.position[axis.index()] += size.x);
                let hits = layout.hits.iter_mut().filter(|hit| hit.dof.node == node);
                hits.for_each(|hit| hit.position[axis.index()] += size.x);
            }
            Self::HitDisplaced { hit } => {
                let hit = layout.hits.get_mut(hit)?;
                let moved = across(&hit.direction) * size + Vector3::from(hit.position);
                hit.position = moved.into();
            }
            Self::ChannelGain { .. }
            | Self::SensorGain { .. }
            | Self::HitGain { .. }
            | Self::CommonGain => {
                let gain = size.x;
                if gain == 0.0 || !gain.is_finite() {
                    return None;
                }
                for (index, own) in &mut lines {
                    let factors = Responses::from_fn(layout.sensors.len(), |response| {
                        let is_wrong = self.changes(&layout, (*index, response));
                        if is_wrong { gain.recip() } else { 1.0 }
                    });
                    *own = scaled(own, &factors);
                }
            }
        }
        Some((layout, lines))
    }

    /// The change of the readings of a DOF per unit of each number, for a body with everything attached to it. That of
    /// a gain is relative to the gain. `layout` is that of the test under the mistake.
    pub(super) fn slopes(
        self,
        layout: &HostLayout,
        whole: &RigidBody<f64>,
        hit: usize,
    ) -> [Responses<f64, Unbounded>; 2] {
        let zeros = || Responses::zeros(layout.sensors.len());
        if self.is_gain() {
            let readings = layout.accelerance(whole, hit).unwrap_or_else(zeros);
            let own = Responses::from_fn(layout.sensors.len(), |response| {
                if self.changes(layout, (hit, response)) { readings[response] } else { 0.0 }
            });
            return [own, zeros()];
        }
        [Vector2::x(), Vector2::y()].map(|unit| {
            let moved = |distance: f64| {
                let (moved, _) = self.corrected(&(unit * distance), layout, &[])?;
                moved.accelerance(whole, hit)
            };
            match (moved(DIFFERENCE), moved(-DIFFERENCE)) {
                (Some(ahead), Some(behind)) => &(&ahead - &behind) / (2.0 * DIFFERENCE),
                _ => zeros(),
            }
        })
    }

    /// The size after a step as [`Self::slopes`] measures it.
    pub(super) fn advanced(self, size: &Size, step: &Size, length: f64) -> Size {
        if self.is_gain() {
            let [least, most] = GAIN_STEP;
            return Vector2::new(size.x * (1.0 + step.x.clamp(least, most)), 0.0);
        }
        // Nothing lands several lengths of the object away in one step.
        let most = 3.0 * length;
        size + if step.norm() > most { step * (most / step.norm()) } else { *step }
    }

    /// The mistake with its size; `covariance` is that of the steps that [`Self::slopes`] measures.
    pub(super) fn with_size(
        self,
        numbers: Size,
        covariance: &Matrix2<f64>,
        layout: &HostLayout,
    ) -> Option<SizedMistake> {
        // The second number of a mistake with one has no variance.
        let first = covariance[(0, 0)].max(0.0).sqrt();
        let mixed = if first > 0.0 { covariance[(1, 0)] / first } else { 0.0 };
        let second = (covariance[(1, 1)] - mixed * mixed).max(0.0).sqrt();
        let mut spread = Matrix2::new(first, 0.0, mixed, second);
        let size = match self {
            Self::HitDisplaced { hit } => {
                let across = across(&layout.hits.get(hit)?.direction);
                let (moved, spread) = (across * numbers, across * spread);
                FaultSize::Displacements(
                    [0, 1, 2]
                        .map(|k| EstimatedValue { value: moved[k], sigma: spread.row(k).norm() }),
                )
            }
            Self::NodeCoordinate { .. } => {
                FaultSize::Displacement(EstimatedValue { value: numbers.x, sigma: first })
            }
            Self::ChannelGain { .. }
            | Self::SensorGain { .. }
            | Self::HitGain { .. }
            | Self::CommonGain => {
                spread *= numbers.x.abs();
                FaultSize::Gain(EstimatedValue { value: numbers.x, sigma: spread[(0, 0)] })
            }
        };
        Some(SizedMistake { fault: self, size, numbers, spread })
    }
}

/// A mistake with the size that was fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizedMistake {
    /// The kind.
    pub fault: SizedFault,
    /// The size.
    pub size: FaultSize,
    /// The size as the fit has it.
    pub(super) numbers: Size,
    /// A square root of its covariance: each column is a change by one standard deviation.
    pub(super) spread: Matrix2<f64>,
}

/// What is best known of the properties that a common gain changes, mass and inertia; `None` when nothing is.
pub(super) fn known_scale(layout: &HostLayout) -> Option<&Prior<f64>> {
    let relative = |prior: &Prior<f64>| (prior.sigma / prior.value).abs();
    let priors = layout.priors.iter().filter(|prior| !(1..4).contains(&prior.property));
    priors.min_by(|a, b| relative(a).total_cmp(&relative(b)))
}

/// The nodes with a sensor or a measured hit.
pub(crate) fn used_nodes(layout: &HostLayout, lines: &[DofMassLines<f64, Unbounded>]) -> Vec<u16> {
    let sensors = layout.sensors.iter().map(|sensor| sensor.node);
    let hits = lines.iter().filter_map(|(index, _)| Some(layout.hits.get(*index)?.dof.node));
    let mut nodes: Vec<u16> = sensors.chain(hits).collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Two unit vectors perpendicular to a direction and to each other, as columns; along axes where the direction is.
pub(super) fn across(direction: &[f64; 3]) -> nalgebra::Matrix3x2<f64> {
    let direction = Vector3::from(*direction);
    let mut first = Vector3::zeros();
    first[(direction.iamax() + 1) % 3] = 1.0;
    let first = (first - direction * direction.dot(&first)).normalize();
    nalgebra::Matrix3x2::from_columns(&[first, direction.cross(&first)])
}

/// Mass lines with each response multiplied by a factor.
fn scaled(
    lines: &MassLines<f64, Unbounded>,
    factors: &Responses<f64, Unbounded>,
) -> MassLines<f64, Unbounded> {
    let times = |responses: &Responses<f64, Unbounded>| {
        responses.zip_map(factors, |value, factor| value * factor)
    };
    let pair = |i, j| lines.scatter[(i, j)] * factors[i] * factors[j];
    MassLines {
        accelerance: times(&lines.accelerance),
        noise: times(&lines.noise).map(f64::abs),
        scatter: ResponseSquare::from_fn(factors.sensors(), pair),
        hits: lines.hits,
        trend: ForceTrend { products: times(&lines.trend.products), ..lines.trend },
        band_shift: times(&lines.band_shift),
    }
}
