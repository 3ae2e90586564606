//! The small linear algebra that the solvers share.
#![allow(clippy::needless_range_loop, reason = "triangular matrices read better by their indices")]

use nalgebra::{Matrix3, SMatrix, SVD, SVector, SymmetricEigen, Vector3};

use crate::Real;

/// Sweeps after which an iterative decomposition gives up; they need two to three per value.
const ITERATIONS: usize = 200;

/// Singular values below this part of the largest count as zero: 1e-6, in single precision 1.2e-5,
/// which is ten times the rounding error that a chain of about a hundred rotations leaves.
pub(crate) fn rank_cut<R: Real>() -> R {
    (R::of(100.0) * R::default_epsilon()).max(R::of(1e-6))
}

/// `[v]ₓ`, so that `skew(v) w = v × w`.
pub(crate) fn skew<R: Real>(v: &Vector3<R>) -> Matrix3<R> {
    let o = R::zero();
    Matrix3::new(o, -v.z, v.y, v.z, o, -v.x, -v.y, v.x, o)
}

/// True when no element is NaN or infinite.
pub(crate) fn all_finite<R: Real, const M: usize, const N: usize>(m: &SMatrix<R, M, N>) -> bool {
    m.iter().all(|v| v.finite())
}

/// Eigenvalues in ascending order with their unit eigenvectors as columns; `None` when an element
/// is not finite or the iteration does not end.
pub(crate) fn symmetric_eigen3<R: Real>(m: &Matrix3<R>) -> Option<(Vector3<R>, Matrix3<R>)> {
    if !all_finite(m) {
        return None;
    }
    let e = SymmetricEigen::try_new(*m, R::default_epsilon(), ITERATIONS)?;
    let mut order = [0, 1, 2];
    order.sort_unstable_by(|&a, &b| {
        e.eigenvalues[a].partial_cmp(&e.eigenvalues[b]).unwrap_or(core::cmp::Ordering::Equal)
    });
    let values = Vector3::from_fn(|i, _| e.eigenvalues[order[i]]);
    let vectors = Matrix3::from_fn(|i, j| e.eigenvectors[(i, order[j])]);
    (values.iter().all(|v| v.finite()) && all_finite(&vectors)).then_some((values, vectors))
}

/// What the singular values of a matrix tell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spectrum<R> {
    /// Singular values above the cut.
    pub rank: usize,
    /// Largest over smallest; infinite when the smallest is zero.
    pub condition: R,
}

/// Square matrices whose rank and condition can be asked for.
pub(crate) trait Conditioned<R> {
    /// Rank and condition; `None` when an element is not finite or the iteration does not end. A
    /// matrix of zeros has the rank zero.
    fn spectrum(&self) -> Option<Spectrum<R>>;
}

macro_rules! conditioned {
    ($($order:literal)*) => {$(
        impl<R: Real> Conditioned<R> for SMatrix<R, $order, $order> {
            fn spectrum(&self) -> Option<Spectrum<R>> {
                if !all_finite(self) {
                    return None;
                }
                let epsilon = R::default_epsilon();
                let svd = SVD::try_new_unordered(*self, false, false, epsilon, ITERATIONS)?;
                let largest = svd.singular_values.max();
                let smallest = svd.singular_values.min();
                let cut = rank_cut::<R>() * largest;
                let rank = svd.singular_values.iter().filter(|&&v| v > cut).count();
                Some(Spectrum { rank, condition: largest / smallest })
            }
        }
    )*};
}

// The order of nalgebra's decompositions cannot be left generic without carrying its dimension
// arithmetic through every signature.
conditioned!(2 6 10);

/// Lower triangular `C` with `C Cᵀ = m`; `None` when `m` is not positive definite.
pub(crate) fn cholesky<R: Real, const N: usize>(m: &SMatrix<R, N, N>) -> Option<SMatrix<R, N, N>> {
    let mut c = SMatrix::<R, N, N>::zeros();
    for j in 0..N {
        for i in j..N {
            let mut sum = m[(i, j)];
            for k in 0..j {
                sum -= c[(i, k)] * c[(j, k)];
            }
            if i > j {
                c[(i, j)] = sum / c[(j, j)];
            } else if sum > R::zero() && sum.finite() {
                c[(j, j)] = sum.sqrt();
            } else {
                return None;
            }
        }
    }
    Some(c)
}

/// Solves `C x = b` in place for a lower triangular `C` without a zero on its diagonal.
pub(crate) fn forward_substitute<R: Real, const N: usize>(
    c: &SMatrix<R, N, N>,
    b: &mut SVector<R, N>,
) {
    for i in 0..N {
        let mut sum = b[i];
        for k in 0..i {
            sum -= c[(i, k)] * b[k];
        }
        b[i] = sum / c[(i, i)];
    }
}

