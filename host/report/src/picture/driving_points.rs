//! Whether every point that is hit moves with its force, by its accelerance along the hit.
//!
//! Above the modes of the suspension the real part is positive for every rigid body, and at least 1/m; a curve below
//! zero is a reversed axis or hammer. At these modes the real part changes its sign, and the imaginary part is positive
//! instead: the force puts power into the body.
//!
//! The point moves as all sensors together have it; where a sensor sits at the point, its own reading stands beside it.

use massline_shared::identify::ResponseInverse;
use massline_shared::layout::{Dof, HostLayout, RIG_SENSORS};
use massline_shared::modes::reduce_line;
use massline_shared::{FrequencyResponses, Responses};
use nalgebra::{Complex, Vector3, Vector6};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::{Area, Drawing, DrawingOutcome, Heading, write};
use super::legend::{Key, Sign, legend};
use super::panel::{Curve, Panel, range_of};
use super::theme::{COLORS, Dashes, FAINT, INK, LABEL};
use crate::result_file::{Band, DofResponses, ResultFile};
use massline_result::Result;

/// The range of the frequency, over the ends of the band of the mass lines.
const SHOWN: [f64; 2] = [0.7, 1.3];
/// How far the axis follows values beyond the band, in extents of those within it, so that a mode of the suspension or
/// of the body beside the band does not make the band flat.
const BEYOND: f64 = 2.0;
/// Dashes of the mass lines, pixels.
const DASHES: Dashes = Some([10, 6]);
/// The largest number of panels in a row.
const COLUMNS: usize = 4;

/// The point of one DOF.
#[derive(Clone, Debug, PartialEq)]
struct Point {
    dof: Dof,
    band: DisplayedPart,
    curves: Option<Accelerances>,
}

/// What is shown of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
enum DisplayedPart {
    /// The real part about the band of the mass lines, Hz, and that of the mass lines, (m/s²)/N.
    MassLine([f64; 2], f64),
    /// The imaginary part in the suspension band, Hz.
    Suspension([f64; 2]),
}

impl DisplayedPart {
    fn ends_hz(self) -> [f64; 2] {
        match self {
            Self::MassLine(ends, _) | Self::Suspension(ends) => ends,
        }
    }

    fn mass_line(self) -> Option<f64> {
        match self {
            Self::MassLine(_, value) => Some(value),
            Self::Suspension(_) => None,
        }
    }

    /// The part that is positive at a driving point.
    fn part(self, accelerance: Complex<f64>) -> f64 {
        match self {
            Self::MassLine(..) => accelerance.re,
            Self::Suspension(_) => accelerance.im,
        }
    }
}

/// Frequency, Hz, and the part of the accelerance of a point that is shown, (m/s²)/N.
#[derive(Clone, Debug, PartialEq)]
struct Accelerances {
    /// As all sensors have it.
    of_all: Vec<(f64, f64)>,
    /// As the sensor at the point reads it; empty without one.
    of_sensor: Vec<(f64, f64)>,
}

/// The points of a test that are hit.
#[derive(Clone, Debug, PartialEq)]
pub struct DrivingPoints {
    /// What was measured.
    pub title: String,
    /// 1/m of the best answer, 1/kg.
    least: Option<f64>,
    points: Vec<Point>,
}

impl DrivingPoints {
    /// The points of a result; `None` without responses, and when its sensors do not see all motions of the body.
    ///
    /// # Errors
    /// When calibration or answer are malformed.
    pub fn of(source: &ResultFile) -> Result<Option<Self>> {
        let Some(mut layout) = source.layout().cloned() else { return Ok(None) };
        if source.archive().is_some() {
            // An edited archive may have more sensors than its rig.
            layout.sensors.truncate(RIG_SENSORS);
        }
        let layout = &layout;
        let reference = layout.sensor_centroid();
        let inverse = ResponseInverse::new(
            &layout.response_matrix(&reference),
            layout.characteristic_length(),
        );
        let Some(inverse) = inverse.filter(|inverse| inverse.rank == 6) else { return Ok(None) };
        let mut points = Vec::new();
        for responses in source.responses() {
            let Some(hit) = layout.hits.get(responses.hit) else { continue };
            let band = match &responses.band {
                Band::Suspension(ends) => DisplayedPart::Suspension(*ends),
                Band::MassLines(ends, lines) => {
                    let reading =
                        |response: usize| lines.get(response).copied().unwrap_or_default();
                    let readings = Responses::from_fn(layout.sensors.len(), reading);
                    DisplayedPart::MassLine(
                        *ends,
                        hit.unit_force(&reference).dot(&inverse.motion(&readings)),
                    )
                }
            };
            points.push(Point {
                dof: responses.dof,
                band,
                curves: Accelerances::of(layout, &responses, band),
            });
        }
        points.retain(|point| point.curves.is_some() || point.band.mass_line().is_some());
        let mass = source.result().answer().map(|answer| answer.mass_kg.value);
        let least = mass.filter(|mass| *mass > 0.0).map(|mass| 1.0 / mass);
        let least = least.filter(|_| points.iter().all(|point| point.band.mass_line().is_some()));
        let title = source.title.clone();
        Ok((!points.is_empty()).then_some(Self { title, least, points }))
    }
}

