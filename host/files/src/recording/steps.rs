//! The steps of a time column: even, rounded by the digits that were written, uneven, with a gap, or begun again.
//!
//! Times that were rounded lie on a straight line to within their last digit. The line through all of them gives the
//! step far more precisely than two neighbours do.

use std::ops::Range;

use super::line::{EVEN, Line};
use super::uneven::Unevenness;

/// A step longer than this many steps is a gap.
const GAP: f64 = 1.5;
/// Number of stamps below which the rate is that between the first and the last of them.
const FEW_STAMPS: usize = 20;
/// Rows by which one stamp may have fewer than the others without a loss.
const MISSING_OF_STAMP: f64 = 1.75;
/// Bits of the counters of clocks and samples, which begin at zero again after the largest number of so many.
const COUNTER_BITS: [i32; 3] = [16, 24, 32];
/// Relative resolution of a number of 32 bits, in which many programs hold times.
const SINGLE: f64 = 1.2e-7;

/// What the steps of a time column are, in its unit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Steps {
    /// One step.
    Even {
        /// The step.
        step: f64,
        /// Relative uncertainty of the step.
        uncertainty: f64,
        /// The last digit of the times, when their steps differ by it.
        rounded_to: Option<f64>,
    },
    /// Samples are missing.
    Lost {
        /// Number of gaps.
        gaps: usize,
        /// Samples that are missing in the first gap.
        samples: f64,
        /// The row before the first gap, from 0; later its line in the file.
        row: usize,
        /// The time in that row.
        after: f64,
    },
    /// The steps differ for no reason that is known; rows are from 0, and later their lines in the file.
    Uneven(Unevenness),
}

/// A column of times.
#[derive(Clone, Debug, Default)]
pub(super) struct Times {
    pub values: Vec<f64>,
    /// The unit of the last digit of each value, as it was written.
    pub digits: Vec<f64>,
}

impl Times {
    pub fn push(&mut self, value: f64, digit: f64) {
        self.values.push(value);
        self.digits.push(digit);
    }

    /// Values that were written with all digits.
    pub fn exact(values: Vec<f64>) -> Self {
        let digits = vec![0.0; values.len()];
        Self { values, digits }
    }

    /// The same where a counter of whole numbers goes on at zero after its largest one, as the microseconds of a
    /// microcontroller do after 71.6 minutes: there the step is that of the rows before, by whole counters.
    pub fn unwrapped(mut self) -> Self {
        if self.digits.iter().any(|digit| *digit != 1.0) {
            return self;
        }
        let (mut before, mut ahead, mut start) = (None, 0.0, 0);
        for k in 0..self.values.len() {
            let value = self.values[k];
            if let Some(last) = before.filter(|last| value < *last) {
                let rows = (k - 1 - start) as f64;
                let usual = (last + ahead - self.values[start]) / rows;
                let size = COUNTER_BITS.map(|bits| 2_f64.powi(bits)).into_iter().find(|size| {
                    let step = value + size - last;
                    last < *size && (0.5 * usual..1.5 * usual).contains(&step)
                });
                match size {
                    Some(size) => ahead += size,
                    None => (ahead, start) = (0.0, k),
                }
            }
            before = Some(value);
            self.values[k] += ahead;
        }
        self
    }

    /// The rows of this range.
    pub fn part(&self, rows: Range<usize>) -> Self {
        let part = |values: &[f64]| values.get(rows.clone()).unwrap_or_default().to_vec();
        Self { values: part(&self.values), digits: part(&self.digits) }
    }

    /// The parts between which the time begins again.
    pub fn runs(&self) -> Vec<Range<usize>> {
        let mut runs = Vec::new();
        let mut start = 0;
        for (k, pair) in self.values.windows(2).enumerate() {
            let &[last, next] = pair else { continue };
            let first = self.values.get(start).copied().unwrap_or(last);
            if next < last && next - first <= 0.5 * (last - first) {
                runs.push(start..k + 1);
                start = k + 1;
            }
        }
        runs.push(start..self.values.len());
        runs
    }

