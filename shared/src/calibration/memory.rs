//! The memory of the multiplexer in a tumble test: what the hammer's channel keeps of the channel before it.
//!
//! A converter with several inputs samples each after charging a capacitor that still holds the voltage of the input
//! before: `V = U + κ (V_before − U)`. In a tumble test the hammer lies still, and the channel before it goes
//! through −1, 0 and +1 g. So κ is the slope of the hammer's rest level over the level of that channel.
//!
//! The same test cannot see what a sensor axis keeps of another: that looks like cross-axis sensitivity, which it is
//! stored as. Within a sensor that takes it out of measurements too.

use super::tumble::{Position, RestVoltages};
use crate::estimated::EstimatedValue;
use crate::real::Real;
use crate::signal::HAMMER;

/// Memory above this matters: it moves the answer by half a standard deviation where one per cent moves it by two.
pub const LARGE_MEMORY: f64 = 0.002;

/// The share that the hammer's channel keeps of channel `before`, which the same converter reads before it. `None`
/// without three readings, or when that channel did not change.
///
/// ```
/// # use massline_shared::calibration::memory::kept_by_hammer;
/// # use massline_shared::calibration::tumble::{Position, RestVoltages};
/// let reading = |position: Position| {
///     let level: f64 = 1.5 + 0.057 * position.up::<f64>().z;
///     let volts = [0.1 + 0.01 * level, 1.5, 1.5, level];
///     (position, RestVoltages::from_volts(&volts, &[1e-3; 4], &[1e-5; 4]).unwrap())
/// };
/// let kept = kept_by_hammer(&Position::ALL.map(reading), 3).unwrap();
/// assert!((kept.value - 0.01).abs() < 1e-12);
/// // 10 µV in two positions that are 114 mV apart.
/// assert!((kept.sigma / (1e-5 * 2.0_f64.sqrt() / 0.114) - 1.0).abs() < 0.01);
/// ```
pub fn kept_by_hammer<R: Real>(
    readings: &[(Position, RestVoltages<R>)],
    before: usize,
) -> Option<EstimatedValue<R>> {
    let level = |reading: &RestVoltages<R>| {
        let (mean, sigma) = (reading.mean(), reading.sigma());
        Some((*mean.get(before)?, *mean.get(HAMMER)?, *sigma.get(HAMMER)?))
    };
    let levels = || readings.iter().filter_map(|(_, reading)| level(reading));
    let count = levels().count();
    if count < 3 {
        return None;
    }
    let number = R::of(count as f64);
    let mean = |component: fn(&(R, R, R)) -> R| {
        levels().fold(R::zero(), |sum, l| sum + component(&l)) / number
    };
    let (center, rest) = (mean(|l| l.0), mean(|l| l.1));
    let (mut square, mut product, mut noise) = (R::zero(), R::zero(), R::zero());
    for (volts, hammer, sigma) in levels() {
        let off = volts - center;
        square += off * off;
        product += off * (hammer - rest);
        noise += off * off * sigma * sigma;
    }
    let value = product / square;
    let stated = noise.sqrt() / square;
    let left = levels().fold(R::zero(), |sum, (volts, hammer, _)| {
        let residual = hammer - rest - value * (volts - center);
        sum + residual * residual
    });
    // A rest level that drifts from position to position shows in the residuals.
    let seen = (left / R::of((count - 2) as f64) / square).sqrt();
    let sigma = stated.max(seen);
    (value.finite() && sigma.finite()).then_some(EstimatedValue { value, sigma })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn readings<R: Real>(hammer: impl Fn(usize, f64) -> f64) -> [(Position, RestVoltages<R>); 6] {
        let mut place = 0;
        Position::ALL.map(|position| {
            let level = 1.5 + 0.057 * position.up::<f64>().z;
            let volts = [hammer(place, level), 1.5, 1.5, level].map(R::of);
            place += 1;
            let small = [R::of(1e-5); 4];
            (position, RestVoltages::from_volts(&volts, &small, &small).unwrap())
        })
    }

    #[test]
    fn the_share_is_found_in_both_precisions() {
        for kept in [0.0, 0.01, -0.003] {
            let hammer = |_, level: f64| 0.1 + kept * (level - 0.1);
            let double = kept_by_hammer(&readings::<f64>(hammer), 3).unwrap();
            let single = kept_by_hammer(&readings::<f32>(hammer), 3).unwrap();
            // Rounding of 0.1 V relative to 0.114 V.
            assert!((double.value - kept).abs() < 1e-12, "{double:?}");
            assert!((f64::from(single.value) - kept).abs() < 1e-6, "{single:?}");
        }
    }

    #[test]
    fn a_rest_level_that_drifts_makes_it_uncertain_and_not_wrong() {
        // 0.2 mV from position to position: between +Z and −Z as much as a share of 0.2 %.
        let drifting = |place: usize, _| 0.1 + 2e-4 * place as f64;
        let estimate = kept_by_hammer(&readings::<f64>(drifting), 3).unwrap();
        assert!(estimate.value.abs() < 2.0 * estimate.sigma, "{estimate:?}");
        assert!(estimate.sigma > 1e-3, "{estimate:?}");
    }

    #[test]
    fn a_channel_that_does_not_change_or_does_not_exist_shows_nothing() {
        let same = readings::<f64>(|_, _| 0.1);
        assert_eq!(kept_by_hammer(&same, 1), None);
        assert_eq!(kept_by_hammer(&same, 7), None);
        assert_eq!(kept_by_hammer(&same[..2], 3), None);
    }
}
