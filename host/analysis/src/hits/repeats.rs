//! Checks whether the hits of a recording agree. They are compared as a rig compares the hits of a DOF
//! ([`RepeatHits`]), but in the order of their distance from the middle of all hits instead of in time order,
//! so that bad hits come last wherever they are in the recording.
//!
//! The middle is the median of every element. A few bad hits do not shift it as they shift a mean.

use massline_shared::signal::{HitAgreement, KnownScatter, RepeatHits};

/// Hits as vectors of the responses per force, all of one length.
pub(super) struct Repeats {
    hits: Vec<Vec<f64>>,
    /// The hits that agree, in the order of their distance from the middle.
    agreeing: Vec<usize>,
    /// The sum of their vectors.
    sum: Vec<f64>,
    /// The sum of the squares of their lengths.
    squares: f64,
}

impl Repeats {
    /// Compares these hits. If there are any, at least one counts as agreeing.
    pub(super) fn new(hits: Vec<Vec<f64>>) -> Self {
        let order = by_distance_from_the_middle(&hits);
        let sum = vec![0.0; hits.first().map_or(0, Vec::len)];
        let mut repeats = Self { hits, agreeing: Vec::new(), sum, squares: 0.0 };
        for &hit in &order {
            if repeats.beside_the_others(hit).standing() == HitAgreement::Agrees {
                repeats.join(hit);
            }
        }
        // If no two hits agree, the data do not determine which of them is right.
        if repeats.agreeing.len() == 1 {
            order.into_iter().skip(1).for_each(|hit| repeats.join(hit));
        }
        repeats
    }

    /// The hits that agree, at most `wanted` of them, those closest to the middle first.
    pub(super) fn best(&self, wanted: usize) -> &[usize] {
        &self.agreeing[..wanted.min(self.agreeing.len())]
    }

    /// Compares a hit with those that agree, excluding itself.
    pub(super) fn beside_the_others(&self, hit: usize) -> RepeatHits<f64> {
        let Some(own) = self.hits.get(hit) else {
            return RepeatHits {
                others: 0,
                mean_squared: 0.0,
                scatter_squared: 0.0,
                distance_squared: 0.0,
                elsewhere: KnownScatter::none(),
            };
        };
        let among = self.agreeing.contains(&hit);
        let others = self.agreeing.len() - usize::from(among);
        let part = if among { 1.0 } else { 0.0 };
        let (mut mean_squared, mut distance_squared) = (0.0, 0.0);
        for (own, sum) in own.iter().zip(&self.sum) {
            let mean = (sum - part * own) / others.max(1) as f64;
            mean_squared += mean * mean;
            distance_squared += (own - mean) * (own - mean);
        }
        let squares = self.squares - part * square(own);
        RepeatHits {
            others: u32::try_from(others).unwrap_or(u32::MAX),
            mean_squared,
            // Rounding may make the difference negative.
            scatter_squared: (squares - others as f64 * mean_squared).max(0.0),
            distance_squared,
            elsewhere: KnownScatter::none(),
        }
    }

    fn join(&mut self, hit: usize) {
        let Some(own) = self.hits.get(hit) else { return };
        self.sum.iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        self.squares += square(own);
        self.agreeing.push(hit);
    }
}

fn square(vector: &[f64]) -> f64 {
    vector.iter().map(|v| v * v).sum()
}

/// The hits in the order of their distance from the median of every element; equally distant hits stay in
/// their order.
fn by_distance_from_the_middle(hits: &[Vec<f64>]) -> Vec<usize> {
    let length = hits.iter().map(Vec::len).min().unwrap_or(0);
    let middle: Vec<f64> =
        (0..length).map(|k| median(hits.iter().map(|hit| hit[k]).collect())).collect();
    let distance = |hit: &[f64]| {
        hit.iter().zip(&middle).map(|(own, middle)| (own - middle) * (own - middle)).sum::<f64>()
    };
    let distances: Vec<f64> = hits.iter().map(|hit| distance(hit)).collect();
    let mut order: Vec<usize> = (0..hits.len()).collect();
    order.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]));
    order
}