impl Accelerances {
    /// Those of a hit of the layout; `None` with fewer than two bins.
    fn of(layout: &HostLayout, responses: &DofResponses, band: DisplayedPart) -> Option<Self> {
        let hit = layout.hits.get(responses.hit)?;
        let frequencies =
            Some(&responses.frequency_hz).filter(|frequencies| frequencies.len() > 1)?;
        let bins = 0..frequencies.len();
        let readings: Vec<Complex<f64>> = bins
            .clone()
            .flat_map(|bin| {
                responses.accelerance.iter().filter_map(move |values| values.get(bin).copied())
            })
            .collect();
        let readings =
            FrequencyResponses::new(frequencies, &readings, responses.accelerance.len(), 1)?
                .windowed(responses.decay_per_s, 1.0);
        let reference = layout.sensor_centroid();
        let force = hit.unit_force(&reference);
        let rigid = |bin: usize| {
            let mut motion = [Vector6::zeros()];
            reduce_line(layout, &readings, &reference, bin, &mut motion)?;
            Some((frequencies[bin], motion[0].map(|component| band.part(component)).dot(&force)))
        };
        let at_point = layout.sensors.iter().position(|sensor| sensor.node == hit.dof.node);
        let along = at_point.map(|sensor| {
            let rows = layout.sensors[sensor].response_rows(&reference);
            let axes = rows.fixed_view::<3, 3>(0, 0).into_owned();
            (3 * sensor, axes * Vector3::from(hit.direction))
        });
        let read = |bin: usize| {
            let (first, along) = along?;
            let part = |axis: usize| along[axis] * band.part(readings.at(bin, first + axis, 0));
            Some((frequencies[bin], (0..3).map(part).sum()))
        };
        Some(Self {
            of_all: bins.clone().filter_map(rigid).collect(),
            of_sensor: bins.filter_map(read).collect(),
        })
    }

    /// Whether the largest value is negative.
    fn is_negative(&self) -> bool {
        let larger = |a: f64, b: f64| if b.abs() > a.abs() { b } else { a };
        self.of_all.iter().map(|(_, value)| *value).fold(0.0, larger) < 0.0
    }
}

impl Point {
    /// The frequencies that are shown.
    fn range(&self) -> [f64; 2] {
        let [low, high] = self.band.ends_hz();
        let range = match self.band {
            DisplayedPart::MassLine(..) => [SHOWN[0] * low, SHOWN[1] * high],
            DisplayedPart::Suspension(_) => [low, high],
        };
        if range[0] < range[1] { range } else { [0.0, 1.0] }
    }

