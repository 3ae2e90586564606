//! The frequency responses of a DOF: magnitude with the mass lines, phase and coherence, a column for each sensor.

use massline_shared::layout::{Dof, HostLayout};
use nalgebra::Complex;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, styled, tick, write};
use super::clip::{Place, pieces};
use super::legend::{Key, Sign, legend};
use super::phase::{self, LARGEST_STEP, PhaseAxis, phase_of};
use super::theme::{COLORS, Dashes, FAINT, INK, LABEL};
use crate::result_file::{Band, DofResponses, ResultFile};
use massline_result::Result;

/// The responses of one DOF.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    /// What was measured.
    pub title: String,
    /// The DOF.
    pub dof: Dof,
    /// The number of its hits, where it is known.
    hits: Option<u8>,
    /// Nodes of the sensors.
    nodes: Vec<u16>,
    frequency_hz: Vec<f64>,
    /// For each response: magnitude in (m/s²)/N, phase in degrees, and coherence, which is empty where it is not known.
    curves: Vec<[Vec<f64>; 3]>,
    /// What the answers come from.
    band: Band,
}

/// Rows of a picture: share of the height, name, and range; the range of the magnitude follows from the data.
const ROWS: [(f64, &str, [f64; 2]); 3] = [
    (0.5, "|H|, (m/s²)/N", [0.0; 2]),
    (0.25, "phase, °", phase::RANGE),
    (0.25, "coherence", [0.0, 1.05]),
];

const MAGNITUDE: usize = 0;
const PHASE: usize = 1;
const COHERENCE: usize = 2;
/// The frequencies that are shown begin at this part of the lower end of the band.
const BELOW_BAND: f64 = 0.2;
/// Most that is shown of the magnitude: smaller ones are noise, of the largest one.
const DEEPEST: f64 = 1e-4;
/// Room above and below the magnitudes, and the least of the whole range, as factors: below a decade the axis had no
/// numbers.
const ROOM: f64 = 1.4;
const LEAST: f64 = 20.0;
/// Dashes of the mass lines, pixels.
const DASHES: Dashes = Some([10, 6]);
/// Room for the numbers of the first column, and between columns, pixels.
const LEFT: i32 = 120;
const GAP: i32 = 24;

impl Responses {
    /// The responses of every DOF that a result has.
    ///
    /// # Errors
    /// When the calibration of its archive is not one.
    pub fn of(source: &ResultFile) -> Result<Vec<Self>> {
        let Some(layout) = source.layout() else { return Ok(Vec::new()) };
        let each = source.responses().into_iter();
        // Fewer bins make no curve.
        let shown = each.filter(|responses| responses.frequency_hz.len() > 1);
        Ok(shown.map(|responses| Self::of_dof(source.title.clone(), layout, responses)).collect())
    }

    fn of_dof(title: String, layout: &HostLayout, responses: DofResponses) -> Self {
        let curve = |(k, accelerance): (usize, &Vec<_>)| {
            let magnitude = accelerance.iter().map(|h: &Complex<f64>| h.norm()).collect();
            let phase = accelerance.iter().map(|h| phase_of(h.arg())).collect();
            [magnitude, phase, responses.coherence.get(k).cloned().unwrap_or_default()]
        };
        let curves: Vec<_> = responses.accelerance.iter().enumerate().map(curve).collect();
        let nodes = layout.sensors.iter().map(|sensor| sensor.node);
        Self {
            title,
            dof: responses.dof,
            hits: responses.hits,
            nodes: nodes.take(curves.len() / 3).collect(),
            frequency_hz: responses.frequency_hz,
            curves,
            band: responses.band,
        }
    }

    /// The rows of the picture with their shares of its height.
    fn rows(&self) -> Vec<(usize, f64)> {
        let has_coherence = self.curves.iter().any(|curves| !curves[COHERENCE].is_empty());
        let rows = if has_coherence { 0..=COHERENCE } else { 0..=PHASE };
        let total: f64 = rows.clone().map(|row| ROWS[row].0).sum();
        rows.map(|row| (row, ROWS[row].0 / total)).collect()
    }

    /// From the first bin well below the band to the last one, Hz.
    fn range_of_frequency(&self) -> [f64; 2] {
        let positive = self.frequency_hz.iter().copied().filter(|f| *f > 0.0);
        let last = self.frequency_hz.last().copied().unwrap_or(10.0);
        let shown =
            positive.clone().find(|f| *f >= BELOW_BAND * self.band.ends_hz()[0] && *f < last);
        // All of it where the band is not in it.
        [shown.or(positive.clone().next().filter(|f| *f < last)).unwrap_or(0.1 * last), last]
    }

