//! The lines about the modes, which direct identification uses: a few on either side of every mode.
//!
//! Near a mode the responses are far above the noise, and mass and stiffness nearly cancel, so that both show. All
//! lines together are 14 times worse than those about the modes, because the equations have equal weights (theory,
//! section 6).

use heapless::Vec;

use super::vector_fitting::MOST_PAIRS;
use crate::real::Real;
use crate::sorting::sort_short;

/// Most lines on each side of a mode.
pub const LINES_OF_A_SIDE: usize = 4;
/// Fewest lines on each side of a mode, whatever its width.
const FEWEST: usize = 2;
/// Most lines of each set.
pub const MOST_OF_A_SET: usize = MOST_PAIRS * LINES_OF_A_SIDE;

/// Frequency and damping ratio of a mode about which lines are chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Peak<R> {
    /// Natural frequency, Hz.
    pub frequency_hz: R,
    /// Damping ratio.
    pub damping_ratio: R,
}

/// The lines of the two sets, as places in the list of frequencies.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Lines {
    /// Those below their mode.
    pub below: Vec<usize, MOST_OF_A_SET>,
    /// Those above their mode.
    pub above: Vec<usize, MOST_OF_A_SET>,
}

/// How many lines are chosen on each side of a mode.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LinesPerSide {
    /// Those within the width `2ζf`, at least two and at most [`LINES_OF_A_SIDE`].
    #[default]
    Width,
    /// This many, at most [`LINES_OF_A_SIDE`]; the literature takes two.
    Fixed(usize),
}

/// Chooses the lines about each mode. A line between two modes belongs to the nearer one, so none is in both sets.
/// `frequencies` are those of the lines, Hz, ascending.
///
/// ```
/// # use massline_shared::modes::{LinesPerSide, Peak, choose_lines};
/// let frequencies: Vec<f64> = (0..100).map(|k| 0.5 + 0.125 * f64::from(k)).collect();
/// let peaks = [3.0, 3.4].map(|frequency_hz| Peak { frequency_hz, damping_ratio: 0.01 });
/// let lines = choose_lines(&frequencies, &peaks, LinesPerSide::Width);
/// let below: Vec<f64> = lines.below.iter().map(|k| frequencies[*k]).collect();
/// // 3.25 Hz is nearer to 3.4 Hz; 3.125 Hz is above 3.0 Hz.
/// assert_eq!(below, [2.75, 2.875, 3.25, 3.375]);
/// ```
pub fn choose_lines<R: Real>(
    frequencies: &[R],
    peaks: &[Peak<R>],
    per_side: LinesPerSide,
) -> Lines {
    let mut lines = Lines::default();
    let nearest = |line: usize| {
        let distance = |peak: &Peak<R>| (peak.frequency_hz - frequencies[line]).abs();
        let places = peaks.iter().map(distance).enumerate();
        places
            .reduce(|best, next| if next.1 < best.1 { next } else { best })
            .map(|(place, _)| place)
    };
    for (place, peak) in peaks.iter().enumerate() {
        let width = R::of(2.0) * peak.damping_ratio * peak.frequency_hz;
        let split = frequencies.partition_point(|f| *f < peak.frequency_hz);
        let take = |side: &mut dyn Iterator<Item = usize>, to: &mut Vec<usize, MOST_OF_A_SET>| {
            let mut side = side.take_while(|line| nearest(*line) == Some(place)).enumerate();
            let wanted = |&(count, line): &(usize, usize)| {
                let within = (frequencies[line] - peak.frequency_hz).abs() <= width;
                match per_side {
                    LinesPerSide::Width => count < FEWEST || within && count < LINES_OF_A_SIDE,
                    LinesPerSide::Fixed(wanted) => count < wanted.min(LINES_OF_A_SIDE),
                }
            };
            while let Some((_, line)) = side.next().filter(wanted) {
                // There is room for every side of every mode.
                let _ = to.push(line);
            }
        };
        take(&mut (0..split).rev(), &mut lines.below);
        take(&mut (split..frequencies.len()), &mut lines.above);
    }
    sort_short(&mut lines.below, |a, b| a < b);
    sort_short(&mut lines.above, |a, b| a < b);
    lines
}
