//! Whether the sensors agree on the motion of a rigid body, and which sensor's axes or which swapped cables would explain
//! it if they do not.

use massline_shared::FrequencyResponses;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::identify::suspension::FEWEST_MODES;
use massline_shared::layout::{HostLayout, Sensor};
use massline_shared::modes::Reduction;
use nalgebra::{Complex, DMatrix, DVector};

use super::HostFit;

/// Part of the readings that fits no rigid motion from which there is a warning. The default error budget makes 0.03.
const NOTICEABLE: f64 = 0.1;
/// Part from which there is no answer.
const TOO_MUCH: f64 = 0.3;
/// Part below which a change of the layout explains the readings.
const EXPLAINED: f64 = 0.05;

/// A finding about readings that fit no motion of a rigid body at the lines about the modes; an error when one sensor
/// with turned, swapped or reversed axes or the swapped cables of two explain it, or when too much does not fit.
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
    let with = |change: &dyn Fn(&mut HostLayout)| {
        let mut layout = layout.clone();
        change(&mut layout);
        test.share_left(&layout)
    };
    let turned = layout.sensors.iter().enumerate().flat_map(|(place, sensor)| {
        let finding = (Code::SensorAxesSuspect, Subject::sensor(place));
        signed_permutations().map(move |axes| (place, with_axes(sensor, axes), finding))
    });
    let turned = turned
        .map(|(place, sensor, finding)| (with(&|layout| layout.sensors[place] = sensor), finding));
    let swapped = pairs(layout.sensors.len()).map(|(first, second)| {
        let finding = (Code::CablesSwapped, Subject::Whole);
        (with(&|layout| layout.sensors.swap(first, second)), finding)
    });
    let explained =
        turned.chain(swapped).filter(|(left, _)| *left < EXPLAINED && *left < 0.3 * share);
    let best = explained.min_by(|a, b| a.0.total_cmp(&b.0));
    Some(match best {
        Some((left, (code, subject))) => {
            Diagnostic::about(code, Severity::Error, subject, test.chi_squared(left))
        }
        None => {
            let severity = if share > TOO_MUCH { Severity::Error } else { Severity::Warning };
            Diagnostic::whole(Code::ReadingsNotRigid, severity, share as f32)
        }
    })
}

/// The finding about readings in which no modes were found, where there are modes of a rigid body when the cables of two
/// sensors are swapped back.
pub(super) fn swapped_cables(
    layout: &HostLayout,
    readings: &FrequencyResponses<'_, f64>,
    memory: &mut Reduction<f64>,
) -> Option<Diagnostic> {
    let left = pairs(layout.sensors.len()).filter_map(|(first, second)| {
        let mut layout = layout.clone();
        layout.sensors.swap(first, second);
        let fit = HostFit::new(&layout, readings, memory).ok()?;
        let test = Readings::of(&fit, readings);
        let left = test.share_left(&layout);
        (left < EXPLAINED && fit.modes().modes.len() >= FEWEST_MODES)
            .then(|| (left, test.chi_squared(left)))
    });
    let (_, chi_squared) = left.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(Diagnostic::whole(Code::CablesSwapped, Severity::Error, chi_squared))
}

/// Every two of so many sensors.
fn pairs(count: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..count).flat_map(move |first| (first + 1..count).map(move |second| (first, second)))
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

    /// χ² of this part of the readings against their noise.
    fn chi_squared(&self, left: f64) -> f32 {
        (self.squares * left * left / self.noise) as f32
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
