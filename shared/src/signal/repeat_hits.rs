//! Compares the repeat hits at one DOF. One statistic with its limits serves the rig after each hit and the
//! grading of a complete recording.
//!
//! A hit is a vector `x` of measured quantities per force: the mass lines of all responses, or the lines of
//! their frequency responses. It is compared with the mean `m` of the other hits at its DOF:
//!
//! ```text
//! distance = |x − m| / |m|        scatter² = (s₀² + Σ |xᵢ − m|² / |m|²) / (1 + Σ (n − 1))
//! ```
//! The hit itself is excluded from both, so that an outlier does not shift the mean towards itself. The sums of
//! the scatter are over the DOFs measured so far: a person who hits roughly does so everywhere. `s₀` is the
//! expectation before any hit.

use crate::diagnosis::Code;
use crate::layout::{HitPolicy, HitTreatment};
use crate::real::Real;

/// Hits agree up to this relative distance, however little the others scatter.
const AGREES: f64 = 0.15;
/// Hits disagree beyond this relative distance, however much the others scatter: that of a hit that moves the
/// body the other way is two.
const DISAGREES: f64 = 1.0;
/// A hit that disagrees and is further away than this relative distance may have landed elsewhere.
pub const ELSEWHERE: f64 = 0.3;
/// A hit whose distance exceeds the scatter by this factor is an outlier.
const TIMES_SCATTER: f64 = 5.0;
/// Expected relative scatter before any hit, with the weight of one hit.
///
/// Hits with a direction error of 30 mrad and a position error of 2 mm scatter by up to 0.1 where the body
/// rotates easily.
const EXPECTED_SCATTER: f64 = 0.1;

/// A hit compared with the others at its DOF.
///
/// ```
/// # use massline_shared::signal::{HitAgreement, KnownScatter, RepeatHits};
/// // Four hits that scatter by 5 %, and a fifth at 10 % or 40 % of their mean.
/// let others = RepeatHits {
///     others: 4,
///     mean_squared: 1.0_f64,
///     scatter_squared: 3.0 * 0.05 * 0.05,
///     distance_squared: 0.1 * 0.1,
///     elsewhere: KnownScatter::none(),
/// };
/// assert_eq!(others.standing(), HitAgreement::Agrees);
/// let stray = RepeatHits { distance_squared: 0.4 * 0.4, ..others };
/// assert!((stray.limit() - 0.37).abs() < 0.01);
/// assert_ne!(stray.standing(), HitAgreement::Agrees);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RepeatHits<R> {
    /// Number of the others.
    pub others: u32,
    /// Square of the length of the mean of the others.
    pub mean_squared: R,
    /// Sum of the squares of the distances of the others from their mean.
    pub scatter_squared: R,
    /// Square of the distance of the hit from that mean.
    pub distance_squared: R,
    /// Scatter of the hits at other DOFs.
    pub elsewhere: KnownScatter<R>,
}

/// Relative scatter of the repeat hits at several DOFs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KnownScatter<R> {
    squares: R,
    freedom: R,
}

impl<R: Real> KnownScatter<R> {
    /// No DOF.
    pub fn none() -> Self {
        Self { squares: R::zero(), freedom: R::zero() }
    }

    /// Adds a DOF with this many hits, whose mean has a length of this square and whose squared distances from
    /// it have this sum. No effect when the ratio is not finite.
    pub fn add(&mut self, hits: u32, mean_squared: R, scatter_squared: R) {
        let relative = scatter_squared / mean_squared;
        if relative.finite() && hits > 1 {
            self.squares += relative;
            self.freedom += R::of(f64::from(hits - 1));
        }
    }
}

/// Result of comparing a hit with the others at its DOF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HitAgreement<R> {
    /// The hit agrees with the others, or there are none.
    Agrees,
    /// The hit has this relative distance from several others: it is the outlier.
    Outlier(R),
    /// The hit is an outlier at a distance at which it may have landed elsewhere.
    Elsewhere(R),
    /// The hit has this relative distance from the only other one: it cannot be determined which is wrong.
    Inconsistent(R),
    /// The two others have this relative distance from each other: one of them may have landed elsewhere.
    OthersInconsistent(R),
}

