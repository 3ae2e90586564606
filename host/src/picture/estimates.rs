//! The ten properties of one or more answers with their intervals, as errors in parts of scale: the figure by which the papers
//! compare tests and methods.

use std::array;

use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::layout::HostLayout;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, Drawn, Heading, styled, tick, write};
use super::legend::{Key, Sign, legend, mark};
use super::theme::{INK, LABEL, color, cycle};
use crate::error::Result;
use crate::export::Exported;
use crate::result_file::{ResultFile, distinct_names};

/// An answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What it is called: a method, a test.
    pub name: String,
    /// Differences from zero, % of scale.
    pub differences: [f64; 10],
    /// Half widths of the 95 % intervals, % of scale.
    pub half_widths: Option<[f64; 10]>,
}

/// An answer in SI units.
struct Answer {
    name: String,
    /// Whether its interval covers the scatter between hits only.
    is_narrow: bool,
    theta: [f64; 10],
    half_widths: Option<[f64; 10]>,
}

/// Differences beyond this are not those of an answer, % of scale.
const LARGEST_DRAWN: f64 = 1e9;
/// What is said about an interval of which the document says that it is too narrow.
const SCATTER_ONLY: &str = "interval: scatter between hits only";

/// Answers side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// What was measured; the number of results where they are several.
    pub title: String,
    /// What the differences are from: the reference, or the first answer.
    pub zero: String,
    /// Which scale the differences are parts of, for the axis.
    pub scale: String,
    /// The answers.
    pub series: Vec<Series>,
    /// The results that are left out, because they have no answer.
    pub without: Vec<String>,
}

impl Estimates {
    /// All methods of one result and what they say together, or the best answers of several; `None` without an answer. One
    /// without an answer among several is left out, and the legend names it.
    ///
    /// Several results have one scale, that of the first: on scales of their own, equal differences of the body would not be
    /// equally high.
    ///
    /// # Errors
    /// When a result is malformed, or without a layout.
    pub fn of(sources: &[ResultFile]) -> Result<Option<Self>> {
        let (mut answered, mut without) = (Vec::new(), Vec::new());
        for (source, name) in sources.iter().zip(distinct_names(sources)) {
            match source.best()? {
                Some(best) => answered.push((source, best, name)),
                None => without.push(name),
            }
        }
        let Some((first, best, _)) = answered.first() else { return Ok(None) };
        let answers = match sources {
            [one] => answers_of_one(one)?,
            _ => {
                answered.iter().map(|(of, best, name)| Answer::of(of, name.clone(), best)).collect()
            }
        };
        let reference = first.reference();
        let scale = first.scale(reference.map_or(best.body.mass, |of| of[0]))?;
        let from = reference.unwrap_or(best.theta().into());
        let percent = |k: usize, value: f64| 100.0 * value / scale[k];
        let series = |answer: &Answer| Series {
            name: answer.described(),
            differences: array::from_fn(|k| percent(k, answer.theta[k] - from[k])),
            half_widths: answer.half_widths.map(|half| array::from_fn(|k| percent(k, half[k]))),
        };
        let is_shared = answered.iter().all(|(other, ..)| other.reference() == reference);
        Ok(Some(Self {
            title: match sources {
                [one] => one.title.clone(),
                _ if without.is_empty() => format!("{} results", sources.len()),
                _ => format!("{} of {} results", answered.len(), sources.len()),
            },
            zero: match reference {
                Some(_) if is_shared => "the reference".into(),
                Some(_) => "the reference of the first".into(),
                None => answers.first().map_or_else(String::new, |of| of.name.clone()),
            },
            scale: scale_of(first, sources.len()),
            series: answers.iter().map(series).collect(),
            without,
        }))
    }

    /// The largest difference with its interval, % of scale.
    fn largest(&self) -> f64 {
        let of = |series: &Series| {
            let half = series.half_widths.unwrap_or_default();
            let ends = series.differences.iter().zip(half).map(|(d, half)| d.abs() + half);
            ends.fold(0.0, f64::max)
        };
        let largest = self.series.iter().map(of).filter(|v| v.is_finite()).fold(0.0, f64::max);
        if largest > 0.0 { largest.min(LARGEST_DRAWN) } else { 1.0 }
    }
}

/// What the differences are parts of, in a few words: the scale of the first of so many results.
fn scale_of(first: &ResultFile, results: usize) -> String {
    let length = first.layout().map(HostLayout::characteristic_length);
    match results {
        0 | 1 => "% of scale".into(),
        _ => {
            let length = length.map_or(String::new(), |l| format!(" (L = {:.1} mm)", 1e3 * l));
            format!("% of the first one's scale{length}")
        }
    }
}

