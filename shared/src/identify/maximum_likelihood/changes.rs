//! Sizes of changes of the readings that the layout does not have, such as a sensor that sits elsewhere: one step of
//! Gauss and Newton from the minimum of a fit, in which the ten properties and all error sources may follow.

use nalgebra::{SMatrix, SVector};

use super::equations_in;
use super::fit::Fit;
use super::pulls::UnknownValues;
use super::score::Score;
use crate::capacity::Capacity;
use crate::identify::DofMassLines;
use crate::layout::Layout;
use crate::linalg::{all_finite, back_substitute_transposed, cholesky, forward_substitute};
use crate::real::Real;
use crate::responses::{ResponseRows, Responses};

/// The sizes of `K` changes of the readings that explain the residuals of a fit best.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChangeSizes<R, const K: usize> {
    /// The sizes.
    pub sizes: SVector<R, K>,
    /// Their covariance.
    pub covariance: SMatrix<R, K, K>,
}

impl<R: Real> Fit<R> {
    /// Estimates the sizes of changes of the readings, after the last step and before the answer. `changes` gives the
    /// change of the readings of a hit DOF, by its index in the layout, for one unit of each size.
    ///
    /// `sizes = C Gᵀ W r` with `C = (Gᵀ W G)⁻¹`, the residual r, the changes G and the weights W after all other
    /// unknowns (theory, section 12). `None` when the readings do not determine the sizes.
    ///
    /// ```
    /// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
    /// # use massline_shared::identify::Progress;
    /// # use massline_shared::identify::maximum_likelihood::{ErrorBudget, Fit, Start, workspace};
    /// # use massline_shared::responses::Responses;
    /// let layout = frame::layout();
    /// let mut dofs = frame::mass_lines(&layout);
    /// let exact = dofs[1].1.accelerance.clone();
    /// // The force of the second hit was recorded 1 % too low.
    /// dofs[1].1.accelerance *= 1.01;
    /// let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
    /// let mut fit = Fit::start(&layout, &dofs, Start::InertiaRestraint, ErrorBudget::FirstOrder)?;
    /// while fit.step(&layout, &dofs, &mut memory)? == Progress::Going {}
    /// let change = |hit| [if hit == 1 { exact.clone() } else { Responses::zeros(3) }];
    /// let change_sizes = fit.estimate_changes(&layout, &dofs, change, &mut memory).unwrap();
    /// assert!((change_sizes.sizes[0] - 0.01).abs() < 1e-4);
    /// # Ok::<(), massline_shared::diagnosis::Diagnostics>(())
    /// ```
    pub fn estimate_changes<C: Capacity, const K: usize>(
        &self,
        layout: &Layout<R, C>,
        dofs: &[DofMassLines<R, C>],
        mut changes: impl FnMut(usize) -> [Responses<R, C>; K],
        workspace: &mut [R],
    ) -> Option<ChangeSizes<R, K>> {
        let problem = self.problem(layout);
        let mut equations = equations_in(workspace, &problem).ok()?;
        equations.complete()?;
        let unknowns = UnknownValues::<R, C>::of(layout.sensors.len(), equations.solution())?;
        let mut scores: [Score<R, C>; K] = core::array::from_fn(|_| Score::none(&unknowns));
        let mut information = SMatrix::<R, K, K>::zeros();
        let mut places = dofs.iter();
        self.visit(&problem, dofs, &equations, &unknowns, |_, rows, left| {
            let Some((index, _)) = places.next() else { return };
            let columns = ResponseRows(changes(*index));
            for (i, (score, column)) in scores.iter_mut().zip(&columns.0).enumerate() {
                score.add(rows, column, left);
                let weighted = rows.weight.times(column);
                for (k, other) in columns.0.iter().enumerate() {
                    information[(i, k)] += other.dot(&weighted);
                }
            }
        })
        .ok()?;
        for (k, score) in scores.iter().enumerate() {
            let solved = equations.solve(|right| {
                right.iter_mut().zip(score.right.iter()).for_each(|(to, value)| *to = value);
            });
            for (i, other) in scores.iter().enumerate() {
                let explained = other.right.iter().zip(solved);
                information[(i, k)] -= explained.fold(R::zero(), |sum, (b, x)| sum + b * *x);
            }
        }
        equations.restore();
        let factor = cholesky(&information)?;
        let mut covariance = SMatrix::<R, K, K>::zeros();
        for k in 0..K {
            let mut unit = SVector::<R, K>::zeros();
            unit[k] = R::one();
            forward_substitute(&factor, &mut unit);
            back_substitute_transposed(&factor, &mut unit);
            covariance.set_column(k, &unit);
        }
        let sizes = covariance * SVector::from_fn(|k, _| scores[k].score);
        (all_finite(&covariance) && all_finite(&sizes)).then_some(ChangeSizes { sizes, covariance })
    }
}
