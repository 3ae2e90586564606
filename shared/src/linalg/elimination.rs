//! Elimination of some unknowns from equations that arrive a few at a time, in lent memory.

use crate::real::Real;

/// Eliminates the first unknowns of equations whose rows arrive a few at a time: what is left of a row is an equation
/// of the other columns. As [`LeastSquares`](super::LeastSquares), for sizes that are known at run time and for several
/// right sides, which are the last columns. Givens rotations (Golub & Van Loan, Matrix Computations, section 5.2).
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

    /// Adds `M` rows, of which the first numbers are the columns. Then the columns after the eliminated ones are what
    /// these leave of the rows. Several rows at once take half as long as one by one, with the same operations; the
    /// columns are the inner loop, whose turns are independent of each other.
    pub(crate) fn push<const M: usize, const N: usize>(&mut self, rows: &mut [[R; N]; M]) {
        let mut factor = &mut *self.factor;
        for k in 0..self.pivots.min(N) {
            let (pivot, rest) = factor.split_at_mut(self.columns - k);
            factor = rest;
            let Some((diagonal, pivot)) = pivot.split_first_mut() else { return };
            let turns = rows.each_ref().map(|row| {
                let (a, b) = (*diagonal, row[k]);
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
            let mut others = rows.each_mut().map(|row| &mut row[k + 1..]);
            let columns = others.iter().fold(pivot.len(), |least, row| least.min(row.len()));
            let pivot = &mut pivot[..columns];
            others = others.map(|row| &mut row[..columns]);
            for (column, p) in pivot.iter_mut().enumerate() {
                let mut sum = *p;
                for (row, (c, s)) in others.iter_mut().zip(&turns) {
                    let (old, r) = (sum, row[column]);
                    sum = *c * old + *s * r;
                    row[column] = *c * r - *s * old;
                }
                *p = sum;
            }
        }
    }

    /// Solves for the eliminated unknowns with the column of this place as the right side. False when the factor has a
    /// zero on its diagonal; otherwise the solution is in `x`.
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
        let number = |k: usize| (1.3 * (k * k) as f64).sin();
        let mut memory = [0.0; Elimination::<f64>::memory(3, 5)];
        let mut lent = Elimination::of(&mut memory, 3, 5).unwrap();
        let mut one = [LeastSquares::<f64, 3>::new(), LeastSquares::new()];
        let mut left = [0.0; 2];
        for line in 0..7 {
            let mut rows = [0, 1]
                .map(|row| core::array::from_fn::<_, 5, _>(|k| number(10 * line + 5 * row + k)));
            for row in &rows {
                let at = |k: usize| row[k];
                for (side, equations) in one.iter_mut().enumerate() {
                    equations.push([at(0), at(1), at(2)], at(3 + side));
                }
            }
            lent.push(&mut rows);
            for row in &rows {
                left[0] += row[3] * row[3];
                left[1] += row[4] * row[4];
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
        equations.push(&mut [[1.0, 0.0, 2.0]]);
        assert!(!equations.solve(2, &mut [0.0; 2]));
    }
}
