//! Which masses sensors and hammer can measure with a layout, in words.

use massline_analysis::design::MassRange;
use massline_shared::signal::Calibration;

use super::two_digits;

/// The range, as a sentence.
pub fn masses_text(masses: &MassRange) -> String {
    let MassRange { lightest, lightest_everywhere, heaviest, weakest_n } = masses;
    let range = Calibration::ADXL326_RANGE_G;
    let upper = heaviest
        .map_or_else(String::new, |heaviest| format!(" to about {} kg", two_digits(heaviest)));
    format!(
        "masses: sensors of ±{range:.0} g and hits from {weakest_n:.0} N measure objects of this shape from about {} \
         kg{upper}; below {} kg every hit exceeds the range of a sensor",
        two_digits(*lightest_everywhere),
        two_digits(*lightest),
    )
}

/// A warning about an object of this mass, kg, that is outside of the range.
pub fn mass_warning(masses: &MassRange, mass: f64) -> Option<String> {
    let MassRange { lightest, lightest_everywhere, heaviest, weakest_n } = *masses;
    let range = Calibration::ADXL326_RANGE_G;
    let too_light = |hits: &str| {
        format!(
            "{hits} of {weakest_n:.0} N, the weakest that is accepted, exceeds ±{range:.0} g of a sensor on an object \
             of {} kg and is rejected: use a softer tip with a smaller test.min_peak_force_n and test.trigger_n, \
             sensors of a larger range, or a known body glued to the object ([[attached]])",
            two_digits(mass)
        )
    };
    match () {
        () if mass < lightest => Some(too_light("every hit")),
        () if mass < lightest_everywhere => Some(too_light("at some of the hit points a hit")),
        () if heaviest.is_some_and(|heaviest| mass > heaviest) => Some(format!(
            "an object of {} kg answers the hardest hit that the hammer's channel shows with little more than noise: \
             average more hits (test.hits_per_dof), or use a heavier hammer and more sensitive sensors",
            two_digits(mass)
        )),
        () => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_object_outside_of_the_range_is_warned_of() {
        let masses = MassRange {
            lightest: 0.05,
            lightest_everywhere: 0.1,
            heaviest: Some(50.0),
            weakest_n: 8.0,
        };
        let warning = |mass: f64| mass_warning(&masses, mass).unwrap_or_default();
        assert!(
            warning(masses.lightest * 0.99).starts_with("every hit of 8 N"),
            "{}",
            warning(0.01)
        );
        assert!(warning(masses.lightest_everywhere * 0.999).contains("hit of 8 N"));
        assert_eq!(warning(masses.lightest_everywhere * 1.01), "");
        let heaviest = 50.0;
        assert!(warning(heaviest * 1.01).contains("little more than noise"));
        assert_eq!(warning(heaviest * 0.99), "");
    }
}
