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

    /// Adds a row of all columns. Then its columns after the eliminated ones are what these leave of it.
    pub(crate) fn push(&mut self, row: &mut [R]) {
        let mut factor = &mut *self.factor;
        for k in 0..self.pivots {
            let (pivot, rest) = factor.split_at_mut(self.columns - k);
            factor = rest;
            let b = row[k];
            if b == R::zero() {
                continue;
            }
            let a = pivot[0];
            let h = (a * a + b * b).sqrt();
            // This happens only for numbers whose square underflows: there is nothing to rotate.
            if h == R::zero() {
                continue;
            }
            let (c, s) = (a / h, b / h);
            pivot[0] = h;
            for (p, r) in pivot[1..].iter_mut().zip(&mut row[k + 1..]) {
                let (old, other) = (*p, *r);
                *p = c * old + s * other;
                *r = c * other - s * old;
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
            let mut row: [f64; 5] = core::array::from_fn(|k| number(5 * line + k));
            for (side, equations) in one.iter_mut().enumerate() {
                equations.push([row[0], row[1], row[2]], row[3 + side]);
            }
            lent.push(&mut row);
            left[0] += row[3] * row[3];
            left[1] += row[4] * row[4];
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
        equations.push(&mut [1.0, 0.0, 2.0]);
        assert!(!equations.solve(2, &mut [0.0; 2]));
    }
}
