//! Whether the sensors agree on the motion of a rigid body, and which sensor's axes would explain it if they do not.

use massline_shared::FrequencyResponses;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::layout::{HostLayout, Sensor};
use nalgebra::{Complex, DMatrix, DVector};

use super::HostFit;

/// Part of the readings that fits no rigid motion from which there is a warning. The default error budget makes 0.03.
const NOTICEABLE: f64 = 0.1;
/// Part from which there is no answer.
const TOO_MUCH: f64 = 0.3;

/// A finding about readings that fit no motion of a rigid body at the lines about the modes; an error when one sensor
/// with turned, swapped or reversed axes explains it, or when too much does not fit.
pub(super) fn not_rigid(
    fit: &HostFit<'_>,
    readings: &FrequencyResponses<'_, f64>,
) -> Option<Diagnostic> {
    let layout = fit.layout();
    let test = Readings::of(fit, readings);
    let share = test.share_left(layout);
    if share < NOTICEABLE {
        return None;
    }
    let turned = layout.sensors.iter().enumerate().flat_map(|(place, sensor)| {
        signed_permutations().map(move |axes| (place, with_axes(sensor, axes)))
    });
    let explained = turned.filter_map(|(place, sensor)| {
        let mut layout = layout.clone();
        layout.sensors[place] = sensor;
        let left = test.share_left(&layout);
        (left < 0.5 * NOTICEABLE && left < 0.3 * share).then_some((left, place))
    });
    let best = explained.min_by(|a, b| a.0.total_cmp(&b.0));
    Some(match best {
        Some((left, place)) => {
            let (code, subject) = (Code::SensorAxesSuspect, Subject::sensor(place));
            let chi_squared = test.squares * left * left / fit.noise().powi(2);
            Diagnostic::about(code, Severity::Error, subject, chi_squared as f32)
        }
        None => {
            let severity = if share > TOO_MUCH { Severity::Error } else { Severity::Warning };
            Diagnostic::whole(Code::ReadingsNotRigid, severity, share as f32)
        }
    })
}

/// The readings of all channels at the lines about the modes, under every hit.
struct Readings {
    lines: Vec<(Complex<f64>, DMatrix<Complex<f64>>)>,
    /// Sum of their squares.
    squares: f64,
    /// Variance of the noise of one of them.
    noise: f64,
}

impl Readings {
    fn of(fit: &HostFit<'_>, readings: &FrequencyResponses<'_, f64>) -> Self {
        let (channels, hits) = (readings.channels(), readings.hits());
        let places = fit.lines().below.iter().chain(&fit.lines().above);
        let of_line = |&line: &usize| {
            let at = |channel, hit| readings.at(line, channel, hit);
            (readings.s(line), DMatrix::from_fn(channels, hits, at))
        };
        let lines: Vec<_> = places.map(of_line).collect();
        let squares = lines.iter().map(|(_, readings)| readings.norm_squared()).sum();
        Self { lines, squares, noise: fit.noise().powi(2) }
    }

    /// The part of the readings that no motion explains, beyond what the noise leaves.
    fn share_left(&self, layout: &HostLayout) -> f64 {
        let mut left = 0.0;
        for (s, readings) in &self.lines {
            let (channels, hits) = readings.shape();
            let row = |channel: usize| layout.response_row_at(channel, *s);
            let matrix = DMatrix::from_fn(channels, 6, |channel, k| row(channel)[k]);
            let basis = matrix.qr().q();
            for column in readings.column_iter() {
                let column: DVector<Complex<f64>> = column.into_owned();
                left += (&column - &basis * (basis.adjoint() * &column)).norm_squared();
            }
            left -= self.noise * (channels.saturating_sub(6) * hits) as f64;
        }
        (left.max(0.0) / self.squares).sqrt()
    }
}

/// The 47 ways to turn, swap or reverse three axes: the axis that each reads instead, and its sign.
fn signed_permutations() -> impl Iterator<Item = [(usize, f64); 3]> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let permutations = orders.into_iter().flat_map(|order| {
        (0..8_u8).map(move |signs| {
            std::array::from_fn(|k| (order[k], if signs >> k & 1 == 0 { 1.0 } else { -1.0 }))
        })
    });
    permutations.skip(1)
}

fn with_axes(sensor: &Sensor<f64>, axes: [(usize, f64); 3]) -> Sensor<f64> {
    let mut turned = *sensor;
    for (turned, row) in turned.axes.iter_mut().zip(sensor.axes) {
        *turned = axes.map(|(from, sign)| row[from] * sign);
    }
    turned
}