    /// From the smallest to the largest magnitude that is shown.
    fn range_of_magnitude(&self) -> [f64; 2] {
        let [first, last] = self.range_of_frequency();
        let shown = |magnitudes: &[f64]| {
            let of_lines = self.frequency_hz.iter().copied().zip(magnitudes.to_vec());
            of_lines.filter(move |(f, _)| (first..=last).contains(f)).map(|(_, m)| m)
        };
        let magnitudes = self.curves.iter().flat_map(|curves| shown(&curves[MAGNITUDE]));
        let magnitudes =
            magnitudes.chain(self.band.mass_lines().into_iter().flatten().map(|a| a.abs()));
        let magnitudes: Vec<f64> = magnitudes.filter(|m| m.is_normal() && *m > 0.0).collect();
        let largest = magnitudes.iter().copied().fold(0.0, f64::max);
        if largest == 0.0 {
            return [1e-4, 1.0];
        }
        let least = magnitudes.iter().copied().fold(largest, f64::min).max(DEEPEST * largest);
        let [low, high] = [least / ROOM, largest * ROOM];
        let missing = (LEAST / (high / low)).max(1.0).sqrt();
        [low / missing, high * missing]
    }

    /// The pieces of a curve that are drawn, in the units of the axes.
    fn pieces(&self, row: usize, values: &[f64]) -> Vec<Vec<Place>> {
        let is_log = row == MAGNITUDE;
        // Lines are straight on the paper, where both may be logarithms.
        let up = |value: f64| if is_log { value.log10() } else { value };
        let back = |value: f64| if is_log { 10_f64.powf(value) } else { value };
        let points: Vec<Place> = self
            .frequency_hz
            .iter()
            .zip(values)
            .map(|(f, value)| (f.log10(), up(*value)))
            .collect();
        let is_joined = |a: &Place, b: &Place| row != PHASE || (a.1 - b.1).abs() <= LARGEST_STEP;
        let [x, y] = [self.range_of_frequency().map(f64::log10), self.range_of(row).map(up)];
        let pieces = points.chunk_by(is_joined).flat_map(|run| pieces(run, x, y));
        let in_units =
            |piece: Vec<Place>| piece.into_iter().map(|(f, v)| (10_f64.powf(f), back(v))).collect();
        pieces.map(in_units).collect()
    }

    /// The part of the frequencies in the suspension band; `None` for all of them.
    fn shaded(&self) -> Option<[f64; 2]> {
        let Band::Suspension(ends) = self.band else { return None };
        let [first, last] = self.range_of_frequency();
        let shown = ends.map(|f| f.clamp(first, last));
        (shown != [first, last]).then_some(shown)
    }

    /// The range of a row.
    fn range_of(&self, row: usize) -> [f64; 2] {
        if row == MAGNITUDE { self.range_of_magnitude() } else { ROWS[row].2 }
    }

    fn panel<B: DrawingBackend>(
        &self,
        area: &Area<B>,
        sensor: usize,
        row: usize,
        is_lowest: bool,
    ) -> DrawingOutcome<B> {
        let [low, high] = self.range_of(row);
        let place = (sensor, row, is_lowest);
        match row {
            MAGNITUDE => self.curves_over(area, (low..high).log_scale(), place),
            PHASE => self.curves_over(area, PhaseAxis::new(), place),
            _ => self.curves_over(area, low..high, place),
        }
    }

    /// The three curves of a sensor over the frequency, on this scale.
    fn curves_over<B: DrawingBackend, Y>(
        &self,
        area: &Area<B>,
        scale: Y,
        (sensor, row, is_lowest): (usize, usize, bool),
    ) -> DrawingOutcome<B>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let is_first = sensor == 0;
        let [first, last] = self.range_of_frequency();
        let mut chart = ChartBuilder::on(area)
            .margin_right(16)
            .margin_top(6)
            .set_label_area_size(LabelAreaPosition::Left, if is_first { LEFT } else { GAP })
            .set_label_area_size(LabelAreaPosition::Bottom, if is_lowest { 76 } else { 12 })
            .build_cartesian_2d((first..last).log_scale(), scale)?;
        let name = |f: &f64| if is_lowest { tick(*f) } else { String::new() };
        let mut mesh = chart.configure_mesh();
        let numbers = |value: &f64| if is_first { tick(*value) } else { String::new() };
        styled(&mut mesh).x_labels(4).y_labels(5).x_label_formatter(&name);
        mesh.y_label_formatter(&numbers);
        if is_lowest {
            mesh.x_desc("frequency, Hz");
        }
        if is_first {
            mesh.y_desc(ROWS[row].1);
        }
        mesh.draw()?;
        if let Some(ends) = self.shaded() {
            let [low, high] = self.range_of(row);
            let corners = [(ends[0], low), (ends[1], high)];
            chart.draw_series([Rectangle::new(corners, FAINT.mix(0.45).filled())])?;
        }
        for (axis, color) in COLORS.iter().take(3).enumerate() {
            let response = 3 * sensor + axis;
            for piece in self.pieces(row, &self.curves[response][row]) {
                chart.draw_series(LineSeries::new(piece, color.stroke_width(2)))?;
            }
            let level = self.band.mass_lines().and_then(|lines| lines.get(response));
            if let (MAGNITUDE, Some([length, gap]), Some(level)) = (row, DASHES, level) {
                let line = self.band.ends_hz().map(|f| (f.clamp(first, last), level.abs()));
                let style = color.stroke_width(5);
                chart.draw_series(DashedLineSeries::new(line, length, gap, style))?;
            }
        }
        Ok(())
    }
}

