//! The normal equations of the augmented form, packed: nuisance parameters first, then the ten properties.
//!
//! Every error source is an unknown in units of its standard deviation with a unit prior, so its diagonal
//! element starts at one. Eliminating the nuisance parameters leaves the information about the inertial
//! parameters under the complete covariance (theory, section 4) without ever forming that covariance: the
//! memory does not grow with the hits.

use nalgebra::{SMatrix, SVector, Vector3};

use super::model::{HIT_NUISANCES, HitErrors, SENSITIVITIES, SENSOR_NUISANCES};
use crate::capacity::Capacity;
use crate::linalg::{PackedMatrix, dot, triangle};
use crate::real::Real;
use crate::responses::{ResponseSquare, Responses};

/// Size of the normal equations for this number of unknowns and hit DOFs: the packed matrix, two right sides, and
/// the errors of the hits.
pub(super) const fn workspace(unknowns: usize, hits: usize) -> usize {
    triangle(unknowns) + 2 * unknowns + HIT_NUISANCES * hits
}

/// Matrix, right side, and room for a second right side.
#[derive(Debug)]
pub(super) struct NormalEquations<'w, R> {
    matrix: PackedMatrix<'w, R>,
    right: &'w mut [R],
    second: &'w mut [R],
    /// Estimated errors of the hits of each DOF, in the order of the data; none are zero.
    hit_errors: &'w mut [HitErrors<R>],
    unknowns: usize,
    nuisances: usize,
}

/// Contribution of one hit DOF: the columns of each sensor and those that all sensors share.
pub(super) struct Rows<'r, R: Real, C: Capacity> {
    /// Inverse covariance of the readings.
    pub(super) weight: &'r ResponseSquare<R, C>,
    /// Columns that change the readings of one sensor only.
    pub(super) sensors: &'r [[Vector3<R>; SENSOR_NUISANCES]],
    /// Columns that change all readings: the shared nuisance parameters, then the ten properties.
    pub(super) shared: &'r [Responses<R, C>],
    /// Measured minus modelled readings.
    pub(super) residual: &'r Responses<R, C>,
}

impl<'w, R: Real> NormalEquations<'w, R> {
    /// The equations of `nuisances` nuisance parameters and the ten properties in a workspace, for hits
    /// without errors; `None` when it is too small.
    pub(super) fn new(workspace: &'w mut [R], nuisances: usize) -> Option<Self> {
        Some(Self { hit_errors: &mut [], ..Self::with_hit_errors(workspace, nuisances, 0)? })
    }

    /// The same for hits on this many DOFs, with the errors that the workspace has.
    pub(super) fn with_hit_errors(
        workspace: &'w mut [R],
        nuisances: usize,
        hits: usize,
    ) -> Option<Self> {
        let unknowns = nuisances + 10;
        let (matrix, rest) = workspace.split_at_mut_checked(triangle(unknowns))?;
        let (right, rest) = rest.split_at_mut_checked(unknowns)?;
        let (second, rest) = rest.split_at_mut_checked(unknowns)?;
        let (hit_errors, _) = rest.as_chunks_mut();
        let hit_errors = hit_errors.get_mut(..hits)?;
        let matrix = PackedMatrix(matrix);
        Some(Self { matrix, right, second, hit_errors, unknowns, nuisances })
    }

    /// Errors of the hits on the DOF at this place in the data.
    pub(super) fn hit_errors(&self, place: usize) -> HitErrors<R> {
        self.hit_errors.get(place).copied().unwrap_or([R::zero(); HIT_NUISANCES])
    }

    /// Stores the errors of the hits on the DOF at this place.
    pub(super) fn set_hit_errors(&mut self, place: usize, errors: HitErrors<R>) {
        // There is room for the hits of every layout.
        if let Some(stored) = self.hit_errors.get_mut(place) {
            *stored = errors;
        }
    }

    /// Sets the errors of all hits to zero.
    pub(super) fn clear_hit_errors(&mut self) {
        self.hit_errors.fill([R::zero(); HIT_NUISANCES]);
    }

    /// Resets the equations to the priors of the nuisance parameters.
    pub(super) fn clear(&mut self) {
        self.matrix.0.fill(R::zero());
        self.right.fill(R::zero());
        for i in 0..self.nuisances {
            *self.matrix.at(i, i) = R::one();
        }
    }