impl Answer {
    /// An answer of a result, by a name.
    fn of(source: &ResultFile, name: String, answer: &Exported) -> Self {
        Self {
            name,
            is_narrow: source.covers_scatter_only(&answer.method),
            theta: answer.theta().into(),
            half_widths: answer.half_widths.map(Into::into),
        }
    }

    /// Its name, with what has to be said about its interval.
    fn described(&self) -> String {
        let Self { name, is_narrow, .. } = self;
        if *is_narrow { format!("{name} ({SCATTER_ONLY})") } else { name.clone() }
    }
}

/// The answers of all methods, and the combined one.
fn answers_of_one(source: &ResultFile) -> Result<Vec<Answer>> {
    let methods = source.answers()?;
    let mut answers: Vec<Answer> =
        methods.iter().map(|of| Answer::of(source, of.method.clone(), of)).collect();
    if let Some(combined) = source.combined()?.filter(|_| answers.len() > 1) {
        let (theta, half_widths) = (combined.theta, Some(combined.half_widths));
        answers.push(Answer { name: "combined".into(), is_narrow: false, theta, half_widths });
    }
    Ok(answers)
}

impl Drawing for Estimates {
    fn heading(&self) -> Heading<'_> {
        Heading { subject: &self.title, shows: format!("difference from {}", self.zero) }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        let key = |(place, series): (usize, &Series)| {
            Key::of(series.name.clone(), Sign::Marker(cycle(place)), color(place))
        };
        let missing = |name: &String| Key::of(format!("{name}: no answer"), Sign::Ring, INK);
        let keys = self.series.iter().enumerate().map(key);
        let keys: Vec<Key> = keys.chain(self.without.iter().map(missing)).collect();
        let used = legend(area, &keys)?;
        let (_, area) = area.split_vertically(used);
        let limit = 1.08 * self.largest();
        let mut chart = ChartBuilder::on(&area)
            .set_label_area_size(LabelAreaPosition::Left, 130)
            .set_label_area_size(LabelAreaPosition::Bottom, 50)
            .build_cartesian_2d(-0.5..9.5, -limit..limit)?;
        styled(&mut chart.configure_mesh())
            .disable_x_mesh()
            .disable_x_axis()
            .y_labels(9)
            .y_label_formatter(&|value| tick(*value))
            .y_desc(format!("{}, with 95 % interval", self.scale))
            .draw()?;
        chart.draw_series([PathElement::new([(-0.5, 0.0), (9.5, 0.0)], INK.stroke_width(2))])?;
        let plane = chart.plotting_area();
        let (left, top) = area.get_base_pixel();
        let at = |place: (f64, f64)| {
            let (x, y) = plane.map_coordinate(&place);
            (x - left, y - top)
        };
        let width = 0.8 / self.series.len().max(1) as f64;
        for (place, series) in self.series.iter().enumerate() {
            for k in 0..10 {
                let x = k as f64 + width * (place as f64 + 0.5) - 0.4;
                let y = series.differences[k];
                if let Some(half) = series.half_widths.map(|half| half[k]) {
                    let cap = 0.25 * width.min(0.3);
                    interval(&area, color(place), &at, (x, [y - half, y + half]), cap)?;
                }
                mark(&area, at((x, y)), cycle(place), color(place))?;
            }
        }
        let bottom = plane.get_pixel_range().1.end - top;
        for (k, parameter) in INERTIAL_PARAMETERS.iter().enumerate() {
            let below = (at((k as f64, 0.0)).0, bottom + 28);
            write(&area, parameter.symbol, below, (HPos::Center, VPos::Center), LABEL)?;
        }
        Ok(())
    }
}

/// An interval with caps of this half width; `at` takes places of the chart to pixels.
fn interval<B: DrawingBackend>(
    area: &Area<B>,
    color: RGBColor,
    at: &impl Fn((f64, f64)) -> (i32, i32),
    (x, ends): (f64, [f64; 2]),
    cap: f64,
) -> Drawn<B> {
    let ink = color.stroke_width(3);
    area.draw(&PathElement::new(ends.map(|y| at((x, y))), ink))?;
    ends.into_iter()
        .try_for_each(|y| area.draw(&PathElement::new([(x - cap, y), (x + cap, y)].map(at), ink)))
}
