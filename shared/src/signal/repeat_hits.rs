//! Do the hits at one DOF agree? How far two are apart, and how far is too far.

use nalgebra::Complex;

use crate::Real;

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
pub fn inconsistent_from<R: Real>(siblings: u32, scatter: R) -> R {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_hits_do_not_tell_their_scatter() {
        assert_eq!(inconsistent_from(2, 0.01), DISAGREES);
        assert_eq!(inconsistent_from(3, 0.01), AGREES);
        assert_eq!(inconsistent_from(3, 0.1), 0.4);
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
