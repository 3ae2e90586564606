//! From the functions of a universal file to the mass lines of a layout.

use massline_shared::identify::MassLines;
use massline_shared::layout::{Axis, Dof, HOST_SENSORS, HostLayout, Sensor};
use massline_shared::mass_line::{BasisRow, Line, MassLineBasis, MassLineError, Terms};
use nalgebra::{Complex, SVector};

use crate::uff::{Frf, Function, NodeDirection, Quantity, UffFault, UffFile};
use crate::{Error, Result};

/// Channels that the host solves for.
pub(super) const CHANNELS: usize = 3 * HOST_SENSORS;

/// The mass lines of every hit of the layout.
pub(super) fn mass_lines(
    layout: &HostLayout,
    uff: &UffFile,
    quantity: Option<Quantity>,
) -> Result<Vec<MassLines<f64, CHANNELS>>> {
    let mut all = Vec::new();
    for hit in &layout.hits {
        let mut accelerance = SVector::<f64, CHANNELS>::zeros();
        let places = layout.sensors.iter().flat_map(|sensor| Axis::ALL.map(|axis| (sensor, axis)));
        for (to, (sensor, axis)) in accelerance.iter_mut().zip(places) {
            *to = mass_line(layout, uff, quantity, sensor, axis, hit.dof)?;
        }
        all.push(MassLines::without_scatter(accelerance));
    }
    Ok(all)
}

/// The mass line of one sensor axis due to one hit.
fn mass_line(
    layout: &HostLayout,
    uff: &UffFile,
    quantity: Option<Quantity>,
    sensor: &Sensor<f64>,
    axis: Axis,
    hit: Dof,
) -> Result<f64> {
    let function = find(uff, sensor.node, axis, hit)?;
    let frf = function.accelerance(quantity)?;
    let sign = sign(function.response) * sign(function.reference) * hit.sign.factor();
    let points = band(&frf, layout.test.band_hz);
    if let Some((f, _)) = points.iter().find(|(f, h)| !(f.is_finite() && is_finite(h))) {
        let message = format!(
            "the frequency response of {} (dataset {}) is NaN or infinite at {f} Hz; measure or \
             export it again",
            name(sensor.node, axis, hit),
            function.dataset
        );
        return Err(Error::input("data_not_finite", message));
    }
    let lines = || points.iter().map(|&(frequency, _)| Line { frequency, weight: 1.0 });
    let mut rows = vec![BasisRow::default(); points.len()];
    let fit = MassLineBasis::new(lines(), layout.test.band_hz, 0.0, Terms::Abc, &mut rows)
        .and_then(|basis| basis.fit(points.iter().map(|&(_, h)| h)));
    fit.map(|line| sign * line.accelerance()).map_err(|error| {
        let [low, high] = layout.test.band_hz;
        let code = match error {
            MassLineError::BandTooNarrow => "band_too_narrow",
            MassLineError::NotFinite => "data_not_finite",
            _ => "uff_corrupt",
        };
        let message = format!(
            "the frequency response of {} (dataset {}) has {} lines within {low} to {high} Hz: \
             {error}; change test.band_hz or export more lines",
            name(sensor.node, axis, hit),
            function.dataset,
            points.len()
        );
        Error::input(code, message)
    })
}

/// The one function of a sensor axis and hit.
fn find(uff: &UffFile, node: u16, axis: Axis, hit: Dof) -> Result<&Function> {
    let at = |place: NodeDirection, node: u16, axis: Axis| {
        place.node == i64::from(node) && place.direction.unsigned_abs() == axis.index() as u64 + 1
    };
    let mut matching = uff
        .functions
        .iter()
        .filter(|f| at(f.response, node, axis) && at(f.reference, hit.node, hit.axis));
    let mut frfs = matching.clone().filter(|f| f.is_frequency_response());
    match (frfs.next(), frfs.next(), matching.next()) {
        (Some(function), None, _) => Ok(function),
        (Some(first), Some(second), _) => {
            let message = format!(
                "the frequency response of {} is there twice, in datasets {} and {}; remove one",
                name(node, axis, hit),
                first.dataset,
                second.dataset
            );
            Err(Error::input("frf_doubled", message))
        }
        (None, _, Some(other)) => {
            let found = other.function_type;
            let error = other.error(UffFault::FunctionType { found });
            Err(Error::from(error).within(name(node, axis, hit)))
        }
        (None, _, None) => {
            let message = format!(
                "there is no frequency response of {}; export it (response node {node}, direction \
                 ±{}, reference node {}, direction ±{}) or take sensor or hit out of the layout",
                name(node, axis, hit),
                axis.index() + 1,
                hit.node,
                hit.axis.index() + 1
            );
            Err(Error::input("frf_missing", message))
        }
    }
}

/// Frequencies and accelerances within the band, ascending.
fn band(frf: &Frf, [low, high]: [f64; 2]) -> Vec<(f64, Complex<f64>)> {
    let mut points: Vec<_> = frf
        .frequency_hz
        .iter()
        .copied()
        .zip(frf.accelerance.iter().copied())
        .filter(|(f, _)| !(*f < low || *f > high))
        .collect();
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    points
}

fn is_finite(h: &Complex<f64>) -> bool {
    h.re.is_finite() && h.im.is_finite()
}

fn sign(place: NodeDirection) -> f64 {
    if place.direction < 0 { -1.0 } else { 1.0 }
}

fn name(node: u16, axis: Axis, hit: Dof) -> String {
    format!("the sensor on node {node}, axis {axis:?}, due to the hit {hit}")
}
