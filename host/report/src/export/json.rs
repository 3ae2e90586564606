//! JSON: values, standard deviations, intervals and covariance, in the order that the file states.

use serde_json::{Value, json};

use super::heading;
use super::subject::{ExportedResult, Vector10};
use massline_result::{Error, Result};

/// The version of the file. It is incremented whenever a key is renamed or removed or changes its meaning, but not when
/// a key is added.
pub(super) const SCHEMA_VERSION: u32 = 1;

/// An object.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let mut bytes = serde_json::to_vec_pretty(&object(exported))
        .map_err(|e| Error::internal("json", format!("the object is not written: {e}")))?;
    bytes.push(b'\n');
    Ok(bytes)
}

fn object(exported: &ExportedResult) -> Value {
    let units = exported.units;
    let placement = &exported.placement;
    let body = &exported.body;
    let list = |values: Vector10| values.iter().copied().collect::<Vec<f64>>();
    let matrix = |size: usize, element: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..size).map(|i| (0..size).map(|j| element(i, j)).collect()).collect()
    };
    let [low, high] = exported.interval().map_or([None; 2], |ends| ends.map(Some));
    json!({
        "schema_version": SCHEMA_VERSION,
        "title": exported.test.title,
        "method": exported.method(),
        "source": exported.test.source,
        "program": heading::PROGRAM,
        "verdict": exported.verdict,
        "doubts": exported.doubts,
        "physically_consistent": exported.violated_condition().is_none(),
        "convention": heading::convention(),
        "units": {
            "mass": units.mass_unit(),
            "length": units.length_unit(),
            "inertia": units.inertia_unit(),
            "force_and_time": units.force_and_time(),
        },
        "frame": {
            "name": placement.frame.to_string(),
            "origin": <[f64; 3]>::from(placement.origin),
            "axes": matrix(3, &|i, j| placement.axes[(i, j)]),
        },
        "mass": body.mass,
        "center_of_mass": <[f64; 3]>::from(body.center_of_mass),
        "inertia": matrix(3, &|i, j| body.inertia[(i, j)]),
        "order": heading::order(),
        "value": list(exported.theta()),
        "sigma": exported.sigma().map(list),
        "low95": low.map(list),
        "high95": high.map(list),
        "covariance": exported.covariance().map(|c| matrix(10, &|i, j| c[(i, j)])),
    })
}
