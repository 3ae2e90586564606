//! The ten properties of one or more answers with their 95 % intervals, each property on a scale of its own and with
//! its numbers.

use massline_result::{Estimate, TestResult, Verdict};
use massline_shared::body::INERTIAL_PARAMETERS;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, text, write};
use super::legend::{Key, Sign, legend, line, mark};
use super::scale::{range_about, ticks};
use super::theme::{Dashes, FAINT, INK, LABEL, SMALL, color, cycle};
use crate::result_file::{ResultFile, distinct_names};
use crate::typography::with_minus_signs;
use crate::words::in_interval;
use massline_result::Result;

/// What is said about an interval of which the document says that it is too narrow.
const SCATTER_ONLY: &str = "no interval: scatter between hits only";
/// Panels below each other.
const ROWS: usize = 5;
/// Room in a panel for the symbol at the left, the values and half widths at the right, and the ticks below, pixels.
const LEFT: i32 = 84;
const VALUE: i32 = 112;
const RIGHT: i32 = 232;
const BELOW: i32 = 40;
/// Highest row of an answer, and the least letters that can be read, pixels.
const HIGHEST: i32 = 34;
const LEAST: f64 = 11.0;
/// Dashes of the expected value, pixels.
const EXPECTED: Dashes = Some([9, 5]);
/// A number of more digits than this is no property of an object.
const LARGEST_WRITTEN: f64 = 1e9;

/// An answer in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What it is called: a method, a test; with what has to be said about its interval.
    pub name: String,
    /// The ten properties.
    pub theta: [f64; 10],
    /// Half widths of the 95 % intervals, which decide the digits.
    pub half_widths: Option<[f64; 10]>,
}

/// The verdict of a result in words, unless that is good.
fn verdict_of(source: &ResultFile) -> Option<&'static str> {
    source.result().verdict.filter(|verdict| *verdict != Verdict::Good).map(Verdict::words)
}

/// What is said in brackets; empty where nothing is.
fn in_brackets(remarks: &[Option<&str>]) -> String {
    let texts: Vec<_> = remarks.iter().copied().flatten().collect();
    if texts.is_empty() { String::new() } else { format!(" ({})", texts.join("; ")) }
}

/// Answers side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// What was measured; the number of results where they are several.
    pub title: String,
    /// The verdict on one result in brackets, unless that is good.
    pub verdict: String,
    /// The answers.
    pub series: Vec<Series>,
    /// What the properties should be, where that is known and the same for all results.
    pub expected: [Option<f64>; 10],
    /// The results that are left out, because they have no answer.
    pub without: Vec<String>,
}

impl Estimates {
    /// All methods of one result and what they say together, or the best answers of several; `None` without an answer.
    /// One without an answer among several is left out, and the legend names it.
    ///
    /// # Errors
    /// When a result is malformed.
    pub fn of(sources: &[ResultFile]) -> Result<Option<Self>> {
        let (mut answered, mut without) = (Vec::new(), Vec::new());
        for (source, name) in sources.iter().zip(distinct_names(sources)) {
            match source.result().answer() {
                Some(best) => answered.push((source, best, name)),
                None => without.push(name),
            }
        }
        let Some((first, ..)) = answered.first() else { return Ok(None) };
        let series = match sources {
            [one] => answers_of_one(one.result()),
            _ => answered
                .iter()
                .map(|(source, best, name)| Series::of(name, verdict_of(source), best))
                .collect(),
        };
        let expected = first.expected();
        let is_shared = answered.iter().all(|(other, ..)| other.expected() == expected);
        Ok(Some(Self {
            title: match sources {
                [one] => one.title.clone(),
                _ if without.is_empty() => format!("{} results", sources.len()),
                _ => format!("{} of {} results", answered.len(), sources.len()),
            },
            verdict: match sources {
                [one] => in_brackets(&[verdict_of(one)]),
                _ => String::new(),
            },
            series,
            expected: if is_shared { expected } else { [None; 10] },
            without,
        }))
    }

