//! How a test was measured: what a report of impact testing has to state (compare ISO 7626-5).

use massline_shared::calibration::CalibrationMethod;
use massline_shared::layout::{HostLayout, TestSettings};
use massline_shared::mass_line::Terms;
use massline_shared::signal::RECORD_SCANS;

use crate::archive::Archive;
use crate::calibration::day::Day;
use crate::error::Result;
use crate::layout_file::Statements;
use crate::report::hash_text;
use crate::result_file::ResultFile;

use super::for_people;

/// Rows under a heading.
pub(super) struct Group {
    pub heading: &'static str,
    pub rows: Vec<Fact>,
}

/// A row: what it is, and what is known of it.
pub(super) struct Fact {
    pub label: &'static str,
    /// Empty where nobody has stated it.
    pub value: String,
}

/// All groups of a result.
///
/// # Errors
/// When the calibration of the archive is not one.
pub(super) fn groups(source: &ResultFile) -> Result<Vec<Group>> {
    let mut groups = vec![statements(source)];
    if let Some(archive) = source.archive() {
        groups.push(rig(archive));
        groups.push(calibration(archive)?);
    }
    if let Some(layout) = source.layout() {
        groups.push(settings(source, &layout.test)?);
        groups.push(budget(layout));
    }
    groups.push(files(source));
    groups.retain(|group| !group.rows.is_empty());
    Ok(groups)
}

fn fact(label: &'static str, value: impl Into<String>) -> Fact {
    Fact { label, value: value.into() }
}

/// What only a person can state.
fn statements(source: &ResultFile) -> Group {
    let nothing = Statements::default();
    let of = source.layout_file().map_or(&nothing, |file| &file.statements);
    let document = source.document();
    let measured = document["measured"].as_str().unwrap_or_default();
    let mut rows = vec![
        fact("measured", for_people(measured)),
        fact("object", &of.object),
        fact("support", &of.support),
        fact("hammer and tip", &of.hammer),
        fact("sensors and mounting", &of.sensors),
        fact("operator", &of.operator),
        fact("place", &of.place),
    ];
    if !of.remarks.is_empty() {
        rows.push(fact("remarks", &of.remarks));
    }
    Group { heading: "Test", rows }
}

fn rig(archive: &Archive) -> Group {
    let rig = &archive.rig;
    let changed = if rig.git_dirty { ", with changes" } else { "" };
    let mut rows = vec![
        fact("board", &rig.board),
        fact("firmware", format!("{} (commit {}{changed})", rig.firmware, rig.git_hash)),
    ];
    if let Some(sampler) = rig.sampler {
        let rate = f64::from(sampler.adc.rate.0);
        let seconds = RECORD_SCANS as f64 / rate;
        let before = 1e3 * f64::from(sampler.pre_trigger_scans) / rate;
        rows.push(fact(
            "sampling",
            format!("{rate:.0} scans per second, {} bits", sampler.adc.bits),
        ));
        rows.push(fact(
            "record of a hit",
            format!("{seconds:.3} s, {before:.0} ms of it before the hit"),
        ));
    }
    if let Some(spectra) = archive.spectra.first() {
        rows.push(fact("frequency resolution", format!("{:.3} Hz", spectra.resolution_hz)));
    }
    Group { heading: "Rig", rows }
}

fn calibration(archive: &Archive) -> Result<Group> {
    let mut rows = Vec::new();
    match archive.calibration()? {
        None => {
            rows.push(fact("calibration", "not in the archive: the rig had another one by then"))
        }
        Some(of) => {
            rows.push(fact("method", spelled(of.method)));
            // A data sheet has no day.
            if of.method != CalibrationMethod::DataSheet || !of.date.is_empty() {
                rows.push(fact("calibrated", dated(&of.date, archive.measured.as_deref())));
            }
            if !of.hammer.is_empty() {
                rows.push(fact("hammer", of.hammer.as_str()));
            }
            let named: Vec<&str> = of
                .sensors
                .iter()
                .map(|name| name.as_str())
                .filter(|name| !name.is_empty())
                .collect();
            if !named.is_empty() {
                rows.push(fact("sensors", named.join(", ")));
            }
            let percent = |relative: f32| format!("{:.2} %", 100.0 * relative);
            let sigma = of.sigma;
            rows.push(fact(
                "its uncertainty (1 sd)",
                format!(
                    "gains {}, cross-axis {}, hammer {}",
                    percent(sigma.gain),
                    percent(sigma.cross_axis),
                    percent(sigma.hammer_gain)
                ),
            ));
            if let Some(temperature) = of.temperature {
                rows.push(fact("temperature then", format!("{temperature:.0} °C")));
            }
        }
    }
    let checksum = hash_text(archive.result.head.calibration);
    rows.push(fact("checksum", checksum.unwrap_or_else(|| "none".into())));
    Ok(Group { heading: "Calibration", rows })
}

