//! Linear least squares over the complex numbers, for several right sides.
#![allow(clippy::needless_range_loop, reason = "triangular matrices read better by their indices")]

use nalgebra::{Complex, SMatrix};

use super::{Spectrum, count_above, spectrum};
use crate::real::Real;

/// Complex linear least squares of `N` unknowns for `M` right sides, whose rows arrive one by one: as
/// [`LeastSquares`](super::LeastSquares), with rotations whose cosine is real.
#[derive(Clone, Debug)]
pub(crate) struct ComplexLeastSquares<R, const N: usize, const M: usize> {
    /// Upper triangular factor with a real diagonal, row by row.
    factor: [[Complex<R>; N]; N],
    right: [[Complex<R>; M]; N],
}

impl<R: Real, const N: usize, const M: usize> ComplexLeastSquares<R, N, M> {
    pub(crate) fn new() -> Self {
        let zero = Complex::new(R::zero(), R::zero());
        Self { factor: [[zero; N]; N], right: [[zero; M]; N] }
    }

    /// Adds the equations `row · X = right`, and returns what no X can explain of the right sides.
    pub(crate) fn push(
        &mut self,
        mut row: [Complex<R>; N],
        mut right: [Complex<R>; M],
    ) -> [Complex<R>; M] {
        for k in 0..N {
            let b = row[k];
            let pivot = &mut self.factor[k];
            let a = pivot[k].re;
            let h = (a * a + b.norm_sqr()).sqrt();
            // This happens only for zeros and for numbers whose square underflows: there is nothing to rotate.
            if h == R::zero() {
                continue;
            }
            let (c, s) = (a / h, b.unscale(h));
            pivot[k] = Complex::new(h, R::zero());
            for j in k + 1..N {
                rotate(c, s, &mut pivot[j], &mut row[j]);
            }
            for j in 0..M {
                rotate(c, s, &mut self.right[k][j], &mut right[j]);
            }
        }
        right
    }

    /// The `N` equations that have the same solution and the same spectrum as all that were added.
    pub(crate) fn rows(&self) -> impl Iterator<Item = (&[Complex<R>; N], &[Complex<R>; M])> {
        self.factor.iter().zip(&self.right)
    }

    /// Rank and condition of the matrix of all rows.
    pub(crate) fn spectrum<const DOUBLE: usize>(&self) -> Option<Spectrum<R>> {
        let Spectrum { rank, condition } = spectrum(&self.as_real::<DOUBLE>())?;
        Some(Spectrum { rank: rank / 2, condition })
    }

    /// Number of singular values of the matrix of all rows that are not below `limit > 0`; zero when an element is not
    /// finite.
    pub(crate) fn count_above<const DOUBLE: usize>(&self, limit: R) -> usize {
        count_above(&self.as_real::<DOUBLE>(), limit) / 2
    }

    /// The factor as a real matrix, which has every singular value twice.
    fn as_real<const DOUBLE: usize>(&self) -> [[R; DOUBLE]; DOUBLE] {
        const { assert!(DOUBLE == 2 * N, "a complex number is a real 2 × 2 matrix") };
        let mut real = [[R::zero(); DOUBLE]; DOUBLE];
        for i in 0..N {
            for j in i..N {
                let Complex { re, im } = self.factor[i][j];
                (real[i][j], real[N + i][N + j]) = (re, re);
                (real[i][N + j], real[N + i][j]) = (-im, im);
            }
        }
        real
    }

    /// Variance of each unknown for right sides with a variance of one: the diagonal of `(Aᴴ A)⁻¹`. `None` when the
    /// factor has a zero on its diagonal.
    pub(crate) fn variances(&self) -> Option<[R; N]> {
        let zero = Complex::new(R::zero(), R::zero());
        let mut variances = [R::zero(); N];
        for (i, variance) in variances.iter_mut().enumerate() {
            // A row of the inverse factor.
            let mut row = [zero; N];
            for j in i..N {
                let pivot = self.factor[j][j].re;
                if pivot == R::zero() {
                    return None;
                }
                let unit = if i == j { R::one() } else { R::zero() };
                let known = (i..j).fold(zero, |sum, k| sum + row[k] * self.factor[k][j]);
                row[j] = (Complex::new(unit, R::zero()) - known).unscale(pivot);
                *variance += row[j].norm_sqr();
            }
        }
        Some(variances)
    }

