//! How a test was measured: what a report of impact testing has to state (compare ISO 7626-5).

mod calibration;
mod rig;
mod spectra;

use massline_shared::layout::{
    ApparatusUncertainty, ErrorSource, HostLayout, TestProfile, TestSettings, UncertaintyUnit,
};
use massline_shared::mass_line::Terms;

use crate::result_file::ResultFile;
use massline_files::layout_file::Statements;
use massline_result::Result;

use super::for_people;
pub(super) use calibration::method_and_day;
pub(super) use rig::{board, simulated};

/// Rows under a heading.
pub(super) struct Group {
    pub heading: &'static str,
    pub rows: Vec<Fact>,
    /// What is folded below the rows.
    pub more: Option<CollapsibleTable>,
}

/// A row: what it is, and what is known of it.
pub(super) struct Fact {
    pub label: &'static str,
    /// Empty where nobody has stated it.
    pub value: String,
}

/// A table to be opened.
pub(super) struct CollapsibleTable {
    pub summary: &'static str,
    pub header: Vec<&'static str>,
    pub rows: Vec<Vec<String>>,
}

/// All groups of a result.
///
/// # Errors
/// When the calibration of the archive is not one.
pub(super) fn groups(source: &ResultFile) -> Result<Vec<Group>> {
    let mut groups = vec![statements(source), rig::group(source), calibration::group(source)?];
    if let Some(layout) = source.layout() {
        groups.push(settings(source, &layout.test));
    }
    groups.push(spectra::group(source, &source.result().measured_dofs()));
    let uses_modes = source.result().suspension.is_some();
    groups.extend(source.layout_in_force().map(|layout| budget(&layout, uses_modes)));
    groups.push(files(source));
    groups.retain(|group| !group.rows.is_empty());
    Ok(groups)
}

impl Group {
    fn new(heading: &'static str, rows: Vec<Fact>) -> Self {
        Self { heading, rows, more: None }
    }
}

fn fact(label: &'static str, value: impl Into<String>) -> Fact {
    Fact { label, value: value.into() }
}

fn percent(relative: impl Into<f64>) -> String {
    format!("{:.2} %", 100.0 * relative.into())
}

/// What only a person can state.
fn statements(source: &ResultFile) -> Group {
    let nothing = Statements::default();
    let statements = source.layout_file().map_or(&nothing, |file| &file.statements);
    let measured = source.result().measured.as_deref().unwrap_or_default();
    let mut rows = vec![
        fact("measured", for_people(measured)),
        fact("object", &statements.object),
        fact("support", &statements.support),
        fact("hammer and tip", &statements.hammer),
        fact("sensors and mounting", &statements.sensors),
        fact("operator", &statements.operator),
        fact("place", &statements.place),
    ];
    if !statements.remarks.is_empty() {
        rows.push(fact("remarks", &statements.remarks));
    }
    Group::new("Test", rows)
}