/// A date, and how long before the test it was.
fn dated(date: &str, measured: Option<&str>) -> String {
    if date.is_empty() {
        return "without a date".into();
    }
    let day = |text: &str| text.get(..10)?.parse::<Day>().ok();
    match (day(date), measured.and_then(day)) {
        (Some(then), Some(test)) => match then.days_until(test) {
            0 => format!("{date}, on the day of the test"),
            1 => format!("{date}, one day before the test"),
            days if days > 1 => format!("{date}, {days} days before the test"),
            _ => format!("{date}, after the test"),
        },
        _ => date.to_owned(),
    }
}

/// The settings that the result depends on: those of records and hits only where a rig has measured it.
fn settings(source: &ResultFile, test: &TestSettings<f64>) -> Result<Group> {
    let document = source.document();
    let mut rows = Vec::new();
    let by_rig = source.archive().is_some() || document["firmware"].is_string();
    let has_mass_lines = document["mass_lines"].as_array().is_some_and(|of| !of.is_empty());
    if let Some(modes) = source.modes()? {
        let [low, high] = modes.band_hz;
        rows.push(fact("band of the suspension modes", format!("{low:.1} to {high:.1} Hz")));
    }
    if by_rig || has_mass_lines {
        let automatic = document["band_automatic"] == true;
        let band = match test.band_hz {
            Some([low, high]) if !automatic => format!("{low:.1} to {high:.1} Hz"),
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
        let estimator = test.frf_estimator.name().replacen('h', "H", 1);
        let windows = format!(
            "force ±{:.1} ms about its peak, exponential with a decay rate of {:.1} s⁻¹",
            1e3 * test.force_window_s,
            test.exponential_decay
        );
        rows.extend([
            fact("frequency responses", format!("estimator {estimator}")),
            fact("windows", windows),
            fact("hits wanted at each DOF", test.hits_per_dof.to_string()),
            fact("trigger", format!("{:.1} N", test.trigger_n)),
            fact("smallest peak force", format!("{:.1} N", test.min_peak_force_n)),
        ]);
    }
    Ok(Group { heading: "Settings", rows })
}

/// How a calibration was made, in words.
fn spelled(method: CalibrationMethod) -> &'static str {
    match method {
        CalibrationMethod::DataSheet => "sensitivities of the data sheets",
        CalibrationMethod::Tumble => "tumble test",
        CalibrationMethod::Block => "block test",
        CalibrationMethod::TumbleAndBlock => "tumble and block tests",
        CalibrationMethod::Other => "other",
    }
}

fn budget(layout: &HostLayout) -> Group {
    let mut rows = Vec::new();
    if let Some(hit) = layout.hits.first() {
        let of = hit.uncertainty;
        rows.push(fact(
            "where and how the hammer lands",
            format!("{:.1} mm, {:.0} mrad from hit to hit", 1e3 * of.position, 1e3 * of.direction),
        ));
        rows.push(fact(
            "marks",
            format!("{:.1} mm, {:.0} mrad", 1e3 * of.node_position, 1e3 * of.node_direction),
        ));
    }
    if let Some(sensor) = layout.sensors.first() {
        let of = sensor.uncertainty;
        rows.push(fact(
            "sensors",
            format!(
                "{:.1} mm, {:.0} mrad, gain {:.2} %, cross-axis {:.2} %",
                1e3 * of.position,
                1e3 * of.rotation,
                100.0 * of.gain,
                100.0 * of.cross_axis
            ),
        ));
    }
    rows.push(fact("hammer's gain", format!("{:.2} %", 100.0 * layout.hammer_gain)));
    let learned = if layout.learn_budget { "corrected from the data" } else { "used as stated" };
    rows.push(fact("budget", learned));
    Group { heading: "Error budget as stated (1 sd, first sensor and hit)", rows }
}

fn files(source: &ResultFile) -> Group {
    let document = source.document();
    let program = source.archive().map(|archive| archive.program.clone()).unwrap_or_default();
    let mut rows = vec![fact("file", &source.name)];
    if let Some(hash) = document["layout_hash"].as_str() {
        rows.push(fact("layout hash", hash));
    }
    if !program.is_empty() {
        rows.push(fact("written by", format!("massline {program}")));
    }
    rows.push(fact("solved and reported by", concat!("massline ", env!("CARGO_PKG_VERSION"))));
    Group { heading: "Files and versions", rows }
}