    /// The solution, one column for each right side; `None` when the factor has a zero on its diagonal.
    pub(crate) fn solve(&self) -> Option<SMatrix<Complex<R>, N, M>> {
        let zero = Complex::new(R::zero(), R::zero());
        let mut x = SMatrix::<Complex<R>, N, M>::from_element(zero);
        for i in (0..N).rev() {
            let pivot = self.factor[i][i].re;
            if pivot == R::zero() {
                return None;
            }
            for j in 0..M {
                let known = (i + 1..N).fold(zero, |sum, k| sum + self.factor[i][k] * x[(k, j)]);
                x[(i, j)] = (self.right[i][j] - known).unscale(pivot);
            }
        }
        Some(x)
    }
}

fn rotate<R: Real>(c: R, s: Complex<R>, pivot: &mut Complex<R>, row: &mut Complex<R>) {
    let (p, r) = (*pivot, *row);
    *pivot = p.scale(c) + s.conj() * r;
    *row = r.scale(c) - s * p;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_left_is_orthogonal_to_the_columns() {
        let number = |k: usize| Complex::new((k as f64).sin(), (1.7 * k as f64).cos());
        let rows: [([_; 2], [_; 2]); 5] = core::array::from_fn(|k| {
            ([number(4 * k), number(4 * k + 1)], [number(4 * k + 2), number(4 * k + 3)])
        });
        let mut equations = ComplexLeastSquares::<f64, 2, 2>::new();
        let squares = |right: &[Complex<f64>]| right.iter().map(|v| v.norm_sqr()).sum::<f64>();
        let left: f64 =
            rows.iter().map(|(row, right)| squares(&equations.push(*row, *right))).sum();
        let solution = equations.solve().unwrap();
        let residuals = rows.iter().map(|(row, right)| {
            [0, 1].map(|side| {
                right[side] - row[0] * solution[(0, side)] - row[1] * solution[(1, side)]
            })
        });
        let expected: f64 = residuals.map(|residual| squares(&residual)).sum();
        assert!((left - expected).abs() < 1e-13 * expected, "{left} {expected}");
        for (unknown, side) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let along: Complex<f64> = rows
                .iter()
                .map(|(row, right)| {
                    let left =
                        right[side] - row[0] * solution[(0, side)] - row[1] * solution[(1, side)];
                    row[unknown].conj() * left
                })
                .sum();
            assert!(along.norm() < 1e-14, "{along}");
        }
        assert_eq!(equations.spectrum::<4>().unwrap().rank, 2);
        let normal = nalgebra::Matrix2::from_fn(|i, j| {
            rows.iter().map(|(row, _)| row[i].conj() * row[j]).sum::<Complex<f64>>()
        });
        let inverse = normal.try_inverse().unwrap();
        for (i, variance) in equations.variances().unwrap().into_iter().enumerate() {
            assert!((inverse[(i, i)].re - variance).abs() < 1e-13 * variance);
        }
    }

    #[test]
    fn dependent_columns_show_in_the_rank() {
        let i = Complex::new(0.0, 1.0);
        let mut equations = ComplexLeastSquares::<f64, 2, 0>::new();
        for k in 1..5 {
            let value = Complex::new(f64::from(k), 1.0);
            equations.push([value, value * i], []);
        }
        assert_eq!(equations.spectrum::<4>().unwrap().rank, 1);
        // The other singular value is √2 times the norm of a column, √(2 + 5 + 10 + 17).
        assert_eq!([8.2, 8.3].map(|limit| equations.count_above::<4>(limit)), [1, 0]);
    }
}
