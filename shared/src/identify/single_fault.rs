//! Single mistakes of a person: a reversed axis, swapped cables, a sensor glued on rotated, a hit at the
//! wrong node, two nodes swapped. Each corresponds to a layout other than the nominal one, so it can be tested by
//! fitting that layout to the same data and comparing χ².
//!
//! For a rigid body, nine readings of a hit satisfy three conditions, none of which involves the readings
//! normal to the plane of three sensors: a single hit does not reveal every mistake. All hits together reveal
//! most, because one body has to explain them all.

use nalgebra::SVector;

use super::maximum_likelihood::{self, ErrorBudget, Start};
use super::{Consistency, DofMassLines, MassLines};
use crate::body::RigidBody;
use crate::capacity::{Capacity, List};
use crate::layout::{Axis, Layout, Sign};
use crate::real::Real;

/// χ² must fall by this much for a mistake to be accepted, and to exclude another one: the value that chance
/// exceeds for one unknown in one of a thousand tests.
pub const DECISIVE_CHI_SQUARED: f64 = 10.83;

/// The axis that each axis of a sensor actually reads: a signed permutation of the axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AxisMap(pub [(Sign, Axis); 3]);

/// A single mistake; sensors and hits are indices of the layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SingleFault<R> {
    /// A sensor is glued on rotated, or wired with axes reversed or swapped.
    SensorAxes {
        /// The sensor.
        sensor: usize,
        /// The axes that it reads.
        reads: AxisMap,
    },
    /// The cables of two sensors are swapped.
    CablesSwapped {
        /// The sensors.
        sensors: [usize; 2],
    },
    /// The positions of two nodes are swapped, for everything on them.
    NodesSwapped {
        /// The nodes.
        nodes: [u16; 2],
        /// Their positions as the layout has them, body frame, m.
        positions: [[R; 3]; 2],
    },
    /// A DOF was hit at another node, in its own direction.
    HitAtNode {
        /// The DOF.
        hit: usize,
        /// The node that was hit.
        node: u16,
        /// Position of that node, body frame, m.
        position: [R; 3],
    },
    /// A DOF was hit from the other side.
    HitReversed {
        /// The DOF.
        hit: usize,
    },
}

impl AxisMap {
    const IDENTITY: Self =
        Self([(Sign::Plus, Axis::X), (Sign::Plus, Axis::Y), (Sign::Plus, Axis::Z)]);

    /// All three axes reversed.
    pub const REVERSED: Self =
        Self([(Sign::Minus, Axis::X), (Sign::Minus, Axis::Y), (Sign::Minus, Axis::Z)]);

    /// This axis reversed.
    pub fn with_reversed(axis: Axis) -> Self {
        let mut map = Self::IDENTITY;
        if let Some((sign, _)) = map.0.get_mut(axis.index()) {
            *sign = Sign::Minus;
        }
        map
    }

    /// The axis maps that one mistake with a sensor can produce: one axis reversed or all three, two swapped, or one
    /// of the 23 rotations of a cube onto itself.
    pub fn mistakes() -> impl Iterator<Item = Self> {
        Self::all().filter(|map| {
            let reversed = map.0.iter().filter(|(sign, _)| *sign == Sign::Minus).count();
            let moved = map
                .0
                .iter()
                .zip(Axis::ALL)
                .filter(|((_, mapped_axis), axis)| mapped_axis != axis)
                .count();
            // Of the improper maps, only those that a single mistake produces.
            let single = reversed + moved / 2 == 1 || (reversed == 3 && moved == 0);
            *map != Self::IDENTITY && (map.is_turn() || single)
        })
    }