    /// True for values that rise and never fall, but for a few returns to the beginning.
    pub fn rise(&self) -> bool {
        let runs = self.runs();
        let rises = |run: &Range<usize>| {
            let values = self.values.get(run.clone()).unwrap_or_default();
            values.is_sorted() && values.first() < values.last()
        };
        let enough = self.values.len() >= 8 || matches!(self.steps(), Steps::Even { .. });
        self.values.len() >= 3
            && enough
            && runs.len() * 8 <= self.values.len().max(8)
            && runs.iter().all(rises)
    }

    /// The first row at which other times are more than half a step from these times `ratio`, or from a straight line
    /// through them where the ratio is not known. Times that begin further apart than the recording is long have
    /// another origin.
    pub fn departs(&self, other: &Self, ratio: Option<f64>) -> Option<usize> {
        let (own, others) = (&self.values, &other.values);
        let rows = own.len().min(others.len());
        let ends = |values: &[f64]| Some([*values.first()?, *values.get(rows.checked_sub(1)?)?]);
        let ([a, b], [c, d]) = (ends(own)?, ends(others)?);
        let slope = ratio.unwrap_or((d - c) / (b - a));
        let origin = c - slope * a;
        let origin = if ratio.is_some() && origin.abs() < (d - c).abs() { 0.0 } else { origin };
        let step = (slope * (b - a) / rows as f64).abs();
        let digits = self.resolution().into_iter().zip(other.resolution());
        let mut pairs = own.iter().zip(others).zip(digits);
        pairs.position(|((time, other), (digit, of_other))| {
            let most = 0.5 * step + 2.0 * (slope.abs() * digit + of_other);
            let departure = (other - origin - slope * time).abs();
            departure > most || departure.is_nan()
        })
    }

    /// True for values of which not all are equal.
    pub fn change(&self) -> bool {
        self.values.len() > 2 && self.values.windows(2).any(|pair| pair[0] != pair[1])
    }

    /// The coarsest resolution of the times, relative to their range.
    pub fn coarseness(&self) -> f64 {
        let (first, last) = (self.values.first(), self.values.last());
        let range = last.copied().unwrap_or_default() - first.copied().unwrap_or_default();
        self.resolution().into_iter().fold(0.0, f64::max) / range
    }

    /// True for 0, 1, 2, … or 1, 2, 3, …
    pub fn count(&self) -> bool {
        let first = self.values.first().copied().unwrap_or(f64::NAN);
        (first == 0.0 || first == 1.0)
            && self.runs().into_iter().all(|run| {
                let values = self.values.get(run).unwrap_or_default();
                values.windows(2).all(|pair| matches!(pair, &[a, b] if b - a == 1.0))
            })
    }

    /// The steps of a run.
    pub fn steps(&self) -> Steps {
        let digits = self.resolution();
        let line = Line::through(&self.values, &digits, 0..self.values.len());
        let mean = line.step;
        let is_even = |pair: &[f64]| matches!(pair, &[a, b] if (b - a - mean).abs() <= EVEN * mean);
        if mean > 0.0 && self.values.len() > 1 && self.values.windows(2).all(is_even) {
            return Steps::Even { step: mean, uncertainty: line.uncertainty, rounded_to: None };
        }
        if mean > 0.0 && line.fits(&self.values, &digits) {
            let digit = (0..self.values.len()).map(|k| self.digit(k)).fold(0.0, f64::max);
            if digit > mean {
                return self.stamped(mean, digit);
            }
            return Steps::Even {
                step: mean,
                uncertainty: line.uncertainty,
                rounded_to: Some(digit),
            };
        }
        self.lost(&digits).unwrap_or_else(|| Steps::Uneven(Unevenness::of(&self.values, &digits)))
    }

