//! Small linear algebra that the solvers share.
#![allow(clippy::needless_range_loop, reason = "triangular matrices read better by their indices")]

mod complex_least_squares;
mod eigenvalues;
mod elimination;
mod least_squares;
mod packed;

pub(crate) use complex_least_squares::ComplexLeastSquares;
pub(crate) use eigenvalues::eigenvalues;
pub(crate) use elimination::Elimination;
pub(crate) use least_squares::LeastSquares;
pub(crate) use packed::{PackedMatrix, dot, lower_places, triangle};

use nalgebra::{Matrix3, SMatrix, SVector, SymmetricEigen, Vector3};

use crate::real::Real;
use crate::sorting::sort_short;

/// Largest number of sweeps of an iterative decomposition; two to three per value are normal.
const ITERATIONS: usize = 200;

/// Singular values below this fraction of the largest count as zero: 1e-6, in single precision 1.2e-5. The
/// latter is ten times the rounding error of a chain of about a hundred rotations.
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

/// Eigenvalues in ascending order, with unit eigenvectors as columns; `None` when an element is not finite or
/// the iteration does not converge.
pub(crate) fn symmetric_eigen3<R: Real>(m: &Matrix3<R>) -> Option<(Vector3<R>, Matrix3<R>)> {
    if !all_finite(m) {
        return None;
    }
    let e = SymmetricEigen::try_new(*m, R::default_epsilon(), ITERATIONS)?;
    let mut order = [0, 1, 2];
    sort_short(&mut order, |&a, &b| e.eigenvalues[a] < e.eigenvalues[b]);
    let values = Vector3::from_fn(|i, _| e.eigenvalues[order[i]]);
    let vectors = Matrix3::from_fn(|i, j| e.eigenvectors[(i, order[j])]);
    (values.iter().all(|v| v.finite()) && all_finite(&vectors)).then_some((values, vectors))
}

/// Rank and condition of a matrix from its singular values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Spectrum<R> {
    /// Number of singular values above the cut.
    pub rank: usize,
    /// Largest over smallest; infinite when the smallest is zero.
    pub condition: R,
}

/// Rank and condition of a square matrix; `None` when an element is not finite. A zero matrix has rank zero
/// and an infinite condition.
///
/// Householder reflections make the matrix bidiagonal; Sturm counts on the Golub-Kahan form then bound the
/// largest and the smallest singular value and count those above the cut (Golub & Van Loan, Matrix
/// Computations, sections 5.4.8 and 8.4). The method always terminates, and costs a quarter of computing all
/// singular values by QR steps.
pub(crate) fn spectrum<R: Real, const N: usize>(matrix: &[[R; N]; N]) -> Option<Spectrum<R>> {
    let zero = R::zero();
    let mut largest_element = zero;
    for value in matrix.iter().flatten() {
        if !value.finite() {
            return None;
        }
        largest_element = largest_element.max(value.abs());
    }
    if largest_element == zero {
        return Some(Spectrum { rank: 0, condition: R::one() / zero });
    }
    let bidiagonal = Bidiagonal::of(matrix, largest_element);
    let largest = bidiagonal.bisect(|count| count == 0, bidiagonal.bound());
    let rank = bidiagonal.count_from(rank_cut::<R>() * largest);
    let smallest = bidiagonal.bisect(|count| count < N, largest);
    Some(Spectrum { rank, condition: largest / smallest })
}

/// Number of singular values of a square matrix that are not below `limit > 0`; zero when an element is not finite.
pub(crate) fn count_above<R: Real, const N: usize>(matrix: &[[R; N]; N], limit: R) -> usize {
    let largest = matrix.iter().flatten().fold(R::zero(), |top, value| top.max(value.abs()));
    let finite = matrix.iter().flatten().all(|value| value.finite());
    if !finite || largest == R::zero() {
        return 0;
    }
    Bidiagonal::of(matrix, largest).count_from(limit / largest)
}

/// Squares of the diagonal and the superdiagonal of a bidiagonal matrix, which is scaled to a largest element
/// of one.
struct Bidiagonal<R, const N: usize> {
    diagonal: [R; N],
    /// Squares of the superdiagonal; the last is zero.
    above: [R; N],
}

