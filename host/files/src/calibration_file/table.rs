//! The tables of a calibration file, and what is checked in them.

use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};
use massline_shared::signal::{Calibration, ChannelCalibration, CrossAxis};
use massline_shared::units::{Hertz, Volts};
use serde::{Deserialize, Serialize};

use super::MALFORMED;
use crate::day::Day;
use crate::limited::at_most;
use massline_result::{Error, Result};

/// Largest number of sensors of a file.
const MOST_SENSORS: usize = 4096;

/// The TOML representation of a calibration, also used in a tape's sidecar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [calibration]")]
pub struct CalibrationTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) method: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) date: Option<Day>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) temperature_c: Option<f32>,
    sensor_range_m_per_s2: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) sigma: Option<CalibrationSigma>,
    pub(super) hammer: HammerTable,
    #[serde(default, deserialize_with = "at_most::<MOST_SENSORS, _, _>")]
    pub(super) sensor: Vec<SensorTable>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [hammer]")]
pub(super) struct HammerTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) id: Option<String>,
    zero_v: f32,
    sensitivity_v_per_n: f32,
    #[serde(default = "nominal_cutoff")]
    rc_cutoff_hz: f32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[sensor]]")]
pub(super) struct SensorTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) id: Option<String>,
    zero_v: [f32; 3],
    sensitivity_v_per_m_per_s2: [f32; 3],
    #[serde(default = "nominal_cutoffs")]
    rc_cutoff_hz: [f32; 3],
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cross_axis: Option<CrossAxis>,
}

fn nominal_cutoff() -> f32 {
    Calibration::RC_CUTOFF.0 as f32
}

fn nominal_cutoffs() -> [f32; 3] {
    [nominal_cutoff(); 3]
}

impl CalibrationTable {
    /// The calibration with its origin.
    pub fn of_record(record: &CalibrationRecord) -> Self {
        let mut table = Self::of(&record.calibration);
        let text = |text: &str| (!text.is_empty()).then(|| text.to_owned());
        table.method = Some(record.method.name().into());
        // A rig may hold a text that is not a date; a file with it could not be read back.
        table.date = record.date.parse().ok();
        table.temperature_c = record.temperature;
        table.sigma = Some(record.sigma);
        table.hammer.id = text(&record.hammer);
        for (sensor, id) in table.sensor.iter_mut().zip(&record.sensors) {
            sensor.id = text(id);
        }
        table
    }

    /// The calibration without its origin.
    pub fn of(calibration: &Calibration) -> Self {
        let [hammer, sensors @ ..] = &calibration.channels;
        let sensor = sensors
            .chunks_exact(3)
            .zip(&calibration.cross_axis)
            .map(|(axes, cross_axis)| SensorTable {
                id: None,
                zero_v: [0, 1, 2].map(|k| axes[k].zero.0),
                sensitivity_v_per_m_per_s2: [0, 1, 2].map(|k| axes[k].sensitivity),
                rc_cutoff_hz: [0, 1, 2].map(|k| axes[k].cutoff.0),
                cross_axis: (*cross_axis != CrossAxis::default()).then_some(*cross_axis),
            })
            .collect();
        Self {
            method: None,
            date: None,
            temperature_c: None,
            sensor_range_m_per_s2: Some(calibration.sensor_range),
            sigma: None,
            hammer: HammerTable {
                id: None,
                zero_v: hammer.zero.0,
                sensitivity_v_per_n: hammer.sensitivity,
                rc_cutoff_hz: hammer.cutoff.0,
            },
            sensor,
        }
    }

    /// The calibration without its origin, checked.
    ///
    /// # Errors
    /// Exit 2 with the key of what is wrong.
    pub fn calibration(&self) -> Result<Calibration> {
        Ok(self.record()?.calibration)
    }

    /// The calibration with its origin, checked.
    pub fn record(&self) -> Result<CalibrationRecord> {
        let mut record = CalibrationRecord::from(Calibration::default());
        if let Some(range) = self.sensor_range_m_per_s2 {
            if !(range.is_finite() && range > Calibration::SMALLEST_RANGE) {
                return Err(bad("sensor_range_m_per_s2", range, "more than 2 g, that is 19.6133"));
            }
            record.calibration.sensor_range = range;
        }
        self.read_origin(&mut record)?;
        let hammer = &self.hammer;
        check("hammer", hammer.zero_v, hammer.sensitivity_v_per_n, hammer.rc_cutoff_hz)?;
        record.hammer = short("hammer: id", hammer.id.as_deref())?;
        record.calibration.channels[0] = ChannelCalibration {
            zero: Volts(hammer.zero_v),
            sensitivity: hammer.sensitivity_v_per_n,
            cutoff: Hertz(hammer.rc_cutoff_hz),
        };
        for (k, sensor) in self.sensor.iter().enumerate() {
            sensor.check(k)?;
            sensor.write(k, &mut record)?;
        }
        Ok(record)
    }