    /// The values of the curves at frequencies in a range.
    fn values(&self, [low, high]: [f64; 2]) -> impl Iterator<Item = f64> + '_ {
        let curves = self
            .curves
            .iter()
            .flat_map(|accelerances| accelerances.of_all.iter().chain(&accelerances.of_sensor));
        curves.filter(move |(f, _)| (low..=high).contains(f)).map(|(_, value)| *value)
    }

    /// The range of the accelerance: all that is drawn, but for what is far beyond the values within the band.
    fn range_of_values(&self, least: Option<f64>) -> [f64; 2] {
        let fixed = || self.band.mass_line().into_iter().chain(least);
        let inside = self.values(self.band.ends_hz()).chain(fixed());
        let [low, high] = range_of(inside);
        let far = BEYOND * (high - low);
        let values = self.values(self.range()).map(|value| value.clamp(low - far, high + far));
        range_of(values.chain(fixed()))
    }

    fn draw<B: DrawingBackend>(
        &self,
        area: &Area<B>,
        least: Option<f64>,
        (is_first, is_lowest): (bool, bool),
    ) -> DrawingOutcome<B> {
        let width = area.dim_in_pixel().0 as i32;
        let of_curve = || self.curves.as_ref().is_some_and(Accelerances::is_negative);
        let is_reversed = self.band.mass_line().map_or_else(of_curve, |value| value < 0.0);
        let against = if is_reversed { ": against its force" } else { "" };
        let name = format!("{}{against}", self.dof);
        write(area, &name, (width / 2 + 40, 20), (HPos::Center, VPos::Center), LABEL)?;
        let (_, area) = area.split_vertically(38);
        let x = self.range();
        let mut curves = vec![Curve::level(x, 0.0, INK).wide(3)];
        curves.extend(least.map(|least| Curve::level(x, least, COLORS[2]).wide(3)));
        if let Some(accelerances) = &self.curves {
            curves.push(Curve::of(accelerances.of_sensor.clone(), COLORS[3]).wide(3));
            curves.push(Curve::of(accelerances.of_all.clone(), COLORS[0]).wide(3));
        }
        if let DisplayedPart::MassLine(ends, value) = self.band {
            curves.push(Curve::level(ends, value, COLORS[1]).wide(5).dashed(DASHES));
        }
        let panel = Panel {
            x,
            y: self.range_of_values(least),
            below: Some(if is_lowest { "frequency, Hz" } else { "" }),
            left: match self.band {
                _ if !is_first => "",
                DisplayedPart::MassLine(..) => "real part, (m/s²)/N",
                DisplayedPart::Suspension(_) => "imaginary part, (m/s²)/N",
            },
            room: if is_first { 120 } else { 80 },
            shaded: self.band.mass_line().map(|_| self.band.ends_hz()),
        };
        panel.draw(&area, &curves)
    }
}

impl Drawing for DrivingPoints {
    fn heading(&self) -> Heading<'_> {
        Heading { subject: &self.title, shows: "driving-point accelerance".into() }
    }

    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B> {
        let mut keys =
            vec![Key::of("all sensors as one rigid body", Sign::Line(3, None), COLORS[0])];
        let has_sensor = |accelerances: &Accelerances| !accelerances.of_sensor.is_empty();
        if self.points.iter().flat_map(|point| &point.curves).any(has_sensor) {
            keys.push(Key::of("sensor at the point alone", Sign::Line(3, None), COLORS[3]));
        }
        if self.points.iter().any(|point| point.band.mass_line().is_some()) {
            keys.push(Key::of("mass lines", Sign::Line(5, DASHES), COLORS[1]));
            keys.push(Key::of("their band", Sign::Patch, FAINT));
        }
        if self.least.is_some() {
            keys.push(Key::of("1/m: no point moves less", Sign::Line(3, None), COLORS[2]));
        }
        let used = legend(area, &keys)?;
        let (_, area) = area.split_vertically(used);
        let count = self.points.len();
        let rows = count.div_ceil(COLUMNS).max(1);
        let columns = count.div_ceil(rows).max(1);
        let panels = area.split_evenly((rows, columns));
        for (place, (point, panel)) in self.points.iter().zip(&panels).enumerate() {
            let is_lowest = place + columns >= count;
            point.draw(panel, self.least, (place % columns == 0, is_lowest))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range_of_curve(beside: f64) -> [f64; 2] {
        let curve = vec![(8.0, beside), (10.0, 4.2), (50.0, 4.3), (100.0, 4.5), (120.0, 5.4)];
        let point = Point {
            dof: "4:+X".parse().unwrap(),
            band: DisplayedPart::MassLine([10.0, 100.0], 4.2),
            curves: Some(Accelerances { of_all: curve, of_sensor: Vec::new() }),
        };
        point.range_of_values(Some(0.8))
    }

    #[test]
    fn the_axis_holds_the_curve_beside_its_band() {
        let [low, high] = range_of_curve(4.4);
        assert!(low < 0.0 && 5.4 < high && high < 6.0, "{low} {high}");
    }

    #[test]
    fn a_mode_beside_the_band_does_not_make_it_flat() {
        let [low, high] = range_of_curve(900.0);
        assert!(low < 0.0 && 5.4 < high && high < 20.0, "{low} {high}");
    }
}
