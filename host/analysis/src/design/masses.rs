//! The masses that sensors and hammer can measure with a layout, before anything is hit.
//!
//! A rigid body of a given shape answers a force `F` with accelerations `F k/m` at its sensors; k is 1 at the centre of
//! mass and grows with the distance from it. Below the lightest mass, the weakest hit that is accepted exceeds the
//! range of a sensor. Above the heaviest, the noise of a hit as hard as the hammer's channel shows is a larger part of
//! the answer than is of use.

use massline_shared::STANDARD_GRAVITY;
use massline_shared::body::RigidBody;
use massline_shared::layout::{HostLayout, TestProfile};
use massline_shared::signal::Calibration;

use super::noise;

/// The hardest hit that the hammer's channel shows, N: 3.2 V at 22.5 mV/N.
const HARDEST_N: f64 = 140.0;
/// How long such a hit lasts with the usual tip, s: half a period of a sine.
const PULSE_S: f64 = 0.002;
/// Length of a record after the hit, s.
const RECORD_S: f64 = 0.5;
/// The largest noise of one hit that is of use, relative to 1/m.
const NOISIEST: f64 = 0.02;

/// The masses that objects of the assumed shape may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassRange {
    /// Below this mass every hit exceeds the range of a sensor, kg.
    pub lightest: f64,
    /// Below this mass some hits do, kg.
    pub lightest_everywhere: f64,
    /// Above this mass the noise of one hit is too large, kg; `None` in the suspension profile, whose forecast has the
    /// noise.
    pub heaviest: Option<f64>,
    /// The weakest hit that is accepted, N.
    pub weakest_n: f64,
}

impl MassRange {
    /// The range for objects of the shape of this body; `None` when no hit moves it.
    pub fn of(layout: &HostLayout, body: &RigidBody<f64>) -> Option<Self> {
        let largest = |hit| Some(layout.accelerance(body, hit)?.largest());
        let shapes: Vec<f64> =
            (0..layout.hits.len()).filter_map(largest).map(|most| most * body.mass).collect();
        let test = &layout.test;
        let weakest_n = test.trigger_n.max(test.min_peak_force_n);
        // Gravity takes a part of the range.
        let rest = if layout.senses_gravity() { 1.0 } else { 0.0 };
        let range = (Calibration::ADXL326_RANGE_G - rest) * STANDARD_GRAVITY;
        let mass = |shape: f64| weakest_n * shape / range;
        let lightest = shapes.iter().copied().reduce(f64::min).map(mass)?;
        let lightest_everywhere = shapes.iter().copied().reduce(f64::max).map(mass)?;
        let is_usable = lightest.is_finite() && lightest > 0.0 && lightest_everywhere.is_finite();
        let heaviest = (test.profile == TestProfile::MassLine).then(|| {
            let impulse = HARDEST_N * PULSE_S * 2.0 / std::f64::consts::PI;
            let [from, to] = test.expected_band();
            let lines = ((to - from) * RECORD_S).max(1.0);
            NOISIEST
                / (noise::of_white_noise(impulse, test.exponential_decay, RECORD_S) / lines.sqrt())
        });
        is_usable.then_some(Self { lightest, lightest_everywhere, heaviest, weakest_n })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::design::body_for_checks;
    use massline_files::layout_file::LayoutFile;

    /// An L of 8 cm with three sensors, of 120 g.
    const BRACKET: &str = r#"
sensors = [1, 2, 3]
hits = ["1:+X", "2:+Y", "3:+Z"]
node = [
    { id = 1, position_m = [0.0, 0.0, 0.0] },
    { id = 2, position_m = [0.08, 0.0, 0.0] },
    { id = 3, position_m = [0.0, 0.08, 0.02] },
]
[reference]
mass_kg = 0.12
"#;

    fn range(text: &str) -> (MassRange, f64) {
        let file = LayoutFile::parse(text, "bracket.toml").unwrap();
        let (body, _) = body_for_checks(&file);
        (MassRange::of(&file.layout, &body).unwrap(), body.mass)
    }

    #[test]
    fn the_lightest_mass_is_that_of_the_weakest_hit_at_the_range_of_the_sensors() {
        let (masses, mass) = range(BRACKET);
        let file = LayoutFile::parse(BRACKET, "bracket.toml").unwrap();
        let (mut body, _) = body_for_checks(&file);
        // The same shape with the lightest mass: its hit of 8 N reads 15 g, and one of gravity is left.
        body.inertia *= masses.lightest / mass;
        body.mass = masses.lightest;
        let reads = (0..3).map(|hit| file.layout.accelerance(&body, hit).unwrap().largest() * 8.0);
        let least = reads.fold(f64::INFINITY, f64::min);
        assert!((least / (15.0 * STANDARD_GRAVITY) - 1.0).abs() < 1e-12, "{least}");
        assert!(masses.lightest <= masses.lightest_everywhere);
    }

    #[test]
    fn a_bracket_is_far_from_the_heaviest_object() {
        let heaviest = range(BRACKET).0.heaviest.unwrap();
        assert!((20.0..200.0).contains(&heaviest), "{heaviest}");
    }

    #[test]
    fn the_range_goes_with_the_weakest_hit_and_not_with_the_stated_mass() {
        let (one, _) = range(BRACKET);
        let (heavy, _) = range(&BRACKET.replace("0.12", "12.0"));
        assert!((heavy.lightest / one.lightest - 1.0).abs() < 1e-9);
        let (strong, _) = range(&format!("{BRACKET}[test]\nmin_peak_force_n = 16.0\n"));
        assert!((strong.lightest / one.lightest - 2.0).abs() < 1e-9);
        // A hit below the trigger level is never recorded.
        let (level, _) =
            range(&format!("{BRACKET}[test]\nmin_peak_force_n = 1.0\ntrigger_n = 4.0\n"));
        assert!((level.lightest / one.lightest - 0.5).abs() < 1e-9);
    }
}
