//! Finds the band of the mass line from the data: above the suspension modes, below the elastic ones.

use crate::real::Real;

/// Ratio of the lower end to the highest suspension mode (theory, section 5).
pub const ABOVE_SUSPENSION: f64 = 3.0;
/// Ratio of the upper end to the first elastic mode (theory, section 5).
pub const BELOW_ELASTIC: f64 = 0.4;
/// A peak counts as a mode when it exceeds the higher of the two valleys beside it by this factor, in squares
/// of accelerances: one decibel. The noise of averaged spectra is far below that.
const PROMINENCE: f64 = 1.26;
/// A mode below this number of σ of the exponential window makes no such peak: `|s²/(s² + ω₀²)|²` at
/// `s = σ + iω₀` is 1.26 for `ω₀ = 1.7 σ`.
const HIDDEN: f64 = 1.7;

/// The band and the modes that limit it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FoundBand<R> {
    /// Lower and upper end, Hz.
    pub ends: [R; 2],
    /// The highest suspension mode, Hz; `None` when none is visible because it lies below the first bin or
    /// is hidden by the window.
    pub suspension: Option<R>,
    /// The first elastic mode, Hz; `None` when none is visible up to the last bin, which then takes its
    /// place.
    pub elastic: Option<R>,
}

/// Finds the band from the squares of accelerances. These are summed over all available channels and hits, so
/// that a node or an antiresonance of a single one does not matter.
///
/// The modes are the peaks of the sum. The plateau lies in the widest gap between two neighbouring modes on a
/// logarithmic scale: rigid body modes on soft cords lie within an octave or two, neighbouring elastic modes
/// differ by factors below three, and a usable plateau is wider than both. The first and the last bin limit
/// the gap where no mode does. Theory, section 5, has the factors.
///
/// `squares[k]` belongs to the bin at `frequency(k)`, Hz, ascending; `decay` is σ of the exponential window,
/// 1/s. `None` when there are no bins, or when the gap leaves no band between three times its lower and 0.4
/// times its upper end.
///
/// ```
/// # use massline_shared::mass_line::{ABOVE_SUSPENSION, BELOW_ELASTIC, find_band};
/// # use massline_shared::nalgebra::Complex;
/// // A suspension mode at 4 Hz and an elastic one at 200 Hz, bins 0.5 Hz apart.
/// let frequency = |bin: usize| 0.5 * bin as f64;
/// let mode = |f: f64, f0: f64| {
///     let ratio = f / f0;
///     ratio * ratio / Complex::new(1.0 - ratio * ratio, 0.02 * ratio)
/// };
/// let squares: Vec<f64> = (0..500)
///     .map(|bin| (mode(frequency(bin), 4.0) + mode(frequency(bin), 200.0)).norm_sqr())
///     .collect();
/// let band = find_band(&squares, frequency, 0.0).unwrap();
/// assert!((band.ends[0] - ABOVE_SUSPENSION * 4.0).abs() < 0.5);
/// assert!((band.ends[1] - BELOW_ELASTIC * 200.0).abs() < 1.0);
/// ```
pub fn find_band<R: Real>(
    squares: &[R],
    frequency: impl Fn(usize) -> R,
    decay: R,
) -> Option<FoundBand<R>> {
    let first = (0..squares.len()).map(&frequency).find(|f| *f > R::zero())?;
    let last = frequency(squares.len() - 1);
    let mut widest: Option<[Edge<R>; 2]> = None;
    let mut below = Edge { frequency: first, mode: false };
    let peaks = (1..squares.len().saturating_sub(1))
        .filter(|&k| is_mode(squares, k))
        .map(|k| Edge { frequency: summit(squares, &frequency, k), mode: true });
    for above in peaks.chain([Edge { frequency: last, mode: false }]) {
        let wider = widest.is_none_or(|[low, high]| {
            above.frequency * low.frequency > high.frequency * below.frequency
        });
        if wider && above.frequency > below.frequency {
            widest = Some([below, above]);
        }
        below = above;
    }
    let [low, high] = widest?;
    let hidden = decay * R::of(HIDDEN) / R::two_pi();
    let ends = [
        low.frequency.max(hidden) * R::of(ABOVE_SUSPENSION),
        high.frequency * R::of(BELOW_ELASTIC),
    ];
    let band = FoundBand {
        ends,
        suspension: low.mode.then_some(low.frequency),
        elastic: high.mode.then_some(high.frequency),
    };
    (ends[0] < ends[1]).then_some(band)
}

/// An end of a gap between two modes.
#[derive(Clone, Copy)]
struct Edge<R> {
    frequency: R,
    /// False for the first and the last bin.
    mode: bool,
}

/// True for a peak that is high enough above the valleys on both sides.
fn is_mode<R: Real>(squares: &[R], k: usize) -> bool {
    let peak = squares[k];
    if !(peak > squares[k - 1] && peak >= squares[k + 1]) {
        return false;
    }
    // The valley on a side ends at the next higher bin.
    let valley = |lowest: R, v: &R| lowest.min(*v);
    let left = squares[..k].iter().rev().take_while(|v| **v <= peak).fold(peak, valley);
    let right = squares[k + 1..].iter().take_while(|v| **v <= peak).fold(peak, valley);
    peak > left.max(right) * R::of(PROMINENCE)
}

