//! Differences between methods, and the combined estimate.

use heapless::Vec;
use nalgebra::{SMatrix, SVector};

use super::Propagation;
use crate::Real;
use crate::identify::METHODS;
use crate::linalg::cholesky;

/// Most methods that are compared: all of them.
pub const MOST_METHODS: usize = METHODS;
/// Probability that chance alone makes any difference of a test significant.
const CHANCE: f64 = 1e-3;
/// A difference below this share of the larger standard deviation of two methods does not matter, however well it is known:
/// it moves no interval by a noticeable part.
const NOTICEABLE: f64 = 0.5;

/// The difference between two methods that contradicts chance most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Difference<R> {
    /// Places of the two methods.
    pub methods: [usize; 2],
    /// The property, in the order of `theta`.
    pub property: usize,
    /// The first minus the second, in the unit of the property.
    pub difference: R,
    /// Standard deviation of the difference.
    pub sigma: R,
    /// True when chance does not explain it.
    pub significant: bool,
}

/// The methods compared, and the best estimate of all of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement<R> {
    /// The largest difference of every pair.
    pub pairs: Vec<Difference<R>, { MOST_METHODS * (MOST_METHODS - 1) / 2 }>,
    /// The method whose removal leaves no significant difference, where one is enough.
    pub outlier: Option<usize>,
    /// `theta` by generalised least squares of all methods but the outlier.
    pub theta: SVector<R, 10>,
    /// Covariance of `theta`.
    pub covariance: SMatrix<R, 10, 10>,
    /// Standard deviations between the methods that were added, because they differ by more than chance; zero when
    /// they agree.
    pub between: SVector<R, 10>,
}

impl<R: Real> Agreement<R> {
    /// Compares and combines these answers, of which the places are those of the propagation. `None` with fewer than two
    /// answers, or when a covariance is singular.
    pub fn of<const M: usize>(
        answers: &[Option<SVector<R, 10>>; M],
        propagation: &Propagation<R, M>,
    ) -> Option<Self> {
        let mut seen: Vec<usize, M> = (0..M)
            .filter(|m| answers[*m].is_some() && propagation.unstable(*m).is_none())
            .collect();
        if seen.len() < 2 {
            return None;
        }
        let pairs = differences(&seen, answers, propagation);
        let outlier = outlier(&seen, &pairs);
        let disagree = pairs.iter().any(|pair| pair.significant);
        if let Some(outlier) = outlier {
            seen.retain(|m| *m != outlier);
        }
        let (theta, mut covariance) = combined(&seen, answers, propagation)?;
        let mut between = SVector::zeros();
        if disagree && outlier.is_none() {
            between = spread(&seen, answers, &theta);
            for k in 0..10 {
                covariance[(k, k)] += between[k] * between[k];
            }
        }
        Some(Self { pairs, outlier, theta, covariance, between })
    }

    /// True when chance explains every difference.
    pub fn agrees(&self) -> bool {
        !self.pairs.iter().any(|pair| pair.significant)
    }
}

/// The largest difference of every pair, in its standard deviations.
fn differences<R: Real, const M: usize>(
    seen: &[usize],
    answers: &[Option<SVector<R, 10>>; M],
    propagation: &Propagation<R, M>,
) -> Vec<Difference<R>, { MOST_METHODS * (MOST_METHODS - 1) / 2 }> {
    let tests = 10 * seen.len() * (seen.len() - 1) / 2;
    // At least the two-sided quantile for so many tests: P(|z| > t) < exp(−t²/2).
    let limit = R::of(libm::sqrt(2.0 * libm::log(tests as f64 / CHANCE)));
    let mut pairs = Vec::new();
    for (place, &a) in seen.iter().enumerate() {
        for &b in &seen[..place] {
            let Some((first, second)) = answers[a].zip(answers[b]) else { continue };
            let variance = |k: usize, x: usize, y: usize| propagation.covariance(x, y)[(k, k)];
            let of = |k: usize| {
                let (of_a, of_b) = (variance(k, a, a), variance(k, b, b));
                let variance = of_a + of_b - variance(k, a, b) - variance(k, b, a);
                let sigma = variance.max(R::zero()).sqrt();
                let difference = first[k] - second[k];
                let noticeable = of_a.max(of_b).sqrt() * R::of(NOTICEABLE);
                let significant = difference.abs() > sigma * limit && difference.abs() > noticeable;
                Difference { methods: [a, b], property: k, difference, sigma, significant }
            };
            // Significant ones first, then by their size in standard deviations.
            let size = |d: &Difference<R>| d.difference.abs() / (d.sigma + R::default_epsilon());
            let larger = |x: Difference<R>, y: Difference<R>| {
                let order = (y.significant, size(&y)) > (x.significant, size(&x));
                if order { y } else { x }
            };
            if let Some(most) = (0..10).map(of).reduce(larger) {
                // There is room for every pair of the most methods.
                let _ = pairs.push(most);
            }
        }
    }
    pairs
}

