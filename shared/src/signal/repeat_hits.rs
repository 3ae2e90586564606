//! Compares the repeat hits at one DOF. One statistic with its limits serves the rig after each hit and the
//! grading of a complete recording.
//!
//! A hit is a vector `x` of measured quantities per force: the mass lines of all responses, or the lines of
//! their frequency responses. It is compared with the mean `m` of the other hits at its DOF:
//!
//! ```text
//! distance = |x − m| / |m|        scatter = [Σ |xᵢ − m|² / (n − 1)]^½ / |m|
//! ```
//! The hit itself is excluded from both, so that an outlier does not shift the mean towards itself.

use crate::Real;

/// Hits agree up to this relative distance, however little the others scatter.
const AGREES: f64 = 0.15;
/// Hits disagree beyond this relative distance, however much the others scatter.
///
/// Hits with a direction error of 30 mrad and a position error of 2 mm differ by up to 0.4 where the body
/// rotates easily.
const DISAGREES: f64 = 0.6;
/// A hit whose distance exceeds the scatter of the others by this factor is an outlier.
const TIMES_SCATTER: f64 = 4.0;
/// Smallest number of other hits whose scatter is used.
const FEWEST_FOR_SCATTER: u32 = 3;

/// A hit compared with the others at its DOF.
///
/// ```
/// # use massline_shared::signal::{RepeatHits, HitAgreement};
/// // Four hits that scatter by 5 %, and a fifth at 10 % or 40 % of their mean.
/// let others = RepeatHits {
///     others: 4,
///     mean_squared: 1.0_f64,
///     scatter_squared: 3.0 * 0.05 * 0.05,
///     distance_squared: 0.1 * 0.1,
/// };
/// assert_eq!(others.standing(), HitAgreement::Agrees);
/// let stray = RepeatHits { distance_squared: 0.4 * 0.4, ..others };
/// assert!((stray.limit() - 0.2).abs() < 1e-12);
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
}

/// Result of comparing a hit with the others at its DOF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HitAgreement<R> {
    /// The hit agrees with the others, or there are none.
    Agrees,
    /// The hit has this relative distance from several others: it is the outlier.
    Outlier(R),
    /// The hit has this relative distance from the only other one: it cannot be determined which is wrong.
    Inconsistent(R),
}

impl<R: Real> RepeatHits<R> {
    /// Relative distance of the hit from the mean of the others; `None` without others, or when it is not
    /// finite.
    pub fn distance(&self) -> Option<R> {
        let distance = (self.distance_squared / self.mean_squared).sqrt();
        (self.others > 0 && distance.finite()).then_some(distance)
    }

    /// Relative scatter of the others about their mean; zero with fewer than two.
    pub fn scatter(&self) -> R {
        let freedom = R::of(f64::from(self.others.max(2) - 1));
        (self.scatter_squared / freedom / self.mean_squared).sqrt()
    }

    /// Relative distance above which the hit is inconsistent with the others.
    pub fn limit(&self) -> R {
        if self.others < FEWEST_FOR_SCATTER {
            return R::of(DISAGREES);
        }
        (self.scatter() * R::of(TIMES_SCATTER)).max(R::of(AGREES)).min(R::of(DISAGREES))
    }

    /// Result of the comparison; a hit without a distance agrees.
    pub fn standing(&self) -> HitAgreement<R> {
        match self.distance().filter(|&distance| distance > self.limit()) {
            None => HitAgreement::Agrees,
            Some(distance) if self.others > 1 => HitAgreement::Outlier(distance),
            Some(distance) => HitAgreement::Inconsistent(distance),
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
        }
    }

    #[test]
    fn distance_and_scatter_are_relative_to_the_mean() {
        let hit = hit(4, 0.1, 0.5);
        // The tolerance covers the rounding of squares and roots.
        assert!((hit.distance().unwrap() - 0.5).abs() < 1e-15);
        assert!((hit.scatter() - 0.1).abs() < 1e-15);
    }

    #[test]
    fn few_hits_do_not_tell_their_scatter() {
        assert_eq!(hit(2, 0.01, 0.0).limit(), DISAGREES);
        assert_eq!(hit(3, 0.01, 0.0).limit(), AGREES);
        assert!((hit(3, 0.1, 0.0).limit() - 0.4).abs() < 1e-15);
    }

    #[test]
    fn one_against_one_tells_less_than_one_against_several() {
        assert_eq!(hit(0, 0.0, 0.9).standing(), HitAgreement::Agrees);
        assert_eq!(hit(1, 0.0, 0.5).standing(), HitAgreement::Agrees);
        assert!(matches!(hit(1, 0.0, 0.7).standing(), HitAgreement::Inconsistent(_)));
        assert!(matches!(hit(2, 0.01, 0.7).standing(), HitAgreement::Outlier(_)));
        assert!(matches!(hit(4, 0.01, 0.2).standing(), HitAgreement::Outlier(_)));
        assert_eq!(hit(4, 0.1, 0.2).standing(), HitAgreement::Agrees);
    }

    #[test]
    fn nothing_speaks_against_a_hit_whose_distance_is_no_number() {
        let nothing = RepeatHits { mean_squared: 0.0, ..hit(4, 0.0, 0.0) };
        assert_eq!((nothing.distance(), nothing.standing()), (None, HitAgreement::Agrees));
    }
}
