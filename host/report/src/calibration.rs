//! Calibrations and what calibration tests find, as text and JSON.

pub mod capacitor;
pub mod electronics;
pub mod plausible;

use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::block::SensorRatio;
use massline_shared::calibration::tumble::Tumble;
use massline_shared::layout::AXIS_LETTERS;
use massline_shared::signal::HAMMER;
use massline_shared::units::Hertz;
use nalgebra::Matrix3;

use massline_analysis::calibration::block::Block;
use massline_analysis::calibration::cutoffs::{CutoffError, FoundCutoff, RcCutoff};
use massline_analysis::calibration::electronics::Memory;
use massline_analysis::calibration::verify::{Drift, DriftVerdict, by_sensor};
use massline_result::{Error, Finding, Verdict};
use massline_shared::calibration::tumble::Position;

use crate::document::{
    self, AxisDrift, Calibration, CalibrationCheck, HammerCalibration, HammerRatio,
    SensorCalibration, SensorCheck, TumbledSensor,
};
use crate::table;
use crate::tone::Tone;
use crate::words::{findings, message, with_sigma};

/// A calibration as JSON.
pub fn record_json(record: &CalibrationRecord) -> Calibration {
    let calibration = &record.calibration;
    let hammer = &calibration.channels[HAMMER];
    let sensor = |k: usize, id: &str| {
        let axes = [0, 1, 2].map(|axis| calibration.channels[1 + 3 * k + axis]);
        SensorCalibration {
            id: id.to_owned(),
            zero_v: axes.map(|axis| axis.zero.0.into()),
            sensitivity_v_per_m_per_s2: rows(&calibration.sensor_sensitivity(k)),
            rc_cutoff_hz: axes.map(|axis| axis.cutoff.0.into()),
        }
    };
    Calibration {
        method: record.method.name().into(),
        date: record.date.as_str().to_owned(),
        temperature_c: record.temperature.map(f64::from),
        sigma: record.sigma.into(),
        hammer: HammerCalibration {
            id: record.hammer.as_str().to_owned(),
            zero_v: hammer.zero.0.into(),
            sensitivity_v_per_n: hammer.sensitivity.into(),
            rc_cutoff_hz: hammer.cutoff.0.into(),
        },
        sensors: record.sensors.iter().enumerate().map(|(k, id)| sensor(k, id)).collect(),
    }
}