    /// Times whose last digit is longer than a step: several rows have the same stamp, and equally many between any
    /// two.
    fn stamped(&self, step: f64, digit: f64) -> Steps {
        // The rows at which another stamp begins. Between the first and the last of them, all rows of a stamp are
        // there.
        let begins: Vec<usize> =
            (1..self.values.len()).filter(|&k| self.values[k - 1] != self.values[k]).collect();
        // A line through few stamps leans on the parts of stamps at its ends.
        let whole = begins.first().filter(|_| begins.len() < FEW_STAMPS).zip(begins.last()).map(
            |(&first, &last)| {
                let at = |row: usize| self.values.get(row).copied().unwrap_or(f64::NAN);
                (at(last) - at(first)) / (last - first).max(1) as f64
            },
        );
        let step = whole.filter(|step| *step > 0.0).unwrap_or(step);
        for pair in begins.windows(2) {
            let &[from, to] = pair else { continue };
            let missing = (self.values[to] - self.values[from]) / step - (to - from) as f64;
            // Where another digit is the last one, a stamp is rounded on its two sides differently.
            let is_even = [from - 1, to].iter().all(|&k| self.digit(k) == self.digit(from));
            if is_even && missing > MISSING_OF_STAMP {
                let samples = missing.round();
                let after = self.values[to - 1];
                return Steps::Lost { gaps: 1, samples, row: to - 1, after };
            }
        }
        // The stamps begin up to a row beside their times; three of them are too few to show that they do.
        let stamps = begins.len().saturating_sub(1) as f64;
        let uncertainty = if stamps < 3.0 { 0.5 } else { step / (digit * stamps) };
        Steps::Even { step, uncertainty, rounded_to: Some(digit) }
    }

    /// The first gap, when the parts between the gaps have one step.
    fn lost(&self, digits: &[f64]) -> Option<Steps> {
        let (gaps, parts) = self.gaps(digits);
        let longest = parts.iter().max_by_key(|part| part.len())?.clone();
        let line = Line::through(&self.values, digits, longest);
        let fits = |part: &Range<usize>| {
            let own = Line::through(&self.values, digits, part.clone());
            let line = own.with_step_of(&line);
            line.fits(&self.values, digits)
        };
        let &first = gaps.first()?;
        let (&before, &after) = (self.values.get(first)?, self.values.get(first + 1)?);
        let samples = ((after - before) / line.step).round() - 1.0;
        let lost = line.step > 0.0 && samples >= 1.0 && parts.iter().all(fits);
        lost.then_some(Steps::Lost { gaps: gaps.len(), samples, row: first, after: before })
    }

    /// The rows before a gap, and the parts between.
    fn gaps(&self, digits: &[f64]) -> (Vec<usize>, Vec<Range<usize>>) {
        let mut steps: Vec<f64> = self.values.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let middle = steps.len() / 2;
        let mean = steps.iter().sum::<f64>() / steps.len().max(1) as f64;
        let digit = |k: usize| {
            let digit = |k: usize| digits.get(k).copied().unwrap_or_default();
            digit(k).max(digit(k + 1))
        };
        let typical = if steps.is_empty() {
            return (Vec::new(), Vec::new());
        } else {
            *steps.select_nth_unstable_by(middle, f64::total_cmp).1
        };
        let typical = if typical > 2.0 * digit(self.values.len() / 2) { typical } else { mean };
        let mut gaps = Vec::new();
        let mut parts = Vec::new();
        let mut start = 0;
        for (k, pair) in self.values.windows(2).enumerate() {
            if pair[1] - pair[0] > GAP * typical + 2.0 * digit(k) {
                gaps.push(k);
                parts.push(start..k + 1);
                start = k + 1;
            }
        }
        parts.push(start..self.values.len());
        (gaps, parts)
    }

    /// The parts of a recording in blocks: equally many rows each, with pauses that are longer than half a block.
    pub fn blocks(&self) -> Vec<Range<usize>> {
        let digits = self.resolution();
        let (gaps, parts) = self.gaps(&digits);
        let length = parts.first().map_or(0, Range::len);
        let at = |row: usize| self.values.get(row).copied().unwrap_or(f64::NAN);
        let duration =
            parts.first().map_or(f64::NAN, |part| at(part.end.saturating_sub(1)) - at(part.start));
        let pauses = gaps.iter().all(|&row| at(row + 1) - at(row) > 0.5 * duration);
        let even =
            |part: &Range<usize>| matches!(self.part(part.clone()).steps(), Steps::Even { .. });
        let is_blocks = length >= 3 && parts.iter().all(|part| part.len() == length) && pauses;
        if is_blocks && !gaps.is_empty() && parts.iter().all(even) { parts } else { Vec::new() }
    }