impl<R: Real, const N: usize> Bidiagonal<R, N> {
    fn of(matrix: &[[R; N]; N], scale: R) -> Self {
        let mut a = matrix.map(|row| row.map(|v| v / scale));
        let mut squares = Self { diagonal: [R::zero(); N], above: [R::zero(); N] };
        for k in 0..N {
            squares.diagonal[k] = clear_below(&mut a, k);
            if k + 1 < N {
                squares.above[k] = clear_right(&mut a, k);
            }
        }
        squares
    }

    /// Upper bound of the singular values: the Frobenius norm with a margin for rounding.
    fn bound(&self) -> R {
        let sum = self.diagonal.iter().chain(&self.above).fold(R::zero(), |sum, v| sum + *v);
        sum.sqrt() * R::of(1.001)
    }

    /// Number of singular values that are not below `x > 0`. The eigenvalues of the symmetric tridiagonal
    /// matrix with a zero diagonal and the off-diagonal d₁, e₁, d₂, e₂, … are the singular values with both
    /// signs.
    fn count_from(&self, x: R) -> usize {
        // Replaces a pivot that vanishes.
        let tiny = x * R::default_epsilon();
        let mut below = 1;
        let mut pivot = -x;
        let beside = self.diagonal.iter().zip(&self.above).flat_map(|(d, e)| [*d, *e]);
        for square in beside.take(2 * N - 1) {
            pivot = -x - square / pivot;
            if pivot.abs() < tiny {
                pivot = -tiny;
            }
            if pivot < R::zero() {
                below += 1;
            }
        }
        2 * N - below
    }

    /// The smallest `x` between zero and `high` for which `above(count_from(x))` holds; zero when it is
    /// negligible compared with `high`.
    fn bisect(&self, above: impl Fn(usize) -> bool, mut high: R) -> R {
        let half = R::of(0.5);
        let negligible = high * R::default_epsilon() * R::default_epsilon();
        // ε^⅔ is 2e-5 in single and 4e-11 in double precision, which is enough for ranks and conditions.
        let close = R::default_epsilon().cbrt().powi(2);
        let mut low = R::zero();
        while high - low > high * close {
            if high < negligible {
                return R::zero();
            }
            let middle = (low + high) * half;
            if above(self.count_from(middle)) {
                high = middle;
            } else {
                low = middle;
            }
        }
        high
    }
}

/// Reflects the rows from `k` on so that column `k` becomes zero below the diagonal; returns the square of
/// the new diagonal element.
fn clear_below<R: Real, const N: usize>(a: &mut [[R; N]; N], k: usize) -> R {
    let mut v = [R::zero(); N];
    for i in k..N {
        v[i] = a[i][k];
    }
    let (square, beta) = reflect(&mut v, k);
    let mut sums = [R::zero(); N];
    for i in k..N {
        for j in k + 1..N {
            sums[j] += v[i] * a[i][j];
        }
    }
    for i in k..N {
        let factor = beta * v[i];
        for j in k + 1..N {
            a[i][j] -= factor * sums[j];
        }
    }
    square
}

/// Reflects the columns after `k` so that row `k` becomes zero after its superdiagonal; returns the square of
/// the new superdiagonal element.
fn clear_right<R: Real, const N: usize>(a: &mut [[R; N]; N], k: usize) -> R {
    let mut v = a[k];
    let (square, beta) = reflect(&mut v, k + 1);
    for row in a.iter_mut().skip(k + 1) {
        let mut sum = R::zero();
        for j in k + 1..N {
            sum += v[j] * row[j];
        }
        let factor = beta * sum;
        for j in k + 1..N {
            row[j] -= factor * v[j];
        }
    }
    square
}

/// Turns `x = v[from..]` into the vector of the reflection `I − β v vᵀ` that maps it to the first axis;
/// returns `|x|²` and β. Both are zero when there is nothing to reflect: compared with a largest element of
/// one, `ε²` is negligible, and its square would be close to the smallest number of the format.
fn reflect<R: Real, const N: usize>(v: &mut [R; N], from: usize) -> (R, R) {
    let mut square = R::zero();
    for i in from..N {
        square += v[i] * v[i];
    }
    let first = v[from];
    // The sign is opposite to that of the first component, so that nothing cancels.
    let target = if first > R::zero() { -square.sqrt() } else { square.sqrt() };
    let half_norm = square - first * target;
    let nothing = R::default_epsilon() * R::default_epsilon();
    if half_norm <= nothing * nothing {
        return (square, R::zero());
    }
    v[from] = first - target;
    (square, R::one() / half_norm)
}