/// The method that is in every significant pair; `None` when there is none, more than one, or only two methods.
fn outlier<R: Real>(seen: &[usize], pairs: &[Difference<R>]) -> Option<usize> {
    if seen.len() < 3 {
        return None;
    }
    let significant = || pairs.iter().filter(|pair| pair.significant);
    significant().next()?;
    let mut in_all = seen.iter().filter(|m| significant().all(|pair| pair.methods.contains(m)));
    match (in_all.next(), in_all.next()) {
        (Some(only), None) => Some(*only),
        _ => None,
    }
}

/// Generalised least squares, property by property: `theta` and its covariance.
fn combined<R: Real, const M: usize>(
    seen: &[usize],
    answers: &[Option<SVector<R, 10>>; M],
    propagation: &Propagation<R, M>,
) -> Option<(SVector<R, 10>, SMatrix<R, 10, 10>)> {
    let count = seen.len();
    let mut weights = [[R::zero(); 10]; MOST_METHODS];
    for k in 0..10 {
        let weight = weights_of_property(seen, k, propagation)?;
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
            let of_pair = propagation.covariance(a, b);
            for k in 0..10 {
                for l in 0..10 {
                    covariance[(k, l)] += weights[i][k] * weights[j][l] * of_pair[(k, l)];
                }
            }
        }
    }
    // The weights follow the draws, so the variance over the draws is too small and the true one larger than the smallest.
    let draws = f64::from(propagation.draws());
    let widening = R::of(draws / (draws - count as f64));
    Some((theta, covariance * (widening * widening)))
}

/// Weights `C⁻¹ 1/(1ᵀ C⁻¹ 1)` of one property.
fn weights_of_property<R: Real, const M: usize>(
    seen: &[usize],
    property: usize,
    propagation: &Propagation<R, M>,
) -> Option<[R; MOST_METHODS]> {
    // Methods that are not there are independent, with weight zero.
    let mut covariance = SMatrix::<R, MOST_METHODS, MOST_METHODS>::identity();
    let scale = |m: usize| propagation.covariance(m, m)[(property, property)].sqrt();
    for (i, &a) in seen.iter().enumerate().take(MOST_METHODS) {
        for (j, &b) in seen.iter().enumerate().take(i + 1) {
            let joint = propagation.covariance(a, b)[(property, property)];
            let correlation = joint / (scale(a) * scale(b));
            covariance[(i, j)] = correlation;
            covariance[(j, i)] = correlation;
        }
    }
    // Two methods may give nearly the same; this much independent error keeps their weights from growing without bound.
    for i in 0..seen.len().min(MOST_METHODS) {
        covariance[(i, i)] += R::of(1e-4);
    }
    let factor = cholesky(&covariance)?;
    let mut sides = SVector::<R, MOST_METHODS>::zeros();
    for (i, &m) in seen.iter().enumerate().take(MOST_METHODS) {
        sides[i] = scale(m).recip();
    }
    let whitened = factor.solve_lower_triangular(&sides)?;
    let solved = factor.tr_solve_lower_triangular(&whitened)?;
    let mut weights = [R::zero(); MOST_METHODS];
    let mut sum = R::zero();
    for (i, &m) in seen.iter().enumerate().take(MOST_METHODS) {
        weights[i] = solved[i] / scale(m);
        sum += weights[i];
    }
    weights.iter_mut().for_each(|weight| *weight /= sum);
    weights.iter().all(|weight| weight.finite()).then_some(weights)
}

/// Root mean square distance of the answers from the combined one.
fn spread<R: Real, const M: usize>(
    seen: &[usize],
    answers: &[Option<SVector<R, 10>>; M],
    theta: &SVector<R, 10>,
) -> SVector<R, 10> {
    let mut sum = SVector::<R, 10>::zeros();
    for answer in seen.iter().filter_map(|m| answers[*m]) {
        let distance = answer - theta;
        sum += distance.component_mul(&distance);
    }
    let count = R::of(seen.len().max(1) as f64);
    sum.map(|v| (v / count).sqrt())
}
