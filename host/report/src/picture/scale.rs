//! Scales of axes: ranges, and ticks at round numbers.

use crate::typography::with_minus_signs;

/// Room beyond the outermost value, share of the range.
const ROOM: f64 = 0.06;
/// Values that differ by less than this share are one value: computing it in another order moves the last digits.
const EQUAL: f64 = 1e-9;
/// Range about a single value, share of the value.
const ABOUT: f64 = 0.01;
/// Most decimals of a tick, and the least number that is written with a power of ten.
const MOST_DECIMALS: f64 = 12.0;
const LARGE: f64 = 1e9;

/// The distance of ticks on an axis of this length: 1, 2 or 5 times a power of ten, at most so many of them.
pub(super) fn step_of(length: f64, most: f64) -> f64 {
    let power = 10_f64.powf((length / most).log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|k| k * power);
    steps.into_iter().find(|step| length / step <= most).unwrap_or(length)
}

/// The range of these values with some room, without regard to zero; `None` where no value is a number.
pub(super) fn range_about(values: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    let ends = |value: f64| [value; 2];
    let widen = |[a, b]: [f64; 2], [low, high]: [f64; 2]| [a.min(low), b.max(high)];
    let [low, high] = values.filter(|value| value.is_finite()).map(ends).reduce(widen)?;
    let room = match high - low {
        size if size > EQUAL * low.abs().max(high.abs()) => ROOM * size,
        _ if low == 0.0 => 1.0,
        _ => ABOUT * low.abs(),
    };
    let range = [low - room, high + room];
    (range[0] < range[1] && (range[1] - range[0]).is_finite()).then_some(range)
}

/// The ticks in a range, at most so many, each with its number.
pub(super) fn ticks([low, high]: [f64; 2], most: f64) -> Vec<(f64, String)> {
    let step = step_of(high - low, most);
    let decimals = (-step.log10()).ceil().clamp(0.0, MOST_DECIMALS) as usize;
    let tick = |k: usize| {
        // Adding zero takes the sign from a negative zero.
        let value = ((low / step).ceil() + k as f64) * step + 0.0;
        let large = value.abs() >= LARGE;
        let text = if large { format!("{value:e}") } else { format!("{value:.decimals$}") };
        (value, with_minus_signs(&text))
    };
    (0..=most as usize).map(tick).take_while(|(value, _)| *value <= high).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_and_round() {
        for (end, step) in [(2.5, 0.5), (9.0, 1.0), (35.0, 5.0), (1e6, 1e5)] {
            let tick_step = step_of(end, 10.0);
            assert!((tick_step / step - 1.0).abs() < 1e-9, "{end}: {tick_step}");
        }
    }

    #[test]
    fn a_narrow_range_far_from_zero_has_ticks_with_the_decimals_that_tell_them_apart() {
        let numbers = |range| {
            let ticks = ticks(range, 4.0);
            ticks.into_iter().map(|(_, text)| text).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(numbers([-1.2207, -1.2199]), "−1.2206 −1.2204 −1.2202 −1.2200");
        assert_eq!(numbers([-0.4, 0.4]), "−0.4 −0.2 0.0 0.2 0.4");
    }

    #[test]
    fn a_range_without_a_size_or_a_number_is_no_trouble() {
        assert_eq!(range_about([2.0, f64::NAN, 2.0].into_iter()), Some([1.98, 2.02]));
        // The last digits do not stretch the axis; the range itself moves by no more than they do.
        let [low, high] = range_about([2.0, 2.0 + 1e-14].into_iter()).expect("a range");
        assert!((low - 1.98).abs() < 1e-12 && (high - 2.02).abs() < 1e-12, "{low} {high}");
        assert_eq!(range_about([0.0].into_iter()), Some([-1.0, 1.0]));
        assert_eq!(range_about([f64::NAN, f64::INFINITY].into_iter()), None);
        assert_eq!(range_about([f64::MAX, f64::MIN].into_iter()), None);
    }
}