/// Replaces a symmetric `S` by `A S Aᵀ`, for an `A` of mostly zeros.
pub(crate) fn congruence<R: Real, const N: usize>(a: &SMatrix<R, N, N>, s: &mut SMatrix<R, N, N>) {
    // Applied on the left, then on the right by symmetry.
    for _side in 0..2 {
        let mut transposed = [[R::zero(); N]; N];
        for (k, column) in a.column_iter().enumerate() {
            for (row, value) in transposed.iter_mut().zip(column.iter()) {
                if *value != R::zero() {
                    for (to, element) in row.iter_mut().zip(s.row(k).iter()) {
                        *to += *value * *element;
                    }
                }
            }
        }
        s.data.0 = transposed;
    }
}

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

/// Solves `Cᵀ x = b` in place for a lower triangular `C` without a zero on its diagonal.
pub(crate) fn back_substitute_transposed<R: Real, const N: usize>(
    c: &SMatrix<R, N, N>,
    b: &mut SVector<R, N>,
) {
    for i in (0..N).rev() {
        let mut sum = b[i];
        for k in i + 1..N {
            sum -= c[(k, i)] * b[k];
        }
        b[i] = sum / c[(i, i)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Matrix5;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn rank_and_condition_are_those_of_the_singular_values(
            rows in prop::array::uniform5(prop::array::uniform5(-1.0..1.0_f64)),
            shrink in 1e-4..1.0_f64,
            rank in 1..=5_usize,
        ) {
            // Rows beyond the rank are sums of the first ones; scaling one row spreads the singular values.
            let mut rows = rows;
            rows[0] = rows[0].map(|v| v * shrink);
            for i in rank..5 {
                rows[i] = core::array::from_fn(|j| (0..rank).map(|k| rows[k][j]).sum::<f64>() * i as f64);
            }
            let matrix = Matrix5::from_fn(|i, j| rows[i][j]);
            // nalgebra's decomposition is the reference.
            let values = matrix.singular_values();
            let (largest, smallest) = (values.max(), values.min());
            let kept = values.iter().filter(|&&v| v > 1e-6 * largest).count();
            let near_cut = values.iter().any(|&v| v > 1e-7 * largest && v < 1e-5 * largest);
            prop_assume!(!near_cut);
            let double = spectrum(&rows).unwrap();
            prop_assert_eq!(double.rank, kept);
            if kept == 5 {
                // The tolerance covers rounding times the condition, in both decompositions.
                let condition = largest / smallest;
                prop_assert!((double.condition / condition - 1.0).abs() < 1e-14 * condition + 2e-10);
            } else {
                prop_assert!(double.condition > 1e12);
            }
            let single = spectrum(&rows.map(|row| row.map(|v| v as f32))).unwrap();
            // The cut in single precision is at 1.2e-5, the rounding below 1e-6.
            if !values.iter().any(|&v| v > 1e-7 * largest && v < 1e-4 * largest) {
                prop_assert_eq!(single.rank, kept);
            }
        }
    }

    #[test]
    fn diagonal_and_empty_matrices_have_an_obvious_spectrum() {
        let full = spectrum(&[[3.0, 0.0, 0.0], [0.0, -0.5, 0.0], [0.0, 0.0, 6.0]]).unwrap();
        assert_eq!(full.rank, 3);
        // The bisection stops at ε^⅔.
        assert!((full.condition - 12.0_f64).abs() < 12.0 * 2e-10);
        let flat = spectrum(&[[3.0_f32, 0.0], [0.0, 0.0]]).unwrap();
        assert_eq!((flat.rank, flat.condition), (1, f32::INFINITY));
        let nothing = spectrum(&[[0.0_f32; 4]; 4]).unwrap();
        assert_eq!((nothing.rank, nothing.condition), (0, f32::INFINITY));
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
        assert!(spectrum(&[[1.0, f32::NAN], [0.0, 1.0]]).is_none());
    }
}
