//! Elimination of some unknowns from equations that arrive one by one, in lent memory.

use crate::Real;

/// Eliminates the first unknowns of equations whose rows arrive one by one: what is left of a row is an equation of the
/// other columns. As [`LeastSquares`](super::LeastSquares), for sizes that are known at run time and for several right
/// sides, which are the last columns. Givens rotations (Golub & Van Loan, Matrix Computations, section 5.2).
pub(crate) struct Elimination<'m, R> {
    /// The pivot rows, one after the other, each from its diagonal on.
    factor: &'m mut [R],
    pivots: usize,
    columns: usize,
}

impl<'m, R: Real> Elimination<'m, R> {
    /// Numbers of memory for this many unknowns that are eliminated, of all columns.
    pub(crate) const fn memory(pivots: usize, columns: usize) -> usize {
        pivots * columns - pivots * pivots.saturating_sub(1) / 2
    }

    /// The equations so far, in memory that was zero before the first of them. `None` when the memory is too small.
    pub(crate) fn of(memory: &'m mut [R], pivots: usize, columns: usize) -> Option<Self> {
        let factor = memory.get_mut(..Self::memory(pivots, columns))?;
        Some(Self { factor, pivots, columns })
    }

    /// Adds `M` rows of all columns, column by column. Then the columns after the eliminated ones are what these leave of the
    /// rows. Several rows at once take half as long as one by one, with the same operations.
    pub(crate) fn push<const M: usize>(&mut self, rows: &mut [[R; M]]) {
        let mut factor = &mut *self.factor;
        for k in 0..self.pivots {
            let (pivot, rest) = factor.split_at_mut(self.columns - k);
            factor = rest;
            let Some((diagonal, pivot)) = pivot.split_first_mut() else { return };
            let turns = rows[k].map(|b| {
                let a = *diagonal;
                let h = (a * a + b * b).sqrt();
                // Zeros, and numbers whose square underflows: there is nothing to rotate.
                if b == R::zero() || h == R::zero() {
                    return (R::one(), R::zero());
                }
                *diagonal = h;
                (a / h, b / h)
            });
            if turns.iter().all(|(_, s)| *s == R::zero()) {
                continue;
            }
            for (p, column) in pivot.iter_mut().zip(&mut rows[k + 1..]) {
                let mut sum = *p;
                for (r, (c, s)) in column.iter_mut().zip(&turns) {
                    let old = sum;
                    sum = *c * old + *s * *r;
                    *r = *c * *r - *s * old;
                }
                *p = sum;
            }
        }
    }

    /// Solves for the eliminated unknowns with the column of this place as the right side. False when the factor has a zero
    /// on its diagonal; otherwise the solution is in `x`.
    pub(crate) fn solve(&self, right: usize, x: &mut [R]) -> bool {
        let mut end = self.factor.len();
        for k in (0..self.pivots).rev() {
            let start = end - (self.columns - k);
            let pivot = &self.factor[start..end];
            end = start;
            if pivot[0] == R::zero() {
                return false;
            }
            let known = pivot[1..].iter().zip(&x[k + 1..self.pivots]);
            let sum = known.fold(pivot[right - k], |sum, (p, x)| sum - *p * *x);
            x[k] = sum / pivot[0];
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::LeastSquares;
    use super::*;

    #[test]
    fn equations_are_solved_as_by_least_squares() {
        let number = |k: usize| (1.3 * k as f64).sin();
        let mut memory = [0.0; Elimination::<f64>::memory(3, 5)];
        let mut lent = Elimination::of(&mut memory, 3, 5).unwrap();
        let mut one = [LeastSquares::<f64, 3>::new(), LeastSquares::new()];
        let mut left = [0.0; 2];
        for line in 0..7 {
            let mut rows: [[f64; 2]; 5] =
                core::array::from_fn(|k| [0, 1].map(|row| number(10 * line + 5 * row + k)));
            for row in 0..2 {
                let at = |k: usize| rows[k][row];
                for (side, equations) in one.iter_mut().enumerate() {
                    equations.push([at(0), at(1), at(2)], at(3 + side));
                }
            }
            lent.push(&mut rows);
            for row in 0..2 {
                left[0] += rows[3][row] * rows[3][row];
                left[1] += rows[4][row] * rows[4][row];
            }
        }
        for (side, equations) in one.iter().enumerate() {
            let mut x = [0.0; 3];
            assert!(lent.solve(3 + side, &mut x));
            // The operations are the same.
            assert_eq!(x, equations.solve().unwrap().as_slice());
            assert_eq!(left[side], equations.residual());
        }
    }

    #[test]
    fn what_is_missing_is_reported() {
        let mut memory = [0.0; 4];
        assert!(Elimination::<f64>::of(&mut memory, 2, 3).is_none());
        let mut memory = [0.0; Elimination::<f64>::memory(2, 3)];
        let mut equations = Elimination::of(&mut memory, 2, 3).unwrap();
        equations.push(&mut [[1.0], [0.0], [2.0]]);
        assert!(!equations.solve(2, &mut [0.0; 2]));
    }
}