impl<R: Real> HitAgreement<R> {
    /// Code of the disagreement of a hit that stays, and the relative distance.
    pub fn finding(&self) -> Option<(Code, R)> {
        match *self {
            Self::Agrees | Self::OthersInconsistent(_) => None,
            Self::Outlier(distance) => Some((Code::HitInconsistent, distance)),
            Self::Elsewhere(distance) => Some((Code::HitElsewhere, distance)),
            Self::Inconsistent(distance) => Some((Code::HitsInDoubt, distance)),
        }
    }

    /// What a policy does about it: to the hit, or to both others.
    pub fn treatment(&self, policy: HitPolicy) -> HitTreatment {
        let of_outlier = policy.treatment(Code::HitInconsistent);
        match self {
            Self::Agrees => HitTreatment::Keep,
            Self::Outlier(_) | Self::Inconsistent(_) => of_outlier,
            Self::Elsewhere(_) if of_outlier == HitTreatment::Reject => of_outlier,
            Self::Elsewhere(_) | Self::OthersInconsistent(_) => {
                policy.treatment(Code::HitElsewhere)
            }
        }
    }
}

impl<R: Real> RepeatHits<R> {
    /// Relative distance of the hit from the mean of the others; `None` without others, or when it is not
    /// finite.
    pub fn distance(&self) -> Option<R> {
        let distance = (self.distance_squared / self.mean_squared).sqrt();
        (self.others > 0 && distance.finite()).then_some(distance)
    }

    /// Relative scatter of repeat hits, from these and those at other DOFs.
    pub fn scatter(&self) -> R {
        let mut known = self.elsewhere;
        known.add(self.others, self.mean_squared, self.scatter_squared);
        let expected = R::of(EXPECTED_SCATTER * EXPECTED_SCATTER);
        ((expected + known.squares) / (R::one() + known.freedom)).sqrt()
    }

    /// Relative distance above which the hit is inconsistent with the others: it and the mean of the others
    /// both scatter.
    pub fn limit(&self) -> R {
        let others = R::of(f64::from(self.others.max(1)));
        let scatter = self.scatter() * (R::one() + others.recip()).sqrt();
        (scatter * R::of(TIMES_SCATTER)).max(R::of(AGREES)).min(R::of(DISAGREES))
    }

