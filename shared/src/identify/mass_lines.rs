//! The measured input of an identification: the mass lines of one hit DOF with their scatter.

use core::ops::Index;

use nalgebra::SMatrix;

use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::layout::Layout;
use crate::linalg::{lower_places, triangle};
use crate::real::Real;
use crate::responses::{ResponseSquare, Responses};

/// Mass line accelerances of one hit DOF, response by response.
#[derive(Clone, Debug, PartialEq)]
pub struct MassLines<R: Real, C: Capacity> {
    /// Accelerance A of every response, averaged over the hits, (m/s²)/N; zero beyond the last.
    pub accelerance: Responses<R, C>,
    /// Standard deviation of each averaged accelerance due to the noise of the bins about the fit,
    /// corrected by [`window_correlation`](crate::mass_line::window_correlation), (m/s²)/N. It does not
    /// include placement errors, which change all lines together. Zero when unknown.
    pub noise: Responses<R, C>,
    /// Sample covariance of the single hits' accelerances, ((m/s²)/N)².
    pub scatter: ResponseSquare<R, C>,
    /// Number of hits averaged.
    pub hits: u16,
    /// How the single hits' accelerances change with their force.
    pub trend: ForceTrend<R, C>,
    /// Change of every accelerance when the ends of the band are left out, (m/s²)/N; zero for plateaus.
    pub band_shift: Responses<R, C>,
}

/// Sums over the repeat hits of one DOF about their means: the regression of the accelerances on the squared force.
/// Those of a linear chain do not depend on the force.
///
/// What counts as the force of a hit is what its loudest response shows: elastic modes that a short contact excites
/// make that response larger during the contact than the force alone would.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceTrend<R: Real, C: Capacity> {
    /// Mean squared force, N².
    pub mean: R,
    /// Sum of the squared deviations of the squared force, N⁴; zero when unknown.
    pub squares: R,
    /// Sum of the products of both deviations for every response, (m/s²) N.
    pub products: Responses<R, C>,
}

/// The mass lines of a hit DOF with its index in the layout.
pub type DofMassLines<R, C> = (usize, MassLines<R, C>);

impl<R: Real, C: Capacity> ForceTrend<R, C> {
    /// The trend of hits whose forces are unknown, for this many sensors.
    pub fn unknown(sensors: usize) -> Self {
        Self { mean: R::zero(), squares: R::zero(), products: Responses::zeros(sensors) }
    }
}

impl<R: Real, C: Capacity> MassLines<R, C> {
    /// Mass lines from accelerances of unknown noise and scatter.
    pub fn without_scatter(accelerance: Responses<R, C>) -> Self {
        let sensors = accelerance.sensors();
        Self {
            accelerance,
            noise: Responses::zeros(sensors),
            scatter: ResponseSquare::zeros(sensors),
            hits: 1,
            trend: ForceTrend::unknown(sensors),
            band_shift: Responses::zeros(sensors),
        }
    }

    /// The same with these standard deviations of the noise.
    pub fn with_noise(self, noise: Responses<R, C>) -> Self {
        Self { noise, ..self }
    }

    /// The same in another precision.
    pub fn cast<Q: Real>(&self) -> MassLines<Q, C> {
        let to = |v: R| Q::of(v.to_f64());
        MassLines {
            accelerance: self.accelerance.map(to),
            noise: self.noise.map(to),
            scatter: self.scatter.map(to),
            hits: self.hits,
            trend: ForceTrend {
                mean: to(self.trend.mean),
                squares: to(self.trend.squares),
                products: self.trend.products.map(to),
            },
            band_shift: self.band_shift.map(to),
        }
    }

    /// The same in another capacity, for this many sensors; readings of sensors beyond them are left out.
    pub fn resized<D: Capacity>(&self, sensors: usize) -> MassLines<R, D> {
        let resized = |readings: &Responses<R, C>| {
            let readings = readings.as_slice();
            Responses::from_fn(sensors, |k| readings.get(k).copied().unwrap_or_else(R::zero))
        };
        MassLines {
            accelerance: resized(&self.accelerance),
            noise: resized(&self.noise),
            scatter: ResponseSquare::from_fn(sensors, |i, j| {
                if i.max(j) < self.scatter.rows() { self.scatter[(i, j)] } else { R::zero() }
            }),
            hits: self.hits,
            trend: ForceTrend {
                mean: self.trend.mean,
                squares: self.trend.squares,
                products: resized(&self.trend.products),
            },
            band_shift: resized(&self.band_shift),
        }
    }

