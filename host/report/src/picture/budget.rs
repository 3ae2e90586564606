//! The error budget as the layout states it beside what the data have taught.

use massline_result::Details;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, styled, tick, write};
use super::legend::{Key, Sign, legend};
use super::theme::{COLORS, LABEL};
use crate::result_file::ResultFile;
use crate::words::two_digits;
use massline_result::{BudgetTerm, ErrorBudget};

/// A larger value is drawn as this.
const LARGEST_DRAWN: f64 = 1e9;
/// A larger value is written with a power of ten.
const LARGEST_WRITTEN: f64 = 1e6;

/// An entry of the budget.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// What it is of.
    pub name: &'static str,
    /// Its quantity with the unit.
    pub quantity: &'static str,
    /// As stated and as learned, in that unit.
    pub values: [f64; 2],
}

/// The budget of a fit.
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// What was measured.
    pub title: String,
    /// Its entries.
    pub entries: [Entry; 3],
}

impl Budget {
    /// The budget of a result; `None` when the data have taught nothing about it.
    pub fn of(source: &ResultFile, details: &Details) -> Option<Self> {
        let ErrorBudget { learned_from, hit_position_m, hit_direction_rad, constant_scale } =
            details.error_budget?;
        let entry = |name, quantity, factor: f64, term: BudgetTerm| Entry {
            name,
            quantity,
            values: [factor * term.stated, factor * term.learned],
        };
        let entries = [
            entry("where hits land", "standard deviation, mm", 1e3, hit_position_m),
            entry("direction of hits", "standard deviation, mrad", 1e3, hit_direction_rad),
            entry(learned_from.constant(), "factor of its budget", 1.0, constant_scale),
        ];
        Some(Self { title: source.title.clone(), entries })
    }
}

impl Entry {
    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let width = area.dim_in_pixel().0 as i32;
        write(area, self.name, (width / 2 + 45, 24), (HPos::Center, VPos::Center), LABEL)?;
        let (_, area) = area.split_vertically(50);
        let largest = self.values.iter().copied().filter(|v| v.is_finite()).fold(0.0, f64::max);
        let top = if largest.is_normal() { 1.15 * largest.min(LARGEST_DRAWN) } else { 1.0 };
        let mut chart = ChartBuilder::on(&area)
            .margin_right(20)
            .set_label_area_size(LabelAreaPosition::Left, 110)
            .set_label_area_size(LabelAreaPosition::Bottom, 50)
            .build_cartesian_2d(0.0..2.0, 0.0..top)?;
        styled(&mut chart.configure_mesh())
            .disable_x_mesh()
            .disable_x_axis()
            .y_labels(6)
            .y_label_formatter(&|value| tick(*value))
            .y_desc(self.quantity)
            .draw()?;
        let bar = |(place, value): (usize, &f64)| {
            let left = place as f64 + 0.2;
            let corners = [(left, 0.0), (left + 0.6, value.clamp(0.0, top))];
            Rectangle::new(corners, COLORS[place].filled())
        };
        chart.draw_series(self.values.iter().enumerate().map(bar))?;
        let plane = chart.plotting_area();
        let (left, upper) = area.get_base_pixel();
        for (place, value) in self.values.iter().enumerate() {
            let ends = (place as f64 + 0.5, value.clamp(0.0, top));
            let (x, y) = plane.map_coordinate(&ends);
            let at = (x - left, y - upper - 18);
            write(&area, &figure(*value), at, (HPos::Center, VPos::Center), LABEL)?;
        }
        Ok(())
    }
}

/// A figure of the budget with two significant digits, as texts have it; short also when it is none of a test.
fn figure(value: f64) -> String {
    if value.abs() < LARGEST_WRITTEN { two_digits(value) } else { format!("{value:.1e}") }
}

impl Drawing for Budget {
    fn heading(&self) -> Heading<'_> {
        Heading { subject: &self.title, shows: "error budget as stated and as learned".into() }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let keys = [
            Key::of("as the layout states it", Sign::Patch, COLORS[0]),
            Key::of("learned from the data", Sign::Patch, COLORS[1]),
        ];
        let used = legend(area, &keys)?;
        let (_, area) = area.split_vertically(used);
        let panels = area.split_evenly((1, self.entries.len()));
        self.entries.iter().zip(&panels).try_for_each(|(entry, panel)| entry.draw(panel))
    }
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn figures_are_those_of_the_text() {
        for (value, text) in
            [(2.0499, "2.0"), (31.02, "31"), (0.614, "0.61"), (1e300, "1.0e300"), (f64::NAN, "NaN")]
        {
            assert_eq!(figure(value), text);
        }
    }
}
