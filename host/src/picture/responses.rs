//! The frequency responses of a DOF: magnitude with the mass lines, phase and coherence, a column for each sensor.

use massline_protocol::object::DofResult;
use massline_shared::layout::RIG_SENSORS;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, Drawn, legend, styled, write};
use super::theme::{COLORS, LABEL};
use crate::archive::ArchivedSpectra;
use crate::error::Result;
use crate::result_file::ResultFile;
use crate::uff::Frf;

/// The responses of one DOF.
#[derive(Clone, Debug, PartialEq)]
pub struct Responses {
    /// What was measured.
    pub title: String,
    /// The DOF, `node:±axis`, and the number of its hits.
    pub dof: String,
    hits: u8,
    /// Nodes of the sensors.
    nodes: Vec<u16>,
    frequency_hz: Vec<f64>,
    /// For each response: magnitude in (m/s²)/N, phase in degrees, and coherence.
    curves: Vec<[Vec<f64>; 3]>,
    /// Band of the mass lines, Hz, and the rigid-body accelerance of each response, (m/s²)/N.
    band_hz: [f64; 2],
    accelerance: Vec<f64>,
}

/// Rows of a picture: share of the height, name, and range; the range of the magnitude follows from the data.
const ROWS: [(f64, &str, [f64; 2]); 3] = [
    (0.5, "|H|, (m/s²)/N", [0.0; 2]),
    (0.25, "phase, °", [-110.0, 290.0]),
    (0.25, "coherence", [0.0, 1.05]),
];

const MAGNITUDE: usize = 0;
/// Room for the numbers of the first column, and between columns, pixels.
const LEFT: i32 = 120;
const GAP: i32 = 24;

impl Responses {
    /// The responses of every DOF whose spectra the archive of a result holds.
    ///
    /// # Errors
    /// When its calibration is not one.
    pub fn of(source: &ResultFile) -> Result<Vec<Self>> {
        let Some(archive) = source.archive() else { return Ok(Vec::new()) };
        let frfs = archive.frfs()?;
        let nodes: Vec<u16> =
            archive.layout.resolved.sensors.iter().map(|of| of.node).take(RIG_SENSORS).collect();
        let responses = 3 * nodes.len();
        let of_dof = |(spectra, frfs): (&ArchivedSpectra, &[Frf])| {
            // Fewer bins make no curve.
            frfs.first().filter(|frf| frf.frequency_hz.len() > 1)?;
            let dof = archive.result.dofs.iter().find(|of| of.dof.to_string() == spectra.dof)?;
            Some(Self::of_dof(source, spectra, frfs, dof, nodes.clone()))
        };
        let each = archive.spectra.iter().zip(frfs.chunks_exact(responses.max(1)));
        Ok(each.filter_map(of_dof).collect())
    }

    fn of_dof(
        source: &ResultFile,
        spectra: &ArchivedSpectra,
        frfs: &[Frf],
        dof: &DofResult,
        nodes: Vec<u16>,
    ) -> Self {
        let curve = |(k, frf): (usize, &Frf)| {
            let magnitude = frf.accelerance.iter().map(|h| h.norm()).collect();
            let phase = frf.accelerance.iter().map(|h| phase_of(h.arg())).collect();
            [magnitude, phase, spectra.coherence(k)]
        };
        Self {
            title: source.title.clone(),
            dof: spectra.dof.clone(),
            hits: spectra.hits,
            frequency_hz: frfs.first().map_or(Vec::new(), |frf| frf.frequency_hz.clone()),
            curves: frfs.iter().enumerate().map(curve).collect(),
            band_hz: dof.band_hz.map(f64::from),
            accelerance: dof.accelerance[..3 * nodes.len()].iter().map(|&a| a.into()).collect(),
            nodes,
        }
    }

    /// From well below the band to the last bin, Hz.
    fn range_of_frequency(&self) -> [f64; 2] {
        let first = self.frequency_hz.first().copied().unwrap_or(1.0);
        let last = self.frequency_hz.last().copied().unwrap_or(10.0);
        // All of it where the band is not in it.
        let below = Some(0.2 * self.band_hz[0]).filter(|below| *below < last);
        [first.max(below.unwrap_or(first)), last]
    }

