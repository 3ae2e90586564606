//! `f_gravity_`: sensors that measure gravity, at single frequencies.

use core::fmt::Write as _;

use massline_shared::body::RigidBody;
use massline_shared::capacity::Rig;
use massline_shared::identify::ResponseInverse;
use massline_shared::identify::inertia_restraint::Regression;
use massline_shared::layout::sensor_shift;
use massline_shared::{Real, ResponseRows};
use nalgebra::{Complex, SVector, Vector3};

use crate::Check;
use crate::layout::{GoldenLayout, GoldenResponses, RESPONSES};

pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let layout = check.layout()?;
    let gravity = Vector3::from(layout.gravity?);
    let body = RigidBody::from_theta(&SVector::from(check.input_array::<10>("theta_true")?));
    for array in check.case.arrays {
        let Some(frequency) = frequency_of(array.path) else {
            continue;
        };
        let omega = R::two_pi() * R::of(frequency.parse().ok()?);
        let s = Complex::new(R::zero(), omega);
        let with = layout.response_matrix_at(&Vector3::zeros(), s);
        let with = ResponseRows(with.0.map(|column| column.map(|v| v.re)));
        let readings = readings(&layout, &body, &with)?;
        let path = |name: &str| {
            let mut path = heapless::String::<32>::new();
            write!(path, "{frequency}.{name}").ok().map(|()| path)
        };
        check.response_rows(&path("G_gravity")?, &with);
        check.numbers(&path("H")?, &row_major(&readings));
        let plain = layout.response_matrix(&Vector3::zeros());
        let ignored = identify(&layout, &plain, &readings)?;
        check.numbers(&path("theta_if_ignored")?, ignored.as_slice());
        let modelled = identify(&layout, &with, &readings)?;
        check.numbers(&path("theta_if_modelled")?, modelled.as_slice());
        check.numbers(&path("sensor_shift")?, sensor_shift(&gravity, omega).as_slice());
    }
    Some(())
}

type SensorColumns<R> = heapless::Vec<GoldenResponses<R>, 4>;

/// Extracts `5` from `expected.5.sensor_shift`, once for each frequency.
fn frequency_of(path: &'static str) -> Option<&'static str> {
    path.strip_prefix("expected.")?.strip_suffix(".sensor_shift")
}

fn readings<R: Real>(
    layout: &GoldenLayout<R>,
    body: &RigidBody<R>,
    response: &ResponseRows<R, Rig, 6>,
) -> Option<SensorColumns<R>> {
    let mut readings = SensorColumns::new();
    for hit in &layout.hits {
        let motion = body.acceleration(&hit.unit_force(&Vector3::zeros()))?;
        readings.push(response.times(&motion)).ok()?;
    }
    Some(readings)
}

/// The inertia restraint method about the origin with a given response matrix.
fn identify<R: Real>(
    layout: &GoldenLayout<R>,
    response: &ResponseRows<R, Rig, 6>,
    readings: &SensorColumns<R>,
) -> Option<SVector<R, 10>> {
    let length = layout.characteristic_length();
    let inverse = ResponseInverse::new(response, length)?;
    let mut regression = Regression::new(length);
    for (hit, readings) in layout.hits.iter().zip(readings) {
        regression.add(&inverse.motion(readings), &hit.unit_force(&Vector3::zeros()));
    }
    Some(regression.solve().ok()?.body.theta())
}

fn row_major<R: Real>(columns: &SensorColumns<R>) -> heapless::Vec<R, 36> {
    (0..RESPONSES).flat_map(|row| columns.iter().map(move |c| c[row])).collect()
}
