//! The size of a fault from its scores.

use massline_shared::EstimatedValue;
use massline_shared::identify::Consistency;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// A change of which what is unknown besides explains all but this part shows nothing.
const LEAST_OWN_PART: f64 = 1e-4;

/// What the data show of a fault.
pub(crate) struct FaultEstimate {
    /// Along each of its directions.
    pub(super) sizes: Vec<EstimatedValue<f64>>,
    pub(super) consistency: Consistency<f64>,
    /// One standard deviation of the size, in the direction that changes a property most.
    pub(super) sigma: f64,
    pub(super) shift: f64,
    pub(super) found_shift: f64,
}

/// The size that the data give a fault, along the directions in which they know it well enough.
pub(crate) struct FoundSize {
    /// Along each direction of the fault.
    pub(super) size: DVector<f64>,
    /// Columns: sizes of one standard deviation each, independent of one another.
    spread: DMatrix<f64>,
    /// The scores along them, of variance one.
    scores: DVector<f64>,
}

impl FoundSize {
    /// The size of a fault with these `scores` and the information `own` about its directions, of which `all` would be
    /// there if nothing else were unknown. Directions in which one standard deviation of the size is more than `largest`
    /// are left out; `None` where none stays.
    pub(crate) fn of(
        own: &DMatrix<f64>,
        all: &DVector<f64>,
        scores: &DVector<f64>,
        largest: f64,
    ) -> Option<Self> {
        // In units of what each direction would be known to if nothing else were unknown.
        let unit = all.map(|v| if v > 0.0 { v.sqrt().recip() } else { 0.0 });
        let units = DMatrix::from_diagonal(&unit);
        let SymmetricEigen { eigenvectors, eigenvalues } =
            SymmetricEigen::new(&units * own * &units);
        let columns: Vec<DVector<f64>> = (0..eigenvalues.len())
            .filter(|k| eigenvalues[*k] > LEAST_OWN_PART)
            .map(|k| &units * eigenvectors.column(k) / eigenvalues[k].sqrt())
            .filter(|column| column.norm() <= largest)
            .collect();
        if columns.is_empty() {
            return None;
        }
        let spread = DMatrix::from_columns(&columns);
        let scores = spread.transpose() * scores;
        Some(Self { size: &spread * &scores, spread, scores })
    }

    /// χ² of no such fault, for errors as large as the budget says.
    pub(crate) fn squares(&self) -> f64 {
        self.scores.norm_squared()
    }

    /// Number of directions.
    pub(super) fn degrees(&self) -> usize {
        self.scores.len()
    }

    /// The estimate, with the changes of the properties in their standard deviations per size along each direction.
    pub(crate) fn estimate(&self, changes: &DMatrix<f64>, chi_squared: f64) -> FaultEstimate {
        let Self { size, spread, .. } = self;
        let shifts = changes * spread;
        let (most, shift) = (0..self.degrees())
            .map(|k| (k, shifts.column(k).amax()))
            .max_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap_or_default();
        let sizes =
            (0..size.len()).map(|k| EstimatedValue { value: size[k], sigma: spread.row(k).norm() });
        let degrees_of_freedom = self.degrees() as u16;
        FaultEstimate {
            sizes: sizes.collect(),
            consistency: Consistency { chi_squared, degrees_of_freedom },
            sigma: spread.column(most).norm(),
            shift,
            found_shift: (changes * size).amax(),
        }
    }
}
