//! Packed symmetric matrices and their Cholesky factors.

use core::ops::Range;

use crate::real::Real;

/// Number of elements of a packed matrix with this number of rows; also where a row begins.
pub(crate) const fn triangle(rows: usize) -> usize {
    rows * (rows + 1) / 2
}

/// Endless iterator over rows and columns of a lower triangle, row by row.
pub(crate) fn lower_places() -> impl Iterator<Item = (usize, usize)> {
    (0..).flat_map(|i| (0..=i).map(move |j| (i, j)))
}

/// A symmetric matrix, or the lower triangular Cholesky factor of one: the lower triangle row by row, in memory that
/// its owner gives. The memory may have room for more rows than are used.
#[derive(Debug)]
pub(crate) struct PackedMatrix<'m, R>(pub(crate) &'m mut [R]);

impl<R: Real> PackedMatrix<'_, R> {
    /// A row up to its diagonal.
    pub(crate) fn row(&self, i: usize) -> &[R] {
        &self.0[triangle(i)..triangle(i + 1)]
    }

    /// Solves `L x = b` in place for those unknowns of a factor that belong to these columns, and subtracts from the
    /// others of `x` what they explain.
    pub(crate) fn forward(&self, columns: Range<usize>, x: &mut [R]) {
        let Range { start, end } = columns;
        for i in start..x.len() {
            let row = self.row(i);
            let known = start..i.min(end);
            let left = x[i] - dot(&row[known.clone()], &x[known]);
            x[i] = if i < end { left / row[i] } else { left };
        }
    }

    /// Solves `Lᵀ x = b` in place for the first unknowns of a factor.
    pub(crate) fn backward(&self, x: &mut [R]) {
        for i in (0..x.len()).rev() {
            let row = self.row(i);
            let value = x[i] / row[i];
            x[i] = value;
            for (to, factor) in x.iter_mut().zip(&row[..i]) {
                *to -= *factor * value;
            }
        }
    }

    /// Solves `L Lᵀ x = b` in place for the first unknowns of a factor.
    pub(crate) fn solve(&self, x: &mut [R]) {
        self.forward(0..x.len(), x);
        self.backward(x);
    }

    /// The same matrix, lent for a shorter time.
    pub(crate) fn reborrow(&mut self) -> PackedMatrix<'_, R> {
        PackedMatrix(self.0)
    }

    /// A row up to its diagonal.
    pub(crate) fn row_mut(&mut self, i: usize) -> &mut [R] {
        &mut self.0[triangle(i)..triangle(i + 1)]
    }

    /// The element at a row and a column, in either order.
    pub(crate) fn at(&mut self, i: usize, j: usize) -> &mut R {
        &mut self.0[triangle(i.max(j)) + i.min(j)]
    }

    /// Replaces these columns of the first rows by those of the Cholesky factor (Banachiewicz order), and subtracts
    /// from the elements after them what they explain. What the columns before these explain has been subtracted
    /// already. `None` when a pivot is not above `least` or not finite.
    pub(crate) fn factorise(&mut self, columns: Range<usize>, rows: usize, least: R) -> Option<()> {
        let Range { start, end } = columns;
        for i in start..rows {
            let (above, row) = self.0.split_at_mut(triangle(i));
            let row = &mut row[..=i];
            let mut others = &above[triangle(start)..];
            for j in start..i {
                let (other, below) = others.split_at(j + 1);
                others = below;
                let known = start..j.min(end);
                let left = row[j] - dot(&row[known.clone()], &other[known]);
                row[j] = if j < end { left / other[j] } else { left };
            }
            let known = &row[start..i.min(end)];
            let left = row[i] - dot(known, known);
            row[i] = if i >= end {
                left
            } else if left > least && left.finite() {
                left.sqrt()
            } else {
                return None;
            };
        }
        Some(())
    }

    /// Undoes [`Self::factorise`] of the columns from `start` to the last row.
    pub(crate) fn multiply(&mut self, start: usize, rows: usize) {
        for i in (start..rows).rev() {
            let (above, row) = self.0.split_at_mut(triangle(i));
            // The elements beyond j are no longer needed.
            row[i] = dot(&row[start..=i], &row[start..=i]);
            for j in (start..i).rev() {
                row[j] = dot(&row[start..=j], &above[triangle(j) + start..=triangle(j) + j]);
            }
        }
    }

    /// Replaces the first rows of a factor by those of its inverse. `scratch` has room for a row.
    pub(crate) fn invert(&mut self, rows: usize, scratch: &mut [R]) {
        for i in 0..rows {
            let (above, row) = self.0.split_at_mut(triangle(i));
            let (row, sums) = (&mut row[..=i], &mut scratch[..i]);
            sums.fill(R::zero());
            for (k, factor) in row[..i].iter().enumerate() {
                for (sum, value) in sums.iter_mut().zip(&above[triangle(k)..triangle(k + 1)]) {
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
}

/// Inner product, four terms at a time: most instructions of a fit are spent here. Two sums are one vector of a
/// PC; four, or each added in one step, take a Cortex-M4F more instructions.
pub(crate) fn dot<R: Real>(a: &[R], b: &[R]) -> R {
    let (a, rest_of_a) = a.as_chunks::<4>();
    let (b, rest_of_b) = b.as_chunks::<4>();
    let (mut even, mut odd) = (R::zero(), R::zero());
    for (a, b) in a.iter().zip(b) {
        even = even + a[0] * b[0] + a[2] * b[2];
        odd = odd + a[1] * b[1] + a[3] * b[3];
    }
    rest_of_a.iter().zip(rest_of_b).fold(even + odd, |sum, (a, b)| sum + *a * *b)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `[[4, 2, 0.4], [2, 5, 1], [0.4, 1, 3]]`.
    const MATRIX: [f64; 6] = [4.0, 2.0, 5.0, 0.4, 1.0, 3.0];
    /// What the matrix makes of `[1, 2, 3]`.
    const RIGHT: [f64; 3] = [4.0 + 4.0 + 1.2, 2.0 + 10.0 + 3.0, 0.4 + 2.0 + 9.0];
    /// Only rounding is left.
    const ROUNDING: f64 = 1e-14;

    fn is_close(values: &[f64], expected: &[f64]) -> bool {
        values.iter().zip(expected).all(|(a, b)| (a - b).abs() < ROUNDING)
    }

    #[test]
    fn a_factor_solves_and_inverts() {
        let mut memory = MATRIX;
        let mut matrix = PackedMatrix(&mut memory[..]);
        matrix.factorise(0..3, 3, 0.0).unwrap();
        let mut x = RIGHT;
        matrix.solve(&mut x);
        assert!(is_close(&x, &[1.0, 2.0, 3.0]), "{x:?}");
        let columns = [0, 1, 2].map(|k| {
            let mut column = [0.0; 3];
            column[k] = 1.0;
            matrix.solve(&mut column);
            column
        });
        matrix.invert(3, &mut [0.0; 3]);
        // With the inverse factor A the inverse matrix is AᵀA.
        for (i, j) in lower_places().take(6) {
            let sum: f64 = (i..3).map(|k| matrix.row(k)[i] * matrix.row(k)[j]).sum();
            assert!((sum - columns[i][j]).abs() < ROUNDING, "{i} {j}");
        }
    }

    #[test]
    fn a_part_is_eliminated_and_the_rest_factored_later() {
        let mut memory = MATRIX;
        let mut matrix = PackedMatrix(&mut memory[..]);
        matrix.factorise(0..1, 3, 0.0).unwrap();
        let mut x = RIGHT;
        matrix.forward(0..1, &mut x);
        // The equations of the others, without the first unknown.
        let rest = [5.0 - 2.0 * 2.0 / 4.0, 1.0 - 2.0 * 0.4 / 4.0, 3.0 - 0.4 * 0.4 / 4.0];
        let left = [rest[0] * 2.0 + rest[1] * 3.0, rest[1] * 2.0 + rest[2] * 3.0];
        assert!(is_close(&[*matrix.at(1, 1), *matrix.at(1, 2), *matrix.at(2, 2)], &rest));
        assert!(is_close(&x[1..], &left), "{x:?}");
        matrix.factorise(1..3, 3, 0.0).unwrap();
        let mut whole = MATRIX;
        PackedMatrix(&mut whole[..]).factorise(0..3, 3, 0.0).unwrap();
        assert!(is_close(matrix.0, &whole));
        matrix.multiply(1, 3);
        assert!(is_close(&[*matrix.at(1, 1), *matrix.at(2, 1), *matrix.at(2, 2)], &rest));
    }

    #[test]
    fn a_singular_matrix_has_no_factor() {
        assert!(PackedMatrix(&mut [1.0, 1.0, 1.0][..]).factorise(0..2, 2, 0.0).is_none());
        assert!(PackedMatrix(&mut [f64::NAN][..]).factorise(0..1, 1, 0.0).is_none());
    }
}