    /// Four decades below the largest magnitude.
    fn range_of_magnitude(&self) -> [f64; 2] {
        let inside = |magnitudes: &Vec<f64>| {
            let of_lines = self.frequency_hz.iter().zip(magnitudes);
            let wanted = of_lines.filter(|(f, m)| **f >= 0.2 * self.band_hz[0] && **m > 0.0);
            wanted.map(|(_, m)| *m).fold(0.0, f64::max)
        };
        let largest = self.curves.iter().map(|of| inside(&of[0])).fold(0.0, f64::max);
        if largest > 0.0 { [largest * 1e-4, largest * 1.5] } else { [1e-4, 1.0] }
    }

    fn panel<B: DrawingBackend>(&self, area: &Area<B>, sensor: usize, row: usize) -> Drawn<B> {
        let [low, high] = if row == MAGNITUDE { self.range_of_magnitude() } else { ROWS[row].2 };
        if row == MAGNITUDE {
            self.curves_over(area, (low..high).log_scale(), sensor, row)
        } else {
            self.curves_over(area, low..high, sensor, row)
        }
    }

    /// The three curves of a sensor over the frequency, on this scale.
    fn curves_over<B: DrawingBackend, Y>(
        &self,
        area: &Area<B>,
        scale: Y,
        sensor: usize,
        row: usize,
    ) -> Drawn<B>
    where
        Y: AsRangedCoord<Value = f64>,
        Y::CoordDescType: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let (is_first, is_lowest) = (sensor == 0, row + 1 == ROWS.len());
        let [first, last] = self.range_of_frequency();
        let mut chart = ChartBuilder::on(area)
            .margin_right(16)
            .margin_top(6)
            .set_label_area_size(LabelAreaPosition::Left, if is_first { LEFT } else { GAP })
            .set_label_area_size(LabelAreaPosition::Bottom, if is_lowest { 76 } else { 12 })
            .build_cartesian_2d((first..last).log_scale(), scale)?;
        let name = |f: &f64| if is_lowest { format!("{f}") } else { String::new() };
        let nothing = |_: &f64| String::new();
        let mut mesh = chart.configure_mesh();
        styled(&mut mesh).x_labels(4).y_labels(5).x_label_formatter(&name);
        if is_lowest {
            mesh.x_desc("frequency, Hz");
        }
        if is_first {
            mesh.y_desc(ROWS[row].1);
        } else {
            mesh.y_label_formatter(&nothing);
        }
        mesh.draw()?;
        for (axis, color) in COLORS.iter().take(3).enumerate() {
            let response = 3 * sensor + axis;
            let values = self.frequency_hz.iter().zip(&self.curves[response][row]);
            let points = values.map(|(f, value)| (*f, *value)).filter(|(f, _)| *f >= first);
            chart.draw_series(LineSeries::new(points, color.stroke_width(2)))?;
            if row == MAGNITUDE {
                let level = self.accelerance[response].abs();
                let line = self.band_hz.map(|f| (f, level));
                let dashes = DashedLineSeries::new(line, 10, 6, color.stroke_width(5));
                chart.draw_series(dashes)?;
            }
        }
        Ok(())
    }
}

/// A phase in degrees from −90 to 270, so that noise does not throw a response against the force from one end to the other.
fn phase_of(radians: f64) -> f64 {
    let degrees = radians.to_degrees();
    if degrees < -90.0 { degrees + 360.0 } else { degrees }
}

impl Drawing for Responses {
    fn title(&self) -> String {
        let Self { title, dof, hits, .. } = self;
        format!("{title}: frequency responses to {hits} hits at {dof}")
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B> {
        let names =
            ["along x of the sensor", "along y", "along z; dashed: the mass lines in their band"];
        let names: Vec<_> =
            names.iter().zip(COLORS).map(|(name, color)| ((*name).into(), color)).collect();
        let used = legend(area, &names)?;
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
            let mut top = heads;
            for (row, (share, ..)) in ROWS.iter().enumerate() {
                let tall = (share * f64::from(height as i32 - heads)) as i32;
                let (panel, _) = area.margin(top, 0, left, 0).split_vertically(tall);
                let (panel, _) = panel.split_horizontally(column);
                self.panel(&panel, sensor, row)?;
                top += tall;
            }
        }
        Ok(())
    }
}
