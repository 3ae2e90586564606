//! Times whose steps differ: how, where, and whether the rows may be even samples all the same.

use super::line::Line;
use super::number::six_digits;

/// How far a time may be from even steps, in steps, where no sample is missing.
const NEAR: f64 = 0.5;

/// What is uneven about the steps of a time column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unevenness {
    /// The shortest step, and the row before it.
    pub shortest: (f64, usize),
    /// The longest step, and the row before it.
    pub longest: (f64, usize),
    /// How many rows have the time of the row before, and the first of these rows.
    pub repeats: (usize, usize),
    /// Whether the rows may be even samples: each time is close to even steps, or all stamps last equally long.
    pub may_be_even: bool,
}

impl Unevenness {
    /// What is uneven about times whose last digits are `digits`.
    pub(super) fn of(times: &[f64], digits: &[f64]) -> Self {
        let mut unevenness = Self {
            shortest: (f64::INFINITY, 0),
            longest: (f64::NEG_INFINITY, 0),
            repeats: (0, 0),
            may_be_even: are_near_even(times, digits) || are_stamps_of_equal_length(times),
        };
        for (row, pair) in times.windows(2).enumerate() {
            let step = pair[1] - pair[0];
            if step < unevenness.shortest.0 {
                unevenness.shortest = (step, row);
            }
            if step > unevenness.longest.0 {
                unevenness.longest = (step, row);
            }
            if step == 0.0 {
                let first = if unevenness.repeats.0 == 0 { row + 1 } else { unevenness.repeats.1 };
                unevenness.repeats = (unevenness.repeats.0 + 1, first);
            }
        }
        unevenness
    }

    /// The same with the places of its rows, which are from 0.
    pub fn at(self, place: impl Fn(usize) -> usize) -> Self {
        let (shortest, longest, repeats) = (self.shortest, self.longest, self.repeats);
        Self {
            shortest: (shortest.0, place(shortest.1)),
            longest: (longest.0, place(longest.1)),
            repeats: (repeats.0, place(repeats.1)),
            ..self
        }
    }

    /// What is wrong with the times called `name`, and what to do; `place` names a place.
    pub fn sentence(&self, name: &str, place: impl Fn(usize) -> String) -> String {
        let (shortest, after_shortest) = self.shortest;
        let (longest, after_longest) = self.longest;
        let (repeats, first) = self.repeats;
        let fault = if shortest < 0.0 {
            return format!(
                "{name} goes back by {} after {}; export the samples in the order of their time, each once",
                six_digits(-shortest),
                place(after_shortest)
            );
        } else if repeats > 0 {
            let rows = match repeats {
                1 => "1 row has".to_owned(),
                rows => format!("{rows} rows have"),
            };
            format!("{rows} the time of the row before in {name}, the first in {}", place(first))
        } else {
            format!(
                "the steps of {name} differ: {} after {}, {} after {}",
                six_digits(shortest),
                place(after_shortest),
                six_digits(longest),
                place(after_longest)
            )
        };
        let advice = match (self.may_be_even, repeats) {
            (true, _) => {
                "export even samples, or state the rate with --rate-hz if the samples are even"
            }
            (false, 0) => "samples may be missing: export even samples",
            (false, _) => "rows are repeated or samples are missing: export even samples",
        };
        format!("{fault}; {advice}")
    }
}

/// Whether each time is less than half a step from a straight line: no row can be missing then.
fn are_near_even(times: &[f64], digits: &[f64]) -> bool {
    Line::through(times, digits, 0..times.len()).is_near(times, digits, NEAR)
}

/// Whether each stamp stands in equally many rows, but for the first and the last one, and the stamps are even.
fn are_stamps_of_equal_length(times: &[f64]) -> bool {
    let begins: Vec<usize> = (1..times.len()).filter(|&k| times[k - 1] != times[k]).collect();
    let lengths: Vec<usize> = begins.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let Some(&length) = lengths.first() else { return false };
    let ends = [begins.first(), begins.last().map(|last| times.len() - last).as_ref()]
        .into_iter()
        .flatten()
        .all(|&end| end <= length);
    let stamps: Vec<f64> = begins.iter().filter_map(|&k| times.get(k)).copied().collect();
    let steps: Vec<f64> = stamps.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let mean = steps.iter().sum::<f64>() / steps.len() as f64;
    let is_even = steps.iter().all(|step| (step - mean).abs() <= 0.01 * mean);
    length > 1 && ends && is_even && lengths.iter().all(|other| *other == length)
}

#[cfg(test)]
mod tests {
    use super::super::steps::{Steps, Times};
    use super::*;

    fn uneven(values: Vec<f64>) -> Unevenness {
        let Steps::Uneven(unevenness) = Times::exact(values).steps() else { panic!("it is even") };
        unevenness
    }

    fn sentence(unevenness: Unevenness) -> String {
        unevenness.at(|row| row + 2).sentence("Time", |line| format!("line {line}"))
    }

    #[test]
    fn what_is_uneven_is_named_with_its_place() {
        let count = |rows: usize| (0..rows).map(|k| k as f64).collect::<Vec<_>>();
        // One row twice.
        let mut twice = count(100);
        twice.insert(50, 49.0);
        let text = sentence(uneven(twice));
        let words =
            "1 row has the time of the row before in Time, the first in line 52; rows are repeated";
        assert!(text.starts_with(words) && !text.contains("--rate-hz"), "{text}");
        // Two rows in the wrong order.
        let mut swapped = count(100);
        swapped.swap(50, 51);
        let text = sentence(uneven(swapped));
        assert!(
            text.starts_with("Time goes back by 1 after line 52") && !text.contains("rate"),
            "{text}"
        );
        // Jitter, with the places of the extremes.
        let mut jitter = count(100);
        jitter[30] += 0.3;
        let text = sentence(uneven(jitter));
        let words = "the steps of Time differ: 0.7 after line 32, 1.3 after line 31;";
        assert!(text.starts_with(words) && text.contains("--rate-hz"), "{text}");
        // Another rate from the middle on.
        let slower = (0..100).map(|k| if k < 50 { f64::from(k) } else { f64::from(2 * k - 50) });
        let text = sentence(uneven(slower.collect()));
        assert!(text.contains("samples may be missing") && !text.contains("--rate-hz"), "{text}");
        // A stamp for each block of ten rows, and one block that lacks a row.
        let blocks: Vec<f64> = (0..100).map(|k| f64::from(k / 10 * 10)).collect();
        let text = sentence(uneven(blocks.clone()));
        let words = "90 rows have the time of the row before in Time, the first in line 3; export";
        assert!(text.starts_with(words) && text.contains("--rate-hz"), "{text}");
        let mut lossy = blocks;
        lossy.remove(55);
        assert!(!sentence(uneven(lossy)).contains("--rate-hz"));
    }
}
