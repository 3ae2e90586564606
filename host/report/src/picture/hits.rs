//! The records of a DOF with all its hits overlaid, so that an odd one is seen: the force and its spectrum, and the
//! responses of all axes over the impulse of their hit, which are equal for equal hits of any strength.

use massline_shared::layout::{Dof, RIG_SENSORS, TestSettings};
use massline_shared::signal::{AdcProperties, Calibration, HitAnalysis, Scan};
use nalgebra::Complex;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, write};
use super::legend::{Key, Sign, legend};
use super::panel::{Curve, Panel, range_of};
use super::theme::{FAINT, LABEL, color, dashes};
use crate::readings::{Chain, Readings};
use crate::result_file::ResultFile;
use massline_files::archive::{Archive, ArchivedSampler, HitRecord};
use massline_result::Result;

/// Time before the trigger that is shown, and the shortest time after it, ms.
const BEFORE: f64 = 4.0;
const AFTER: f64 = 24.0;
/// The force is shown until it stays below this part of its peak.
const ENDED: f64 = 0.1;
/// Largest number of hits in a picture.
const MOST: usize = 64;
/// Room between the names of the axes of the upper row and the names of the sensors below, pixels.
const BETWEEN: i32 = 22;
/// The spectrum of the force is shown down to here, dB.
const LOWEST: f64 = -40.0;

/// A hit in physical units.
#[derive(Clone, Debug, PartialEq)]
struct Hit {
    /// Its number on the rig.
    number: u32,
    /// Force, N.
    force: Vec<f64>,
    /// Each response over the impulse, m/s² per N s.
    responses: Vec<Vec<f64>>,
    /// Magnitude of the force's spectrum over that at 0 Hz, dB, bin by bin from 0 Hz.
    spectrum: Vec<f64>,
}

/// The hits of one DOF.
#[derive(Clone, Debug, PartialEq)]
pub struct HitsOfDof {
    /// What was measured.
    pub title: String,
    /// The DOF.
    pub dof: Dof,
    /// Nodes of the sensors.
    nodes: Vec<u16>,
    /// Time between scans and the time before the trigger, ms.
    step: f64,
    before: f64,
    /// Resolution of the spectra, and the band of the mass lines, Hz.
    resolution: f64,
    band_hz: [f64; 2],
    hits: Vec<Hit>,
    /// Number of further records, for which there is no room.
    left_out: usize,
}

impl HitsOfDof {
    /// The hits of every DOF of which an archive has records, in the order of the test; none when it does not have the
    /// calibration, without which their codes have no unit.
    ///
    /// # Errors
    /// When the calibration of the archive is not one.
    pub fn of(source: &ResultFile) -> Result<Vec<Self>> {
        let Some(archive) = source.archive() else { return Ok(Vec::new()) };
        let Some(calibration) = archive.calibration() else { return Ok(Vec::new()) };
        let sampler = archive.rig.sampler;
        let records = Records { archive, calibration: &calibration.calibration, sampler };
        let dofs = archive.layout.resolved.hits.iter().map(|hit| hit.dof);
        Ok(dofs.filter_map(|dof| records.hits_of(dof, source.title.clone())).collect())
    }

    /// Time of a scan after the trigger, ms.
    fn time(&self, scan: usize) -> f64 {
        scan as f64 * self.step - self.before
    }

    /// Until the force of every hit has ended.
    fn times(&self) -> [f64; 2] {
        let end_of = |hit: &Hit| {
            let peak = hit.force.iter().copied().fold(0.0, f64::max);
            let last = hit.force.iter().rposition(|force| *force > ENDED * peak);
            last.map_or(0.0, |scan| self.time(scan))
        };
        let end = self.hits.iter().map(end_of).fold(0.0, f64::max);
        [-BEFORE, (1.2 * end).max(AFTER)]
    }

    fn over_time(&self, place: usize, values: &[f64]) -> Curve {
        let points = values.iter().enumerate().map(|(scan, value)| (self.time(scan), *value));
        curve(place, points.collect())
    }