/// The settings that the result depends on: those of records and hits only where a rig has measured it.
fn settings(source: &ResultFile, test: &TestSettings<f64>) -> Group {
    let result = source.result();
    let mut rows = Vec::new();
    let by_rig = source.archive().is_some() || result.firmware.is_some();
    if let Some(modes) = &result.suspension {
        let [low, high] = modes.band_hz;
        rows.push(fact("band of the suspension modes", format!("{low:.1} to {high:.1} Hz")));
    }
    let of_modes = test.profile == TestProfile::Suspension;
    if by_rig && !of_modes || !result.mass_lines.is_empty() {
        let band = match test.band_hz {
            Some([low, high]) if !result.band_automatic => format!("{low:.1} to {high:.1} Hz"),
            _ => "found from the data".into(),
        };
        rows.push(fact("band of the mass lines", band));
        let terms = match test.terms {
            Terms::A => "A",
            Terms::Ab => "A + B/s²",
            Terms::Abc => "A + B/s² + C s²",
        };
        rows.push(fact("mass lines", terms));
    }
    if by_rig {
        let measured = result.measured_dofs();
        let hits: Vec<u16> = measured.iter().filter_map(|dof| dof.hits).collect();
        let estimator = result.frf_estimator.map_or(test.frf_estimator, |named| named.0).name();
        let estimator = estimator.replacen('h', "H", 1);
        let windows = format!(
            "force ±{:.1} ms about its peak, exponential with a decay rate of {:.1} s⁻¹",
            1e3 * test.force_window_s,
            test.exponential_decay
        );
        rows.extend([
            fact("frequency responses", format!("estimator {estimator}")),
            fact("windows", windows),
            fact("averages at each DOF", averages(&hits, test.hits_per_dof)),
            fact("trigger", format!("{:.1} N", test.trigger_n)),
        ]);
        rows.push(match of_modes {
            true => {
                let [least, most] = test.impulse_ns;
                fact("impulse of a hit", format!("{least:.2} to {most:.2} N s"))
            }
            false => fact("smallest peak force", format!("{:.1} N", test.min_peak_force_n)),
        });
    }
    Group::new("Settings", rows)
}

/// How many hits are averaged, and how many were wanted.
fn averages(hit_counts: &[u16], wanted: u8) -> String {
    match (hit_counts.iter().min(), hit_counts.iter().max()) {
        (Some(&least), Some(&most)) if [least, most] == [u16::from(wanted); 2] => {
            format!("{wanted} hits, as wanted")
        }
        (Some(least), Some(most)) if least == most => format!("{least} hits; {wanted} were wanted"),
        (Some(least), Some(most)) => format!("{least} to {most} hits; {wanted} were wanted"),
        _ => format!("{wanted} hits were wanted"),
    }
}

/// A standard deviation as a person reads it.
fn shown_sigma(sigma: f64, unit: UncertaintyUnit) -> String {
    match unit {
        UncertaintyUnit::Meters => format!("{:.1} mm", 1e3 * sigma),
        UncertaintyUnit::Radians => format!("{:.0} mrad", 1e3 * sigma),
        UncertaintyUnit::Relative => percent(sigma),
    }
}

fn budget(layout: &HostLayout, uses_modes: bool) -> Group {
    let sensors = layout.sensors.iter().take(1).flat_map(|sensor| sensor.uncertainty.rows());
    let hits = layout.hits.iter().take(1).flat_map(|hit| hit.uncertainty.rows());
    let has_gravity = layout.gravity.is_some();
    let apparatus = layout
        .apparatus
        .rows()
        .zip(ApparatusUncertainty::<f64>::SOURCES)
        .filter(|(_, source)| **source != ErrorSource::GravityDirection || has_gravity);
    let counted = sensors
        .chain(hits)
        .chain(apparatus.map(|(row, _)| row))
        .filter(|(key, _)| uses_modes || !key.only_modes);
    let mut rows: Vec<_> =
        counted.map(|(key, sigma)| fact(key.meaning, shown_sigma(*sigma, key.unit))).collect();
    // The methods that use the suspension modes learn nothing about it.
    let learns = layout.learn_budget && layout.test.profile == TestProfile::MassLine;
    let learned = if learns { "corrected from the data" } else { "used as stated" };
    rows.push(fact("budget", learned));
    Group::new("Error budget of the answer (1 sd, first sensor and hit)", rows)
}

fn files(source: &ResultFile) -> Group {
    let program = source.archive().map(|archive| archive.program.clone()).unwrap_or_default();
    let mut rows = vec![fact("file", &source.name)];
    if let Some(hash) = &source.result().layout_hash {
        rows.push(fact("layout hash", hash));
    }
    if !program.is_empty() {
        rows.push(fact("written by", format!("massline {program}")));
    }
    rows.push(fact("solved and reported by", concat!("massline ", env!("CARGO_PKG_VERSION"))));
    Group::new("Files and versions", rows)
}
