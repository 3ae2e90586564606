//! What a factor smells of: a unit, a converter, a reversed sign.

use massline_shared::EstimatedValue;

/// Factors that come from units and instruments, with their meaning.
const MEANINGS: [(f64, &str); 15] = [
    (-1.0, "a reversed sign"),
    (9.806_65, "m/s² read as g"),
    (1.0 / 9.806_65, "g read as m/s²"),
    (-9.806_65, "m/s² read as g, with the sign reversed"),
    (-1.0 / 9.806_65, "g read as m/s², with the sign reversed"),
    (1000.0, "a unit a thousand times smaller, such as mm/s² or mV, read without its prefix"),
    (0.001, "a unit a thousand times larger, such as kN or V, read without its prefix"),
    (100.0, "a setting of a hundred, such as 100 mV/g beside 1 mV/g, or cm read as m"),
    (0.01, "a setting of a hundredth, such as 1 mV/g beside 100 mV/g, or m read as cm"),
    (10.0, "a setting of the amplifier: a gain of ten"),
    (0.1, "a setting of the amplifier: a gain of a tenth"),
    (4.448_222, "lbf read as N, or the reverse"),
    (1.0 / 4.448_222, "N read as lbf, or the reverse"),
    (2.0, "a differential input read as single-ended, or a range of a converter"),
    (0.5, "a differential input read as single-ended, or a range of a converter"),
];
/// A factor is recognized within this part of itself: calibrations are rarely worse.
const RECOGNIZED: f64 = 0.02;
/// The most that the uncertainty of a factor may be for it to be recognized.
const KNOWN: f64 = 0.1;
/// Number of standard deviations within which a factor is recognized.
const SIGMAS: f64 = 2.0;

/// The meaning of a factor, when it is near one that has a meaning: the readings over their true values.
pub(super) fn of_gain(gain: EstimatedValue<f64>) -> Option<&'static str> {
    let near = MEANINGS.into_iter().filter_map(|(factor, meaning)| {
        let relative = gain.value / factor - 1.0;
        let sigma = (gain.sigma / gain.value).abs();
        let is_near = sigma < KNOWN && relative.abs() < RECOGNIZED.max(SIGMAS * sigma);
        is_near.then_some((relative.abs(), meaning))
    });
    near.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, meaning)| meaning)
}

/// The meaning of a displaced coordinate that is written as `written`, m: the true value over it.
pub(super) fn of_coordinate(
    written: f64,
    displacement: EstimatedValue<f64>,
) -> Option<&'static str> {
    let is_near = |factor: f64| {
        let missed = (displacement.value - (factor - 1.0) * written).abs();
        missed < (SIGMAS * displacement.sigma).max(RECOGNIZED * (factor * written).abs())
    };
    // Both values are the same for a coordinate near zero.
    let is_clear = displacement.value.abs() > 3.0 * displacement.sigma;
    [
        (-1.0, "its sign is reversed"),
        (0.1, "it is ten times too large"),
        (10.0, "it is ten times too small"),
    ]
    .into_iter()
    .find_map(|(factor, meaning)| (is_clear && is_near(factor)).then_some(meaning))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gain(value: f64) -> Option<&'static str> {
        of_gain(EstimatedValue { value, sigma: 0.01 * value })
    }

    #[test]
    fn factors_of_units_have_a_meaning_and_others_have_none() {
        assert_eq!(gain(9.9), Some("m/s² read as g"));
        assert_eq!(gain(0.102), Some("g read as m/s²"));
        assert_eq!(gain(-1.01), Some("a reversed sign"));
        assert!(gain(1010.0).is_some_and(|meaning| meaning.contains("mm/s²")));
        assert!(gain(4.45).is_some_and(|meaning| meaning.contains("lbf")));
        for other in [1.0, 1.3, 0.77, 3.0, 7.0, -2.0] {
            assert_eq!(gain(other), None, "{other}");
        }
        assert_eq!(of_gain(EstimatedValue { value: 9.8, sigma: 3.0 }), None);
    }

    #[test]
    fn a_reversed_sign_is_recognized() {
        let moved = |value| EstimatedValue { value, sigma: 0.002 };
        assert_eq!(of_coordinate(0.25, moved(-0.501)), Some("its sign is reversed"));
        assert_eq!(of_coordinate(0.25, moved(-0.05)), None);
        assert_eq!(of_coordinate(0.0, moved(0.001)), None);
    }
}