    /// The last digit of a time, as far as it tells how finely the times were written. A program that omits zeros at
    /// the end writes 0.1 between 0.0998 and 0.1002.
    fn digit(&self, k: usize) -> f64 {
        let written = |k: usize| self.digits.get(k).copied();
        let beside = [k.checked_sub(1).and_then(written), written(k + 1)];
        let beside = beside.into_iter().flatten().fold(0.0, f64::max);
        written(k).unwrap_or_default().min(beside)
    }

    /// The resolution of each time: its last digit, or that of the number in which it was held.
    fn resolution(&self) -> Vec<f64> {
        let (first, last) = (self.values.first(), self.values.last());
        let (first, last) = (first.copied().unwrap_or_default(), last.copied().unwrap_or_default());
        let step = (last - first).abs() / self.values.len().max(2) as f64;
        let in_single = first.abs() <= (last - first).abs();
        let resolution = |(k, value): (usize, &f64)| {
            let single = if in_single { (SINGLE * value.abs()).min(0.25 * step) } else { 0.0 };
            self.digit(k) + single + 2.0 * f64::EPSILON * value.abs()
        };
        self.values.iter().enumerate().map(resolution).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 1.0 / 5120.0;

    /// Times as a program would write them.
    fn written(rows: usize, write: impl Fn(f64) -> String) -> Times {
        let mut times = Times::default();
        for k in 0..rows {
            let text = write(k as f64 * STEP);
            let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
            let places = mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len());
            let digit = 10_f64.powi(exponent.parse::<i32>().unwrap() - places as i32);
            times.push(text.parse().unwrap(), digit);
        }
        times
    }

    #[track_caller]
    fn rate(times: &Times, relative: f64) -> Option<f64> {
        let Steps::Even { step, rounded_to, .. } = times.steps() else {
            panic!("{:?}", times.steps())
        };
        assert!((STEP / step - 1.0).abs() < relative, "{}", 1.0 / step);
        rounded_to
    }

    #[test]
    fn rounded_times_give_the_rate_of_the_whole_length() {
        assert_eq!(rate(&written(6144, |t| format!("{t}")), 1e-9), None);
        // Four decimals are half a step; the line through 6144 times is a thousand times finer.
        assert_eq!(rate(&written(6144, |t| format!("{t:.4}")), 1e-5), Some(1e-4));
        assert!(rate(&written(6144, |t| format!("{t:.3}")), 1e-4).is_some());
        assert!(rate(&written(6144, |t| format!("{t:.5}")), 1e-6).is_some());
        // Two decimals of a mantissa: up to a hundredth of the time itself.
        assert!(rate(&written(6144, |t| format!("{t:.2e}")), 1e-3).is_some());
        // Truncated instead of rounded.
        assert!(
            rate(&written(6144, |t| format!("{:.4}", (t * 1e4).floor() * 1e-4)), 1e-4).is_some()
        );
        // Six digits, as many programs write numbers.
        let six = |t: f64| {
            if t < 1.0 { format!("{t}").chars().take(10).collect() } else { format!("{t:.5}") }
        };
        rate(&written(20_000, six), 1e-6);
        // Held in 32 bits.
        rate(&written(300_000, |t| format!("{}", t as f32)), 1e-6);
    }

