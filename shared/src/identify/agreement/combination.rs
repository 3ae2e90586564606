//! The combined estimate of several methods.

use heapless::Vec;
use nalgebra::{SMatrix, SVector};

use super::difference::{Difference, MOST_PAIRS, differences, outliers};
use super::{MOST_METHODS, Propagation};
use crate::linalg::cholesky;
use crate::real::Real;

/// Two methods may give nearly the same; this much independent error, relative to their variances, keeps their weights
/// from growing without bound.
const INDEPENDENT: f64 = 1e-4;
/// Steps of the bisection for the standard deviation between methods; each halves its uncertainty.
const BISECTIONS: usize = 30;

/// The methods compared, and the best estimate of all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement<R> {
    /// The largest difference of every pair.
    pub pairs: Vec<Difference<R>, MOST_PAIRS>,
    /// The few methods without which no significant difference is left.
    pub outliers: Vec<usize, MOST_METHODS>,
    /// `theta` by generalised least squares of all methods but the outliers.
    pub theta: SVector<R, 10>,
    /// Covariance of `theta`.
    pub covariance: SMatrix<R, 10, 10>,
    /// Standard deviations between the methods that their answers have besides those of the noise, because they differ
    /// by more than chance and no few of them are off; zero when the rest agrees.
    pub between: SVector<R, 10>,
}

/// What a comparison says of the methods.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Chance explains every difference.
    Agree,
    /// A few methods are off, and chance explains the differences of the others.
    SomeOff,
    /// The methods differ by more than chance, and no few of them are off.
    Differ,
}

impl Outcome {
    /// Every outcome.
    pub const ALL: [Self; 3] = [Self::Agree, Self::SomeOff, Self::Differ];

    /// The outcome of a comparison that has found differences beyond chance, or methods that are off.
    pub fn of(is_significant: bool, is_any_off: bool) -> Self {
        match (is_any_off, is_significant) {
            (true, _) => Self::SomeOff,
            (false, true) => Self::Differ,
            (false, false) => Self::Agree,
        }
    }

    /// Its name in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Agree => "agree",
            Self::SomeOff => "some_off",
            Self::Differ => "differ",
        }
    }
}

impl<R: Real> Agreement<R> {
    /// Compares and combines these answers, of which the places are those of the propagation. `None` with fewer than
    /// two answers, or when a covariance is singular.
    pub fn of<const M: usize>(
        answers: &[Option<SVector<R, 10>>],
        propagation: &Propagation<R, M>,
    ) -> Option<Self> {
        let mut seen: Vec<usize, MOST_METHODS> = (0..answers.len().min(MOST_METHODS))
            .filter(|m| answers[*m].is_some() && propagation.unstable(*m).is_none())
            .collect();
        if seen.len() < 2 {
            return None;
        }
        let pairs = differences(&seen, answers, propagation);
        let outliers = outliers(&seen, &pairs);
        seen.retain(|m| !outliers.contains(m));
        let (theta, between) = (SVector::zeros(), SVector::zeros());
        let mut agreement = Self { pairs, outliers, theta, covariance: SMatrix::zeros(), between };
        if agreement.outcome() == Outcome::Differ {
            for k in 0..10 {
                agreement.between[k] = between_methods(&seen, k, answers, propagation)?;
            }
        }
        (agreement.theta, agreement.covariance) =
            combined(&seen, answers, propagation, &agreement.between)?;
        Some(agreement)
    }

    /// Whether the methods agree.
    pub fn outcome(&self) -> Outcome {
        let is_significant = self.pairs.iter().any(|pair| pair.significant);
        Outcome::of(is_significant, !self.outliers.is_empty())
    }

    /// The difference that contradicts chance most.
    pub fn largest(&self) -> Option<&Difference<R>> {
        let size = |difference: &Difference<R>| {
            (
                difference.significant,
                difference.difference.abs() / (difference.sigma + R::default_epsilon()),
            )
        };
        self.pairs.iter().reduce(|a, b| if size(b) > size(a) { b } else { a })
    }
}

/// Generalised least squares, property by property, with these standard deviations between the methods: `theta` and its
/// covariance.
fn combined<R: Real, const M: usize>(
    seen: &[usize],
    answers: &[Option<SVector<R, 10>>],
    propagation: &Propagation<R, M>,
    between: &SVector<R, 10>,
) -> Option<(SVector<R, 10>, SMatrix<R, 10, 10>)> {
    let count = seen.len();
    let mut weights = [[R::zero(); 10]; MOST_METHODS];
    for k in 0..10 {
        let weight = Joint::of(seen, k, propagation, between[k])?.weights()?;
        for (to, value) in weights.iter_mut().zip(weight) {
            to[k] = value;
        }
    }
    let mut theta = SVector::zeros();
    for (place, &m) in seen.iter().enumerate() {
        let answer = answers[m]?;
        for k in 0..10 {
            theta[k] += weights[place][k] * answer[k];
        }
    }
    let mut covariance = SMatrix::<R, 10, 10>::zeros();
    for (i, &a) in seen.iter().enumerate() {
        for (j, &b) in seen.iter().enumerate() {
            for k in 0..10 {
                for l in 0..10 {
                    covariance[(k, l)] +=
                        weights[i][k] * weights[j][l] * propagation.element([a, b], [k, l]);
                }
            }
        }
    }
    // The weights follow the draws, so the variance over the draws is too small and the true one larger than the
    // smallest.
    let draws = f64::from(propagation.draws());
    let widening = R::of(draws / (draws - count as f64));
    covariance *= widening * widening;
    // One cause may put several methods off by the same, so that a mean of more methods is no better.
    for k in 0..10 {
        covariance[(k, k)] += between[k] * between[k];
    }
    Some((theta, covariance))
}