    /// True when all numbers are those of this many sensors.
    fn have_sensors(&self, sensors: usize) -> bool {
        let Self { accelerance, noise, scatter, trend, band_shift, .. } = self;
        let parts = [accelerance, noise, &trend.products, band_shift];
        parts.iter().all(|responses| responses.sensors() == sensors)
            && scatter.rows() == 3 * sensors
    }

    /// Converts stored numbers: one accelerance and one standard deviation of its noise for each response,
    /// and the lower triangle of the scatter row by row. Noise and scatter are empty when unknown. `None`
    /// when the lengths do not match.
    pub fn from_parts(accelerance: &[R], noise: &[R], lower: &[R], hits: u16) -> Option<Self> {
        let count = accelerance.len();
        let fits = |length, whole| length == 0 || length == whole;
        let mut lines = Self::without_scatter(Responses::zeros(count.div_ceil(3)));
        let room = lines.accelerance.as_slice().len();
        if count > room || !fits(noise.len(), count) || !fits(lower.len(), triangle(count)) {
            return None;
        }
        lines.hits = hits;
        lines.accelerance.as_mut_slice()[..count].copy_from_slice(accelerance);
        lines.noise.as_mut_slice()[..noise.len()].copy_from_slice(noise);
        for ((i, j), value) in lower_places().zip(lower) {
            lines.scatter[(i, j)] = *value;
            lines.scatter[(j, i)] = *value;
        }
        Some(lines)
    }
}

/// Mean and sample covariance of the single hits' mass lines, updated hit by hit (Welford 1962).
///
/// ```
/// # use massline_shared::capacity::Fixed;
/// # use massline_shared::identify::ScatterAccumulator;
/// # use massline_shared::responses::Responses;
/// let mut hits = ScatterAccumulator::<f64, Fixed<1, 1>>::new(1);
/// for x in [0.9, 1.0, 1.1] {
///     hits.add(&Responses::from([[x, 2.0 * x, 0.0]]), Some(400.0));
/// }
/// let lines = hits.mass_lines();
/// assert!((lines.accelerance[1] - 2.0).abs() < 1e-12);
/// // The sample variance of x is 0.01, and y varies with it by twice as much.
/// assert!((lines.scatter[(0, 0)] - 0.01).abs() < 1e-12);
/// assert!((lines.scatter[(1, 0)] - 0.02).abs() < 1e-12);
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ScatterAccumulator<R: Real, C: Capacity> {
    mean: Responses<R, C>,
    /// Sum of the outer products of the deviations; both triangles.
    outer: ResponseSquare<R, C>,
    hits: u16,
    trend: ForceTrend<R, C>,
    /// Hits of known force. A number, because with a flag here an empty `Option` is not all zeros, and a rig's static
    /// memory would have to be copied from its flash.
    forces: u16,
}

impl<R: Real, C: Capacity> ScatterAccumulator<R, C> {
    /// An accumulator without hits, for this many sensors.
    pub fn new(sensors: usize) -> Self {
        Self {
            mean: Responses::zeros(sensors),
            outer: ResponseSquare::zeros(sensors),
            hits: 0,
            trend: ForceTrend::unknown(sensors),
            forces: 0,
        }
    }

    /// Adds the mass lines of one hit of this squared force, N²; a hit of unknown force shows no trend.
    pub fn add(&mut self, accelerance: &Responses<R, C>, squared_force: Option<R>) {
        self.hits = self.hits.saturating_add(1);
        let share = R::of(f64::from(self.hits)).recip();
        let before = accelerance - &self.mean;
        self.mean.add_multiple(&before, share);
        let after = accelerance - &self.mean;
        self.add_force(&after, squared_force);
        let rows = self.outer.rows();
        for j in 0..rows {
            for i in j..rows {
                let product = before[i] * after[j];
                self.outer[(i, j)] += product;
                if i > j {
                    self.outer[(j, i)] += product;
                }
            }
        }
    }