/// The median: the middle value, or the mean of the two middle values; zero of an empty list.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    let even = values.len().is_multiple_of(2);
    if values.is_empty() {
        return 0.0;
    }
    let (below, &mut upper, _) = values.select_nth_unstable_by(middle, f64::total_cmp);
    let lower = if even { below.iter().copied().fold(f64::NEG_INFINITY, f64::max) } else { upper };
    (upper + lower) * 0.5
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hits of length about one that differ by these numbers.
    fn with(offsets: &[f64]) -> Repeats {
        Repeats::new(offsets.iter().map(|&offset| vec![1.0, offset]).collect())
    }

    /// The hits that agree, in the order of the recording.
    fn agreeing(repeats: &Repeats) -> Vec<usize> {
        let mut hits = repeats.best(usize::MAX).to_vec();
        hits.sort_unstable();
        hits
    }

    #[test]
    fn a_median_is_the_middle_or_between_the_two_middle_ones() {
        assert_eq!(median(vec![]), 0.0);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
        assert_eq!(median(vec![4.0, 1.0, 2.0, 8.0]), 3.0);
    }

    #[test]
    fn one_bad_hit_is_far_and_the_good_ones_are_not() {
        let repeats = with(&[0.0, 0.02, 0.9, 0.04, 0.01]);
        assert_eq!(agreeing(&repeats), [0, 1, 3, 4]);
        let distance = |hit| repeats.beside_the_others(hit).distance().unwrap();
        assert!(distance(2) > 0.8);
        assert!([0, 1, 3, 4].iter().all(|&hit| distance(hit) < 0.05));
        assert!(matches!(repeats.beside_the_others(2).standing(), HitAgreement::Elsewhere(_)));
    }

    #[test]
    fn two_bad_hits_of_five_do_not_hide_behind_each_other() {
        for bad in [[0.5, 0.5], [0.5, -0.5], [0.9, 0.4]] {
            let repeats = with(&[bad[0], 0.0, 0.02, bad[1], 0.01]);
            assert_eq!(agreeing(&repeats), [1, 2, 4], "{bad:?}");
        }
    }

    #[test]
    fn more_hits_than_wanted_leave_the_closest_ones() {
        let repeats = with(&[0.0, 0.05, 0.01, 0.11, 0.02]);
        let mut best = repeats.best(3).to_vec();
        best.sort_unstable();
        assert_eq!(best, [0, 2, 4]);
        assert_eq!(agreeing(&repeats).len(), 5);
        assert!(with(&[]).best(3).is_empty());
    }

    #[test]
    fn hits_that_scatter_much_are_told_from_one_that_does_not_belong() {
        assert_eq!(agreeing(&with(&[0.0, 0.1, 0.2, 0.15, 0.9])), [0, 1, 2, 3]);
    }

    #[test]
    fn of_two_that_disagree_both_are_named_and_one_alone_is_not() {
        let repeats = with(&[0.0, 1.5]);
        for hit in [0, 1] {
            let standing = repeats.beside_the_others(hit).standing();
            assert!(matches!(standing, HitAgreement::Inconsistent(_)), "{standing:?}");
        }
        assert_eq!(agreeing(&repeats), [0, 1]);
        let alone = with(&[0.3]).beside_the_others(0);
        assert_eq!((alone.distance(), alone.standing()), (None, HitAgreement::Agrees));
    }

    #[test]
    fn a_bad_hit_after_a_hundred_good_ones_is_left_out() {
        let mut offsets: Vec<f64> = (0..100).map(|k| 1e-3 * f64::from(k)).collect();
        offsets.push(0.9);
        assert_eq!(agreeing(&with(&offsets)), (0..100).collect::<Vec<_>>());
    }

    #[test]
    fn a_hit_from_the_other_side_is_found_among_three() {
        let good = vec![1.0, 2.0];
        let turned = good.iter().map(|v| -v).collect();
        let repeats = Repeats::new(vec![good.clone(), turned, good]);
        assert_eq!(agreeing(&repeats), [0, 2]);
        assert_eq!(repeats.beside_the_others(1).distance(), Some(2.0));
    }
}
