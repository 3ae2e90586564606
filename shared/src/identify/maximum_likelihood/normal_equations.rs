//! The normal equations of the augmented form, packed: nuisance parameters first, then the ten properties.
//!
//! Every error source is an unknown in units of its standard deviation with a unit prior, so its diagonal
//! element starts at one. Eliminating the nuisance parameters leaves the information about the inertial
//! parameters under the complete covariance (theory, section 4) without ever forming that covariance: the
//! memory does not grow with the hits.

use nalgebra::{SMatrix, SVector, Vector3};

use super::model::{HIT_NUISANCES, HitErrors, SENSITIVITIES, SENSOR_NUISANCES};
use crate::Real;
use crate::layout::HOST_HITS;
use crate::responses::{ResponseSquare, Responses};

/// Size of the normal equations for this number of unknowns: the packed matrix, two right sides, and the
/// errors of the hits.
pub(super) const fn workspace(unknowns: usize) -> usize {
    unknowns * (unknowns + 1) / 2 + 2 * unknowns + HIT_NUISANCES * HOST_HITS
}

/// Lower triangle row by row, the right side, and room for a second right side.
#[derive(Debug)]
pub(super) struct NormalEquations<'w, R> {
    packed: &'w mut [R],
    right: &'w mut [R],
    second: &'w mut [R],
    /// Estimated errors of the hits of each DOF, in the order of the data; none are zero.
    hit_errors: &'w mut [HitErrors<R>],
    unknowns: usize,
    nuisances: usize,
}

/// Contribution of one hit DOF: the columns of each sensor and those that all sensors share.
pub(super) struct Rows<'r, R, const S: usize> {
    /// Inverse covariance of the readings.
    pub(super) weight: &'r ResponseSquare<R, S>,
    /// Columns that change the readings of one sensor only.
    pub(super) sensors: &'r [[Vector3<R>; SENSOR_NUISANCES]],
    /// Columns that change all readings: the shared nuisance parameters, then the ten properties.
    pub(super) shared: &'r [Responses<R, S>],
    /// Measured minus modelled readings.
    pub(super) residual: &'r Responses<R, S>,
}

impl<'w, R: Real> NormalEquations<'w, R> {
    /// The equations of `nuisances` nuisance parameters and the ten properties in a workspace, for hits
    /// without errors; `None` when it is too small.
    pub(super) fn new(workspace: &'w mut [R], nuisances: usize) -> Option<Self> {
        Some(Self { hit_errors: &mut [], ..Self::with_hit_errors(workspace, nuisances)? })
    }

    /// The same for hits with the errors that the workspace has.
    pub(super) fn with_hit_errors(workspace: &'w mut [R], nuisances: usize) -> Option<Self> {
        let unknowns = nuisances + 10;
        let length = unknowns * (unknowns + 1) / 2;
        let (packed, rest) = workspace.split_at_mut_checked(length)?;
        let (right, rest) = rest.split_at_mut_checked(unknowns)?;
        let (second, rest) = rest.split_at_mut_checked(unknowns)?;
        let (hit_errors, _) = rest.as_chunks_mut();
        Some(Self { packed, right, second, hit_errors, unknowns, nuisances })
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
        self.packed.fill(R::zero());
        self.right.fill(R::zero());
        for i in 0..self.nuisances {
            self.packed[start(i) + i] = R::one();
        }
    }

    /// Adds the readings of a hit DOF; returns the weighted square of the residual.
    pub(super) fn add<const S: usize>(&mut self, rows: &Rows<'_, R, S>) -> R {
        let first_shared = rows.sensors.len() * SENSOR_NUISANCES;
        for (i, columns) in rows.sensors.iter().enumerate() {
            for (k, others) in rows.sensors.iter().enumerate().take(i + 1) {
                let block = rows.weight.block(k, i);
                for (a, own) in columns.iter().enumerate() {
                    // In a diagonal block only the lower triangle is needed.
                    let count = if i == k { a + 1 } else { SENSOR_NUISANCES };
                    let first = start(SENSOR_NUISANCES * i + a) + SENSOR_NUISANCES * k;
                    let cells = &mut self.packed[first..first + count];
                    add_products(cells, others, &(block * own));
                }
            }
        }
        for (s, shared) in rows.shared.iter().enumerate() {
            let weighted = rows.weight.times(shared);
            let row = start(first_shared + s);
            for (i, columns) in rows.sensors.iter().enumerate() {
                let part: Vector3<R> = weighted.column(i).into_owned();
                let first = row + SENSOR_NUISANCES * i;
                add_products(&mut self.packed[first..first + SENSOR_NUISANCES], columns, &part);
            }
            for (k, other) in rows.shared.iter().enumerate().take(s + 1) {
                self.packed[row + first_shared + k] += other.dot(&weighted);
            }
        }
        add_right(self.right, rows)
    }

