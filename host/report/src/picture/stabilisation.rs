//! The poles over the order of the fit: those of the body stay where they are.

use massline_result::Modes;
use plotters::prelude::*;

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, styled, tick};
use super::legend::{Key, Sign, legend};
use super::theme::{COLORS, FAINT, INK};
use crate::result_file::ResultFile;
use massline_result::Order;

/// How far the axis follows poles to either side of the band, in widths of the band: one that is further away would
/// leave no room for those of the body.
const BESIDE: f64 = 0.5;
/// Room beside the outermost pole, in widths of the band.
const ROOM: f64 = 0.02;

/// The poles of the fits of all orders.
#[derive(Clone, Debug, PartialEq)]
pub struct Stabilisation {
    /// What was measured.
    pub title: String,
    /// The suspension band, Hz.
    pub band_hz: [f64; 2],
    /// The orders: whether the modes come from it, and its poles: frequency in Hz, and whether the next smaller order
    /// has it as well.
    pub orders: Vec<(bool, Vec<(f64, bool)>)>,
}

impl Stabilisation {
    /// The orders of a result's fit of the modes.
    pub fn of(source: &ResultFile, modes: &Modes) -> Self {
        let poles = |order: &Order| {
            let order_poles = order.poles.iter().map(|pole| (pole.frequency_hz, pole.stable));
            (order.used, order_poles.collect())
        };
        Self {
            title: source.title.clone(),
            band_hz: modes.band_hz,
            orders: modes.orders.iter().map(poles).collect(),
        }
    }

    /// The frequencies of all poles, Hz.
    fn frequencies(&self) -> impl Iterator<Item = f64> + '_ {
        self.orders.iter().flat_map(|(_, poles)| poles).map(|(hz, _)| *hz)
    }

    /// The ends of the axis, Hz: the band, and the poles that are not too far away from it.
    fn range(&self) -> [f64; 2] {
        let [low, high] = self.band_hz;
        let width = high - low;
        let [least, most] = [low - BESIDE * width, high + BESIDE * width];
        let near = self.frequencies().filter(|hz| (least..=most).contains(hz));
        let widen = |[low, high]: [f64; 2], hz: f64| {
            [low.min(hz - ROOM * width), high.max(hz + ROOM * width)]
        };
        let [low, high] = near.fold([low, high], widen);
        [low.max(0.0), high]
    }

    /// The number of poles beyond the ends of the axis.
    fn left_out(&self) -> usize {
        let [low, high] = self.range();
        self.frequencies().filter(|hz| !(low..=high).contains(hz)).count()
    }

    fn keys(&self) -> Vec<Key> {
        let mut keys = vec![
            Key::of("stable: the order below has it too", Sign::Disc, COLORS[0]),
            Key::of("new", Sign::Ring, COLORS[1]),
            Key::of("the order that the modes are taken from", Sign::Line(2, None), INK),
            Key::of("suspension band", Sign::Patch, FAINT),
        ];
        match self.left_out() {
            0 => {}
            1 => keys[1].name += "; one is further away than this axis",
            count => keys[1].name += &format!("; {count} are further away than this axis"),
        }
        keys
    }
}

impl Drawing for Stabilisation {
    fn heading(&self) -> Heading<'_> {
        Heading { subject: &self.title, shows: "poles over the order of the fit".into() }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let used = legend(area, &self.keys())?;
        let (_, area) = area.split_vertically(used);
        let [low, high] = self.range();
        let top = self.orders.len() as f64 + 0.6;
        let mut chart = ChartBuilder::on(&area)
            .margin_right(18)
            .set_label_area_size(LabelAreaPosition::Left, 110)
            .set_label_area_size(LabelAreaPosition::Bottom, 80)
            .build_cartesian_2d(low..high, 0.4..top)?;
        let corners = [(self.band_hz[0], 0.4), (self.band_hz[1], top)];
        chart.draw_series([Rectangle::new(corners, FAINT.mix(0.45).filled())])?;
        styled(&mut chart.configure_mesh())
            .x_desc("frequency, Hz")
            .y_desc("modes in the fit")
            .y_labels(self.orders.len())
            .x_label_formatter(&|hz| tick(*hz))
            .y_label_formatter(&|order| format!("{order:.0}"))
            .draw()?;
        for (place, (used, poles)) in self.orders.iter().enumerate() {
            let order = (place + 1) as f64;
            if *used {
                let line = [(low, order), (high, order)];
                chart.draw_series([PathElement::new(line, INK.stroke_width(2))])?;
            }
            // The library would draw one beyond the axis at its end.
            let seen = poles.iter().filter(|(hz, _)| (low..=high).contains(hz));
            let marks = seen.map(|(hz, is_stable)| {
                let [stable, new] = [COLORS[0].filled(), COLORS[1].stroke_width(3)];
                Circle::new((*hz, order), 10, if *is_stable { stable } else { new })
            });
            chart.draw_series(marks)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn with(poles: &[f64]) -> Stabilisation {
        let poles = poles.iter().map(|hz| (*hz, false)).collect();
        Stabilisation { title: String::new(), band_hz: [0.5, 12.5], orders: vec![(true, poles)] }
    }

    #[test]
    fn the_axis_reaches_to_a_pole_beside_the_band() {
        let drawn = with(&[3.0, 13.799]);
        let [low, high] = drawn.range();
        assert!(low == 0.5 && 13.799 < high && high < 14.5, "{low} {high}");
        assert_eq!(drawn.left_out(), 0);
        assert_eq!(with(&[3.0]).range(), [0.5, 12.5]);
    }

    #[test]
    fn poles_far_away_are_left_out_and_counted() {
        let drawn = with(&[3.0, 900.0, -40.0, f64::NAN]);
        assert_eq!(drawn.range(), [0.5, 12.5]);
        assert_eq!(drawn.left_out(), 3);
        assert!(drawn.keys()[1].name.contains("3 are further away"), "{:?}", drawn.keys());
    }
}
