//! The measured input of an identification: the mass lines of one hit DOF with their scatter.

use core::borrow::Borrow;

use nalgebra::{SMatrix, SVector};

use crate::Real;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::layout::Layout;
use crate::linalg::all_finite;

/// Mass line accelerances of one hit DOF, response by response.
#[derive(Clone, Debug, PartialEq)]
pub struct MassLines<R, const CH: usize> {
    /// Accelerance A of every response, averaged over the hits, (m/s²)/N; zero beyond the last.
    pub accelerance: SVector<R, CH>,
    /// Standard deviation of each averaged accelerance by the noise of the spectral lines about the
    /// fit, corrected by [`window_correlation`](crate::mass_line::window_correlation), (m/s²)/N:
    /// placement is not in it, as it moves all lines together. Zero when not known.
    pub noise: SVector<R, CH>,
    /// Sample covariance of the single hits' accelerances, ((m/s²)/N)².
    pub scatter: SMatrix<R, CH, CH>,
    /// Hits averaged.
    pub hits: u16,
}

impl<R: Real, const CH: usize> MassLines<R, CH> {
    /// Of accelerances of which neither noise nor scatter is known.
    pub fn without_scatter(accelerance: SVector<R, CH>) -> Self {
        Self { accelerance, noise: SVector::zeros(), scatter: SMatrix::zeros(), hits: 1 }
    }

    /// The same with the standard deviations of the noise.
    pub fn with_noise(self, noise: SVector<R, CH>) -> Self {
        Self { noise, ..self }
    }

    /// The same in another precision.
    pub fn cast<Q: Real>(&self) -> MassLines<Q, CH> {
        let to = |v: R| Q::of(v.to_f64());
        MassLines {
            accelerance: self.accelerance.map(to),
            noise: self.noise.map(to),
            scatter: self.scatter.map(to),
            hits: self.hits,
        }
    }

    /// From stored numbers: as many accelerances and standard deviations of their noise as there are
    /// responses, and the lower triangle of the scatter row by row. Noise and scatter are empty when
    /// they are not known. `None` when they do not fit together.
    pub fn from_parts(accelerance: &[R], noise: &[R], lower: &[R], hits: u16) -> Option<Self> {
        let count = accelerance.len();
        let fits = |length, whole| length == 0 || length == whole;
        let triangle = count * (count + 1) / 2;
        if count > CH || !fits(noise.len(), count) || !fits(lower.len(), triangle) {
            return None;
        }
        let mut lines = Self::without_scatter(SVector::<R, CH>::zeros());
        lines.hits = hits;
        lines.accelerance.rows_mut(0, count).copy_from_slice(accelerance);
        lines.noise.rows_mut(0, noise.len()).copy_from_slice(noise);
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

    /// Relative distance of the mass lines of another hit from the mean, `|A − mean| / |mean|`; `None`
    /// without hits.
    pub fn distance(&self, accelerance: &SVector<R, CH>) -> Option<R> {
        let distance = (accelerance - self.mean).norm() / self.mean.norm();
        (self.hits > 0 && distance.finite()).then_some(distance)
    }

    /// Relative scatter of the hits, `(tr Cov)^½ / |mean|`; zero with fewer than two hits.
    pub fn spread(&self) -> R {
        self.covariance().trace().sqrt() / self.mean.norm()
    }

    /// Sample covariance, zero with fewer than two hits.
    pub fn covariance(&self) -> SMatrix<R, CH, CH> {
        self.outer / R::of(f64::from(self.hits.max(2) - 1))
    }

    /// The mass lines with the mean of the single hits as accelerance, of unknown noise.
    pub fn mass_lines(&self) -> MassLines<R, CH> {
        self.mass_lines_at(self.mean)
    }

    /// The mass lines with an accelerance from averaged spectra, of unknown noise.
    pub fn mass_lines_at(&self, accelerance: SVector<R, CH>) -> MassLines<R, CH> {
        let scatter = self.covariance();
        MassLines { scatter, hits: self.hits, ..MassLines::without_scatter(accelerance) }
    }
}

impl<R: Real, const CH: usize> Default for ScatterAccumulator<R, CH> {
    fn default() -> Self {
        Self::new()
    }
}

/// Errors for every DOF that the layout does not have, and for numbers that are not finite.
pub(crate) fn check_mass_lines<R, const S: usize, const H: usize, const CH: usize, B>(
    layout: &Layout<R, S, H>,
    dofs: impl Iterator<Item = (usize, B)>,
) -> Result<(), Diagnostics>
where
    R: Real,
    B: Borrow<MassLines<R, CH>>,
{
    let mut found = Diagnostics::new();
    for (index, lines) in dofs {
        let lines = lines.borrow();
        let finite = all_finite(&lines.accelerance)
            && all_finite(&lines.scatter)
            && all_finite(&lines.noise);
        let code = if layout.hits.get(index).is_none() {
            Code::HitNotInLayout
        } else if !finite {
            Code::DataNotFinite
        } else {
            continue;
        };
        // Sixteen are enough to say.
        let _ = found.push(Diagnostic::about(code, Severity::Error, Subject::hit(index), 0.0));
    }
    if found.is_empty() { Ok(()) } else { Err(found) }
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
        let noise = SVector::from_fn(|i, _| if i < 6 { 0.1 + i as f32 } else { 0.0 });
        let lines = sums.mass_lines().with_noise(noise);
        let lower: std::vec::Vec<_> = lower_triangle(&lines.scatter, 6).collect();
        let accelerance = &lines.accelerance.as_slice()[..6];
        let noise = &lines.noise.as_slice()[..6];
        assert_eq!(MassLines::from_parts(accelerance, noise, &lower, 4), Some(lines.clone()));
        assert_eq!(MassLines::<f32, 9>::from_parts(accelerance, noise, &lower[1..], 4), None);
        assert_eq!(MassLines::<f32, 9>::from_parts(accelerance, &noise[1..], &lower, 4), None);
        assert_eq!(MassLines::<f32, 4>::from_parts(accelerance, noise, &[], 4), None);
        let whole: std::vec::Vec<_> = lower_triangle(&lines.scatter, 9).collect();
        assert_eq!(symmetric(&whole), Some(lines.scatter));
        assert_eq!(symmetric::<f32, 9>(&lower), None);
    }

    #[test]
    fn a_hit_is_as_far_from_the_others_as_from_their_mean() {
        let mut sums = ScatterAccumulator::<f64, 2>::new();
        assert_eq!(sums.distance(&SVector::from([1.0, 0.0])), None);
        sums.add(&SVector::from([3.0, 3.9]));
        sums.add(&SVector::from([3.0, 4.1]));
        // From (3, 4) to (0, 0) and to (3, 9), over 5.
        assert_eq!(sums.distance(&SVector::zeros()), Some(1.0));
        assert!((sums.distance(&SVector::from([3.0, 9.0])).unwrap() - 1.0).abs() < 1e-15);
        // Two hits 0.1 from their mean have the variance 0.02.
        assert!((sums.spread() - 0.02_f64.sqrt() / 5.0).abs() < 1e-15);
    }

    #[test]
    fn one_hit_has_no_scatter() {
        let mut sums = ScatterAccumulator::<f32, 3>::default();
        sums.add(&SVector::from([1.0, 2.0, 3.0]));
        assert_eq!(sums.mass_lines().scatter, SMatrix::<f32, 3, 3>::zeros());
        assert_eq!(*sums.mean(), SVector::from([1.0, 2.0, 3.0]));
    }
}