    /// Adds a prior on a linear combination of the ten properties: `slope · x = residual`, in standard
    /// deviations.
    pub(super) fn add_prior(&mut self, slope: &SVector<R, 10>, residual: R) {
        for i in 0..10 {
            let row = start(self.nuisances + i) + self.nuisances;
            for k in 0..=i {
                self.packed[row + k] += slope[i] * slope[k];
            }
            self.right[self.nuisances + i] += slope[i] * residual;
        }
    }

    /// Eliminates the nuisance parameters (Cholesky, Banachiewicz order, on their columns).
    /// [`Self::information`] and [`Self::gradient`] then give the remaining equations. `None` when a pivot is
    /// not positive or not finite.
    pub(super) fn eliminate(&mut self) -> Option<()> {
        self.factor(0, self.nuisances)?;
        for i in 0..self.unknowns {
            let row = &self.packed[start(i)..start(i) + i + 1];
            let done = i.min(self.nuisances);
            let sum = dot(&row[..done], &self.right[..done]);
            let value = self.right[i] - sum;
            self.right[i] = if i < self.nuisances { value / row[i] } else { value };
        }
        Some(())
    }

    /// Factors the columns `from..to`, and subtracts from the rows below them the part that these columns
    /// explain.
    fn factor(&mut self, from: usize, to: usize) -> Option<()> {
        for i in from..self.unknowns {
            let (above, row) = self.packed.split_at_mut(start(i));
            let row = &mut row[..=i];
            let mut others = &above[start(from)..];
            for j in from..i {
                let (other, below) = others.split_at(j + 1);
                others = below;
                if j < to {
                    row[j] = (row[j] - dot(&row[from..j], &other[from..j])) / other[j];
                } else {
                    row[j] -= dot(&row[from..to], &other[from..to]);
                }
            }
            let known = &row[from..i.min(to)];
            let value = row[i] - dot(known, known);
            row[i] = if i >= to {
                value
            } else if value > R::zero() && value.finite() {
                value.sqrt()
            } else {
                return None;
            };
        }
        Some(())
    }