    /// Adds the readings of a hit DOF; returns the weighted square of the residual.
    pub(super) fn add<C: Capacity>(&mut self, rows: &Rows<'_, R, C>) -> R {
        let first_shared = rows.sensors.len() * SENSOR_NUISANCES;
        for (i, columns) in rows.sensors.iter().enumerate() {
            for (k, others) in rows.sensors.iter().enumerate().take(i + 1) {
                let block = rows.weight.block(k, i);
                for (a, own) in columns.iter().enumerate() {
                    // In a diagonal block only the lower triangle is needed.
                    let count = if i == k { a + 1 } else { SENSOR_NUISANCES };
                    let row = self.matrix.row_mut(SENSOR_NUISANCES * i + a);
                    let first = SENSOR_NUISANCES * k;
                    add_products(&mut row[first..first + count], others, &(block * own));
                }
            }
        }
        for (s, shared) in rows.shared.iter().enumerate() {
            let weighted = rows.weight.times(shared);
            let row = self.matrix.row_mut(first_shared + s);
            for (i, columns) in rows.sensors.iter().enumerate() {
                let part = Vector3::from(weighted.of_sensor(i));
                let first = SENSOR_NUISANCES * i;
                add_products(&mut row[first..first + SENSOR_NUISANCES], columns, &part);
            }
            for (cell, other) in row[first_shared..].iter_mut().zip(rows.shared) {
                *cell += other.dot(&weighted);
            }
        }
        add_right(self.right, rows)
    }

    /// Adds a prior on a linear combination of the ten properties: `slope · x = residual`, in standard
    /// deviations.
    pub(super) fn add_prior(&mut self, slope: &SVector<R, 10>, residual: R) {
        for i in 0..10 {
            let row = &mut self.matrix.row_mut(self.nuisances + i)[self.nuisances..];
            for (cell, other) in row.iter_mut().zip(slope) {
                *cell += slope[i] * *other;
            }
            self.right[self.nuisances + i] += slope[i] * residual;
        }
    }

    /// Eliminates the nuisance parameters (Cholesky, Banachiewicz order, on their columns).
    /// [`Self::information`] and [`Self::gradient`] then give the remaining equations. `None` when a pivot is
    /// not positive or not finite.
    pub(super) fn eliminate(&mut self) -> Option<()> {
        self.matrix.factorise(0..self.nuisances, self.unknowns, R::zero())?;
        self.matrix.forward(0..self.nuisances, self.right);
        Some(())
    }

    /// After [`Self::eliminate`]: the information about the ten properties.
    pub(super) fn information(&self) -> SMatrix<R, 10, 10> {
        SMatrix::from_fn(|i, j| {
            self.matrix.row(self.nuisances + i.max(j))[self.nuisances + i.min(j)]
        })
    }

    /// After [`Self::eliminate`]: half the negative gradient of the cost.
    pub(super) fn gradient(&self) -> SVector<R, 10> {
        SVector::from_fn(|i, _| self.right[self.nuisances + i])
    }

    /// After [`Self::eliminate`]: the reduction of the cost by the nuisance parameters.
    pub(super) fn explained(&self) -> R {
        self.right[..self.nuisances].iter().fold(R::zero(), |sum, v| sum + *v * *v)
    }

    /// Starts a second right side, for other residuals with the same weights.
    pub(super) fn begin_second(&mut self) {
        self.second.fill(R::zero());
    }

    /// Adds a hit DOF to the second right side; returns the weighted square of its residual.
    pub(super) fn add_second<C: Capacity>(&mut self, rows: &Rows<'_, R, C>) -> R {
        add_right(self.second, rows)
    }

    /// Reduction of the cost of the second right side by the nuisance parameters.
    pub(super) fn explained_second(&mut self) -> R {
        let of_nuisances = &mut self.second[..self.nuisances];
        self.matrix.forward(0..self.nuisances, of_nuisances);
        of_nuisances.iter().fold(R::zero(), |sum, value| sum + *value * *value)
    }

    /// After [`Self::eliminate`]: factors the part of the ten properties as well, so that [`Self::solve`]
    /// works. `None` when the information is not positive definite.
    pub(super) fn complete(&mut self) -> Option<()> {
        self.matrix.factorise(self.nuisances..self.unknowns, self.unknowns, R::zero())
    }

    /// Undoes [`Self::complete`].
    pub(super) fn restore(&mut self) {
        self.matrix.multiply(self.nuisances, self.unknowns);
    }

    /// After [`Self::eliminate`]: the nuisance parameters in standard deviations, for the present ten
    /// properties.
    pub(super) fn nuisances(&mut self) -> &[R] {
        self.second.copy_from_slice(self.right);
        self.matrix.backward(&mut self.second[..self.nuisances]);
        &self.second[..self.nuisances]
    }

    /// After [`Self::complete`]: all unknowns at the minimum, nuisance parameters first. They are also the
    /// second right side.
    pub(super) fn solution(&mut self) -> &[R] {
        self.second.copy_from_slice(self.right);
        self.matrix.forward(self.nuisances..self.unknowns, self.second);
        self.matrix.backward(self.second);
        self.second
    }