/// The standard deviation between methods with which the scatter of their answers about their mean is what it should
/// be, and no method has a negative weight, so that the mean lies among the answers (Paule and Mandel 1982, for answers
/// with covariances).
fn between_methods<R: Real, const M: usize>(
    seen: &[usize],
    property: usize,
    answers: &[Option<SVector<R, 10>>],
    propagation: &Propagation<R, M>,
) -> Option<R> {
    let mut values = [R::zero(); MOST_METHODS];
    for (to, &m) in values.iter_mut().zip(seen) {
        *to = answers[m]?[property];
    }
    let values = &values[..seen.len()];
    let explains = |between: R| {
        let joint = Joint::of(seen, property, propagation, between)?;
        let weights = joint.weights()?;
        let mean = weights.iter().zip(values).fold(R::zero(), |sum, (w, v)| sum + *w * *v);
        let squares = joint.squares(values, mean)?;
        let positive = weights.iter().all(|weight| *weight >= R::zero());
        Some(positive && squares <= R::of((seen.len() - 1) as f64))
    };
    if explains(R::zero())? {
        return Some(R::zero());
    }
    let least = values.iter().fold(values[0], |least, v| least.min(*v));
    let most = values.iter().fold(values[0], |most, v| most.max(*v));
    let largest = seen
        .iter()
        .fold(most - least, |sum, &m| sum + propagation.element([m, m], [property; 2]).sqrt());
    let (mut low, mut high) = (R::zero(), largest);
    // A large enough spread explains any finite answers.
    for _ in 0..BISECTIONS {
        if explains(high)? {
            break;
        }
        high *= R::of(2.0);
    }
    if !explains(high)? {
        return None;
    }
    for _ in 0..BISECTIONS {
        let middle = (low + high) / R::of(2.0);
        if explains(middle)? { high = middle } else { low = middle }
    }
    Some(high)
}

/// The joint covariance of the answers to one property, as a factor of its correlations.
struct Joint<R> {
    count: usize,
    factor: SMatrix<R, MOST_METHODS, MOST_METHODS>,
    scales: [R; MOST_METHODS],
}

impl<R: Real> Joint<R> {
    /// With this standard deviation between the methods.
    fn of<const M: usize>(
        seen: &[usize],
        property: usize,
        propagation: &Propagation<R, M>,
        between: R,
    ) -> Option<Self> {
        // Methods that are not there are independent, with weight zero.
        let mut covariance = SMatrix::<R, MOST_METHODS, MOST_METHODS>::identity();
        let mut scales = [R::one(); MOST_METHODS];
        for (scale, &m) in scales.iter_mut().zip(seen) {
            let own = propagation.element([m, m], [property; 2]);
            *scale = (own + between * between).sqrt();
        }
        for (i, &a) in seen.iter().enumerate().take(MOST_METHODS) {
            for (j, &b) in seen.iter().enumerate().take(i) {
                let joint = propagation.element([a, b], [property; 2]);
                let correlation = joint / (scales[i] * scales[j]);
                covariance[(i, j)] = correlation;
                covariance[(j, i)] = correlation;
            }
            covariance[(i, i)] += R::of(INDEPENDENT);
        }
        Some(Self { count: seen.len(), factor: cholesky(&covariance)?, scales })
    }

    /// Weights `C⁻¹ 1/(1ᵀ C⁻¹ 1)`.
    fn weights(&self) -> Option<[R; MOST_METHODS]> {
        let whitened = self.whitened(|_| R::one())?;
        let solved = self.factor.tr_solve_lower_triangular(&whitened)?;
        let mut weights = [R::zero(); MOST_METHODS];
        let mut sum = R::zero();
        for i in 0..self.count {
            weights[i] = solved[i] / self.scales[i];
            sum += weights[i];
        }
        weights.iter_mut().for_each(|weight| *weight /= sum);
        weights.iter().all(|weight| weight.finite()).then_some(weights)
    }

    /// `(v − mean)ᵀ C⁻¹ (v − mean)`.
    fn squares(&self, values: &[R], mean: R) -> Option<R> {
        Some(self.whitened(|i| values[i] - mean)?.norm_squared())
    }

    fn whitened(&self, value: impl Fn(usize) -> R) -> Option<SVector<R, MOST_METHODS>> {
        let mut sides = SVector::<R, MOST_METHODS>::zeros();
        for i in 0..self.count {
            sides[i] = value(i) / self.scales[i];
        }
        self.factor.solve_lower_triangular(&sides)
    }
}