    /// After [`Self::eliminate`]: the information about the ten properties.
    pub(super) fn information(&self) -> SMatrix<R, 10, 10> {
        SMatrix::from_fn(|i, j| {
            let (i, j) = (i.max(j), i.min(j));
            self.packed[start(self.nuisances + i) + self.nuisances + j]
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
    pub(super) fn add_second<const S: usize>(&mut self, rows: &Rows<'_, R, S>) -> R {
        add_right(self.second, rows)
    }

    /// Reduction of the cost of the second right side by the nuisance parameters.
    pub(super) fn explained_second(&mut self) -> R {
        let mut explained = R::zero();
        for i in 0..self.nuisances {
            let row = &self.packed[start(i)..start(i) + i + 1];
            let value = (self.second[i] - dot(&row[..i], &self.second[..i])) / row[i];
            self.second[i] = value;
            explained += value * value;
        }
        explained
    }

    /// After [`Self::eliminate`]: factors the part of the ten properties as well, so that [`Self::solve`]
    /// works. `None` when the information is not positive definite.
    pub(super) fn complete(&mut self) -> Option<()> {
        self.factor(self.nuisances, self.unknowns)
    }

    /// Undoes [`Self::complete`].
    pub(super) fn restore(&mut self) {
        let first = self.nuisances;
        for i in (first..self.unknowns).rev() {
            let (above, row) = self.packed.split_at_mut(start(i));
            // The elements beyond j are no longer needed.
            row[i] = dot(&row[first..=i], &row[first..=i]);
            for j in (first..i).rev() {
                row[j] = dot(&row[first..=j], &above[start(j) + first..=start(j) + j]);
            }
        }
    }

    /// After [`Self::eliminate`]: the nuisance parameters in standard deviations, for the present ten
    /// properties.
    pub(super) fn nuisances(&mut self) -> &[R] {
        self.second.copy_from_slice(self.right);
        back_substitute(self.packed, &mut self.second[..self.nuisances]);
        &self.second[..self.nuisances]
    }

    /// After [`Self::complete`]: all unknowns at the minimum, nuisance parameters first. They are also the
    /// second right side.
    pub(super) fn solution(&mut self) -> &[R] {
        self.second.copy_from_slice(self.right);
        for i in self.nuisances..self.unknowns {
            let row = &self.packed[start(i)..start(i) + i + 1];
            let others = self.nuisances..i;
            let value = self.second[i] - dot(&row[others.clone()], &self.second[others]);
            self.second[i] = value / row[i];
        }
        back_substitute(self.packed, self.second);
        self.second
    }

    /// After [`Self::complete`]: trace and squared Frobenius norm of `I − P`, where `P` is the covariance of
    /// the first `count` unknowns. The equations cannot be used afterwards.
    pub(super) fn shrinkage(&mut self, count: usize) -> (R, R) {
        self.invert_factor();
        // With the inverse factor A and its first columns alone, P = AᵀA, which has the trace and the norm of
        // AAᵀ: products of rows, which lie in one piece.
        let row = |i: usize| &self.packed[start(i)..start(i) + (i + 1).min(count)];
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

    /// Replaces the factor by its inverse, row by row. Overwrites the second right side.
    fn invert_factor(&mut self) {
        for i in 0..self.unknowns {
            let (above, row) = self.packed.split_at_mut(start(i));
            let (row, sums) = (&mut row[..=i], &mut self.second[..i]);
            sums.fill(R::zero());
            for (k, factor) in row[..i].iter().enumerate() {
                let other = &above[start(k)..start(k) + k + 1];
                for (sum, value) in sums.iter_mut().zip(other) {
                    *sum += *factor * *value;
                }
            }
            let pivot = row[i].recip();
            row[i] = pivot;
            for (to, sum) in row.iter_mut().zip(sums) {
                *to = -*sum * pivot;
            }
        }
    }

    /// After [`Self::complete`]: solves for a right side that `fill` writes.
    pub(super) fn solve(&mut self, fill: impl FnOnce(&mut [R])) -> &[R] {
        self.second.fill(R::zero());
        fill(self.second);
        for i in 0..self.unknowns {
            let row = &self.packed[start(i)..start(i) + i + 1];
            self.second[i] = (self.second[i] - dot(&row[..i], &self.second[..i])) / row[i];
        }
        back_substitute(self.packed, self.second);
        self.second
    }

    /// After [`Self::complete`]: the first half of [`Self::solve_readings`], `L⁻¹ Xᵀ w`. The products of two such
    /// columns are those with the covariance of the unknowns between them.
    pub(super) fn project_readings<const S: usize>(
        &self,
        rows: &Rows<'_, R, S>,
        weighted: &Responses<R, S>,
        projected: &mut [R],
    ) {
        projected.fill(R::zero());
        let (of_sensors, of_shared) = projected.split_at_mut(rows.sensors.len() * SENSOR_NUISANCES);
        rows.add_products(weighted, of_sensors, of_shared);
        for i in 0..self.unknowns {
            let row = &self.packed[start(i)..start(i) + i + 1];
            projected[i] = (projected[i] - dot(&row[..i], &projected[..i])) / row[i];
        }
    }

    /// The second half: the unknowns that these projected readings change.
    pub(super) fn solve_projected(&mut self, projected: &[R]) -> &[R] {
        self.second.copy_from_slice(projected);
        back_substitute(self.packed, self.second);
        self.second
    }

    /// After [`Self::complete`]: solves for readings of a hit DOF that are already weighted.
    pub(super) fn solve_readings<const S: usize>(
        &mut self,
        rows: &Rows<'_, R, S>,
        weighted: &Responses<R, S>,
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

/// Offset of a row in the packed triangle.
const fn start(row: usize) -> usize {
    row * (row + 1) / 2
}

/// Adds `xᵀ W r` for every column of the nuisance parameters and the ten properties; returns `rᵀ W r`.
fn add_right<R: Real, const S: usize>(right: &mut [R], rows: &Rows<'_, R, S>) -> R {
    let weighted = rows.weight.times(rows.residual);
    let (of_sensors, of_shared) = right.split_at_mut(rows.sensors.len() * SENSOR_NUISANCES);
    rows.add_products(&weighted, of_sensors, of_shared);
    rows.residual.dot(&weighted)
}

impl<R: Real, const S: usize> Rows<'_, R, S> {
    /// Adds `xᵀ w` for weighted readings `w` and every column `x`.
    pub(super) fn add_products(
        &self,
        weighted: &Responses<R, S>,
        of_sensors: &mut [R],
        of_shared: &mut [R],
    ) {
        let cells = of_sensors.chunks_mut(SENSOR_NUISANCES);
        for (i, (columns, cells)) in self.sensors.iter().zip(cells).enumerate() {
            add_products(cells, columns, &weighted.column(i).into_owned());
        }
        for (column, to) in self.shared.iter().zip(of_shared) {
            *to += column.dot(weighted);
        }
    }
}

/// Solves `Lᵀ x = b` in place.
fn back_substitute<R: Real>(packed: &[R], b: &mut [R]) {
    for i in (0..b.len()).rev() {
        let row = &packed[start(i)..start(i) + i + 1];
        let value = b[i] / row[i];
        b[i] = value;
        for (to, factor) in b[..i].iter_mut().zip(row) {
            *to -= *factor * value;
        }
    }
}

/// Unrolled by four: most of the fit's instructions are spent here.
fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    let (a, rest_of_a) = a.as_chunks::<4>();
    let (b, rest_of_b) = b.as_chunks::<4>();
    let mut sum = R::zero();
    for (a, b) in a.iter().zip(b) {
        sum = sum + a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    }
    rest_of_a.iter().zip(rest_of_b).fold(sum, |sum, (a, b)| sum + *a * *b)
}
