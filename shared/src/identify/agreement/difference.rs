//! Differences between methods, and which methods are off.

use heapless::Vec;
use nalgebra::SVector;

use super::{MOST_METHODS, Propagation};
use crate::real::Real;

/// Most pairs of methods.
pub const MOST_PAIRS: usize = MOST_METHODS * (MOST_METHODS - 1) / 2;
/// Probability that chance alone makes any difference of a test significant.
const CHANCE: f64 = 1e-3;
/// A difference below this share of the larger standard deviation of two methods does not matter, however well it is
/// known: it moves no interval by a noticeable part.
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

/// The largest difference of every pair, in its standard deviations.
pub(super) fn differences<R: Real, const M: usize>(
    seen: &[usize],
    answers: &[Option<SVector<R, 10>>],
    propagation: &Propagation<R, M>,
) -> Vec<Difference<R>, MOST_PAIRS> {
    let tests = 10 * seen.len() * (seen.len() - 1) / 2;
    // At least the two-sided quantile for so many tests: P(|z| > t) < exp(−t²/2).
    let limit = R::of(libm::sqrt(2.0 * libm::log(tests as f64 / CHANCE)));
    let mut pairs = Vec::new();
    for (place, &a) in seen.iter().enumerate() {
        for &b in &seen[..place] {
            let Some((first, second)) = answers[a].zip(answers[b]) else { continue };
            let variance = |k: usize, x: usize, y: usize| propagation.element([x, y], [k; 2]);
            let difference_of = |k: usize| {
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
            if let Some(most) = (0..10).map(difference_of).reduce(larger) {
                // There is room for every pair of the most methods.
                let _ = pairs.push(most);
            }
        }
    }
    pairs
}

/// The fewest methods without which no significant difference is left, where they are fewer than those that then agree,
/// and no others would do as well; empty otherwise.
pub(super) fn outliers<R: Real>(
    seen: &[usize],
    pairs: &[Difference<R>],
) -> Vec<usize, MOST_METHODS> {
    let place = |method: usize| seen.iter().position(|m| *m == method);
    let mask = |pair: &Difference<R>| {
        let bits = pair.methods.iter().filter_map(|method| place(*method));
        bits.fold(0_u32, |mask, place| mask | 1 << place)
    };
    let significant: Vec<u32, MOST_PAIRS> =
        pairs.iter().filter(|pair| pair.significant).map(mask).collect();
    let clears = |set: &u32| significant.iter().all(|pair| pair & set != 0);
    let fewest = (1..1_u32 << seen.len()).filter(clears).map(u32::count_ones).min();
    let is_minority = |count: &u32| 2 * *count < seen.len() as u32 && !significant.is_empty();
    let Some(count) = fewest.filter(is_minority) else { return Vec::new() };
    let mut sets = (1..1_u32 << seen.len()).filter(|set| set.count_ones() == count && clears(set));
    match (sets.next(), sets.next()) {
        (Some(only), None) => {
            seen.iter().enumerate().filter(|(k, _)| only >> k & 1 == 1).map(|(_, m)| *m).collect()
        }
        _ => Vec::new(),
    }
}
