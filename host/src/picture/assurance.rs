//! The modal assurance criterion of every mode with every other.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, Drawn, write};
use super::theme::{INK, LABEL, PAPER, SMALL, shade};
use crate::result_file::{ResultFile, ShownModes};

/// From this value on, the number is written in the colour of the paper.
const DARK: f64 = 0.6;

/// The criterion for all pairs of modes.
#[derive(Clone, Debug, PartialEq)]
pub struct Assurance {
    /// What was measured.
    pub title: String,
    /// The modes, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Row by row, from 0 to 1.
    pub values: Vec<Vec<f64>>,
}

impl Assurance {
    /// The criterion of a result's modes.
    pub fn of(source: &ResultFile, modes: &ShownModes) -> Self {
        let (title, values) = (source.title.clone(), modes.modal_assurance.clone());
        Self { title, frequencies_hz: modes.frequencies_hz(), values }
    }
}

impl Drawing for Assurance {
    fn title(&self) -> String {
        format!("{}: modal assurance criterion (MAC)", self.title)
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        const LABELS: i32 = 130;
        let (width, height) = area.dim_in_pixel();
        let count = self.values.len().max(1) as i32;
        let cell = (width as i32 - LABELS).min(height as i32 - 2 * LABELS / 2) / count;
        let left = LABELS + (width as i32 - LABELS - cell * count) / 2;
        for (i, hz) in self.frequencies_hz.iter().enumerate() {
            let middle = i as i32 * cell + cell / 2;
            let name = format!("{hz:.2} Hz");
            let beside = (left - 14, middle);
            write(area, &name, beside, (HPos::Right, VPos::Center), SMALL)?;
            let below = (left + middle, cell * count + 24);
            write(area, &name, below, (HPos::Center, VPos::Center), SMALL)?;
        }
        for (i, row) in self.values.iter().enumerate() {
            for (k, value) in row.iter().enumerate() {
                let (x, y) = (left + k as i32 * cell, i as i32 * cell);
                let square = [(x, y), (x + cell, y + cell)];
                area.draw(&Rectangle::new(square, shade(*value).filled()))?;
                area.draw(&Rectangle::new(square, INK.stroke_width(1)))?;
                let ink = if *value > DARK { &PAPER } else { &INK };
                let style = super::canvas::text(LABEL)
                    .color(ink)
                    .pos(plotters::style::text_anchor::Pos::new(HPos::Center, VPos::Center));
                area.draw_text(&format!("{value:.2}"), &style, (x + cell / 2, y + cell / 2))?;
            }
        }
        Ok(())
    }
}
