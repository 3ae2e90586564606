//! Calibrations as text and JSON.

use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::block::SensorRatio;
use massline_shared::calibration::tumble::Tumble;
use massline_shared::layout::AXIS_LETTERS;
use massline_shared::signal::HAMMER;
use massline_shared::units::Hertz;
use nalgebra::Matrix3;
use serde_json::{Value, json};

use crate::calibration::block::Block;
use crate::calibration::cutoffs::{CutoffError, FoundCutoff, RcCutoff};
use crate::calibration::verify::{Drift, Verdict, by_sensor};
use crate::output::{self, Tone};
use crate::report::{diagnostics_json, message, with_sigma};

/// A calibration as JSON.
pub(super) fn record_json(record: &CalibrationRecord) -> Value {
    let calibration = &record.calibration;
    let [hammer, axes @ ..] = &calibration.channels;
    let sensors: Vec<_> = axes
        .chunks_exact(3)
        .enumerate()
        .map(|(k, axes)| {
            json!({
                "id": record.sensors.get(k).map(|id| id.as_str()),
                "zero_v": axes.iter().map(|axis| axis.zero.0).collect::<Vec<_>>(),
                "sensitivity_v_per_m_per_s2": rows(&calibration.sensor_sensitivity(k)),
                "rc_cutoff_hz": axes.iter().map(|axis| axis.cutoff.0).collect::<Vec<_>>(),
            })
        })
        .collect();
    json!({
        "method": record.method.name(),
        "date": record.date.as_str(),
        "temperature_c": record.temperature,
        "sigma": {
            "gain": record.sigma.gain,
            "cross_axis": record.sigma.cross_axis,
            "hammer_gain": record.sigma.hammer_gain,
        },
        "hammer": {
            "id": record.hammer.as_str(),
            "zero_v": hammer.zero.0,
            "sensitivity_v_per_n": hammer.sensitivity,
            "rc_cutoff_hz": hammer.cutoff.0,
        },
        "sensors": sensors,
    })
}

/// A calibration as a table.
pub(super) fn record_text(record: &CalibrationRecord) -> String {
    let calibration = &record.calibration;
    let mut table = output::table();
    table.set_header(["", "", "zero, V", "sensitivity", "cross-axis, %", "RC, Hz"]);
    let hammer = calibration.channels[0];
    table.add_row([
        format!("hammer {}", record.hammer),
        String::new(),
        format!("{:.4}", hammer.zero.0),
        format!("{:.4} mV/N", 1e3 * hammer.sensitivity),
        String::new(),
        rc(hammer.cutoff),
    ]);
    for (k, id) in record.sensors.iter().enumerate() {
        let matrix = calibration.cross_axis[k].matrix::<f64>();
        for (a, axis) in AXIS_LETTERS.iter().enumerate() {
            let channel = calibration.channels[1 + 3 * k + a];
            let [first, second] = [(a + 1) % 3, (a + 2) % 3];
            let cross = |b: usize| format!("{} {:+.2}", AXIS_LETTERS[b], 100.0 * matrix[(a, b)]);
            table.add_row([
                if a == 0 { format!("sensor {} {id}", k + 1) } else { String::new() },
                axis.to_string(),
                format!("{:.4}", channel.zero.0),
                format!("{:.4} mV/(m/s²)", 1e3 * channel.sensitivity),
                format!("{}  {}", cross(first), cross(second)),
                rc(channel.cutoff),
            ]);
        }
    }
    let sigma = record.sigma;
    let date = if record.date.is_empty() { "day not known" } else { record.date.as_str() };
    let temperature = record.temperature.map_or(String::new(), |t| format!(", {t:.1} °C"));
    format!(
        "{table}\n{} ({date}{temperature}); 1 σ: gain {:.2} %, cross-axis {:.2} %, hammer {:.2} %",
        record.method.name(),
        100.0 * sigma.gain,
        100.0 * sigma.cross_axis,
        100.0 * sigma.hammer_gain,
    )
}

/// The text of a cutoff frequency; a placeholder when it is not known.
fn rc(cutoff: Hertz<f32>) -> String {
    if cutoff.0 > 0.0 { format!("{:.1}", cutoff.0) } else { "-".into() }
}

/// The result of a tumble test.
pub(super) fn tumble_json(found: &Tumble<f64>) -> Value {
    let sensors: Vec<_> = found
        .sensors
        .iter()
        .map(|sensor| {
            json!({
                "zero_v": sensor.zero.as_slice(),
                "zero_sigma_v": sensor.zero_sigma.as_slice(),
                "sensitivity_v_per_m_per_s2": rows(&sensor.sensitivity),
                "sensitivity_sigma_v_per_m_per_s2": rows(&sensor.sensitivity_sigma),
                "tilt_rad": sensor.tilt,
            })
        })
        .collect();
    json!({ "sensors": sensors })
}

pub(super) fn tumble_text(found: &Tumble<f64>, record: &CalibrationRecord, memory: &str) -> String {
    let tilts = found.sensors.iter().map(|s| format!("{:.1}", 1e3 * s.tilt)).collect::<Vec<_>>();
    format!(
        "{}\npositions tilted by {} mrad rms\n{memory}\nnext, calibrate the hammer: massline calibrate block",
        record_text(record),
        tilts.join(", "),
    )
}

