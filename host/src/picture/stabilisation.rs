//! The poles over the order of the fit: those of the body stay where they are.

use plotters::prelude::*;

use super::canvas::{Area, Drawing, Drawn, legend, styled};
use super::theme::{COLORS, INK};
use crate::document::Order;
use crate::result_file::{ResultFile, ShownModes};

/// The poles of the fits of all orders.
#[derive(Clone, Debug, PartialEq)]
pub struct Stabilisation {
    /// What was measured.
    pub title: String,
    /// The suspension band, Hz.
    pub band_hz: [f64; 2],
    /// The orders: whether the modes come from it, and its poles: frequency in Hz, and whether the next smaller order has it
    /// as well.
    pub orders: Vec<(bool, Vec<(f64, bool)>)>,
}

impl Stabilisation {
    /// The orders of a result's fit of the modes.
    pub fn of(source: &ResultFile, modes: &ShownModes) -> Self {
        let poles = |order: &Order| {
            let all = order.poles.iter().map(|pole| (pole.frequency_hz, pole.stable));
            (order.used, all.collect())
        };
        Self {
            title: source.title.clone(),
            band_hz: modes.band_hz,
            orders: modes.orders.iter().map(poles).collect(),
        }
    }
}

impl Drawing for Stabilisation {
    fn title(&self) -> String {
        format!("{}: poles over the order of the fit", self.title)
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        let [stable, new] = [COLORS[0], COLORS[1]];
        let names = [
            ("stable: the order below has it too".into(), stable),
            ("new".into(), new),
            ("line: the order that the modes are taken from".into(), INK),
        ];
        let used = legend(area, &names)?;
        let (_, area) = area.split_vertically(used);
        let [low, high] = self.band_hz;
        let mut chart = ChartBuilder::on(&area)
            .set_label_area_size(LabelAreaPosition::Left, 110)
            .set_label_area_size(LabelAreaPosition::Bottom, 80)
            .build_cartesian_2d(low..high, 0.4..self.orders.len() as f64 + 0.6)?;
        styled(&mut chart.configure_mesh())
            .x_desc("frequency, Hz")
            .y_desc("modes in the fit")
            .y_labels(self.orders.len())
            .y_label_formatter(&|order| format!("{order:.0}"))
            .draw()?;
        for (place, (used, poles)) in self.orders.iter().enumerate() {
            let order = (place + 1) as f64;
            if *used {
                let line = [(low, order), (high, order)];
                chart.draw_series([PathElement::new(line, INK.stroke_width(2))])?;
            }
            let marks = poles.iter().map(|(hz, is_stable)| {
                let ink = if *is_stable { stable.filled() } else { new.stroke_width(3) };
                Circle::new((*hz, order), 10, ink)
            });
            chart.draw_series(marks)?;
        }
        Ok(())
    }
}