    /// All 48 axis maps.
    fn all() -> impl Iterator<Item = Self> {
        const ORDERS: [[usize; 3]; 6] =
            [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        ORDERS.into_iter().flat_map(|order| {
            (0..8_u8).map(move |signs| {
                Self(core::array::from_fn(|k| {
                    let sign = if signs >> k & 1 == 1 { Sign::Minus } else { Sign::Plus };
                    (sign, Axis::ALL[order[k] % 3])
                }))
            })
        })
    }

    /// True for a rotation of the sensor, false for a mirror image.
    pub fn is_turn(&self) -> bool {
        let [x, y, z] = self.0.map(|(_, axis)| axis.index());
        let even = (y + 3 - x) % 3 == 1 && (z + 3 - y) % 3 == 1;
        let minuses = self.0.iter().filter(|(sign, _)| *sign == Sign::Minus).count();
        even == (minuses % 2 == 0)
    }

    fn of<R: Real>(&self, axes: &[[R; 3]; 3]) -> [[R; 3]; 3] {
        self.0.map(|(sign, axis)| axes[axis.index()].map(|v| v * R::of(sign.factor())))
    }
}

impl<R: Real> SingleFault<R> {
    /// Every mistake that could have been made in a test; `nodes` are the points that could have been hit.
    pub fn all<'a, C: Capacity>(
        layout: &'a Layout<R, C>,
        nodes: &'a [(u16, [R; 3])],
    ) -> impl Iterator<Item = Self> + 'a {
        let sensors = layout.sensors.len();
        let axes = (0..sensors).flat_map(|sensor| {
            AxisMap::mistakes().map(move |reads| Self::SensorAxes { sensor, reads })
        });
        let cables = (0..sensors)
            .flat_map(move |a| (a + 1..sensors).map(move |b| [a, b]))
            .map(|sensors| Self::CablesSwapped { sensors });
        let hits = layout.hits.iter().enumerate().flat_map(move |(hit, nominal)| {
            let others = nodes.iter().filter(move |(node, _)| *node != nominal.dof.node);
            others
                .map(move |&(node, position)| Self::HitAtNode { hit, node, position })
                .chain([Self::HitReversed { hit }])
        });
        let is_used = |node: u16| {
            let mut on_nodes = layout.sensors.iter().map(|sensor| sensor.node);
            on_nodes.any(|used| used == node) || layout.hits.iter().any(|hit| hit.dof.node == node)
        };
        let swapped = nodes.iter().enumerate().flat_map(move |(i, a)| {
            let later = nodes.iter().skip(i + 1);
            let others = later.filter(move |b| is_used(a.0) && is_used(b.0) && a.1 != b.1);
            others.map(|b| Self::NodesSwapped { nodes: [a.0, b.0], positions: [a.1, b.1] })
        });
        axes.chain(cables).chain(hits).chain(swapped)
    }

    /// The nominal layout with this mistake; `None` when it does not have the sensor or hit.
    pub fn applied<C: Capacity>(&self, layout: &Layout<R, C>) -> Option<Layout<R, C>> {
        let mut layout = layout.clone();
        match *self {
            Self::SensorAxes { sensor, reads } => {
                let sensor = layout.sensors.get_mut(sensor)?;
                sensor.axes = reads.of(&sensor.axes);
            }
            Self::CablesSwapped { sensors: [a, b] } => {
                if a.max(b) >= layout.sensors.len() {
                    return None;
                }
                layout.sensors.swap(a, b);
            }
            Self::NodesSwapped { nodes: [a, b], positions: [of_a, of_b] } => {
                let moved = |node: u16| match node {
                    node if node == a => Some(of_b),
                    node if node == b => Some(of_a),
                    _ => None,
                };
                for sensor in layout.sensors.iter_mut() {
                    sensor.position = moved(sensor.node).unwrap_or(sensor.position);
                }
                for hit in layout.hits.iter_mut() {
                    hit.position = moved(hit.dof.node).unwrap_or(hit.position);
                }
            }
            Self::HitAtNode { hit, position, .. } => {
                layout.hits.get_mut(hit)?.position = position;
            }
            Self::HitReversed { hit } => {
                let hit = layout.hits.get_mut(hit)?;
                hit.direction = hit.direction.map(|v| -v);
            }
        }
        Some(layout)
    }

    /// χ² of the layout with this mistake. `workspace` as for [`maximum_likelihood::solve`].
    /// `None` when that fit has no answer.
    ///
    /// The mistake is accepted when χ² falls by more than [`DECISIVE_CHI_SQUARED`].
    ///
    /// ```
    /// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
    /// # use massline_shared::identify::maximum_likelihood::{ErrorBudget, Start, solve, workspace};
    /// # use massline_shared::identify::single_fault::{DECISIVE_CHI_SQUARED, SingleFault};
    /// let nominal = frame::layout();
    /// // The person hit 2:-Z and wrote 2:+Z.
    /// let mistake = SingleFault::HitReversed { hit: 1 };
    /// let dofs = frame::mass_lines(&mistake.applied(&nominal).unwrap());
    /// let mut memory = vec![0.0; workspace(nominal.sensors.len(), nominal.hits.len())];
    /// let nominal_fit = solve(&nominal, &dofs, Start::Crude, ErrorBudget::Stated, &mut memory);
    /// let explained = mistake.test(&nominal, &dofs, &mut memory).unwrap().chi_squared;
    /// assert!(explained < 0.1);
    /// assert!(nominal_fit.is_err() || nominal_fit.unwrap().estimate.consistency.unwrap().chi_squared > DECISIVE_CHI_SQUARED);
    /// ```
    pub fn test<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        dofs: &[DofMassLines<R, C>],
        workspace: &mut [R],
    ) -> Option<Consistency<R>> {
        fit(&self.applied(layout)?, dofs, workspace)
    }

    /// Expected χ² of the nominal layout if this mistake had been made with `body`, the object alone: near
    /// its degrees of freedom when the data do not reveal the mistake. `dofs` supply the noise and the number
    /// of hits averaged. `None` when the fit has no answer, which also reveals the mistake.
    pub fn shows<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        body: &RigidBody<R>,
        dofs: &[DofMassLines<R, C>],
        workspace: &mut [R],
    ) -> Option<Consistency<R>> {
        let truth = self.applied(layout)?;
        let attached = layout.attached.iter().map(|a| SVector::from(a.phi));
        let whole = attached.fold(body.phi(), |sum, phi| sum + phi);
        let whole = RigidBody::from_phi(&whole)?;
        let mut readings = C::Hits::<DofMassLines<R, C>>::default();
        for (index, lines) in dofs {
            let accelerance = truth.accelerance(&whole, *index)?;
            readings.push((*index, MassLines { accelerance, ..lines.clone() })).ok()?;
        }
        let Consistency { chi_squared, degrees_of_freedom } = fit(layout, &readings, workspace)?;
        // Noise adds its expected value.
        let chi_squared = chi_squared + R::of(f64::from(degrees_of_freedom));
        Some(Consistency { chi_squared, degrees_of_freedom })
    }
}

/// χ² of the maximum likelihood fit, started from the linear method or, where that has no answer, from a crude
/// start.
fn fit<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
    workspace: &mut [R],
) -> Option<Consistency<R>> {
    let start = Start::InertiaRestraint;
    let solution = maximum_likelihood::solve(layout, dofs, start, ErrorBudget::Stated, workspace);
    solution.ok()?.estimate.consistency
}

#[cfg(test)]
mod tests;