    /// What is drawn how.
    fn keys(&self) -> Vec<Key> {
        let key = |(place, series): (usize, &Series)| {
            Key::of(series.name.clone(), Sign::Marker(cycle(place)), color(place))
        };
        let missing = |name: &String| Key::of(format!("{name}: no answer"), Sign::Ring, INK);
        let mut keys: Vec<Key> = self.series.iter().enumerate().map(key).collect();
        keys.extend(self.without.iter().map(missing));
        if self.expected.iter().any(Option::is_some) {
            keys.push(Key::of("expected value", Sign::Line(2, EXPECTED), INK));
        }
        keys
    }

    /// The panel of a property.
    fn panel<B: DrawingBackend>(&self, area: &Area<B>, k: usize) -> DrawingOutcome<B> {
        let parameter = &INERTIAL_PARAMETERS[k];
        let (width, height) = area.dim_in_pixel();
        let (end, bottom) = (width as i32 - RIGHT, height as i32 - BELOW);
        let symbol = (0, bottom / 2 - 14);
        write(area, parameter.symbol, symbol, (HPos::Left, VPos::Center), LABEL)?;
        let unit = (0, bottom / 2 + 14);
        write(area, parameter.table_unit, unit, (HPos::Left, VPos::Center), SMALL)?;
        let in_table = |si: f64| si * parameter.table_factor;
        let expected = self.expected[k].map(in_table);
        let answers: Vec<[f64; 3]> = self.series.iter().map(|series| series.interval(k)).collect();
        let values = answers.iter().flatten().copied().chain(expected);
        let Some([low, high]) = range_about(values) else { return Ok(()) };
        let x = |value: f64| {
            let share = (value - low) / (high - low);
            LEFT + (share * f64::from(end - LEFT)).round() as i32
        };
        let upright = |value: f64| [(x(value), 0), (x(value), bottom)];
        for (value, number) in ticks_that_fit(area, [low, high], end - LEFT)? {
            area.draw(&PathElement::new(upright(value), FAINT.stroke_width(1)))?;
            let below = (x(value), bottom + 16);
            write(area, &number, below, (HPos::Center, VPos::Center), SMALL)?;
        }
        area.draw(&PathElement::new([(LEFT, bottom), (end, bottom)], INK.stroke_width(1)))?;
        if let Some(expected) = expected.filter(|value| value.is_finite()) {
            line(area, upright(expected), INK.stroke_width(2), EXPECTED)?;
        }
        let row = (bottom / self.series.len().max(1) as i32).min(HIGHEST);
        let top = (bottom - row * self.series.len() as i32) / 2 + row / 2;
        let size = SMALL.min(0.9 * f64::from(row));
        for (place, (series, ends)) in self.series.iter().zip(answers).enumerate() {
            let y = top + place as i32 * row;
            if ends.iter().all(|value| value.is_finite()) {
                interval(area, ends.map(x), y, (row / 3).min(9), color(place))?;
                mark(area, (x(ends[1]), y), cycle(place), color(place))?;
            }
            if size >= LEAST {
                let [value, half_width] = series.numbers(k);
                let middle = end + VALUE;
                write(area, &value, (middle, y), (HPos::Right, VPos::Center), size)?;
                write(area, &half_width, (middle + 8, y), (HPos::Left, VPos::Center), size)?;
            }
        }
        Ok(())
    }
}

impl Series {
    /// An answer, by a name, and a verdict in words to be said with it. An interval of another kind than those beside
    /// it is not drawn.
    fn of(name: &str, verdict: Option<&str>, answer: &Estimate) -> Self {
        let no_interval = match (answer.covers_scatter_only(), answer.half_widths()) {
            (true, _) => Some(SCATTER_ONLY),
            (false, None) => Some("no interval"),
            (false, Some(_)) => None,
        };
        Self {
            name: format!("{name}{}", in_brackets(&[verdict, no_interval])),
            theta: answer.theta(),
            half_widths: answer.half_widths(),
        }
    }