    fn force_over_time<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let hits = self.hits.iter().enumerate();
        let curves: Vec<Curve> =
            hits.map(|(place, hit)| self.over_time(place, &hit.force)).collect();
        let y = range_of(self.hits.iter().flat_map(|hit| hit.force.iter().copied()));
        let below = Some("time after the trigger, ms");
        Panel { x: self.times(), y, below, left: "force, N", room: 110, shaded: None }
            .draw(area, &curves)
    }

    fn spectra<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let over_frequency = |(place, hit): (usize, &Hit)| {
            let points = hit.spectrum.iter().enumerate();
            curve(
                place,
                points.map(|(bin, level)| (bin as f64 * self.resolution, *level)).collect(),
            )
        };
        let curves: Vec<Curve> = self.hits.iter().enumerate().map(over_frequency).collect();
        let bins = self.hits.iter().map(|hit| hit.spectrum.len()).max().unwrap_or(0);
        let highest_hz = bins.max(2) as f64 * self.resolution;
        let panel = Panel {
            x: [0.0, (5.0 * self.band_hz[1]).max(4.0 * self.resolution).min(highest_hz)],
            y: [LOWEST, 6.0],
            below: Some("frequency, Hz"),
            left: "force, dB re 0 Hz",
            room: 110,
            shaded: Some(self.band_hz),
        };
        panel.draw(area, &curves)
    }

    fn responses<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        const FIRST: i32 = 130;
        const OTHERS: i32 = 84;
        const HEADS: i32 = 34;
        let (width, height) = area.dim_in_pixel();
        let columns = self.nodes.len().max(1) as i32;
        let column = (width as i32 - FIRST + OTHERS) / columns;
        let low = 72 - 14;
        let row = (height as i32 - HEADS - low) / 3;
        let times = self.times();
        let shown = |scan: usize| self.time(scan) <= times[1];
        for (sensor, node) in self.nodes.iter().enumerate() {
            let is_first = sensor == 0;
            let left = if is_first { 0 } else { FIRST - OTHERS + column * sensor as i32 };
            let wide = if is_first { column + FIRST - OTHERS } else { column };
            let name = format!("sensor at node {node}, m/s² per N s");
            let middle = left + wide - (column - OTHERS) / 2;
            write(area, &name, (middle, HEADS / 2), (HPos::Center, VPos::Center), LABEL)?;
            for (axis, name) in ["along x", "along y", "along z"].into_iter().enumerate() {
                let is_lowest = axis == 2;
                let top = HEADS + row * axis as i32;
                let tall = if is_lowest { row + low } else { row };
                let (panel, _) = area.margin(top, 0, left, 0).split_vertically(tall);
                let (panel, _) = panel.split_horizontally(wide);
                let of_axis = |hit: &'_ Hit| hit.responses.get(3 * sensor + axis).cloned();
                let responses: Vec<Vec<f64>> = self.hits.iter().filter_map(of_axis).collect();
                let seen = responses.iter().flat_map(|response| response.iter().enumerate());
                let seen = seen.filter(|(scan, _)| shown(*scan)).map(|(_, value)| *value);
                let y = range_of(seen);
                let each = responses.iter().enumerate();
                let curves: Vec<Curve> =
                    each.map(|(place, values)| self.over_time(place, values)).collect();
                let below = is_lowest.then_some("time after the trigger, ms");
                let (name, room) = if is_first { (name, FIRST) } else { ("", OTHERS) };
                let panel_of =
                    Panel { x: times, y, below, left: name, room: room as u32, shaded: None };
                panel_of.draw(&panel, &curves)?;
            }
        }
        Ok(())
    }
}

/// The curve of the hit with this place.
fn curve(place: usize, points: Vec<(f64, f64)>) -> Curve {
    Curve::of(points, color(place)).dashed(dashes(place))
}

