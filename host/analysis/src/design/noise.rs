//! The noise that is assumed of an accelerance in the suspension profile, where none is stated.
//!
//! A response is transformed under the window `e^(−σt)` over the length T of its record. White noise of the one-sided
//! density a leaves the variance `a² E/2` in every line, with the energy of the window
//! `E = ∫ e^(−2σt) dt = (1 − e^(−2σT))/2σ`. An accelerance is the response over the impulse p of the hit, as far as the
//! force lasts much less than a period:
//!
//! ```text
//! σ_H = a √(E/2) / p
//! ```
//! The codes of the converter are unequally wide. What that adds moves with the signal: the more codes the motion
//! passes over, the less the widths add to it, and under a window that ends sooner they add less, as the motion does.
//! It has no formula. On the bench with 0.5 LSB of differential nonlinearity (three tests each, impulses of 0.26 to
//! 1.05 N s on 17.3 kg, σ of 0.05 to 0.2 1/s) it grows with the 0.35th power of the speed p/m that the hit gives and
//! with the fourth root of E.

use massline_shared::STANDARD_GRAVITY;
use massline_shared::layout::TestSettings;

/// One-sided density of the white noise of a channel, g/√Hz: 290 µg/√Hz (data sheet of the ADXL326); 2.5 % for what a
/// low-pass of 500 Hz lets alias at 4 kS/s, and 4 % for the rounding to codes of 13 mg.
const WHITE: f64 = 310e-6;
/// Spectrum of what unequal codes add after a hit of [`SPEED`] under a window of the energy [`ENERGY`], m/s.
const CODES: f64 = 0.0053;
/// Speed that 1.05 N s give 17.3 kg, m/s.
const SPEED: f64 = 0.061;
/// Energy of the default window of 0.1 1/s, s.
const ENERGY: f64 = 5.0;

/// Standard deviation of an accelerance of one hit, of a complex number, (m/s²)/N. The test's own settings count: the
/// mean of its impulses and its window; `mass` is that of the object, kg, and `record_s` the length of a record from
/// the hit on.
pub(super) fn of_one_hit(test: &TestSettings<f64>, mass: f64, record_s: f64) -> f64 {
    let [least, most] = test.impulse_ns;
    let impulse = (least + most) / 2.0;
    let energy = window_energy(test.exponential_decay, record_s);
    let white = of_white_noise(impulse, test.exponential_decay, record_s);
    let codes = CODES * (impulse / mass / SPEED).powf(0.35) * (energy / ENERGY).powf(0.25);
    white.hypot(codes / impulse)
}

/// What the white noise of a channel adds to it after an impulse, N s, under a window of this decay, 1/s.
pub(super) fn of_white_noise(impulse: f64, decay: f64, record_s: f64) -> f64 {
    WHITE * STANDARD_GRAVITY * (window_energy(decay, record_s) / 2.0).sqrt() / impulse
}

/// `∫ e^(−2σt) dt` over a record, s; without a window it is the length of the record.
pub(super) fn window_energy(decay: f64, record_s: f64) -> f64 {
    if decay > 0.0 { -(-2.0 * decay * record_s).exp_m1() / (2.0 * decay) } else { record_s }
}

#[cfg(test)]
mod tests {
    use massline_shared::layout::TestProfile;

    use super::*;

    /// Long enough for every window of these tests but the absent one.
    const RECORD_S: f64 = 200.0;

    fn noise(impulse: f64, decay: f64, mass: f64) -> f64 {
        let test = TestSettings {
            impulse_ns: [0.8 * impulse, 1.2 * impulse],
            exponential_decay: decay,
            ..TestSettings::of_profile(TestProfile::Suspension)
        };
        of_one_hit(&test, mass, RECORD_S)
    }

    #[test]
    fn white_noise_goes_with_the_root_of_the_window_s_energy_and_against_the_impulse() {
        // An object that hardly moves passes over no codes.
        let white = |impulse, decay| noise(impulse, decay, 1e30);
        let usual = white(1.0, 0.1);
        // 310 µg/√Hz and a window of 5 s.
        assert!((usual / (310e-6 * 9.80665 * 2.5_f64.sqrt()) - 1.0).abs() < 1e-9, "{usual}");
        assert!((white(0.25, 0.1) / usual - 4.0).abs() < 1e-6);
        assert!((white(1.0, 0.4) / usual - 0.5).abs() < 1e-6);
        // Without a window all of the record counts.
        assert!((white(1.0, 0.0) / usual - (RECORD_S / 5.0).sqrt()).abs() < 1e-6);
    }

    #[test]
    fn what_the_codes_add_falls_more_slowly_than_white_noise() {
        let codes = |impulse: f64| {
            let [combined, white] = [17.3, 1e30].map(|mass| noise(impulse, 0.1, mass));
            (combined * combined - white * white).sqrt()
        };
        let ratio = codes(0.25) / codes(1.0);
        assert!((ratio / 4.0_f64.powf(0.65) - 1.0).abs() < 1e-6, "{ratio}");
    }
}
