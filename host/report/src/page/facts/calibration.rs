//! The calibration: how and when it was made, and what it has contributed to the error budget.

use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};
use massline_shared::layout::{AXIS_LETTERS, RIG_SENSORS};
use massline_shared::signal::ChannelCalibration;

use super::{CollapsibleTable, Fact, Group, fact, percent};
use crate::result_file::ResultFile;
use crate::typography::with_minus_signs;
use crate::words::hash_text;
use massline_files::day::Day;
use massline_result::Result;

/// A calibration that was made longer ago than this is old, days.
const OLD: i32 = 365;

/// The calibration of a result.
///
/// # Errors
/// When that of the archive is not one.
pub(super) fn group(source: &ResultFile) -> Result<Group> {
    let mut group = Group::new("Calibration", Vec::new());
    let checksum = match source.archive() {
        Some(archive) => {
            match archive.calibration() {
                Some(record) => {
                    group.rows = rows(&record, archive.measured.as_deref());
                    group.more = Some(channels(&record));
                }
                None => group.rows.push(fact(
                    "calibration",
                    "not in the archive: the rig had another one by then",
                )),
            }
            hash_text(archive.result.head.calibration)
        }
        None => source.result().calibration.clone(),
    };
    if source.archive().is_some() || checksum.is_some() {
        let used = match source.gains() {
            Some(gains) => format!("{}, with the drift since then", sigma(&gains)),
            None => "that of the layout, to which this calibration adds nothing".into(),
        };
        group.rows.push(fact("uncertainty in the answer (1 sd)", used));
        group.rows.push(fact("checksum", checksum.unwrap_or_else(|| "none".into())));
    }
    Ok(group)
}

/// How the calibration of a result was made, and when; empty where that is not known.
///
/// # Errors
/// When that of the archive is not one.
pub(in super::super) fn method_and_day(source: &ResultFile) -> Result<String> {
    let Some(archive) = source.archive() else { return Ok(String::new()) };
    Ok(archive.calibration().map_or_else(String::new, |record| {
        let method = spelled(record.method);
        match record.date.as_str() {
            "" => method.to_owned(),
            date => format!("{method}, {date}"),
        }
    }))
}

fn rows(record: &CalibrationRecord, measured: Option<&str>) -> Vec<Fact> {
    let mut rows = vec![fact("method", spelled(record.method))];
    // A data sheet has no day.
    if record.method != CalibrationMethod::DataSheet || !record.date.is_empty() {
        rows.push(fact("calibrated", dated(&record.date, measured)));
    }
    if !record.hammer.is_empty() {
        rows.push(fact("hammer", record.hammer.as_str()));
    }
    let names = record.sensors.iter().map(|name| name.as_str());
    let named: Vec<&str> = names.filter(|name| !name.is_empty()).collect();
    if !named.is_empty() {
        rows.push(fact("sensors", named.join(", ")));
    }
    if let Some(temperature) = record.temperature {
        rows.push(fact("temperature then", format!("{temperature:.0} °C")));
    }
    rows.push(fact("its uncertainty (1 sd)", sigma(&record.sigma)));
    rows
}

fn sigma(sigma: &CalibrationSigma) -> String {
    let [gain, cross_axis, hammer_gain] =
        [sigma.gain, sigma.cross_axis, sigma.hammer_gain].map(percent);
    format!("gains {gain}, cross-axis {cross_axis}, hammer {hammer_gain}")
}

/// Zero, sensitivity and low-pass of every channel.
fn channels(record: &CalibrationRecord) -> CollapsibleTable {
    let row = |name: String, channel: &ChannelCalibration, unit: &str| {
        let cutoff = match channel.cutoff.0 {
            0.0 => "none".to_owned(),
            hertz => format!("{hertz:.1}"),
        };
        let zero = format!("{:.4}", channel.zero.0);
        let sensitivity = format!("{:.4} {unit}", 1e3 * channel.sensitivity);
        vec![name, with_minus_signs(&zero), with_minus_signs(&sensitivity), cutoff]
    };
    let [hammer, responses @ ..] = &record.calibration.channels;
    let mut rows = vec![row("hammer".into(), hammer, "mV/N")];
    for (k, channel) in responses.iter().enumerate().take(3 * RIG_SENSORS) {
        let name = format!("sensor {} {}", k / 3 + 1, AXIS_LETTERS[k % 3]);
        rows.push(row(name, channel, "mV/(m/s²)"));
    }
    CollapsibleTable {
        summary: "Channels: zeros, sensitivities and low-passes",
        header: vec!["channel", "zero, V", "sensitivity", "low-pass, Hz"],
        rows,
    }
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
            days if days > OLD => format!(
                "{date}, {days} days before the test: calibrate again; its uncertainty has grown with its age"
            ),
            days if days > 1 => format!("{date}, {days} days before the test"),
            _ => format!("{date}, after the test"),
        },
        _ => date.to_owned(),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_old_calibration_is_remarked_upon() {
        let measured = Some("2026-08-01T09:00:00Z");
        assert_eq!(dated("2026-07-30", measured), "2026-07-30, 2 days before the test");
        let old = dated("2024-08-01", measured);
        assert!(old.contains("730 days before the test: calibrate again"), "{old}");
        assert_eq!(dated("", measured), "without a date");
    }
}
