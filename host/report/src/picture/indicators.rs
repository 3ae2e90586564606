//! The Norm Indicator: how much of each mode each hit shows (figure 6 of the first paper), a row of bars for each mode.

use massline_result::Modes;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, write};
use super::legend::{Key, Sign, legend};
use super::theme::{COLORS, FAINT, LABEL, SMALL};
use crate::result_file::ResultFile;
use massline_result::{Indicator, Mode};

/// Room for the names of the modes and for those of the hits, pixels.
const LEFT: i32 = 200;
const BELOW: i32 = 50;

/// The indicators of all hits for all modes.
#[derive(Clone, Debug, PartialEq)]
pub struct Indicators {
    /// What was measured.
    pub title: String,
    /// The modes, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Hit DOFs, and the indicator of each for every mode.
    pub hits: Vec<(String, Vec<f64>)>,
}

impl Indicators {
    /// The indicators of a result's modes.
    pub fn of(source: &ResultFile, modes: &Modes) -> Self {
        let hits = modes.modes.first().map(|mode| &mode.norm_indicators).into_iter().flatten();
        let of_hit = |(place, hit): (usize, &Indicator)| {
            let of_mode = |mode: &Mode| {
                mode.norm_indicators.get(place).map_or(0.0, |indicator| indicator.value)
            };
            (hit.dof.clone(), modes.modes.iter().map(of_mode).collect())
        };
        Self {
            title: source.title.clone(),
            frequencies_hz: modes.frequencies_hz(),
            hits: hits.enumerate().map(of_hit).collect(),
        }
    }

    /// The largest indicator for these modes.
    fn largest(&self, modes: impl Fn(usize) -> bool) -> f64 {
        let values = self.hits.iter().flat_map(|(_, values)| values.iter().enumerate());
        let values = values.filter(|(mode, value)| modes(*mode) && value.is_finite());
        values.map(|(_, value)| *value).fold(0.0, f64::max)
    }
}

impl Drawing for Indicators {
    fn heading(&self) -> Heading<'_> {
        let shows = "Norm Indicator, how much of a mode a hit shows".into();
        Heading { subject: &self.title, shows }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let [usual, best] = [COLORS[5], COLORS[0]];
        let keys = [
            Key::of("hit that shows most of the mode", Sign::Patch, best),
            Key::of("other hits", Sign::Patch, usual),
        ];
        let used = legend(area, &keys)?;
        let (_, area) = area.split_vertically(used);
        let (width, height) = area.dim_in_pixel();
        let rows = self.frequencies_hz.len().max(1) as i32;
        let (row, column) =
            ((height as i32 - BELOW) / rows, (width as i32 - LEFT) / self.hits.len().max(1) as i32);
        let largest = self.largest(|_| true);
        // A tenth of a row stays free above the longest bar, besides the number.
        let scale = if largest > 0.0 { 0.6 * f64::from(row) / largest } else { 0.0 };
        for (mode, hz) in self.frequencies_hz.iter().enumerate() {
            let bottom = (mode as i32 + 1) * row;
            let name = format!("{}: {hz:.2} Hz", mode + 1);
            write(&area, &name, (LEFT - 24, bottom - row / 3), (HPos::Right, VPos::Center), LABEL)?;
            let line = [(LEFT, bottom), (LEFT + column * self.hits.len() as i32, bottom)];
            area.draw(&PathElement::new(line, FAINT.stroke_width(2)))?;
            let most = self.largest(|other| other == mode);
            for (hit, (_, values)) in self.hits.iter().enumerate() {
                let value = values[mode];
                let color = if value >= most { best } else { usual };
                let left = LEFT + hit as i32 * column + column / 8;
                let top = bottom - (scale * value).round() as i32;
                let bar = [(left, top), (left + column * 3 / 4, bottom)];
                area.draw(&Rectangle::new(bar, color.filled()))?;
                if column > 60 {
                    let at = (left + column * 3 / 8, top - 16);
                    write(&area, &format!("{value:.3}"), at, (HPos::Center, VPos::Center), SMALL)?;
                }
            }
        }
        for (hit, (dof, _)) in self.hits.iter().enumerate() {
            let at = (LEFT + hit as i32 * column + column / 2, rows * row + 24);
            let size = if column > 90 { LABEL } else { 0.62 * SMALL };
            write(&area, dof, at, (HPos::Center, VPos::Center), size)?;
        }
        Ok(())
    }
}