    fn read_origin(&self, record: &mut CalibrationRecord) -> Result<()> {
        if let Some(name) = &self.method {
            let named = CalibrationMethod::ALL.into_iter().find(|m| m.name() == name);
            let known = CalibrationMethod::ALL.map(CalibrationMethod::name).join(", ");
            let method = named
                .ok_or_else(|| bad("method", format!("\"{name}\""), &format!("one of {known}")))?;
            record.method = method;
        }
        if let Some(sigma) = self.sigma {
            if !sigma.is_usable() {
                return Err(bad(
                    "sigma",
                    serde_json::json!(sigma),
                    "numbers that are not negative",
                ));
            }
            record.sigma = sigma;
        }
        if let Some(date) = self.date {
            record.date = date.text();
        }
        if let Some(temperature) = self.temperature_c {
            if !temperature.is_finite() {
                return Err(bad("temperature_c", temperature, "degrees Celsius, or leave it out"));
            }
            record.temperature = Some(temperature);
        }
        Ok(())
    }
}

/// A name or serial number as the calibration stores it; `key` is its key in the file.
///
/// # Errors
/// Exit 2 when it is too long.
pub fn short(key: &str, text: Option<&str>) -> Result<heapless::String<12>> {
    let text = text.unwrap_or_default();
    text.try_into().map_err(|_| bad(key, format!("\"{text}\""), "at most 12 letters"))
}

impl SensorTable {
    fn check(&self, k: usize) -> Result<()> {
        let name = format!("sensor {}", k + 1);
        for (zero, sensitivity, cutoff) in self.axes() {
            check(&name, zero, sensitivity, cutoff)?;
        }
        if let Some(cross_axis) = &self.cross_axis
            && !cross_axis.is_usable()
        {
            let wanted = format!("numbers between -{0} and {0}", CrossAxis::LARGEST);
            return Err(bad(
                &format!("{name}: cross_axis"),
                serde_json::json!(cross_axis),
                &wanted,
            ));
        }
        Ok(())
    }

    /// Writes this sensor to position `k`; does nothing when the rig has no such position.
    pub(super) fn write(&self, k: usize, record: &mut CalibrationRecord) -> Result<()> {
        let (Some(cross_axis), Some(id)) =
            (record.calibration.cross_axis.get_mut(k), record.sensors.get_mut(k))
        else {
            return Ok(());
        };
        *cross_axis = self.cross_axis.unwrap_or_default();
        *id = short(&format!("sensor {}: id", k + 1), self.id.as_deref())?;
        let channels = record.calibration.channels.iter_mut().skip(1 + 3 * k);
        for (channel, (zero, sensitivity, cutoff)) in channels.zip(self.axes()) {
            *channel = ChannelCalibration { zero: Volts(zero), sensitivity, cutoff: Hertz(cutoff) };
        }
        Ok(())
    }

    /// Zero, sensitivity and cutoff of each axis.
    fn axes(&self) -> [(f32, f32, f32); 3] {
        [0, 1, 2]
            .map(|k| (self.zero_v[k], self.sensitivity_v_per_m_per_s2[k], self.rc_cutoff_hz[k]))
    }
}

fn check(of: &str, zero: f32, sensitivity: f32, cutoff: f32) -> Result<()> {
    if !zero.is_finite() {
        return Err(bad(&format!("{of}: zero_v"), zero, "the output at rest in volts"));
    }
    if !sensitivity.is_normal() {
        return Err(bad(&format!("{of}: sensitivity"), sensitivity, "a number that is not zero"));
    }
    if !(cutoff == 0.0 || cutoff.is_normal() && cutoff > 0.0) {
        let wanted = "the cutoff of the low-pass in Hz, or 0 without one";
        return Err(bad(&format!("{of}: rc_cutoff_hz"), cutoff, wanted));
    }
    Ok(())
}

fn bad(key: &str, value: impl std::fmt::Display, wanted: &str) -> Error {
    Error::input(MALFORMED, format!("{key} = {value} is not valid; use {wanted}"))
}