/// A calibration as a table.
pub fn record_text(record: &CalibrationRecord) -> String {
    let calibration = &record.calibration;
    let mut table = table::table();
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

/// The result of a tumble test, with the hum in its readings and what they show of the multiplexer.
pub fn tumble_json(
    tumble: &Tumble<f64>,
    hum: Vec<document::Hum>,
    memory: Option<Memory>,
) -> document::Tumble {
    let sensors = tumble.sensors.iter().map(|sensor| TumbledSensor {
        zero_v: sensor.zero.into(),
        zero_sigma_v: sensor.zero_sigma.into(),
        sensitivity_v_per_m_per_s2: rows(&sensor.sensitivity),
        sensitivity_sigma_v_per_m_per_s2: rows(&sensor.sensitivity_sigma),
        tilt_rad: sensor.tilt,
    });
    document::Tumble {
        sensors: sensors.collect(),
        hum,
        memory: memory.as_ref().map(electronics::memory_json),
    }
}

/// The same for people; `memory` is what the readings show of the multiplexer.
pub fn tumble_text(tumble: &Tumble<f64>, record: &CalibrationRecord, memory: &str) -> String {
    let tilts = tumble.sensors.iter().map(|s| format!("{:.1}", 1e3 * s.tilt)).collect::<Vec<_>>();
    format!(
        "{}\npositions tilted by {} mrad rms\n{memory}\nnext, calibrate the hammer: massline calibrate block",
        record_text(record),
        tilts.join(", "),
    )
}

/// The result of a block test, relative to the calibration before it.
pub fn block_json(block: &Block) -> document::Block {
    let sensor = |SensorRatio { ratio, sigma }: &SensorRatio<f64>| document::SensorRatio {
        ratio: rows(ratio),
        sigma: rows(sigma),
    };
    document::Block {
        sensors: block.sensors.iter().map(sensor).collect(),
        hammer: block.hammer.map(|hammer| HammerRatio {
            ratio: hammer.ratio,
            sigma: hammer.sigma,
            largest_departure: hammer.departure.0,
            consistent: hammer.is_consistent(),
        }),
        rc_cutoffs: block.cutoffs.iter().map(cutoff_json).collect(),
        electronics: electronics::json(&block.electronics),
        diagnostics: warnings_json(block),
    }
}

/// The rig's warnings about the hits.
fn warnings_json(block: &Block) -> Vec<Finding> {
    findings(&block.warnings, message)
}

fn cutoff_json(cutoff: &RcCutoff) -> document::RcCutoff {
    let measured = cutoff.found.as_ref().ok();
    document::RcCutoff {
        sensor: cutoff.sensor + 1,
        axis: AXIS_LETTERS[cutoff.axis],
        cutoff_hz: measured.map(|measured| measured.cutoff_hz),
        sigma_hz: measured.map(|measured| measured.sigma_hz),
        before_hz: cutoff.before_hz,
        verdict: cutoff.verdict().into(),
        reason: cutoff.found.err().map(|error| error.name().into()),
    }
}

/// The cutoffs as a table, with the reasons why some are not known.
pub fn cutoffs_text(cutoffs: &[RcCutoff], hammer: Hertz<f32>) -> String {
    let mut table = table::table();
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
        let number = |quantity: fn(&FoundCutoff) -> f64| {
            cutoff
                .found
                .as_ref()
                .map_or("-".into(), |measured| format!("{:.1}", quantity(measured)))
        };
        table.add_row([
            (cutoff.sensor + 1).to_string(),
            axis.into(),
            rc(Hertz(cutoff.before_hz as f32)),
            number(|measured| measured.cutoff_hz),
            number(|measured| measured.sigma_hz),
            cutoff.verdict().into(),
        ]);
    }
    let reasons: String = reasons
        .iter()
        .map(|(reason, names)| format!("\n{names}:\n  {}", cutoff_reason(*reason)))
        .collect();
    let against = match hammer.0 > 0.0 {
        true => format!("against the hammer's, taken as {} Hz", rc(hammer)),
        false => "the hammer's is not known".into(),
    };
    format!("RC cutoffs {against}; kept means within 3 sd of the stored value\n{table}{reasons}")
}

/// The same for people.
pub fn block_text(block: &Block, record: &CalibrationRecord) -> String {
    let sentence = match &block.hammer {
        Some(hammer) => {
            format!("true force over the force before: {}", with_sigma(hammer.ratio, hammer.sigma))
        }
        None => "sensors against the hammer; a tumble test before it would tell both apart\n\
                 and know the cross-axis sensitivities better"
            .into(),
    };
    let cutoffs = cutoffs_text(&block.cutoffs, record.calibration.channels[HAMMER].cutoff);
    format!(
        "{}\n{sentence}\n\n{cutoffs}\n\n{}",
        record_text(record),
        electronics::text(&block.electronics)
    )
}

/// The verdict on every channel, and what else the hits show.
pub fn drifts_json(
    drifts: &[Drift],
    tolerance: f64,
    verdict: Verdict,
    record: &CalibrationRecord,
    block: &Block,
) -> CalibrationCheck {
    let channels = drifts.iter().map(|d| AxisDrift {
        sensor: d.sensor + 1,
        axis: AXIS_LETTERS[d.axis],
        drift: d.drift,
        sigma: d.sigma,
        verdict: d.verdict.name().into(),
    });
    let sensors = by_sensor(drifts).into_iter().map(|sensor_drift| SensorCheck {
        sensor: sensor_drift.sensor + 1,
        outcome: sensor_drift.verdict.outcome().into(),
        largest_drift: sensor_drift.largest,
        limit: tolerance,
    });
    CalibrationCheck {
        verdict,
        sensors: sensors.collect(),
        channels: channels.collect(),
        calibrated: record.date.as_str().to_owned(),
        electronics: electronics::json(&block.electronics),
        diagnostics: warnings_json(block),
    }
}