    /// After [`Self::complete`]: trace and squared Frobenius norm of `I − P`, where `P` is the covariance of
    /// the first `count` unknowns. The equations cannot be used afterwards.
    pub(super) fn shrinkage(&mut self, count: usize) -> (R, R) {
        self.matrix.invert(self.unknowns, self.second);
        // With the inverse factor A and its first columns alone, P = AᵀA, which has the trace and the norm of
        // AAᵀ: products of rows, which lie in one piece.
        let row = |i: usize| &self.matrix.row(i)[..(i + 1).min(count)];
        let (mut trace, mut squares) = (R::zero(), R::zero());
        for i in 0..self.unknowns {
            for j in 0..i {
                let other = row(j);
                let product = dot(&row(i)[..other.len()], other);
                squares += product * product * R::of(2.0);
            }
            let own = dot(row(i), row(i));
            trace += own;
            squares += own * own;
        }
        let whole = R::of(count as f64);
        (whole - trace, whole - trace * R::of(2.0) + squares)
    }

    /// After [`Self::complete`]: solves for a right side that `fill` writes.
    pub(super) fn solve(&mut self, fill: impl FnOnce(&mut [R])) -> &[R] {
        self.second.fill(R::zero());
        fill(self.second);
        self.matrix.solve(self.second);
        self.second
    }

    /// After [`Self::complete`]: the first half of [`Self::solve_readings`], `L⁻¹ Xᵀ w`. The products of two such
    /// columns are those with the covariance of the unknowns between them.
    pub(super) fn project_readings<C: Capacity>(
        &self,
        rows: &Rows<'_, R, C>,
        weighted: &Responses<R, C>,
        projected: &mut [R],
    ) {
        projected.fill(R::zero());
        let (of_sensors, of_shared) = projected.split_at_mut(rows.sensors.len() * SENSOR_NUISANCES);
        rows.add_products(weighted, of_sensors, of_shared);
        self.matrix.forward(0..self.unknowns, projected);
    }

    /// The second half: the unknowns that these projected readings change.
    pub(super) fn solve_projected(&mut self, projected: &[R]) -> &[R] {
        self.second.copy_from_slice(projected);
        self.matrix.backward(self.second);
        self.second
    }

    /// After [`Self::complete`]: solves for readings of a hit DOF that are already weighted.
    pub(super) fn solve_readings<C: Capacity>(
        &mut self,
        rows: &Rows<'_, R, C>,
        weighted: &Responses<R, C>,
    ) -> &[R] {
        self.solve(|right| {
            let (of_sensors, of_shared) = right.split_at_mut(rows.sensors.len() * SENSOR_NUISANCES);
            rows.add_products(weighted, of_sensors, of_shared);
        })
    }
}

/// Adds the products of a sensor's first columns with three weighted readings, one to each cell.
fn add_products<R: Real>(
    cells: &mut [R],
    columns: &[Vector3<R>; SENSOR_NUISANCES],
    weighted: &Vector3<R>,
) {
    // Optimised for the number of instructions: most columns have only one nonzero element.
    let (moving_one, others) = cells.split_at_mut(cells.len().min(SENSITIVITIES));
    let (of_one, of_all) = columns.split_at(SENSITIVITIES);
    let by_reading = moving_one.chunks_mut(SENSITIVITIES / 3).zip(of_one.chunks(SENSITIVITIES / 3));
    for (reading, (cells, columns)) in by_reading.enumerate() {
        for (cell, column) in cells.iter_mut().zip(columns) {
            *cell += column[reading] * weighted[reading];
        }
    }
    for (cell, column) in others.iter_mut().zip(of_all) {
        *cell += column.dot(weighted);
    }
}

/// Adds `xᵀ W r` for every column of the nuisance parameters and the ten properties; returns `rᵀ W r`.
fn add_right<R: Real, C: Capacity>(right: &mut [R], rows: &Rows<'_, R, C>) -> R {
    let weighted = rows.weight.times(rows.residual);
    let (of_sensors, of_shared) = right.split_at_mut(rows.sensors.len() * SENSOR_NUISANCES);
    rows.add_products(&weighted, of_sensors, of_shared);
    rows.residual.dot(&weighted)
}

impl<R: Real, C: Capacity> Rows<'_, R, C> {
    /// Adds `xᵀ w` for weighted readings `w` and every column `x`.
    pub(super) fn add_products(
        &self,
        weighted: &Responses<R, C>,
        of_sensors: &mut [R],
        of_shared: &mut [R],
    ) {
        let cells = of_sensors.chunks_mut(SENSOR_NUISANCES);
        for (i, (columns, cells)) in self.sensors.iter().zip(cells).enumerate() {
            add_products(cells, columns, &weighted.of_sensor(i).into());
        }
        for (column, to) in self.shared.iter().zip(of_shared) {
            *to += column.dot(weighted);
        }
    }
}