    /// Removes a hit that was added with these mass lines. `squared_force` computes the squared force that was added,
    /// given the other hits. The sums differ by rounding from those without the hit.
    ///
    /// If the force of any of the hits was unknown, the others stay without a trend.
    pub fn remove(
        &mut self,
        accelerance: &Responses<R, C>,
        squared_force: impl FnOnce(&Self) -> Option<R>,
    ) {
        let known = self.forces == self.hits;
        self.hits = self.hits.saturating_sub(1);
        let sensors = self.mean.sensors();
        if self.hits == 0 {
            *self = Self::new(sensors);
            return;
        }
        let left = R::of(f64::from(self.hits)).recip();
        let after = accelerance - &self.mean;
        self.mean.add_multiple(&after, -left);
        let before = &self.mean - accelerance;
        self.outer.add_outer(&before, &after);
        for i in 0..self.outer.rows() {
            self.outer[(i, i)] = self.outer[(i, i)].max(R::zero());
        }
        match squared_force(self).filter(|_| known) {
            Some(squared) => {
                self.forces = self.hits;
                let stronger = squared - self.trend.mean;
                self.trend.mean -= stronger * left;
                let squares = stronger * (squared - self.trend.mean);
                self.trend.squares = (self.trend.squares - squares).max(R::zero());
                self.trend.products.add_multiple(&after, self.trend.mean - squared);
            }
            None => {
                self.forces = self.forces.min(self.hits - 1);
                self.trend = ForceTrend::unknown(self.mean.sensors());
            }
        }
        if self.hits == 1 {
            // A single hit does not differ from itself.
            self.outer = ResponseSquare::zeros(sensors);
            self.trend = ForceTrend { mean: self.trend.mean, ..ForceTrend::unknown(sensors) };
        }
    }

    /// Adds the squared force of a hit, whose accelerances lie `after` from their new mean. A single hit of unknown
    /// force leaves all of them without a trend.
    fn add_force(&mut self, after: &Responses<R, C>, squared_force: Option<R>) {
        self.forces = self.forces.saturating_add(squared_force.is_some().into());
        let Some(squared) = squared_force.filter(|_| self.forces == self.hits) else {
            self.trend = ForceTrend::unknown(self.mean.sensors());
            return;
        };
        let share = R::of(f64::from(self.hits)).recip();
        let stronger = squared - self.trend.mean;
        self.trend.mean += stronger * share;
        // After this hit the mean lies `stronger * share` higher.
        self.trend.squares += stronger * (stronger - stronger * share);
        self.trend.products.add_multiple(after, stronger);
    }

    /// How the accelerances change with the force.
    pub fn trend(&self) -> &ForceTrend<R, C> {
        &self.trend
    }

    /// Number of hits added.
    pub fn hits(&self) -> u16 {
        self.hits
    }

    /// Mean of the single hits' mass lines.
    pub fn mean(&self) -> &Responses<R, C> {
        &self.mean
    }

    /// Sum of the squares of the distances of the single hits' mass lines from their mean.
    pub fn scatter_squared(&self) -> R {
        self.outer.trace()
    }

    /// Sample covariance, zero with fewer than two hits.
    pub fn covariance(&self) -> ResponseSquare<R, C> {
        let degrees_of_freedom = R::of(f64::from(self.hits.max(2) - 1));
        self.outer.map(|v| v / degrees_of_freedom)
    }

    /// Mass lines whose accelerance is the mean of the single hits, with unknown noise.
    pub fn mass_lines(&self) -> MassLines<R, C> {
        self.mass_lines_at(self.mean.clone())
    }

    /// Mass lines whose accelerance comes from averaged spectra, with unknown noise.
    pub fn mass_lines_at(&self, accelerance: Responses<R, C>) -> MassLines<R, C> {
        let (scatter, hits, trend) = (self.covariance(), self.hits, self.trend.clone());
        MassLines { scatter, hits, trend, ..MassLines::without_scatter(accelerance) }
    }
}

/// Iterates over DOFs without copying them.
pub(crate) fn by_reference<R: Real, C: Capacity>(
    dofs: &[DofMassLines<R, C>],
) -> impl Iterator<Item = (usize, &MassLines<R, C>)> + Clone {
    dofs.iter().map(|(index, lines)| (*index, lines))
}

/// Errors for every DOF that the layout does not have, for numbers of other sensors than the layout has, and for
/// numbers that are not finite.
pub(crate) fn check_mass_lines<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
) -> Result<(), Diagnostics> {
    let mut diagnostics = Diagnostics::new();
    for (index, lines) in dofs {
        let trend = &lines.trend;
        let finite = lines.accelerance.is_finite()
            && lines.scatter.is_finite()
            && lines.noise.is_finite()
            && lines.band_shift.is_finite()
            && trend.products.is_finite()
            && trend.mean.finite()
            && trend.squares.finite();
        let expected = Responses::<R, C>::zeros(layout.sensors.len()).sensors();
        let code = if layout.hits.get(*index).is_none() {
            Code::HitNotInLayout
        } else if !lines.have_sensors(expected) {
            Code::FrfMissing
        } else if !finite {
            Code::DataNotFinite
        } else {
            continue;
        };
        // There is room for sixteen diagnostics; any others are dropped.
        let _ =
            diagnostics.push(Diagnostic::about(code, Severity::Error, Subject::hit(*index), 0.0));
    }
    if diagnostics.is_empty() { Ok(()) } else { Err(diagnostics) }
}