/// Frequency of a peak between the bins: the vertex of the parabola through the logarithms.
fn summit<R: Real>(squares: &[R], frequency: &impl Fn(usize) -> R, k: usize) -> R {
    let [before, at, after] = [k - 1, k, k + 1].map(|k| squares[k].ln());
    let half = R::of(0.5);
    let shift = half * (before - after) / (before - at - at + after);
    let step = half * (frequency(k + 1) - frequency(k - 1));
    if shift.finite() && shift.abs() <= half { frequency(k) + shift * step } else { frequency(k) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Complex;
    use std::vec::Vec;

    const RESOLUTION: f64 = 4000.0 / 2048.0;

    fn frequency(k: usize) -> f64 {
        RESOLUTION * k as f64
    }

    /// Sum over three channels of `Σ a s²/(s² + 2ζω₀ s + ω₀²)`; the signs of `a` differ, so that the
    /// channels have antiresonances.
    fn squares(modes_hz: &[f64], bins: usize, decay: f64, noise: f64) -> Vec<f64> {
        let mut state = 5_u64;
        let mut random = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            ((state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5) * noise
        };
        (0..bins)
            .map(|k| {
                let s = Complex::new(decay, std::f64::consts::TAU * frequency(k));
                (0..3)
                    .map(|channel| {
                        let mut h = Complex::new(random(), random());
                        for (r, f) in modes_hz.iter().enumerate() {
                            let w = std::f64::consts::TAU * f;
                            let sign = if r > 0 && (channel + r) % 3 == 0 { -0.5 } else { 1.0 };
                            h += s * s / (s * s + s * (0.02 * w) + w * w) * sign;
                        }
                        h.norm_sqr()
                    })
                    .sum()
            })
            .collect()
    }

    fn band_of(modes_hz: &[f64], bins: usize, noise: f64) -> FoundBand<f64> {
        find_band(&squares(modes_hz, bins, 10.0, noise), frequency, 10.0).unwrap()
    }

    #[test]
    fn the_band_lies_between_the_highest_suspension_and_the_first_elastic_mode() {
        // The wheel of theory, section 11, with elastic modes like those of the bar.
        let modes = [2.82, 3.22, 3.56, 6.14, 7.16, 7.66, 314.0, 515.0, 642.0];
        for noise in [0.0, 0.1] {
            let band = band_of(&modes, 512, noise);
            // The highest is at 7.66 Hz. Two modes half a hertz apart are one peak at this resolution, and
            // the window moves peaks of accelerances up: half a bin each.
            let suspension = band.suspension.unwrap();
            assert!((6.7..9.7).contains(&suspension), "{band:?}");
            assert!((band.elastic.unwrap() / 314.0 - 1.0).abs() < 0.01, "{band:?}");
            assert_eq!(band.ends, [3.0 * suspension, 0.4 * band.elastic.unwrap()]);
        }
    }

    #[test]
    fn where_no_elastic_mode_shows_the_last_line_stands_for_it() {
        let band = band_of(&[2.0, 3.5, 5.0, 314.0], 128, 0.02);
        assert!(band.elastic.is_none() && band.suspension.is_some(), "{band:?}");
        assert_eq!(band.ends[1], 0.4 * frequency(127));
    }

    #[test]
    fn what_the_window_hides_of_the_suspension_stays_below_the_band() {
        let band = band_of(&[1.4, 314.0], 512, 0.02);
        // 1.7 σ / 2π = 2.7 Hz, whether a peak is visible or not.
        assert!(band.ends[0] >= 3.0 * 17.0 / std::f64::consts::TAU - 1e-12, "{band:?}");
    }

    #[test]
    fn single_precision_finds_the_same() {
        let squares = squares(&[3.5, 6.0, 200.0], 256, 10.0, 0.02);
        let single: Vec<f32> = squares.iter().map(|v| *v as f32).collect();
        let double = find_band(&squares, frequency, 10.0).unwrap();
        let single = find_band(&single, |k| frequency(k) as f32, 10.0).unwrap();
        for k in 0..2 {
            // The parabolas pass through logarithms with seven digits.
            assert!((f64::from(single.ends[k]) / double.ends[k] - 1.0).abs() < 1e-4);
        }
    }

    #[test]
    fn modes_without_a_gap_leave_no_band() {
        let modes: Vec<f64> = (0..9).map(|k| 5.0 * 1.7_f64.powi(k)).collect();
        assert_eq!(find_band(&squares(&modes, 200, 10.0, 0.0), frequency, 10.0), None);
        assert_eq!(find_band::<f64>(&[], frequency, 10.0), None);
        assert_eq!(find_band(&[1.0], frequency, 10.0), None);
        assert_eq!(find_band(&[f64::NAN; 30], frequency, 10.0).map(|b| b.elastic), Some(None));
    }
}
