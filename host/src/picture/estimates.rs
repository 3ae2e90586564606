//! The ten properties of one or more answers with their intervals, as errors in parts of scale: the figure by which the papers
//! compare tests and methods.

use std::array;

use massline_shared::body::INERTIAL_PARAMETERS;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, Drawn, legend, styled, write};
use super::theme::{INK, LABEL, color};
use crate::error::Result;
use crate::export::Exported;
use crate::result_file::ResultFile;

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

/// Differences beyond this are not those of an answer, % of scale.
const LARGEST_DRAWN: f64 = 1e9;

/// Answers side by side.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimates {
    /// What was measured.
    pub title: String,
    /// What the differences are from: the reference, or the first answer.
    pub zero: String,
    /// The answers.
    pub series: Vec<Series>,
}

impl Estimates {
    /// All methods of one result, or the best answers of several; `None` without an answer.
    ///
    /// # Errors
    /// When a result is malformed, has no answer among several, or without a layout.
    pub fn of(sources: &[ResultFile]) -> Result<Option<Self>> {
        let mut answers = Vec::new();
        match sources {
            [one] => answers.extend(one.answers()?.into_iter().map(|of| (of.method.clone(), of))),
            _ => {
                for source in sources {
                    answers.push((source.name.clone(), source.answer(None)?));
                }
            }
        }
        let Some(((name, best), source)) = answers.first().zip(sources.first()) else {
            return Ok(None);
        };
        let reference = source.reference();
        let scale = source.scale(reference.map_or(best.body.mass, |of| of[0]))?;
        let from = reference.unwrap_or_else(|| best.theta().into());
        let percent = |k: usize, value: f64| 100.0 * value / scale[k];
        let series = |(name, answer): &(String, Exported)| Series {
            name: name.clone(),
            differences: array::from_fn(|k| percent(k, answer.theta()[k] - from[k])),
            half_widths: answer.half_widths.map(|half| array::from_fn(|k| percent(k, half[k]))),
        };
        Ok(Some(Self {
            title: source.title.clone(),
            zero: if reference.is_some() { "the reference".into() } else { name.clone() },
            series: answers.iter().map(series).collect(),
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

impl Drawing for Estimates {
    fn title(&self) -> String {
        format!("{}: difference from {}", self.title, self.zero)
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        let names: Vec<_> = self
            .series
            .iter()
            .enumerate()
            .map(|(place, series)| (series.name.clone(), color(place)))
            .collect();
        let used = legend(area, &names)?;
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
            .y_desc("% of scale, with 95 % interval")
            .draw()?;
        chart.draw_series([PathElement::new([(-0.5, 0.0), (9.5, 0.0)], INK.stroke_width(2))])?;
        let width = 0.8 / self.series.len().max(1) as f64;
        for (place, series) in self.series.iter().enumerate() {
            let ink = color(place).stroke_width(3);
            for k in 0..10 {
                let x = k as f64 + width * (place as f64 + 0.5) - 0.4;
                let y = series.differences[k];
                if let Some(half) = series.half_widths.map(|half| half[k]) {
                    let cap = 0.25 * width.min(0.3);
                    let ends = [[(x, y - half), (x, y + half)]];
                    let caps = [y - half, y + half].map(|y| [(x - cap, y), (x + cap, y)]);
                    chart.draw_series(
                        ends.into_iter().chain(caps).map(|line| PathElement::new(line, ink)),
                    )?;
                }
                chart.draw_series([Circle::new((x, y), 7, color(place).filled())])?;
            }
        }
        let plane = chart.plotting_area();
        let bottom = plane.get_pixel_range().1.end;
        let (left, top) = area.get_base_pixel();
        for (k, parameter) in INERTIAL_PARAMETERS.iter().enumerate() {
            let x = plane.map_coordinate(&(k as f64, 0.0)).0;
            let at = (x - left, bottom - top + 28);
            write(&area, parameter.symbol, at, (HPos::Center, VPos::Center), LABEL)?;
        }
        Ok(())
    }
}