impl Drawing for HitsOfDof {
    fn heading(&self) -> Heading<'_> {
        let Self { dof, hits, left_out, .. } = self;
        let shows = match left_out {
            0 => format!("hits at {dof}"),
            _ => format!("the first {} of {} hits at {dof}", hits.len(), hits.len() + left_out),
        };
        Heading { subject: &self.title, shows }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let key = |(place, hit): (usize, &Hit)| {
            Key::of(format!("hit {}", hit.number), Sign::Line(2, dashes(place)), color(place))
        };
        let mut keys: Vec<Key> = self.hits.iter().enumerate().map(key).collect();
        keys.push(Key::of("band of the mass lines", Sign::Patch, FAINT));
        let used = legend(area, &keys)?;
        let (_, area) = area.split_vertically(used);
        let (width, height) = area.dim_in_pixel();
        let (upper, lower) = area.split_vertically(height * 38 / 100);
        let (force, spectra) = upper.split_horizontally(width / 2);
        self.force_over_time(&force)?;
        self.spectra(&spectra)?;
        self.responses(&lower.margin(BETWEEN, 0, 0, 0))
    }
}

/// The records of an archive, and what turns them into hits.
struct Records<'a> {
    archive: &'a Archive,
    calibration: &'a Calibration,
    sampler: ArchivedSampler,
}

impl Records<'_> {
    fn hits_of(&self, dof: Dof, title: String) -> Option<HitsOfDof> {
        let ArchivedSampler { adc, pre_trigger_scans } = self.sampler;
        let layout = &self.archive.layout.resolved;
        let name = dof.to_string();
        let records = self.archive.hit_records.iter().filter(|record| record.dof == name);
        let mut hits = records.filter_map(|record| self.hit(record));
        let shown: Vec<Hit> = hits.by_ref().take(MOST).collect();
        let (hits, left_out) = (shown, hits.count());
        let points = 2 * hits.iter().map(|hit| hit.spectrum.len()).max()?;
        let result = self.archive.result.dofs.iter().find(|result| result.dof == dof);
        let band = result.map(|result| result.band_hz.map(f64::from));
        let step = 1e3 / f64::from(adc.rate.0);
        Some(HitsOfDof {
            title,
            dof,
            nodes: layout.sensors.iter().map(|sensor| sensor.node).take(RIG_SENSORS).collect(),
            step,
            before: f64::from(pre_trigger_scans) * step,
            resolution: f64::from(adc.rate.0) / points.max(1) as f64,
            band_hz: band.unwrap_or_else(|| layout.test.expected_band()),
            hits,
            left_out,
        })
    }

    /// A record in physical units; `None` for one that has no impulse.
    fn hit(&self, record: &HitRecord) -> Option<Hit> {
        let codes = record.codes.as_slice();
        let spectrum = self.spectrum(codes)?;
        let impulse = spectrum.first()?.re;
        if !impulse.is_normal() {
            return None;
        }
        let Readings { force, mut responses } = self.chain().readings(codes);
        responses.iter_mut().flatten().for_each(|value| *value /= impulse);
        let level = |bin: &Complex<f64>| 20.0 * (bin.norm() / impulse.abs()).log10();
        Some(Hit {
            number: record.hit,
            force,
            responses,
            spectrum: spectrum.iter().map(level).collect(),
        })
    }

    fn chain(&self) -> Chain<'_> {
        let ArchivedSampler { adc, pre_trigger_scans } = self.sampler;
        Chain { calibration: self.calibration, adc, pre_trigger_scans }
    }

    /// The spectrum of the force, N s; `None` for a record that is too long or too short for one.
    fn spectrum(&self, codes: &[Scan]) -> Option<Vec<Complex<f64>>> {
        let ArchivedSampler { adc, pre_trigger_scans } = self.sampler;
        let test = &self.archive.layout.resolved.test;
        let analysis = analysis(&adc, self.calibration, test, usize::from(pre_trigger_scans));
        let points = codes.len().next_power_of_two();
        let mut scratch = vec![0.0; points];
        let mut bins = vec![Complex::new(0.0, 0.0); points / 2];
        analysis.force(codes, &mut scratch, &mut bins).ok()?;
        Some(bins)
    }
}

/// The analysis of the force without the exponential window, which is not that of its spectrum at 0 Hz.
fn analysis(
    adc: &AdcProperties,
    calibration: &Calibration,
    test: &TestSettings<f64>,
    pre_trigger: usize,
) -> HitAnalysis<f64> {
    let test = TestSettings { exponential_decay: 0.0, ..*test };
    HitAnalysis::new(adc, calibration, &test, pre_trigger)
}