/// Linear least squares whose rows arrive one by one: only the triangular factor of the rows so far
/// is kept, so the memory does not grow with their number. Givens rotations (Golub & Van Loan,
/// Matrix Computations, section 5.2).
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
            // Only for numbers below the square root of the smallest: nothing to rotate away.
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

    /// The upper triangular factor.
    pub(crate) fn factor(&self) -> SMatrix<R, N, N> {
        SMatrix::from_fn(|i, j| self.factor[i][j])
    }

    /// The solution; `None` when the factor has a zero on its diagonal.
    pub(crate) fn solve(&self) -> Option<SVector<R, N>> {
        let mut x = SVector::from(self.right);
        self.back_substitute(&mut x).then_some(x)
    }

    /// Replaces `b` by `(Aᵀ A)⁻¹ b`, A being the matrix of all rows; false when that does not
    /// exist.
    pub(crate) fn solve_normal(&self, b: &mut SVector<R, N>) -> bool {
        for i in 0..N {
            let mut sum = b[i];
            for k in 0..i {
                sum -= self.factor[k][i] * b[k];
            }
            if self.factor[i][i] == R::zero() {
                return false;
            }
            b[i] = sum / self.factor[i][i];
        }
        self.back_substitute(b)
    }

    /// Root mean square of the residuals over all rows.
    pub(crate) fn rms(&self) -> R {
        (self.residual / R::of(self.rows.max(1) as f64)).sqrt()
    }

    /// `ln det(Aᵀ A)`.
    pub(crate) fn log_det_normal(&self) -> R {
        let mut sum = R::zero();
        for k in 0..N {
            sum += self.factor[k][k].abs().ln();
        }
        sum * R::of(2.0)
    }

    fn back_substitute(&self, b: &mut SVector<R, N>) -> bool {
        for i in (0..N).rev() {
            let row = &self.factor[i];
            let mut sum = b[i];
            for k in i + 1..N {
                sum -= row[k] * b[k];
            }
            if row[i] == R::zero() {
                return false;
            }
            b[i] = sum / row[i];
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix2;

    #[test]
    fn rows_one_by_one_give_the_least_squares_line() {
        // y = 1 + 2 x with residuals (1, -2, 1)·0.1, which are orthogonal to [1, x].
        let mut line = LeastSquares::<f64, 2>::new();
        for (x, y) in [(0.0, 1.1), (1.0, 2.8), (2.0, 5.1)] {
            line.push([1.0, x], y);
        }
        let solution = line.solve().unwrap();
        assert!((solution[0] - 1.0).abs() < 1e-14 && (solution[1] - 2.0).abs() < 1e-14);
        assert!((line.rms() - 0.02_f64.sqrt()).abs() < 1e-14);
        let normal = Matrix2::new(3.0, 3.0, 3.0, 5.0);
        assert!((line.log_det_normal() - f64::ln(normal.determinant())).abs() < 1e-14);
        let mut b = SVector::from([1.0, 0.0]);
        assert!(line.solve_normal(&mut b));
        assert!((normal * b - SVector::from([1.0, 0.0])).norm() < 1e-14);
    }

    #[test]
    fn a_missing_direction_has_no_solution() {
        let mut flat = LeastSquares::<f32, 2>::new();
        flat.push([1.0, 1.0], 1.0);
        flat.push([2.0, 2.0], 2.0);
        assert_eq!(flat.factor().spectrum().unwrap().rank, 1);
        let none = LeastSquares::<f32, 2>::new();
        assert!(none.solve().is_none());
    }

    #[test]
    fn a_cholesky_factor_gives_its_matrix_back() {
        let m = Matrix3::new(4.0, 2.0, 0.4, 2.0, 5.0, 1.0, 0.4, 1.0, 3.0);
        let c = cholesky(&m).unwrap();
        assert!((c * c.transpose() - m).norm() < 1e-14);
        let mut b = SVector::from([1.0, 2.0, 3.0]);
        forward_substitute(&c, &mut b);
        assert!((c * b - SVector::from([1.0, 2.0, 3.0])).norm() < 1e-14);
        assert!(cholesky(&-m).is_none());
    }

    #[test]
    fn a_number_that_is_not_finite_ends_no_decomposition() {
        let mut m = Matrix3::<f32>::identity();
        m[(1, 2)] = f32::NAN;
        assert!(symmetric_eigen3(&m).is_none());
        assert!(SMatrix::<f32, 6, 6>::repeat(f32::NAN).spectrum().is_none());
    }
}
