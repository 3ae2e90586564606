//! The modal assurance criterion of every mode with every other.

use massline_result::Modes;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, text, tick, write};
use super::theme::{INK, LABEL, PAPER, SMALL, shade};
use crate::result_file::ResultFile;

/// From this value on, the number is written in the colour of the paper.
const DARK: f64 = 0.6;
/// Room for the names of the modes at the left and below, pixels.
const LEFT: i32 = 150;
const BELOW: i32 = 30;
/// Room for the key of the colours at the right, and from the squares to it, pixels.
const KEY: i32 = 110;
const GAP: i32 = 60;
/// Width of the key, pixels, and the number of its shades.
const WIDTH: i32 = 30;
const SHADES: i32 = 50;

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
    pub fn of(source: &ResultFile, modes: &Modes) -> Self {
        let (title, values) = (source.title.clone(), modes.modal_assurance.clone());
        Self { title, frequencies_hz: modes.frequencies_hz(), values }
    }
}

impl Drawing for Assurance {
    fn heading(&self) -> Heading<'_> {
        Heading { subject: &self.title, shows: "modal assurance criterion (MAC)".into() }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let (width, height) = area.dim_in_pixel();
        let count = self.values.len().max(1) as i32;
        let (wide, tall) = (width as i32 - LEFT - GAP - KEY, height as i32 - BELOW);
        let cell = wide.min(tall) / count;
        let left = LEFT + (wide - cell * count) / 2;
        for (i, hz) in self.frequencies_hz.iter().enumerate() {
            let middle = i as i32 * cell + cell / 2;
            let name = format!("{hz:.2} Hz");
            let beside = (left - 14, middle);
            write(area, &name, beside, (HPos::Right, VPos::Center), SMALL)?;
            let below = (left + middle, cell * count + 20);
            write(area, &name, below, (HPos::Center, VPos::Center), SMALL)?;
        }
        for (i, row) in self.values.iter().enumerate() {
            for (k, value) in row.iter().enumerate() {
                let (x, y) = (left + k as i32 * cell, i as i32 * cell);
                let square = [(x, y), (x + cell, y + cell)];
                area.draw(&Rectangle::new(square, shade(*value).filled()))?;
                area.draw(&Rectangle::new(square, INK.stroke_width(1)))?;
                let ink = if *value > DARK { &PAPER } else { &INK };
                let style = text(LABEL).color(ink).pos(Pos::new(HPos::Center, VPos::Center));
                area.draw_text(&format!("{value:.2}"), &style, (x + cell / 2, y + cell / 2))?;
            }
        }
        key(area, left + cell * count + GAP, cell * count)
    }
}

/// The key of the colours: a column from 0 at its lower end to 1, with its left edge here.
fn key<B: DrawingBackend>(area: &Area<B>, x: i32, height: i32) -> DrawingOutcome<B> {
    let y = |share: f64| ((1.0 - share) * f64::from(height)).round() as i32;
    for k in 0..SHADES {
        let [from, to] = [k, k + 1].map(|k| f64::from(k) / f64::from(SHADES));
        let corners = [(x, y(to)), (x + WIDTH, y(from))];
        area.draw(&Rectangle::new(corners, shade((from + to) / 2.0).filled()))?;
    }
    area.draw(&Rectangle::new([(x, 0), (x + WIDTH, height)], INK.stroke_width(1)))?;
    for value in [0.0, 0.25, 0.5, 0.75, 1.0] {
        let at = y(value);
        area.draw(&PathElement::new([(x + WIDTH, at), (x + WIDTH + 8, at)], INK.stroke_width(1)))?;
        let beside = (x + WIDTH + 16, at.clamp(10, height - 10));
        write(area, &tick(value), beside, (HPos::Left, VPos::Center), SMALL)?;
    }
    Ok(())
}
