//! Tones in the readings of a channel at rest.

use nalgebra::Complex;

use crate::Real;

/// Frequencies that belong together, Hz.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tone([f64; 2]);

impl Tone {
    /// The mains, each with what a rectifier makes of them; an SSD1306 as it is set up, whose oscillator is good to 10 %: both
    /// sides of its 105 Hz.
    pub const ALL: [Self; 3] = [Self([50.0, 100.0]), Self([60.0, 120.0]), Self([105.0, 109.0])];
}

/// Amplitudes of the frequencies of a tone, by a Hann window over the readings, whose mean is taken out. A frequency that is
/// off by a quarter of a hertz loses 1 % over half a second.
pub(super) fn amplitude<R: Real>(readings: &[R], tone: Tone, rate: R) -> [R; 2] {
    tone.0.map(|hertz| single(readings, R::of(core::f64::consts::TAU * hertz) / rate))
}

/// Amplitude of the tone with this angle from one reading to the next.
fn single<R: Real>(readings: &[R], angle: R) -> R {
    /// Readings after which the rotations begin anew from exact ones.
    const BLOCK: usize = 128;
    let number = R::of(readings.len() as f64);
    let turn = |angle: R| Complex::new(angle.cos(), angle.sin());
    let window_angle = R::of(core::f64::consts::TAU) / number;
    let (step, window_step) = (turn(angle), turn(window_angle));
    let mut total = Complex::new(R::zero(), R::zero());
    for (block, readings) in readings.chunks(BLOCK).enumerate() {
        let start = R::of((block * BLOCK) as f64);
        let (mut rotation, mut window) = (turn(angle * start), turn(window_angle * start));
        for reading in readings {
            let weight = *reading * (R::one() - window.re);
            total += Complex::new(rotation.re * weight, rotation.im * weight);
            (rotation, window) = (rotation * step, window * window_step);
        }
    }
    // The window 1 - cos sums up to the number of readings; half of the amplitude is at the negative frequency.
    (total.re * total.re + total.im * total.im).sqrt() * R::of(2.0) / number
}
