//! Whether the noise of the readings is the same at all lines, and what it is where it is not.
//!
//! What a converter adds that does not average, because its codes are unequally wide, follows the signal: it is there
//! where the readings are, about the modes, and what it adds at one line it adds at the next. So does motion that was
//! left over from before a hit. Taken as white noise, the lines about the modes would count for more than they are
//! worth: the intervals would be too narrow, and what follows the modes would look like a flexible mode.

use massline_shared::FrequencyResponses;
use nalgebra::Complex;

/// Standard normal deviate of the scatter of the lines' variances from which the noise is uneven: chance gives it once
/// in 30 000 tests.
const UNEVEN: f64 = 4.0;
/// Smallest variance of a line, relative to the mean.
const LEAST: f64 = 0.01;
/// Most lines over which noise is taken to be correlated: a mode with its damping and the window of the records is
/// narrower.
const REACH: usize = 6;

/// Noise that is not the same at all lines.
#[derive(Clone, Debug, Default)]
pub(super) struct UnevenNoise {
    /// Precision of every line relative to the mean noise: the reciprocal of its standard deviation.
    pub(super) precision: Vec<f64>,
    /// Factor on standard deviations because neighbouring lines are correlated.
    pub(super) correlation: f64,
}

impl UnevenNoise {
    /// The noise of readings of which a fit leaves this, in their order; `None` where chance explains the scatter of
    /// the lines.
    pub(super) fn of(
        left: &[Complex<f64>],
        readings: &FrequencyResponses<'_, f64>,
    ) -> Option<Self> {
        let of_line = readings.channels() * readings.hits();
        let lines: Vec<&[Complex<f64>]> = left.chunks_exact(of_line.max(1)).collect();
        let squares: Vec<f64> = lines.iter().map(|line| mean_product(line, line)).collect();
        let count = squares.len() as f64;
        let mean = squares.iter().sum::<f64>() / count;
        // Real and imaginary parts.
        let freedom = 2.0 * of_line as f64;
        let scatter: f64 = squares.iter().map(|square| (square / mean - 1.0).powi(2)).sum();
        // χ² of as many lines; the window makes neighbours dependent.
        let deviate =
            (scatter * freedom / 2.0 - count) / ((2.0 * count).sqrt() * readings.correlation);
        (deviate > UNEVEN).then(|| {
            let smooth = smoothed(&squares);
            let mean = smooth.iter().sum::<f64>() / count;
            let precision: Vec<f64> =
                smooth.iter().map(|square| (mean / square.max(LEAST * mean)).sqrt()).collect();
            let correlation = correlation(&lines, &precision).max(readings.correlation);
            Self { precision, correlation }
        })
    }
}

/// Root of one plus twice the sum of the correlation coefficients of a line with the following ones, up to the first
/// that is not positive.
fn correlation(lines: &[&[Complex<f64>]], precision: &[f64]) -> f64 {
    let product = |lag: usize| {
        let pairs = (lag..lines.len()).map(|place| {
            let weight = precision[place] * precision[place - lag];
            weight * mean_product(lines[place], lines[place - lag])
        });
        pairs.sum::<f64>()
    };
    let own = product(0);
    let coefficients = (1..=REACH).map(|lag| product(lag) / own);
    (1.0 + 2.0 * coefficients.take_while(|rho| *rho > 0.0).sum::<f64>()).sqrt()
}

/// Mean of the real parts of `ā b`.
fn mean_product(a: &[Complex<f64>], b: &[Complex<f64>]) -> f64 {
    let sum: f64 = a.iter().zip(b).map(|(a, b)| a.re * b.re + a.im * b.im).sum();
    sum / a.len().max(1) as f64
}

/// Half of each value, and a quarter of each of its neighbours.
fn smoothed(values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let at = |place: usize| {
        let neighbours = values[place.saturating_sub(1)] + values[(place + 1).min(last)];
        0.5 * values[place] + 0.25 * neighbours
    };
    (0..values.len()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const LINES: usize = 120;
    const CHANNELS: usize = 9;
    const HITS: usize = 5;

    /// Numbers from -1 to 1 by the generator of Steele, Lea and Flood.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
            let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
            let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
            (z >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        }

        fn complex(&mut self) -> Complex<f64> {
            Complex::new(self.next(), self.next())
        }
    }

    /// What the noise of residuals is taken for, whose lines have these standard deviations; every second line repeats
    /// a part of the one before.
    fn noise(of_line: impl Fn(usize) -> f64, repeated: f64) -> Option<UnevenNoise> {
        let frequencies: Vec<f64> = (0..LINES).map(|line| line as f64 / 10.0).collect();
        let mut random = Random(3);
        let mut left: Vec<Complex<f64>> = Vec::new();
        for line in 0..LINES {
            for _reading in 0..CHANNELS * HITS {
                let own = random.complex() * of_line(line);
                let before = left.len().checked_sub(CHANNELS * HITS).map(|at| left[at]);
                let shared = before.filter(|_| !line.is_multiple_of(2)).unwrap_or_default();
                left.push(own + shared * repeated);
            }
        }
        let readings = FrequencyResponses::new(&frequencies, &left, CHANNELS, HITS).unwrap();
        UnevenNoise::of(&left, &readings)
    }

    #[test]
    fn even_noise_is_left_as_it_is() {
        assert!(noise(|_| 1e-3, 0.0).is_none());
    }

    #[test]
    fn lines_about_a_mode_have_the_precision_of_their_noise() {
        let of_line = |line: usize| if (40..60).contains(&line) { 3e-3 } else { 1e-3 };
        let uneven = noise(of_line, 0.0).expect("uneven noise");
        // Means of 360 numbers on one side of each, and chance in the largest of twenty.
        let ratio = uneven.precision[20] / uneven.precision[50];
        assert!((ratio / 3.0 - 1.0).abs() < 0.2, "{ratio}");
        let mean = uneven.precision.iter().map(|p| p.powi(-2)).sum::<f64>() / LINES as f64;
        assert!((mean - 1.0).abs() < 1e-12, "{mean}");
        // 119 products of 45 readings scatter by 1 %.
        assert!((uneven.correlation - 1.0).abs() < 0.05, "{}", uneven.correlation);
    }

    #[test]
    fn what_neighbouring_lines_share_counts_as_correlation() {
        let of_line = |line: usize| if (40..60).contains(&line) { 3e-3 } else { 1e-3 };
        let uneven = noise(of_line, 1.0).expect("uneven noise");
        // Every second pair shares one half of the variance of two, so that the coefficients of all pairs add up to
        // a half of √½ before the lines' precision, which is smoothed over three, changes that by a fifth.
        let expected = (1.0 + 2.0 * 0.5 * 0.5_f64.sqrt()).sqrt();
        assert!((uneven.correlation / expected - 1.0).abs() < 0.1, "{}", uneven.correlation);
    }
}
