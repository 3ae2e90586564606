//! Tones in the readings of a channel at rest: the mains, and the screen.
//!
//! The readings get a Hann window, whose bins are `rate / readings` wide: 2 Hz over half a second. A tone between two
//! frequencies that are looked at loses amplitude: 1 % at an eighth of a bin, 4 % at a quarter, 15 % at half a bin. So
//!
//! - the mains, within half a hertz of 50 and 60 Hz, are read at most 4 % too low, at twice that 16 %;
//! - the screen, whose refresh rate is known to 10 % only, is searched in steps of half a bin: at most 4 % too low.
//!
//! Within one and a half bins of 100 and 120 Hz a tone is taken for what a rectifier makes of the mains. A screen
//! there, between 97 and 103 Hz over half a second, cannot be told from it: it is named by whichever is larger, at
//! 100 Hz or at the nearest frequency of the search, and read up to 35 % too low.

use nalgebra::Complex;

use crate::real::Real;

/// The mains, each with what a rectifier makes of them, Hz.
const MAINS: [[f64; 2]; 2] = [[50.0, 100.0], [60.0, 120.0]];
/// Refresh rates of an SSD1306 as it is set up, 105 Hz with an oscillator that is good to 10 %, Hz.
const SCREEN: [f64; 2] = [94.5, 115.5];
/// How close the search for the screen comes to twice the mains, bins.
const DISTANCE: f64 = 1.5;
/// Steps of the search, bins.
const STEP: f64 = 0.5;
/// Most steps between 94.5 and 100 Hz and between 100 and 115.5 Hz; a record of 6 s has that many.
const MOST_STEPS: f64 = 200.0;
/// How far a tone shows at other frequencies, bins: half of the window's main lobe.
const LOBE: f64 = 2.0;
/// The readings are averaged in groups to this rate, Hz: enough for the tones, and fewer to go through.
const AVERAGED_RATE: f64 = 1000.0;

/// Amplitudes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Tones<R> {
    /// At 50 Hz and twice that, and at 60 Hz and twice that. Zero at twice if that is the screen's tone.
    pub mains: [[R; 2]; 2],
    /// Of the screen, at the frequency where it is largest. Zero if that is a tone at twice the mains.
    pub screen: R,
}

impl<R: Real> Tones<R> {
    /// Measures the tones of readings whose mean is taken out. What is left in `readings` has no use.
    ///
    /// One pass over the averages for each frequency: 22 of them over half a second, and more over a longer time, in
    /// which more can be told apart.
    pub fn measure(readings: &mut [R], rate: R) -> Self {
        let bin = rate / R::of(readings.len() as f64);
        let averages = Averages::new(readings, rate);
        let mut mains = MAINS.map(|both| both.map(|hertz| averages.amplitude(R::of(hertz))));
        let (mut screen, mut screen_hertz) = (R::zero(), R::zero());
        for_each_screen(bin, |hertz| {
            let amplitude = averages.amplitude(hertz);
            if amplitude > screen {
                (screen, screen_hertz) = (amplitude, hertz);
            }
        });
        for (amplitudes, [_, twice]) in mains.iter_mut().zip(MAINS) {
            if (screen_hertz - R::of(twice)).abs() >= bin * R::of(LOBE) {
                continue;
            }
            // One tone, seen at both.
            if amplitudes[1] < screen {
                amplitudes[1] = R::zero();
            } else {
                screen = R::zero();
            }
        }
        Self { mains, screen }
    }

    /// Mean square of all tones together.
    pub fn square(&self) -> R {
        let amplitudes = self.mains.iter().flatten().chain([&self.screen]);
        amplitudes.fold(R::zero(), |sum, amplitude| sum + *amplitude * *amplitude) / R::of(2.0)
    }
}

/// Calls `look` with each frequency at which the screen is looked for, Hz: with none in a record that is too short to
/// tell it from the mains.
fn for_each_screen<R: Real>(bin: R, mut look: impl FnMut(R)) {
    let [[_, low], [_, high]] = MAINS.map(|both| both.map(R::of));
    let [slowest, fastest] = SCREEN.map(R::of);
    let (distance, largest_step) = (bin * R::of(DISTANCE), bin * R::of(STEP));
    for [from, to] in [[slowest, low - distance], [low + distance, fastest.min(high - distance)]] {
        if from > to {
            continue;
        }
        let steps = ((to - from) / largest_step).ceil().max(R::one()).min(R::of(MOST_STEPS));
        let mut step = R::zero();
        while step <= steps {
            look(from + (to - from) * step / steps);
            step += R::one();
        }
    }
}

/// Windowed readings, averaged in groups.
struct Averages<'a, R> {
    values: &'a [R],
    /// Readings in a group.
    group: R,
    rate: R,
}

impl<'a, R: Real> Averages<'a, R> {
    /// Averages in place.
    fn new(readings: &'a mut [R], rate: R) -> Self {
        let number = R::of(readings.len() as f64);
        let group = (rate / R::of(AVERAGED_RATE)).max(R::one()).to_f32() as usize;
        let step = turn(R::of(core::f64::consts::TAU) / number);
        let mut window = turn(R::zero());
        let groups = readings.len() / group;
        for at in 0..groups {
            let mut sum = R::zero();
            for reading in &readings[at * group..(at + 1) * group] {
                sum += *reading * (R::one() - window.re);
                window *= step;
            }
            // The window 1 - cos is 1 in the mean; half of an amplitude is at the negative frequency.
            readings[at] = sum * R::of(2.0) / number;
        }
        Self { values: &readings[..groups], group: R::of(group as f64), rate }
    }