/// The result of a block test, relative to the calibration before it.
pub(super) fn block_json(found: &Block) -> Value {
    let sensors: Vec<_> = found
        .sensors
        .iter()
        .map(|SensorRatio { ratio, sigma }| json!({ "ratio": rows(ratio), "sigma": rows(sigma) }))
        .collect();
    let hammer = found.hammer.map(|hammer| {
        json!({
            "ratio": hammer.ratio,
            "sigma": hammer.sigma,
            "largest_departure": hammer.departure.0,
            "consistent": hammer.is_consistent(),
        })
    });
    json!({
        "sensors": sensors,
        "hammer": hammer,
        "rc_cutoffs": found.cutoffs.iter().map(cutoff_json).collect::<Vec<_>>(),
        "electronics": found.electronics.to_json(),
        "diagnostics": warnings_json(found),
    })
}

/// The rig's warnings about the hits.
pub(super) fn warnings_json(found: &Block) -> Value {
    json!(diagnostics_json(&found.warnings, message))
}

fn cutoff_json(cutoff: &RcCutoff) -> Value {
    let found = cutoff.found.as_ref().ok();
    json!({
        "sensor": cutoff.sensor + 1,
        "axis": AXIS_LETTERS[cutoff.axis],
        "cutoff_hz": found.map(|found| found.cutoff_hz),
        "sigma_hz": found.map(|found| found.sigma_hz),
        "before_hz": cutoff.before_hz,
        "verdict": cutoff.verdict(),
        "reason": cutoff.found.err().map(CutoffError::name),
    })
}

/// The cutoffs as a table, with the reasons why some are not known.
pub(super) fn cutoffs_text(cutoffs: &[RcCutoff], hammer: Hertz<f32>) -> String {
    let mut table = output::table();
    table.set_header(["sensor", "axis", "RC before, Hz", "measured, Hz", "± sd", "verdict"]);
    let mut reasons: Vec<(CutoffError, String)> = Vec::new();
    for cutoff in cutoffs {
        let axis = AXIS_LETTERS[cutoff.axis];
        if let Err(reason) = cutoff.found {
            let name = format!("{} {axis}", cutoff.sensor + 1);
            match reasons.iter_mut().find(|(known, _)| *known == reason) {
                Some((_, names)) => *names = format!("{names}, {name}"),
                None => reasons.push((reason, name)),
            }
        }
        let number = |of: fn(&FoundCutoff) -> f64| {
            cutoff.found.as_ref().map_or("-".into(), |found| format!("{:.1}", of(found)))
        };
        table.add_row([
            (cutoff.sensor + 1).to_string(),
            axis.into(),
            rc(Hertz(cutoff.before_hz as f32)),
            number(|found| found.cutoff_hz),
            number(|found| found.sigma_hz),
            cutoff.verdict().into(),
        ]);
    }
    let reasons: String =
        reasons.iter().map(|(reason, names)| format!("\n{names}:\n  {reason}")).collect();
    let against = match hammer.0 > 0.0 {
        true => format!("against the hammer's, taken as {} Hz", rc(hammer)),
        false => "the hammer's is not known".into(),
    };
    format!("RC cutoffs {against}; kept means within 3 sd of the stored value\n{table}{reasons}")
}

pub(super) fn block_text(found: &Block, record: &CalibrationRecord) -> String {
    let said = match &found.hammer {
        Some(hammer) => {
            format!("true force over the force before: {}", with_sigma(hammer.ratio, hammer.sigma))
        }
        None => "sensors against the hammer; a tumble test before it would tell both apart\n\
                 and know the cross-axis sensitivities better"
            .into(),
    };
    let cutoffs = cutoffs_text(&found.cutoffs, record.calibration.channels[HAMMER].cutoff);
    format!("{}\n{said}\n\n{cutoffs}\n\n{}", record_text(record), found.electronics.text())
}

/// The verdict on every channel.
pub(super) fn drifts_json(all: &[Drift], tolerance: f64, record: &CalibrationRecord) -> Value {
    let channels: Vec<_> = all
        .iter()
        .map(|d| {
            json!({
                "sensor": d.sensor + 1,
                "axis": AXIS_LETTERS[d.axis],
                "drift": d.drift,
                "sigma": d.sigma,
                "verdict": d.verdict.name(),
            })
        })
        .collect();
    let sensors: Vec<_> = by_sensor(all)
        .iter()
        .map(|of| {
            json!({
                "sensor": of.sensor + 1,
                "outcome": of.verdict.outcome(),
                "largest_drift": of.largest,
                "limit": tolerance,
            })
        })
        .collect();
    json!({ "sensors": sensors, "channels": channels, "calibrated": record.date.as_str() })
}

fn tone_of(verdict: Verdict) -> Tone {
    match verdict {
        Verdict::Good => Tone::Good,
        Verdict::Unclear => Tone::Warning,
        Verdict::Drifted => Tone::Bad,
    }
}

pub(super) fn drifts_text(all: &[Drift], tolerance: f64) -> String {
    let mut table = output::table();
    table.set_header(["sensor", "axis", "drift, %", "± sd", "verdict"]);
    for d in all {
        table.add_row([
            (d.sensor + 1).to_string(),
            AXIS_LETTERS[d.axis].to_string(),
            format!("{:+.2}", 100.0 * d.drift),
            format!("{:.2}", 100.0 * d.sigma),
            tone_of(d.verdict).mark(d.verdict.name()),
        ]);
    }
    let mut text = table.to_string();
    for of in by_sensor(all) {
        text += &format!(
            "\nsensor {}: {} (largest drift {:+.2} %, limit {:.2} %)",
            of.sensor + 1,
            of.verdict.outcome(),
            100.0 * of.largest,
            100.0 * tolerance,
        );
    }
    text
}

fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)]))
}
