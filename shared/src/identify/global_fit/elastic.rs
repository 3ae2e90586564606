//! The residual `E s²` of the elastic modes, one real number for every channel and hit, which is eliminated.

use nalgebra::Complex;

use super::apparatus::Apparatus;
use super::bin_model::BinModel;
use super::unknowns::{
    FORCE_SLOPES, MOST_SHARED, OWN_NUISANCES, ROW_SLOPES, Unknowns, along, block_of, dot, dot_real,
    place_of_hit, place_of_row, symmetrized, with_properties,
};
use crate::capacity::Capacity;
use crate::linalg::PackedMatrix;
use crate::real::Real;

/// Room for one accelerance: the changes with its unknowns, and the residual.
pub(super) const ROOM: usize = OWN_NUISANCES + MOST_SHARED + 1;

/// Components of all changes and residuals along s². Without room, nothing is eliminated.
pub(super) struct Elastic<'w, R> {
    /// For each hit, sensor and axis: sum of the products with s².
    pub(super) parts: &'w mut [[R; ROOM]],
    /// Sum of |s²|².
    pub(super) norm: R,
}

impl<R: Real> Elastic<'_, R> {
    pub(super) fn clear(&mut self) {
        self.parts.as_flattened_mut().fill(R::zero());
        self.norm = R::zero();
    }

    /// Adds one bin.
    pub(super) fn add<C: Capacity>(
        &mut self,
        unknowns: &Unknowns,
        apparatus: &Apparatus<R, C>,
        model: &BinModel<R, C>,
        s: Complex<R>,
    ) {
        let column = s * s;
        self.norm += column.norm_sqr();
        let sensors = apparatus.sensors.len();
        for (place, part) in self.parts.iter_mut().enumerate() {
            let (hit, sensor, axis) = (place / (3 * sensors), place / 3 % sensors, place % 3);
            let at = [sensor, axis, hit];
            each_slope(unknowns, apparatus, model, at, |k, slope| part[k] += along(column, slope));
            part[ROOM - 1] += along(column, model.residuals[hit][3 * sensor + axis]);
        }
    }

    /// Subtracts the eliminated parts from the equations; returns that of the squared residuals.
    pub(super) fn remove(
        &self,
        unknowns: &Unknowns,
        matrix: &mut PackedMatrix<'_, R>,
        right: &mut [R],
    ) -> R {
        let mut squares = R::zero();
        let sensors = unknowns.sensor_count();
        let count = own_count(unknowns);
        for (place, part) in self.parts.iter().enumerate() {
            let (hit, sensor) = (place / (3 * sensors), place / 3 % sensors);
            let left = part[ROOM - 1] / self.norm;
            for k in first_own(unknowns)..count {
                let (row, value) = (unknown_of(unknowns, sensor, hit, k), part[k] / self.norm);
                right[row] -= part[k] * left;
                for (l, other) in part.iter().enumerate().take(k + 1).skip(first_own(unknowns)) {
                    let column = unknown_of(unknowns, sensor, hit, l);
                    matrix.row_mut(row)[column] -= value * *other;
                }
            }
            squares += part[ROOM - 1] * left;
        }
        squares
    }
}

/// First own unknown in use: without a budget those of sensor, hit and hammer are not.
pub(super) fn first_own(unknowns: &Unknowns) -> usize {
    if unknowns.budget { 0 } else { OWN_NUISANCES }
}

/// Number of own unknowns of a reading: of its sensor, its hit, the hammer, the matrices and the properties.
pub(super) fn own_count(unknowns: &Unknowns) -> usize {
    OWN_NUISANCES + unknowns.len() - unknowns.nuisances()
}

/// Place among all unknowns of an own unknown of a reading; they ascend.
pub(super) fn unknown_of(unknowns: &Unknowns, sensor: usize, hit: usize, own: usize) -> usize {
    match own {
        0..ROW_SLOPES => place_of_row(unknowns, sensor, own),
        _ => match own - ROW_SLOPES {
            k @ 0..FORCE_SLOPES => place_of_hit(unknowns, hit, k),
            k => unknowns.nuisances() + k - FORCE_SLOPES,
        },
    }
}

/// Calls `act` with every own unknown of a reading and the change of the reading with it.
pub(super) fn each_slope<R: Real, C: Capacity>(
    unknowns: &Unknowns,
    apparatus: &Apparatus<R, C>,
    model: &BinModel<R, C>,
    [sensor, axis, hit]: [usize; 3],
    mut act: impl FnMut(usize, Complex<R>),
) {
    let (motion, adjoint) = (&model.motions[hit], &model.adjoints[sensor][axis]);
    if unknowns.budget {
        for u in 0..ROW_SLOPES {
            let slope = model.slope_of_row(&apparatus.sensors[sensor], [sensor, axis], u);
            if let Some(slope) = slope {
                act(u, dot(&slope, motion));
            }
        }
        for (u, force) in apparatus.hits[hit].slopes.iter().enumerate() {
            act(ROW_SLOPES + u, dot_real(adjoint, force));
        }
    }
    let products = with_properties(symmetrized(|m, n| adjoint[m] * motion[n]));
    let mass = model.powers.len() - 1;
    let shared = OWN_NUISANCES;
    for (b, power) in model.powers.iter().enumerate() {
        let (first, elements) = block_of(unknowns, b, mass);
        for (row, k) in elements.enumerate() {
            act(shared + first - unknowns.nuisances() + row, -(*power * products[k]));
        }
    }
}