    #[test]
    fn lost_samples_are_found_with_their_place_and_number() {
        for decimals in [3, 4, 7] {
            let whole = written(6144, |t| format!("{t:.decimals$}"));
            for (from, lost) in [(1000, 40), (3000, 100), (5000, 20)] {
                let mut times = whole.part(0..from);
                let rest = whole.part(from + lost..6144);
                times.values.extend(rest.values);
                times.digits.extend(rest.digits);
                let Steps::Lost { gaps: 1, samples, row, .. } = times.steps() else {
                    panic!("{decimals} {from}: {:?}", times.steps())
                };
                // A time of three decimals is up to three steps off.
                let near = if decimals == 3 { 5.5 } else { 1.1 };
                assert!(
                    row == from - 1 && (samples - lost as f64).abs() < near,
                    "{decimals} {from}: {samples}"
                );
            }
        }
        let mut one = written(512, |t| format!("{t}"));
        one.values.remove(100);
        one.digits.remove(100);
        assert!(
            matches!(one.steps(), Steps::Lost { gaps: 1, samples: 1.0, row: 99, .. }),
            "{:?}",
            one.steps()
        );
    }

    #[test]
    fn a_counter_that_is_full_goes_on_and_one_that_is_set_begins_again() {
        let counter = |from: f64, step: f64, size: f64| {
            let values = (0..2000).map(|k| (from + f64::from(k) * step).rem_euclid(size)).collect();
            Times { values, digits: vec![1.0; 2000] }
        };
        let sizes = [(4_294_900_000.0, 195.0, 32), (65_000.0, 1.0, 16), (0.0, 90.0, 16)];
        for (from, step, bits) in sizes {
            let times = counter(from, step, 2_f64.powi(bits)).unwrapped();
            let Steps::Even { step: measured, .. } = times.steps() else { panic!("{from}") };
            // A line through 2000 numbers of ten digits.
            assert!((measured / step - 1.0).abs() < 1e-9, "{measured}");
            assert_eq!(times.values[1999], from + 1999.0 * step);
        }
        // A time that begins again elsewhere, and one with decimals.
        assert_eq!(counter(1000.0, 195.0, 195_000.0).unwrapped().runs().len(), 3);
        let decimals = Times { digits: vec![0.1; 2000], ..counter(0.0, 90.0, 65_536.0) };
        assert_eq!(decimals.unwrapped().runs().len(), 3);
    }

    #[test]
    fn steps_that_differ_are_uneven() {
        let jitter =
            |k: usize| k as f64 * STEP + if k.is_multiple_of(3) { 0.2 * STEP } else { 0.0 };
        let times = Times::exact((0..512).map(jitter).collect());
        let Steps::Uneven(Unevenness { shortest, longest, .. }) = times.steps() else {
            panic!("{:?}", times.steps())
        };
        assert!((shortest.0 / STEP - 0.8).abs() < 1e-6 && (longest.0 / STEP - 1.2).abs() < 1e-6);
        // One stamp for each block of a hundred rows.
        let blocks = Times::exact((0..5000).map(|k| (k / 100) as f64 * 100.0 * STEP).collect());
        assert!(matches!(blocks.steps(), Steps::Uneven(_)), "{:?}", blocks.steps());
        let backwards = Times::exact((0..100).map(|k| -(k as f64)).collect());
        assert!(matches!(backwards.steps(), Steps::Uneven(_)) && !backwards.rise());
        assert!(!Times::exact(vec![5.0; 100]).rise());
    }

    #[test]
    fn a_time_that_begins_again_is_cut_there() {
        let times = Times::exact((0..600).map(|k| (k % 200) as f64 * STEP - 0.01).collect());
        assert_eq!(times.runs(), [0..200, 200..400, 400..600]);
        assert!(times.rise());
        let counts = Times::exact((0..100).map(f64::from).collect());
        assert!(counts.count() && counts.rise() && !times.count());
        // Blocks of a clock that goes on.
        let triggered = Times::exact(
            (0..600).map(|k| (k % 200) as f64 * STEP + (k / 200) as f64 * 3.0).collect(),
        );
        assert_eq!(triggered.blocks(), [0..200, 200..400, 400..600]);
        assert_eq!(triggered.runs().len(), 1);
        assert!(times.part(0..200).blocks().is_empty());
    }
}
