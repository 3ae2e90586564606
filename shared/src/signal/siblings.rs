//! Do the hits at one DOF agree? Each is compared with the others; the best consistent ones are kept.
//!
//! The statistic of a hit is the *median* of its relative distances to the others: one bad hit among
//! four does not make the good ones look bad, as it would with a mean.

use nalgebra::Complex;

use crate::Real;

/// Hits that can be compared.
pub const MOST_SIBLINGS: usize = 64;

/// Up to this relative distance hits agree, however little the others scatter.
const AGREES: f64 = 0.15;
/// Beyond this relative distance hits disagree, however much the others scatter.
///
/// Hits on the mark that lean by 30 mrad and miss by 2 mm are up to 0.4 apart where the body turns
/// easily.
const DISAGREES: f64 = 0.6;
/// A hit that is this many times farther away than the others are from each other does not belong to
/// them.
const TIMES_SCATTER: f64 = 4.0;
/// Fewer hits than this do not tell their scatter.
const FEWEST_FOR_SCATTER: u32 = 3;

/// From this relative distance on a hit is inconsistent with `siblings` hits at its DOF whose own
/// distances are about `scatter`.
fn inconsistent_from<R: Real>(siblings: u32, scatter: R) -> R {
    if siblings < FEWEST_FOR_SCATTER {
        return R::of(DISAGREES);
    }
    (scatter * R::of(TIMES_SCATTER)).max(R::of(AGREES)).min(R::of(DISAGREES))
}

/// How a hit stands to those at its DOF before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Standing<R> {
    /// It agrees with them, or there are none.
    Agrees,
    /// It is this far from several that agree: it is the one that does not belong.
    Astray(R),
    /// It is this far from the only other one: nothing tells which of the two is wrong.
    Contradicts(R),
}

/// How a hit stands at a relative `distance` from the mean of `siblings` hits whose own distances are
/// about `scatter`; without a distance nothing speaks against it.
pub fn standing<R: Real>(siblings: u32, scatter: R, distance: Option<R>) -> Standing<R> {
    match distance.filter(|&far| far > inconsistent_from(siblings, scatter)) {
        None => Standing::Agrees,
        Some(far) if siblings > 1 => Standing::Astray(far),
        Some(far) => Standing::Contradicts(far),
    }
}

/// Relative distance of two sets of responses per force, `[Σ w |a − b|² / ½ Σ w (|a|² + |b|²)]^½`
/// over triples `(a, b, w)`: 0 when equal, 2 when opposite.
pub fn relative_distance<R: Real>(pairs: impl Iterator<Item = (Complex<R>, Complex<R>, R)>) -> R {
    let (mut apart, mut size) = (R::zero(), R::zero());
    pairs.for_each(|(a, b, weight)| {
        apart += (a - b).norm_sqr() * weight;
        size += (a.norm_sqr() + b.norm_sqr()) * weight;
    });
    let ratio = apart / (size * R::of(0.5));
    if ratio.finite() { ratio.sqrt() } else { R::zero() }
}

/// As for [`standing`], for `hits` (a bit each) whose scatter is the median of their
/// [median distances](median_distance).
pub fn inconsistent_among<R: Real>(hits: u64, distance: &impl Fn(usize, usize) -> R) -> R {
    let medians = members(hits).filter_map(|hit| median_distance(hit, hits, distance));
    let scatter = median(medians.collect()).unwrap_or_else(R::zero);
    inconsistent_from(hits.count_ones(), scatter)
}

/// Median distance of hit `of` to the `others` (a bit each, itself left out); `None` when it is
/// alone.
pub fn median_distance<R: Real>(
    of: usize,
    others: u64,
    distance: &impl Fn(usize, usize) -> R,
) -> Option<R> {
    median(members(others).filter(|&other| other != of).map(|other| distance(of, other)).collect())
}

/// The hits of a set of bits.
fn members(hits: u64) -> impl Iterator<Item = usize> {
    (0..MOST_SIBLINGS).filter(move |&hit| (hits >> hit) & 1 == 1)
}

fn median<R: Real>(mut values: heapless::Vec<R, MOST_SIBLINGS>) -> Option<R> {
    values.sort_unstable_by(|a, b| a.to_f64().total_cmp(&b.to_f64()));
    let upper = values.get(values.len() / 2)?;
    let lower = values.get((values.len() - 1) / 2)?;
    Some((*upper + *lower) * R::of(0.5))
}

