//! YAML: values, standard deviations, intervals and covariance, in the order that the file states.
//!
//! Strings are written as in JSON, which YAML reads; numbers as every version of YAML reads them.

use super::heading;
use super::number::shortest;
use super::subject::ExportedResult;
use massline_result::Result;

/// A document.
pub(super) fn write(exported: &ExportedResult) -> Result<Vec<u8>> {
    let mut text = String::new();
    for line in heading::lines(exported, "") {
        text += &format!("# {line}\n");
    }
    let units = exported.units;
    let placement = &exported.placement;
    let body = &exported.body;
    let quoted = |text: &str| serde_json::Value::from(text).to_string();
    let mut line = |key: &str, value: String| {
        // What has lines of its own begins below its key.
        let gap = if value.is_empty() || value.starts_with('\n') { "" } else { " " };
        text += &format!("{key}:{gap}{value}\n");
    };
    line("schema_version", super::json::SCHEMA_VERSION.to_string());
    line("title", quoted(&exported.test.title));
    line("method", quoted(exported.method()));
    line("source", quoted(&exported.test.source));
    line("program", quoted(heading::PROGRAM));
    line("verdict", quoted(exported.verdict.name()));
    line("physically_consistent", exported.violated_condition().is_none().to_string());
    line("convention", quoted(heading::convention()));
    line("units", String::new());
    line("  mass", quoted(units.mass_unit()));
    line("  length", quoted(units.length_unit()));
    line("  inertia", quoted(&units.inertia_unit()));
    line("frame", String::new());
    line("  name", quoted(&placement.frame.to_string()));
    line("  origin", list(placement.origin.iter().copied()));
    line("  axes", rows(3, |i, j| placement.axes[(i, j)]));
    line("mass", shortest(body.mass));
    line("center_of_mass", list(body.center_of_mass.iter().copied()));
    line("inertia", rows(3, |i, j| body.inertia[(i, j)]));
    line("order", format!("[{}]", heading::order().join(", ")));
    line("value", list(exported.theta().iter().copied()));
    let optional = |values: Option<super::Vector10>| {
        values.map_or("null".into(), |values| list(values.iter().copied()))
    };
    line("sigma", optional(exported.sigma()));
    let [low, high] = exported.interval().map_or([None; 2], |ends| ends.map(Some));
    line("low95", optional(low));
    line("high95", optional(high));
    let covariance = exported.covariance();
    line("covariance", covariance.map_or("null".into(), |c| rows(10, |i, j| c[(i, j)])));
    Ok(text.into_bytes())
}

fn list(values: impl IntoIterator<Item = f64>) -> String {
    format!("[{}]", values.into_iter().map(shortest).collect::<Vec<_>>().join(", "))
}

/// A square matrix row by row, each in its line.
fn rows(size: usize, element: impl Fn(usize, usize) -> f64) -> String {
    let row = |i: usize| format!("\n    - {}", list((0..size).map(|j| element(i, j))));
    (0..size).map(row).collect()
}