    /// Lower end, value and upper end of a property in the unit of tables.
    fn interval(&self, k: usize) -> [f64; 3] {
        let half = self.half_widths.map_or(0.0, |half| half[k]);
        [-half, 0.0, half]
            .map(|beside| (self.theta[k] + beside) * INERTIAL_PARAMETERS[k].table_factor)
    }

    /// Value and half width with the digits of tables.
    fn numbers(&self, k: usize) -> [String; 2] {
        let in_table = |si: f64| si * INERTIAL_PARAMETERS[k].table_factor;
        let half = self.half_widths.map(|half| in_table(half[k]));
        let written = |value: f64| match value.abs() < LARGEST_WRITTEN {
            true => with_minus_signs(&in_interval(value, half)),
            false => with_minus_signs(&format!("{value:.1e}")),
        };
        let half_width = half.map_or(String::new(), |half| format!("± {}", written(half)));
        [written(in_table(self.theta[k])), half_width]
    }
}

/// The answers of all methods, and the combined one.
fn answers_of_one(result: &TestResult) -> Vec<Series> {
    let mut answers: Vec<Series> = result
        .results
        .iter()
        .map(|estimate| Series::of(estimate.method.name(), None, estimate))
        .collect();
    let combined = result.agreement.as_ref().and_then(|agreement| agreement.combined.as_ref());
    if let Some(combined) = combined.filter(|_| answers.len() > 1) {
        let [theta, half] =
            [combined.value, combined.half_width95].map(|properties| properties.in_order());
        answers.push(Series { name: "combined".into(), theta, half_widths: Some(half) });
    }
    answers
}

impl Drawing for Estimates {
    fn heading(&self) -> Heading<'_> {
        let has_intervals = self.series.iter().any(|answer| answer.half_widths.is_some());
        let intervals = if has_intervals { " with their 95 % intervals" } else { "" };
        let shows = format!("the ten properties{intervals}{}", self.verdict);
        Heading { subject: &self.title, shows }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let used = legend(area, &self.keys())? + 8;
        let (_, area) = area.split_vertically(used);
        let columns = INERTIAL_PARAMETERS.len().div_ceil(ROWS);
        let panels = area.split_evenly((ROWS, columns));
        (0..INERTIAL_PARAMETERS.len()).try_for_each(|k| {
            let panel = &panels[k % ROWS * columns + k / ROWS];
            self.panel(&panel.margin(4, 4, 10, 10), k)
        })
    }
}

/// As many ticks as have room for their numbers on an axis of this width, pixels.
fn ticks_that_fit<B: DrawingBackend>(
    area: &Area<B>,
    range: [f64; 2],
    width: i32,
) -> std::result::Result<Vec<(f64, String)>, DrawingAreaErrorKind<B::ErrorType>> {
    for most in [5.0, 4.0, 3.0, 2.0] {
        let ticks = ticks(range, most);
        let mut needed = 0;
        for (_, number) in &ticks {
            needed += area.estimate_text_size(number, &text(SMALL))?.0 as i32 + 24;
        }
        if needed <= width {
            return Ok(ticks);
        }
    }
    Ok(Vec::new())
}

/// An interval with caps of this half height at its ends.
fn interval<B: DrawingBackend>(
    area: &Area<B>,
    [low, _, high]: [i32; 3],
    y: i32,
    cap: i32,
    color: RGBColor,
) -> DrawingOutcome<B> {
    let ink = color.stroke_width(3);
    if low < high {
        area.draw(&PathElement::new([(low, y), (high, y)], ink))?;
    }
    [low, high]
        .into_iter()
        .try_for_each(|x| area.draw(&PathElement::new([(x, y - cap), (x, y + cap)], ink)))
}
