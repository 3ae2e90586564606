//! Linear least squares with rows added one by one.
#![allow(clippy::needless_range_loop, reason = "triangular matrices read better by their indices")]

use nalgebra::SVector;

use super::{Spectrum, spectrum};
use crate::real::Real;

/// Linear least squares whose rows arrive one by one. Only the triangular factor of the rows so far is
/// stored, so the memory does not grow with their number. Givens rotations (Golub & Van Loan, Matrix
/// Computations, section 5.2).
#[derive(Clone, Debug)]
pub(crate) struct LeastSquares<R, const N: usize> {
    /// Upper triangular factor, row by row.
    factor: [[R; N]; N],
    right: [R; N],
    residual: R,
    rows: usize,
}

impl<R: Real, const N: usize> LeastSquares<R, N> {
    pub(crate) fn new() -> Self {
        Self { factor: [[R::zero(); N]; N], right: [R::zero(); N], residual: R::zero(), rows: 0 }
    }

    /// Adds the equation `row · x = right`.
    pub(crate) fn push(&mut self, mut row: [R; N], mut right: R) {
        for k in 0..N {
            let b = row[k];
            if b == R::zero() {
                continue;
            }
            let pivot = &mut self.factor[k];
            let a = pivot[k];
            let h = (a * a + b * b).sqrt();
            // This happens only for numbers whose square underflows: there is nothing to rotate.
            if h == R::zero() {
                continue;
            }
            let (c, s) = (a / h, b / h);
            pivot[k] = h;
            for j in k + 1..N {
                let (p, r) = (pivot[j], row[j]);
                pivot[j] = c * p + s * r;
                row[j] = c * r - s * p;
            }
            let p = self.right[k];
            self.right[k] = c * p + s * right;
            right = c * right - s * p;
        }
        self.residual += right * right;
        self.rows += 1;
    }

    /// Sum of the squared residuals over all rows.
    pub(crate) fn residual(&self) -> R {
        self.residual
    }

    /// The equations for the last `M` unknowns when the others are eliminated.
    pub(crate) fn last<const M: usize>(&self) -> LeastSquares<R, M> {
        const { assert!(M <= N, "unknowns of these equations") };
        let mut rest = LeastSquares::new();
        for k in 0..M {
            rest.factor[k].copy_from_slice(&self.factor[N - M + k][N - M..]);
            rest.right[k] = self.right[N - M + k];
        }
        rest.residual = self.residual;
        rest.rows = self.rows;
        rest
    }

    /// Lengths of the columns of the matrix of all rows.
    pub(crate) fn column_norms(&self) -> [R; N] {
        core::array::from_fn(|k| {
            self.factor.iter().fold(R::zero(), |sum, row| sum + row[k] * row[k]).sqrt()
        })
    }

    /// Rank and condition of the matrix of all rows.
    pub(crate) fn spectrum(&self) -> Option<Spectrum<R>> {
        spectrum(&self.factor)
    }

    /// The same with every column scaled to the length one.
    pub(crate) fn spectrum_of_unit_columns(&self) -> Option<Spectrum<R>> {
        let mut factor = self.factor;
        for (k, norm) in self.column_norms().into_iter().enumerate() {
            if norm > R::zero() {
                factor.iter_mut().for_each(|row| row[k] /= norm);
            }
        }
        spectrum(&factor)
    }

    /// The solution; `None` when the factor has a zero on its diagonal.
    pub(crate) fn solve(&self) -> Option<SVector<R, N>> {
        let mut x = SVector::from(self.right);
        for i in (0..N).rev() {
            let row = &self.factor[i];
            if row[i] == R::zero() {
                return None;
            }
            let mut sum = x[i];
            for k in i + 1..N {
                sum -= row[k] * x[k];
            }
            x[i] = sum / row[i];
        }
        Some(x)
    }

    /// Replaces `rows`, the matrix `B`, by `(Aᵀ A)⁻¹ B`, A being the matrix of all equations; false when the
    /// inverse does not exist. All columns are processed together so that the inner loops run along rows.
    pub(crate) fn solve_normal(&self, rows: &mut [[R; N]; N]) -> bool {
        let zero = R::zero();
        if (0..N).any(|i| self.factor[i][i] == zero) {
            return false;
        }
        for i in 0..N {
            let (above, rest) = rows.split_at_mut(i);
            for (k, other) in above.iter().enumerate() {
                subtract(&mut rest[0], self.factor[k][i], other);
            }
            rest[0] = rest[0].map(|v| v / self.factor[i][i]);
        }
        for i in (0..N).rev() {
            let (rest, below) = rows.split_at_mut(i + 1);
            for (k, other) in (i + 1..).zip(below.iter()) {
                subtract(&mut rest[i], self.factor[i][k], other);
            }
            rest[i] = rest[i].map(|v| v / self.factor[i][i]);
        }
        true
    }

    /// Root mean square of the residuals over all rows.
    pub(crate) fn rms(&self) -> R {
        (self.residual / R::of(self.rows.max(1) as f64)).sqrt()
    }
}

/// `row -= factor · other`.
fn subtract<R: Real, const N: usize>(row: &mut [R; N], factor: R, other: &[R; N]) {
    for (value, other) in row.iter_mut().zip(other) {
        *value -= factor * *other;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix2;

    #[test]
    fn rows_one_by_one_give_the_least_squares_line() {
        // y = 1 + 2 x with the residuals (1, -2, 1)·0.1, which are orthogonal to 1 and x.
        let mut line = LeastSquares::<f64, 2>::new();
        for (x, y) in [(0.0, 1.1), (1.0, 2.8), (2.0, 5.1)] {
            line.push([1.0, x], y);
        }
        let solution = line.solve().unwrap();
        assert!((solution[0] - 1.0).abs() < 1e-14 && (solution[1] - 2.0).abs() < 1e-14);
        assert!((line.rms() - 0.02_f64.sqrt()).abs() < 1e-14);
        let normal = Matrix2::new(3.0, 3.0, 3.0, 5.0);
        let mut b = [[1.0, 2.0], [0.0, -3.0]];
        let right = Matrix2::new(1.0, 2.0, 0.0, -3.0);
        assert!(line.solve_normal(&mut b));
        let solved = Matrix2::new(b[0][0], b[0][1], b[1][0], b[1][1]);
        // The tolerance covers rounding times the condition, 14.
        assert!((normal * solved - right).norm() < 1e-13);
    }

    #[test]
    fn a_missing_direction_has_no_solution() {
        let mut flat = LeastSquares::<f32, 2>::new();
        flat.push([1.0, 1.0], 1.0);
        flat.push([2.0, 2.0], 2.0);
        assert_eq!(flat.spectrum().unwrap().rank, 1);
        let none = LeastSquares::<f32, 2>::new();
        assert!(none.solve().is_none());
        assert!(!none.solve_normal(&mut [[1.0, 0.0], [0.0, 1.0]]));
    }
}