impl Drawing for Responses {
    fn heading(&self) -> Heading<'_> {
        let Self { title, dof, hits, .. } = self;
        let hits = match hits {
            None => "hits".into(),
            Some(1) => "one hit".into(),
            Some(hits) => format!("{hits} hits"),
        };
        Heading { subject: title, shows: format!("frequency responses to {hits} at {dof}") }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let line = Sign::Line(3, None);
        let names = ["along x of the sensor", "along y", "along z"];
        let mut keys: Vec<Key> =
            names.into_iter().zip(COLORS).map(|(name, color)| Key::of(name, line, color)).collect();
        if self.band.mass_lines().is_some() {
            keys.push(Key::of("mass lines in their band", Sign::Line(5, DASHES), INK));
        }
        if self.shaded().is_some() {
            keys.push(Key::of("suspension band", Sign::Patch, FAINT));
        }
        let used = legend(area, &keys)?;
        let (_, area) = area.split_vertically(used);
        let (width, height) = area.dim_in_pixel();
        let columns = self.nodes.len().max(1) as i32;
        let first = LEFT - GAP;
        let other = (width as i32 - first) / columns;
        let heads = 34;
        for (sensor, node) in self.nodes.iter().enumerate() {
            let left = if sensor == 0 { 0 } else { first + other * sensor as i32 };
            let column = if sensor == 0 { other + first } else { other };
            let middle = left + column - other / 2;
            let name = format!("sensor at node {node}");
            write(&area, &name, (middle, heads / 2), (HPos::Center, VPos::Center), LABEL)?;
            let (mut top, rows) = (heads, self.rows());
            for (row, share) in &rows {
                let tall = (share * f64::from(height as i32 - heads)) as i32;
                let (panel, _) = area.margin(top, 0, left, 0).split_vertically(tall);
                let (panel, _) = panel.split_horizontally(column);
                self.panel(&panel, sensor, *row, row + 1 == rows.len())?;
                top += tall;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn responses_with(frequency_hz: Vec<f64>, curve: [Vec<f64>; 3]) -> Responses {
        Responses {
            title: "frame".into(),
            dof: "1:+Z".parse().unwrap(),
            hits: Some(3),
            nodes: vec![3],
            frequency_hz,
            curves: vec![curve.clone(), curve.clone(), curve],
            band: Band::MassLines([10.0, 100.0], vec![0.5; 3]),
        }
    }

    #[test]
    fn the_phase_breaks_where_it_jumps_to_its_other_end() {
        let frequencies = vec![10.0, 20.0, 30.0, 40.0];
        let phase = vec![200.0, 265.0, -85.0, -20.0];
        let drawn = responses_with(frequencies, [vec![1.0; 4], phase.clone(), vec![1.0; 4]]);
        let pieces = drawn.pieces(PHASE, &phase);
        assert_eq!(pieces.len(), 2, "{pieces:?}");
        assert!(pieces[0].iter().all(|(f, v)| *f < 20.1 && *v >= 200.0), "{pieces:?}");
        assert!(pieces[1].iter().all(|(f, v)| *f > 29.9 && *v <= -20.0), "{pieces:?}");
    }

    #[test]
    fn the_axes_hold_what_is_drawn_and_not_much_more() {
        let magnitude = vec![50.0, 2.0, 0.5, 0.1, 0.2];
        let frequencies = vec![1.0, 3.9, 10.0, 50.0, 120.0];
        let drawn = responses_with(frequencies, [magnitude.clone(), vec![0.0; 5], vec![1.0; 5]]);
        assert_eq!(drawn.range_of_frequency(), [3.9, 120.0]);
        let [low, high] = drawn.range_of_magnitude();
        assert!(0.05 < low && low < 0.1 && 2.0 < high && high < 4.0, "{low} {high}");
        // The bin below the axis is not drawn at its end.
        let pieces = drawn.pieces(MAGNITUDE, &magnitude);
        assert!(pieces.len() == 1 && (pieces[0][0].0 - 3.9).abs() < 0.1, "{pieces:?}");
    }

    #[test]
    fn a_notch_below_the_noise_leaves_the_panel() {
        let magnitude = vec![1.0, 1.0, 1e-9, 0.0, 1.0];
        let frequencies = vec![10.0, 20.0, 40.0, 80.0, 120.0];
        let drawn = responses_with(frequencies, [magnitude.clone(), vec![0.0; 5], vec![1.0; 5]]);
        let [low, _] = drawn.range_of_magnitude();
        let pieces = drawn.pieces(MAGNITUDE, &magnitude);
        assert_eq!(pieces.len(), 1, "{pieces:?}");
        let (f, least) = *pieces[0].last().unwrap();
        assert!(f < 40.0 && (least / low - 1.0).abs() < 1e-9, "{f} {least} {low}");
    }
}