    /// Amplitude at a frequency, Hz.
    fn amplitude(&self, hertz: R) -> R {
        let half_angle = R::of(core::f64::consts::PI) * hertz / self.rate;
        let step = turn(R::of(2.0) * half_angle * self.group);
        let mut rotation = turn(R::zero());
        let mut total = Complex::new(R::zero(), R::zero());
        // The rotation loses a few parts in a hundred thousand over 512 steps in single precision.
        for value in self.values {
            total += Complex::new(rotation.re * *value, rotation.im * *value);
            rotation *= step;
        }
        // What the sum over a group leaves of the tone, over the number of its readings.
        let left = (half_angle * self.group).sin() / (self.group * half_angle.sin());
        (total.re * total.re + total.im * total.im).sqrt() / left
    }
}

fn turn<R: Real>(angle: R) -> Complex<R> {
    Complex::new(angle.cos(), angle.sin())
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::*;

    fn measured(hertz: f64, amplitude: f64, readings: usize) -> Tones<f64> {
        let angle = |n: usize| core::f64::consts::TAU * hertz * n as f64 / 4000.0 + 0.7;
        let mut readings: Vec<f64> =
            (0..readings).map(|n| amplitude * libm::sin(angle(n))).collect();
        Tones::measure(&mut readings, 4000.0)
    }

    #[test]
    fn the_screen_is_found_at_all_of_its_rates_but_those_of_a_rectifier() {
        for tenth in 945..=1155 {
            let hertz = f64::from(tenth) / 10.0;
            let Tones { mains, screen } = measured(hertz, 1.0, 2048);
            let [[mains_50, twice_50], [mains_60, twice_60]] = mains;
            // 50 Hz is more than 20 bins away, where the window shows 1e-4; 120 Hz 2.3 bins, where it shows 3 %.
            assert!(mains_50 < 1e-3 && mains_60 < 1e-3 && twice_60 < 0.035, "{hertz}: {mains:?}");
            let largest = screen.max(twice_50);
            match (hertz - 100.0).abs() {
                // A quarter of a bin loses 4 %.
                off if off > 2.93 => {
                    assert!(screen > 0.955 && twice_50 < 0.06, "{hertz}: {screen} {mains:?}")
                }
                // Midway between 100 Hz and the nearest frequency of the search, three quarters of a bin.
                off if off > 1.5 => assert!(screen > 0.65 && twice_50 == 0.0, "{hertz}: {screen}"),
                off if off < 1.4 => assert!(twice_50 > 0.65 && screen == 0.0, "{hertz}: {screen}"),
                _ => assert!(largest > 0.65, "{hertz}: {screen} {mains:?}"),
            }
            assert!(largest < 1.001, "{hertz}: {screen} {mains:?}");
        }
    }

    #[test]
    fn the_mains_lose_what_is_stated_and_are_not_taken_for_the_screen() {
        for (which, hertz) in [(0, 50.0), (1, 60.0)] {
            for off in [-0.5, -0.4, -0.2, 0.0, 0.25, 0.5] {
                let Tones { mains, screen } = measured(hertz + off, 1.0, 2048);
                // 0.5 Hz are 0.256 bins: sin(0.256 π)/(0.256 π)/(1 - 0.256²) = 0.959.
                assert!((0.958..1.001).contains(&mains[which][0]), "{hertz} {off}: {mains:?}");
                assert!(screen < 1e-3, "{hertz} {off}: {screen}");
                let Tones { mains, screen } = measured(2.0 * (hertz + off), 1.0, 2048);
                // Twice that: 0.842.
                assert!((0.841..1.001).contains(&mains[which][1]), "{hertz} {off}: {mains:?}");
                assert!(screen < 0.13, "{hertz} {off}: {screen}");
            }
        }
    }

    #[test]
    fn two_tones_that_are_far_enough_apart_are_both_measured() {
        let angle = |hertz: f64, n: usize| core::f64::consts::TAU * hertz * n as f64 / 4000.0;
        let both = |n| 3.0 * libm::sin(angle(100.0, n)) + libm::cos(angle(108.3, n));
        let mut readings: Vec<f64> = (0..2048).map(both).collect();
        let Tones { mains, screen } = Tones::measure(&mut readings, 4000.0);
        // At four bins the window shows 0.1 % of the other, and the search loses 4 %.
        assert!(
            (mains[0][1] - 3.0).abs() < 0.01 && (screen - 1.0).abs() < 0.05,
            "{mains:?} {screen}"
        );
    }

    #[test]
    fn a_short_record_shows_no_screen_and_a_long_one_more_of_its_rates() {
        // A tenth of a second: 100 Hz cannot be told from any rate of the screen.
        let count = |readings: f64| {
            let mut count = 0;
            for_each_screen(4000.0 / readings, |_: f64| count += 1);
            count
        };
        assert_eq!(count(384.0), 0);
        assert_eq!(measured(106.0, 1.0, 384).screen, 0.0);
        // Half a second, as the documentation of `measure` has it: these and four of the mains.
        assert_eq!(count(2048.0), 18);
        // Two seconds tell 98.5 Hz from 100 Hz.
        assert!(measured(98.5, 1.0, 8192).screen > 0.955);
    }

    #[test]
    fn a_rate_that_no_rig_has_ends_as_well() {
        for rate in [0.0, -1.0, f64::NAN, f64::INFINITY, f64::MIN_POSITIVE, f64::MAX] {
            for readings in [0, 1, 2048] {
                Tones::measure(&mut std::vec![1.0; readings], rate);
                Tones::measure(&mut std::vec![1.0_f32; readings], rate as f32);
            }
        }
    }
}