/// Lower triangle of the first `count` rows of a symmetric matrix, row by row, for storage.
pub fn lower_triangle<R: Real>(
    matrix: &impl Index<(usize, usize), Output = R>,
    count: usize,
) -> impl Iterator<Item = R> {
    lower_places().take(triangle(count)).map(|place| matrix[place])
}

/// The symmetric matrix of a stored lower triangle; `None` unless the length is exact.
pub fn symmetric<R: Real, const N: usize>(lower: &[R]) -> Option<SMatrix<R, N, N>> {
    if lower.len() != triangle(N) {
        return None;
    }
    let mut matrix = SMatrix::<R, N, N>::zeros();
    for ((i, j), value) in lower_places().zip(lower) {
        matrix[(i, j)] = *value;
        matrix[(j, i)] = *value;
    }
    Some(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::{Fixed, Rig};
    use proptest::prelude::*;

    type Two = Fixed<2, 1>;

    fn responses(values: &[f64; 6]) -> Responses<f64, Two> {
        Responses::from_fn(2, |k| values[k])
    }

    proptest! {
        #[test]
        fn the_scatter_is_the_sample_covariance(
            hits in prop::collection::vec(prop::array::uniform6(-2.0..2.0_f64), 2..12),
        ) {
            let mut sums = ScatterAccumulator::<f64, Two>::new(2);
            for hit in hits.iter() {
                sums.add(&responses(hit), Some(400.0));
            }
            let n = hits.len() as f64;
            let mut mean = Responses::zeros(2);
            hits.iter().for_each(|hit| mean.add_multiple(&responses(hit), 1.0 / n));
            let mut expected = ResponseSquare::<f64, Two>::zeros(2);
            for hit in hits.iter() {
                let d = &responses(hit) - &mean;
                expected.add_outer(&d, &(&d / (n - 1.0)));
            }
            // Rounding only.
            prop_assert!((sums.mean() - &mean).norm() < 1e-14);
            let pairs = sums.covariance();
            let mut pairs = pairs.as_slice().iter().zip(expected.as_slice());
            prop_assert!(pairs.all(|(a, b)| (a - b).abs() < 1e-13));
            prop_assert_eq!(usize::from(sums.mass_lines().hits), hits.len());
        }

        #[test]
        fn a_hit_is_removed_again(
            hits in prop::collection::vec(prop::array::uniform6(-2.0..2.0_f64), 0..12),
            (last, force) in (prop::array::uniform6(-2.0..2.0_f64), prop::option::of(1.0..9.0_f64)),
        ) {
            let mut sums = ScatterAccumulator::<f64, Two>::new(2);
            hits.iter().for_each(|hit| sums.add(&responses(hit), Some(4.0 + hit[0])));
            let before = sums.clone();
            sums.add(&responses(&last), force);
            sums.remove(&responses(&last), |_| force);
            prop_assert_eq!(sums.hits, before.hits);
            // Rounding only, of twelve products below a hundred.
            prop_assert!((&sums.mean - &before.mean).largest() < 1e-12);
            let pairs = sums.outer.as_slice().iter().zip(before.outer.as_slice());
            prop_assert!(pairs.into_iter().all(|(one, other)| (one - other).abs() < 1e-12));
            if force.is_none() && !hits.is_empty() {
                prop_assert_eq!(sums.trend(), &ForceTrend::unknown(2));
                sums.add(&responses(&last), Some(4.0));
                prop_assert_eq!(sums.trend(), &ForceTrend::unknown(2), "a force is still missing");
            } else {
                prop_assert_eq!(sums.forces, before.forces);
                let [one, other] = [&sums, &before].map(ScatterAccumulator::trend);
                prop_assert!((one.mean - other.mean).abs() < 1e-12);
                prop_assert!((one.squares - other.squares).abs() < 1e-11);
                prop_assert!((&one.products - &other.products).largest() < 1e-11);
            }
        }
    }

    #[test]
    fn stored_mass_lines_read_back() {
        let mut sums = ScatterAccumulator::<f32, Rig>::new(3);
        for k in 0..4 {
            sums.add(&Responses::from_fn(3, |r| if r < 6 { (r * k) as f32 } else { 0.0 }), None);
        }
        let noise = Responses::from_fn(3, |r| if r < 6 { 0.1 + r as f32 } else { 0.0 });
        let lines = sums.mass_lines().with_noise(noise);
        let lower: std::vec::Vec<_> = lower_triangle(&lines.scatter, 6).collect();
        let accelerance = &lines.accelerance.as_slice()[..6];
        let noise = &lines.noise.as_slice()[..6];
        assert_eq!(MassLines::from_parts(accelerance, noise, &lower, 4), Some(lines.clone()));
        assert_eq!(MassLines::<f32, Rig>::from_parts(accelerance, noise, &lower[1..], 4), None);
        assert_eq!(MassLines::<f32, Rig>::from_parts(accelerance, &noise[1..], &lower, 4), None);
        assert_eq!(MassLines::<f32, Fixed<1, 1>>::from_parts(accelerance, noise, &[], 4), None);
        let whole: std::vec::Vec<_> = lower_triangle(&lines.scatter, 9).collect();
        let read: SMatrix<f32, 9, 9> = symmetric(&whole).unwrap();
        assert!(read.iter().eq(lines.scatter.as_slice()));
        assert_eq!(symmetric::<f32, 9>(&lower), None);
    }

    #[test]
    fn readings_keep_their_place_in_more_room_and_in_less() {
        let mut sums = ScatterAccumulator::<f64, Two>::new(2);
        for k in 0..3 {
            sums.add(&Responses::from_fn(2, |r| (r * k) as f64), Some(400.0));
        }
        let lines = sums.mass_lines().with_noise(Responses::repeat(2, 0.5));
        let wide = lines.resized::<Fixed<4, 1>>(4);
        assert_eq!(wide.accelerance.as_slice()[..6], *lines.accelerance.as_slice());
        assert!(wide.accelerance.as_slice()[6..].iter().all(|&v| v == 0.0));
        assert_eq!((wide.scatter[(5, 4)], wide.scatter[(6, 5)]), (lines.scatter[(5, 4)], 0.0));
        assert_eq!(wide.resized::<Two>(2), lines);
        assert_eq!(wide.resized::<Fixed<1, 1>>(1).noise.as_slice(), [0.5; 3]);
    }

    #[test]
    fn the_scatter_is_a_sum_of_squares() {
        let mut sums = ScatterAccumulator::<f64, Fixed<1, 1>>::new(1);
        sums.add(&Responses::from([[3.0, 3.9, 0.0]]), Some(400.0));
        sums.add(&Responses::from([[3.0, 4.1, 0.0]]), Some(400.0));
        // Two hits, each 0.1 from their mean.
        assert!((sums.scatter_squared() - 0.02).abs() < 1e-15);
    }

    #[test]
    fn the_trend_is_the_regression_on_the_squared_force() {
        let mut sums = ScatterAccumulator::<f64, Fixed<1, 1>>::new(1);
        for force in [14.0_f64, 17.0, 18.0, 22.0] {
            sums.add(
                &Responses::from([[0.8, 0.9 - 1e-4 * force * force, 0.0]]),
                Some(force * force),
            );
        }
        let ForceTrend { mean, squares, products } = sums.trend();
        // Rounding only.
        assert!((mean - (196.0 + 289.0 + 324.0 + 484.0) / 4.0).abs() < 1e-10);
        assert!((products[1] / squares + 1e-4).abs() < 1e-15 && products[0].abs() < 1e-9);
    }

    #[test]
    fn one_hit_has_no_scatter() {
        let mut sums = ScatterAccumulator::<f32, Fixed<1, 1>>::new(1);
        sums.add(&Responses::from([[1.0, 2.0, 3.0]]), Some(400.0));
        assert!(sums.mass_lines().scatter.is_zero());
        assert_eq!(*sums.mean(), Responses::from([[1.0, 2.0, 3.0]]));
    }

    #[test]
    fn a_hit_of_unknown_force_leaves_no_trend() {
        let hits = [[1.0; 6], [1.1; 6], [1.3; 6]].map(|hit| responses(&hit));
        let trend = |forces: [Option<f64>; 3]| {
            let mut sums = ScatterAccumulator::<f64, Two>::new(2);
            hits.iter().zip(forces).for_each(|(hit, force)| sums.add(hit, force));
            sums.trend().clone()
        };
        let known = trend([Some(300.0), Some(400.0), Some(500.0)]);
        // Deviations of −100, 0 and 100 N².
        assert!((known.mean - 400.0).abs() < 1e-9 && (known.squares - 2e4).abs() < 1e-6);
        assert!((known.products[0] - 30.0).abs() < 1e-9, "{known:?}");
        for unknown in 0..3 {
            let mut forces = [Some(300.0), Some(400.0), Some(500.0)];
            forces[unknown] = None;
            assert_eq!(trend(forces), ForceTrend::unknown(2), "{unknown}");
        }
    }
}