    /// Result of the comparison; a hit without a distance agrees.
    pub fn standing(&self) -> HitAgreement<R> {
        let elsewhere = R::of(ELSEWHERE);
        if self.others == 2 {
            // As it was when the second of them was compared with the first.
            let squared = self.scatter_squared * R::of(2.0);
            let pair = Self { others: 1, distance_squared: squared, ..*self };
            let limit = pair.limit().max(elsewhere);
            if squared > limit * limit * self.mean_squared {
                // Two that are opposite have no mean.
                let distance = pair.distance().unwrap_or(R::of(2.0));
                return HitAgreement::OthersInconsistent(distance);
            }
        }
        match self.distance().filter(|&distance| distance > self.limit()) {
            None => HitAgreement::Agrees,
            Some(distance) if self.others < 2 => HitAgreement::Inconsistent(distance),
            Some(distance) if distance > elsewhere => HitAgreement::Elsewhere(distance),
            Some(distance) => HitAgreement::Outlier(distance),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hit at this relative distance from others with this relative scatter, about a mean of length 2.
    fn hit(others: u32, scatter: f64, distance: f64) -> RepeatHits<f64> {
        let freedom = f64::from(others.max(2) - 1);
        RepeatHits {
            others,
            mean_squared: 4.0,
            scatter_squared: 4.0 * scatter * scatter * freedom,
            distance_squared: 4.0 * distance * distance,
            elsewhere: KnownScatter::none(),
        }
    }

    #[test]
    fn the_distance_is_relative_to_the_mean() {
        // The tolerance covers the rounding of squares and roots.
        assert!((hit(4, 0.1, 0.5).distance().unwrap() - 0.5).abs() < 1e-15);
    }

    #[test]
    fn the_scatter_is_that_of_these_hits_and_of_those_elsewhere() {
        // One and two hits show none or little, so the expectation counts.
        assert_eq!(hit(1, 0.0, 0.0).scatter(), EXPECTED_SCATTER);
        assert!((hit(2, 0.1, 0.0).scatter() - 0.1).abs() < 1e-15);
        // √((0.1² + 4 · 0.2²) / 5).
        assert!((hit(5, 0.2, 0.0).scatter() - 0.034_f64.sqrt()).abs() < 1e-15);
        let mut elsewhere = KnownScatter::none();
        (0..20).for_each(|_| elsewhere.add(5, 1.0, 4.0 * 0.2 * 0.2));
        let rough = RepeatHits { elsewhere, ..hit(1, 0.0, 0.7) };
        // 80 degrees of freedom leave one of the expectation: 1 %.
        assert!((rough.scatter() / 0.2 - 1.0).abs() < 0.01);
        assert_eq!(rough.standing(), HitAgreement::Agrees);
        elsewhere.add(5, 0.0, 0.0);
        assert_eq!(RepeatHits { elsewhere, ..rough }, rough, "a DOF without motion tells nothing");
    }

    #[test]
    fn the_limit_follows_the_scatter_between_bounds() {
        let mut steady = KnownScatter::none();
        steady.add(1000, 1.0, 0.0);
        assert_eq!(RepeatHits { elsewhere: steady, ..hit(4, 0.0, 0.0) }.limit(), AGREES);
        assert_eq!(hit(4, 0.9, 0.0).limit(), DISAGREES);
    }

    #[test]
    fn one_against_one_tells_less_than_one_against_several() {
        assert_eq!(hit(0, 0.0, 0.9).standing(), HitAgreement::Agrees);
        assert_eq!(hit(1, 0.0, 0.5).standing(), HitAgreement::Agrees);
        assert!(matches!(hit(1, 0.0, 0.75).standing(), HitAgreement::Inconsistent(_)));
        assert!(matches!(hit(2, 0.01, 0.7).standing(), HitAgreement::Elsewhere(_)));
        assert!(matches!(hit(4, 0.01, 0.29).standing(), HitAgreement::Outlier(_)));
        assert!(matches!(hit(4, 0.01, 0.31).standing(), HitAgreement::Elsewhere(_)));
        assert_eq!(hit(4, 0.1, 0.4).standing(), HitAgreement::Agrees);
    }

    #[test]
    fn a_third_hit_finds_two_others_that_differ() {
        // Two hits 71 % apart scatter by 0.71/√2 about their mean, whatever the third does.
        for distance in [0.0, 0.35, 3.0] {
            let third = hit(2, 0.72 / 2.0_f64.sqrt(), distance).standing();
            assert!(
                matches!(third, HitAgreement::OthersInconsistent(far) if far > 0.7),
                "{third:?}"
            );
        }
        assert_eq!(hit(2, 0.7 / 2.0_f64.sqrt(), 0.35).standing(), HitAgreement::Agrees);
        let opposite = RepeatHits { mean_squared: 0.0, ..hit(2, 0.5, 0.5) };
        assert_eq!(opposite.standing(), HitAgreement::OthersInconsistent(2.0));
    }

    #[test]
    fn the_policy_decides_what_becomes_of_a_hit_that_disagrees() {
        use HitAgreement::{Agrees, Elsewhere, Inconsistent, OthersInconsistent, Outlier};
        use HitTreatment::{Keep, Reject, Warn};
        let standings =
            [Agrees, Outlier(0.2), Elsewhere(0.4), Inconsistent(0.8), OthersInconsistent(0.8)];
        let treated = |policy: HitPolicy| standings.map(|standing| standing.treatment(policy));
        let usual = HitPolicy::default();
        assert_eq!(treated(usual), [Keep, Warn, Reject, Warn, Reject]);
        let strict = usual.with(Code::HitInconsistent, Reject);
        assert_eq!(treated(strict), [Keep, Reject, Reject, Reject, Reject]);
        let lenient = usual.with(Code::HitElsewhere, Warn);
        assert_eq!(treated(lenient), [Keep, Warn, Warn, Warn, Warn]);
    }

    #[test]
    fn nothing_speaks_against_a_hit_whose_distance_is_no_number() {
        let nothing = RepeatHits { mean_squared: 0.0, ..hit(4, 0.0, 0.0) };
        assert_eq!((nothing.distance(), nothing.standing()), (None, HitAgreement::Agrees));
    }
}
