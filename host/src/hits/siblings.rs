//! Do the hits of a recording agree? Each is compared with all others; the best consistent ones are
//! kept.
//!
//! The statistic of a hit is the *median* of its relative distances to the others: one bad hit among
//! four does not make the good ones look bad, as it would with a mean.

use massline_shared::signal::inconsistent_from;

/// The relative distances of all pairs of hits.
pub(super) struct Distances {
    count: usize,
    /// Row by row; the diagonal is not used.
    values: Vec<f64>,
}

impl Distances {
    /// Of `count` hits, from the distance of a pair.
    pub(super) fn new(count: usize, between: impl Fn(usize, usize) -> f64) -> Self {
        let mut values = vec![0.0; count * count];
        for a in 0..count {
            for b in 0..a {
                let distance = between(a, b);
                values[a * count + b] = distance;
                values[b * count + a] = distance;
            }
        }
        Self { count, values }
    }

    fn between(&self, a: usize, b: usize) -> f64 {
        self.values.get(a * self.count + b).copied().unwrap_or(0.0)
    }

    /// Median distance of hit `of` to the `others` (itself left out); `None` when it is alone.
    pub(super) fn median_to(&self, of: usize, others: &[usize]) -> Option<f64> {
        let others = others.iter().filter(|&&other| other != of);
        median(others.map(|&other| self.between(of, other)).collect())
    }

    /// From this distance on one of the `hits` is inconsistent with the others: their scatter is the
    /// median of their median distances.
    pub(super) fn limit_among(&self, hits: &[usize]) -> f64 {
        let medians = hits.iter().filter_map(|&hit| self.median_to(hit, hits));
        let count = u32::try_from(hits.len()).unwrap_or(u32::MAX);
        inconsistent_from(count, median(medians.collect()).unwrap_or(0.0))
    }

    /// The best consistent set of the `hits`: the one that is farthest from the others goes until none
    /// is farther than `limit` and no more than `wanted` are left.
    ///
    /// Of two hits that disagree both stay: nothing tells which is wrong.
    pub(super) fn best_consistent(&self, hits: &[usize], wanted: usize, limit: f64) -> Vec<usize> {
        let mut kept = hits.to_vec();
        loop {
            let far = |place| self.median_to(*kept.get(place)?, &kept);
            let places = (0..kept.len()).filter_map(|place| Some((place, far(place)?)));
            // Of equally far ones the first.
            let worst = places.fold(None, |worst: Option<(usize, f64)>, next| match worst {
                Some(worst) if worst.1 >= next.1 => Some(worst),
                _ => Some(next),
            });
            match worst {
                Some((place, far)) if kept.len() > wanted || (far > limit && kept.len() > 2) => {
                    kept.remove(place);
                }
                _ => return kept,
            }
        }
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    let even = values.len().is_multiple_of(2);
    let (below, &mut upper, _) =
        (!values.is_empty()).then(|| values.select_nth_unstable_by(middle, f64::total_cmp))?;
    let lower = if even { below.iter().copied().fold(f64::NEG_INFINITY, f64::max) } else { upper };
    Some((upper + lower) * 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances of points on a line.
    fn on_a_line(points: &[f64]) -> Distances {
        Distances::new(points.len(), |a, b| (points[a] - points[b]).abs())
    }

    #[test]
    fn a_median_is_the_middle_or_between_the_two_middle_ones() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 8.0]), Some(3.0));
    }

    #[test]
    fn one_bad_hit_is_far_and_the_good_ones_are_not() {
        let all = [0, 1, 2, 3, 4];
        let distances = on_a_line(&[0.0, 0.02, 0.9, 0.04, 0.01]);
        assert!(distances.median_to(2, &all).unwrap() > 0.8);
        assert!([0, 1, 3, 4].iter().all(|&hit| distances.median_to(hit, &all).unwrap() < 0.05));
        let limit = distances.limit_among(&all);
        assert_eq!(distances.best_consistent(&all, 5, limit), [0, 1, 3, 4]);
    }

    #[test]
    fn more_hits_than_wanted_leave_the_closest_ones() {
        let distances = on_a_line(&[0.0, 0.05, 0.01, 0.11, 0.02]);
        assert_eq!(distances.best_consistent(&[0, 1, 2, 3, 4], 3, 1.0), [0, 2, 4]);
        assert_eq!(distances.best_consistent(&[1, 3], 3, 1.0), [1, 3]);
        assert!(distances.best_consistent(&[], 3, 1.0).is_empty());
    }

    #[test]
    fn hits_that_scatter_much_are_told_from_one_that_does_not_belong() {
        let limit = on_a_line(&[0.0, 0.1, 0.2, 0.15, 0.9]).limit_among(&[0, 1, 2, 3, 4]);
        assert!(limit > 0.2 && limit < 0.75, "{limit}");
    }

    #[test]
    fn two_that_disagree_both_stay() {
        let distances = on_a_line(&[0.0, 1.0]);
        assert_eq!(distances.best_consistent(&[0, 1], 2, 0.15), [0, 1]);
        assert_eq!(distances.median_to(0, &[0]), None);
    }

    #[test]
    fn a_bad_hit_after_a_hundred_good_ones_goes() {
        let mut points: Vec<f64> = (0..100).map(|k| 1e-3 * f64::from(k)).collect();
        points.push(0.9);
        let all: Vec<usize> = (0..points.len()).collect();
        let distances = on_a_line(&points);
        let kept = distances.best_consistent(&all, usize::MAX, distances.limit_among(&all));
        assert_eq!(kept, all[..100]);
    }
}
