//! The measured input of an identification: the mass lines of one hit DOF with their scatter.

use nalgebra::{SMatrix, SVector};

use crate::Real;

/// Mass line accelerances of one hit DOF, response by response.
#[derive(Clone, Debug, PartialEq)]
pub struct MassLines<R, const CH: usize> {
    /// Accelerance A of every response, averaged over the hits, (m/s²)/N; zero beyond the last.
    pub accelerance: SVector<R, CH>,
    /// Sample covariance of the single hits' accelerances, ((m/s²)/N)².
    pub scatter: SMatrix<R, CH, CH>,
    /// Hits averaged.
    pub hits: u16,
}

impl<R: Real, const CH: usize> MassLines<R, CH> {
    /// Of accelerances whose scatter is not known, as from a file.
    pub fn without_scatter(accelerance: SVector<R, CH>) -> Self {
        Self { accelerance, scatter: SMatrix::zeros(), hits: 1 }
    }

    /// From stored numbers: as many accelerances as there are responses, and the lower triangle of
    /// the scatter row by row, empty when there is none. `None` when they do not fit together.
    pub fn from_parts(accelerance: &[R], lower: &[R], hits: u16) -> Option<Self> {
        let count = accelerance.len();
        if count > CH || !(lower.is_empty() || lower.len() == count * (count + 1) / 2) {
            return None;
        }
        let mut lines = Self::without_scatter(SVector::<R, CH>::zeros());
        lines.hits = hits;
        for (to, from) in lines.accelerance.iter_mut().zip(accelerance) {
            *to = *from;
        }
        fill_symmetric(&mut lines.scatter, lower.iter().copied());
        Some(lines)
    }
}

/// Mean and sample covariance of the single hits' mass lines, updated hit by hit (Welford 1962).
#[derive(Clone, Debug, PartialEq)]
pub struct ScatterAccumulator<R, const CH: usize> {
    mean: SVector<R, CH>,
    /// Sum of the outer products of the deviations; both triangles.
    outer: SMatrix<R, CH, CH>,
    hits: u16,
}

impl<R: Real, const CH: usize> ScatterAccumulator<R, CH> {
    /// Without hits.
    pub fn new() -> Self {
        Self { mean: SVector::zeros(), outer: SMatrix::zeros(), hits: 0 }
    }

    /// Adds the mass lines of one hit.
    pub fn add(&mut self, accelerance: &SVector<R, CH>) {
        self.hits = self.hits.saturating_add(1);
        let before = accelerance - self.mean;
        self.mean += before / R::of(f64::from(self.hits));
        let after = accelerance - self.mean;
        for j in 0..CH {
            for i in j..CH {
                let product = before[i] * after[j];
                self.outer[(i, j)] += product;
                if i > j {
                    self.outer[(j, i)] += product;
                }
            }
        }
    }

    /// Hits added.
    pub fn hits(&self) -> u16 {
        self.hits
    }

    /// Mean of the single hits' mass lines.
    pub fn mean(&self) -> &SVector<R, CH> {
        &self.mean
    }

    /// Sample covariance, zero with fewer than two hits.
    pub fn covariance(&self) -> SMatrix<R, CH, CH> {
        self.outer / R::of(f64::from(self.hits.max(2) - 1))
    }

    /// The mass lines with the mean of the single hits as accelerance.
    pub fn mass_lines(&self) -> MassLines<R, CH> {
        self.mass_lines_at(self.mean)
    }

    /// The mass lines with an accelerance from averaged spectra.
    pub fn mass_lines_at(&self, accelerance: SVector<R, CH>) -> MassLines<R, CH> {
        MassLines { accelerance, scatter: self.covariance(), hits: self.hits }
    }
}

impl<R: Real, const CH: usize> Default for ScatterAccumulator<R, CH> {
    fn default() -> Self {
        Self::new()
    }
}

/// The lower triangle of the first `count` rows of a symmetric matrix, row by row, as it is stored.
pub fn lower_triangle<R: Real, const N: usize>(
    matrix: &SMatrix<R, N, N>,
    count: usize,
) -> impl Iterator<Item = R> {
    (0..count.min(N)).flat_map(move |i| (0..=i).map(move |j| matrix[(i, j)]))
}

/// The symmetric matrix of a lower triangle as stored; `None` unless it is complete and no more.
pub fn symmetric<R: Real, const N: usize>(lower: &[R]) -> Option<SMatrix<R, N, N>> {
    if lower.len() != N * (N + 1) / 2 {
        return None;
    }
    let mut matrix = SMatrix::<R, N, N>::zeros();
    fill_symmetric(&mut matrix, lower.iter().copied());
    Some(matrix)
}

fn fill_symmetric<R: Real, const N: usize>(
    matrix: &mut SMatrix<R, N, N>,
    lower: impl Iterator<Item = R>,
) {
    let places = (0..N).flat_map(|i| (0..=i).map(move |j| (i, j)));
    for ((i, j), value) in places.zip(lower) {
        matrix[(i, j)] = value;
        matrix[(j, i)] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_scatter_is_the_sample_covariance(
            hits in prop::collection::vec(prop::array::uniform4(-2.0..2.0_f64), 2..12),
        ) {
            let mut sums = ScatterAccumulator::<f64, 4>::new();
            for hit in &hits {
                sums.add(&SVector::from(*hit));
            }
            let n = hits.len() as f64;
            let mean = hits.iter().map(|h| SVector::from(*h)).sum::<SVector<f64, 4>>() / n;
            let mut expected = SMatrix::<f64, 4, 4>::zeros();
            for hit in &hits {
                let d = SVector::from(*hit) - mean;
                expected += d * d.transpose() / (n - 1.0);
            }
            // Rounding only.
            prop_assert!((sums.mean() - mean).norm() < 1e-14);
            prop_assert!((sums.covariance() - expected).norm() < 1e-13);
            prop_assert_eq!(usize::from(sums.mass_lines().hits), hits.len());
        }
    }

    #[test]
    fn stored_mass_lines_read_back() {
        let mut sums = ScatterAccumulator::<f32, 9>::new();
        for k in 0..4 {
            sums.add(&SVector::from_fn(|i, _| if i < 6 { (i * k) as f32 } else { 0.0 }));
        }
        let lines = sums.mass_lines();
        let lower: std::vec::Vec<_> = lower_triangle(&lines.scatter, 6).collect();
        let accelerance = &lines.accelerance.as_slice()[..6];
        assert_eq!(MassLines::from_parts(accelerance, &lower, 4), Some(lines.clone()));
        assert_eq!(MassLines::<f32, 9>::from_parts(accelerance, &lower[1..], 4), None);
        assert_eq!(MassLines::<f32, 4>::from_parts(accelerance, &[], 4), None);
        let whole: std::vec::Vec<_> = lower_triangle(&lines.scatter, 9).collect();
        assert_eq!(symmetric(&whole), Some(lines.scatter));
        assert_eq!(symmetric::<f32, 9>(&lower), None);
    }

    #[test]
    fn one_hit_has_no_scatter() {
        let mut sums = ScatterAccumulator::<f32, 3>::default();
        sums.add(&SVector::from([1.0, 2.0, 3.0]));
        assert_eq!(sums.mass_lines().scatter, SMatrix::<f32, 3, 3>::zeros());
        assert_eq!(*sums.mean(), SVector::from([1.0, 2.0, 3.0]));
    }
}