/// The best consistent set of the `hits` (a bit each): the one that is farthest from the others goes
/// until none is farther than `limit` and no more than `wanted` are left.
///
/// Of two hits that disagree both stay: nothing tells which is wrong.
pub fn best_consistent<R: Real>(
    hits: u64,
    wanted: usize,
    limit: R,
    distance: &impl Fn(usize, usize) -> R,
) -> u64 {
    let mut kept = hits;
    loop {
        let count = kept.count_ones() as usize;
        let mut worst: Option<(usize, R)> = None;
        for hit in members(kept) {
            let Some(far) = median_distance(hit, kept, distance) else { continue };
            if worst.is_none_or(|(_, worst)| far > worst) {
                worst = Some((hit, far));
            }
        }
        match worst {
            Some((hit, far)) if count > wanted || (far > limit && count > 2) => {
                kept &= !(1 << hit);
            }
            _ => return kept,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances of points on a line.
    fn on_a_line<const N: usize>(points: [f64; N]) -> impl Fn(usize, usize) -> f64 {
        move |a, b| (points[a] - points[b]).abs()
    }

    #[test]
    fn one_bad_hit_is_far_and_the_good_ones_are_not() {
        let distance = on_a_line([0.0, 0.02, 0.9, 0.04, 0.01]);
        let median = |hit| median_distance(hit, 0b11111, &distance).unwrap();
        assert!(median(2) > 0.8);
        assert!([0, 1, 3, 4].into_iter().all(|hit| median(hit) < 0.05));
        assert_eq!(
            best_consistent(0b11111, 5, inconsistent_among(0b11111, &distance), &distance),
            0b11011
        );
    }

    #[test]
    fn more_hits_than_wanted_leave_the_closest_ones() {
        let distance = on_a_line([0.0, 0.05, 0.01, 0.11, 0.02]);
        assert_eq!(best_consistent(0b11111, 3, 1.0, &distance), 0b10101);
        assert_eq!(best_consistent(0b01010, 3, 1.0, &distance), 0b01010);
        assert_eq!(best_consistent(0, 3, 1.0, &distance), 0);
    }

    #[test]
    fn hits_that_scatter_much_are_told_from_one_that_does_not_belong() {
        let distance = on_a_line([0.0, 0.1, 0.2, 0.15, 0.9]);
        let limit = inconsistent_among(0b11111, &distance);
        assert!(limit > 0.2 && limit < 0.75, "{limit}");
        assert_eq!(inconsistent_from(2, 0.01), DISAGREES);
        assert_eq!(inconsistent_from(3, 0.01), AGREES);
    }

    #[test]
    fn one_against_one_tells_less_than_one_against_several() {
        assert_eq!(standing(0, 0.0, None), Standing::<f64>::Agrees);
        assert_eq!(standing(1, 0.0, Some(0.5)), Standing::Agrees);
        assert_eq!(standing(1, 0.0, Some(0.7)), Standing::Contradicts(0.7));
        assert_eq!(standing(2, 0.01, Some(0.7)), Standing::Astray(0.7));
        assert_eq!(standing(4, 0.01, Some(0.2)), Standing::Astray(0.2));
        assert_eq!(standing(4, 0.1, Some(0.2)), Standing::Agrees);
    }

    #[test]
    fn two_that_disagree_both_stay() {
        assert_eq!(best_consistent(0b11, 2, AGREES, &on_a_line([0.0, 1.0])), 0b11);
        assert_eq!(median_distance(0, 0b1, &on_a_line([0.0])), None);
    }

    #[test]
    fn opposite_responses_are_two_apart() {
        let one = Complex::new(1.0, 2.0);
        let pair = |a, b| relative_distance([(a, b, 3.0)].into_iter());
        assert_eq!(pair(one, one), 0.0);
        assert_eq!(pair(one, -one), 2.0);
        // 10 % more: 0.1 over the mean size, sqrt((1 + 1.21)/2).
        assert!((pair(one, one * 1.1) - 0.1 / 1.105_f64.sqrt()).abs() < 1e-12);
        assert_eq!(pair(Complex::new(0.0, 0.0), Complex::new(0.0, 0.0)), 0.0);
    }
}
