//! The sensors and hit DOFs of a test.

use massline_shared::layout::HostLayout;

use crate::result_file::ResultFile;
use crate::typography::with_minus_signs;

/// A DOF that was hit.
pub(super) struct DofRow {
    pub dof: String,
    /// Where, mm, and along which direction of the body frame.
    pub position: String,
    pub direction: String,
    /// Number of averaged hits; empty where it is not known.
    pub hits: String,
    pub band: String,
    /// The mean coherence over the band: the median of the responses, and the least of them.
    pub coherence: [String; 2],
    /// How far the fit pulls it, in standard deviations of its budget, and what it leaves of its readings over their
    /// noise.
    pub pull: String,
    pub residual: String,
}

/// The DOFs of a result, in the order of its layout; none where that is not known.
pub(super) fn dofs(source: &ResultFile) -> Vec<DofRow> {
    let Some(layout) = source.layout() else { return Vec::new() };
    let result = source.result();
    let (details, measured_dofs) = (&result.details, result.measured_dofs());
    let row = |hit: &massline_shared::layout::Hit<f64>| {
        let dof = hit.dof.to_string();
        let measured = measured_dofs.iter().find(|measured| measured.dof == dof);
        let fitted =
            details.iter().flat_map(|details| &details.hits).find(|fitted| fitted.dof == dof);
        let sensors = layout.sensors.len();
        let coherence =
            measured.and_then(|measured| measured.coherence.as_ref()).and_then(|values| {
                let mut values: Vec<f64> = values.iter().copied().take(3 * sensors).collect();
                values.sort_by(f64::total_cmp);
                Some(
                    [*values.get(values.len() / 2)?, *values.first()?]
                        .map(|value| format!("{value:.3}")),
                )
            });
        DofRow {
            dof,
            position: millimetres(hit.position),
            direction: unit_vector(hit.direction),
            hits: measured
                .and_then(|measured| measured.hits)
                .map_or(String::new(), |hits| hits.to_string()),
            band: measured
                .and_then(|measured| measured.band_hz)
                .map_or(String::new(), |[low, high]| format!("{low:.1} to {high:.1}")),
            coherence: coherence.unwrap_or_default(),
            pull: fitted
                .and_then(|fitted| fitted.pull)
                .map_or(String::new(), |pull| format!("{pull:.2}")),
            residual: fitted
                .and_then(|fitted| fitted.normalized_residual)
                .map_or(String::new(), |residual| format!("{residual:.2}")),
        }
    };
    layout.hits.iter().map(row).collect()
}

/// The sensors: node, position and axes.
pub(super) fn sensors(layout: &HostLayout) -> Vec<[String; 4]> {
    let row = |sensor: &massline_shared::layout::Sensor<f64>| {
        let [x, y, _] = sensor.axes;
        [sensor.node.to_string(), millimetres(sensor.position), unit_vector(x), unit_vector(y)]
    };
    layout.sensors.iter().map(row).collect()
}

fn millimetres(position: [f64; 3]) -> String {
    // Adding zero takes the sign from a negative zero.
    with_minus_signs(&position.map(|x| format!("{:.1}", (1e4 * x).round() / 10.0 + 0.0)).join(", "))
}

fn unit_vector(direction: [f64; 3]) -> String {
    let part = |x: f64| {
        let rounded = format!("{:.3}", (1e3 * x).round() / 1e3 + 0.0);
        rounded.trim_end_matches('0').trim_end_matches('.').to_owned()
    };
    with_minus_signs(&direction.map(part).join(", "))
}