fn tone_of(verdict: DriftVerdict) -> Tone {
    match verdict {
        DriftVerdict::Good => Tone::Good,
        DriftVerdict::Unclear => Tone::Warning,
        DriftVerdict::Drifted => Tone::Bad,
    }
}

/// What a check of the calibration says, after its verdict; `from_data_sheets` where no calibration is stored.
pub fn check_line(worst: DriftVerdict, from_data_sheets: bool) -> &'static str {
    match (worst, from_data_sheets) {
        (DriftVerdict::Good, false) => "Good: the calibration holds",
        (DriftVerdict::Good, true) => {
            "Good: the channels are what their data sheets say; no calibration is stored"
        }
        (DriftVerdict::Unclear, false) => {
            "Use with care: these hits do not show whether the calibration holds"
        }
        (DriftVerdict::Unclear, true) => {
            "Use with care: these hits do not show whether the channels are what their data sheets say"
        }
        (DriftVerdict::Drifted, false) => "Do not use this calibration: it no longer holds",
        (DriftVerdict::Drifted, true) => {
            "Do not use this rig without a calibration: its channels are not what their data sheets say"
        }
    }
}

/// The drift of every channel as a table, and the outcome for each sensor.
pub fn drifts_text(drifts: &[Drift], tolerance: f64) -> String {
    let mut table = table::table();
    table.set_header(["sensor", "axis", "drift, %", "± sd", "verdict"]);
    for d in drifts {
        table.add_row([
            (d.sensor + 1).to_string(),
            AXIS_LETTERS[d.axis].to_string(),
            format!("{:+.2}", 100.0 * d.drift),
            format!("{:.2}", 100.0 * d.sigma),
            tone_of(d.verdict).mark(d.verdict.name()),
        ]);
    }
    let mut text = table.to_string();
    for sensor_drift in by_sensor(drifts) {
        text += &format!(
            "\nsensor {}: {} (largest drift {:+.2} %, limit {:.2} %)",
            sensor_drift.sensor + 1,
            sensor_drift.verdict.outcome(),
            100.0 * sensor_drift.largest,
            100.0 * tolerance,
        );
    }
    text
}

fn rows(matrix: &Matrix3<f64>) -> [[f64; 3]; 3] {
    [0, 1, 2].map(|row| [0, 1, 2].map(|column| matrix[(row, column)]))
}

/// Why a block test does not determine a cutoff.
fn cutoff_reason(error: CutoffError) -> &'static str {
    match error {
        CutoffError::HammerUnknown => {
            "the calibration has no RC cutoff for the hammer, relative to which this one would be determined"
        }
        CutoffError::NotPushed => "no hit of the layout pushes along it",
        CutoffError::SpectraGone => {
            "hit before this command started, so the rig no longer has its spectra; use --restart to hit it again"
        }
        CutoffError::Undetermined => "the spectra show no steady response along it",
        CutoffError::NoLowPass => {
            "no low-pass makes this difference; is the sensor glued on firmly, and is the breakout's own capacitor off?"
        }
    }
}

/// What the hammer's channel keeps of the one before it, or why the readings of a tumble test do not show it.
pub fn tumble_memory_text(memory: Option<&Memory>) -> String {
    memory.map_or_else(
        || {
            "memory of the multiplexer: not seen here, because no sensor axis is converted before the hammer; see \
             `massline calibrate block`"
                .into()
        },
        electronics::memory_text,
    )
}

/// The error for a sensor, counted from 1, that lies in another position.
pub fn misplaced_error(position: Position, (sensor, lies): (usize, Position)) -> Error {
    Error::undetermined(
        "tumble_position",
        format!(
            "position {position} is not stored: by the calibration on the rig, sensor {sensor} lies as {lies}; turn \
             it. If that calibration is of other sensors, replace it first: massline calibrate push"
        ),
    )
}
