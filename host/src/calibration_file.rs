//! The calibration file in TOML: zeros and sensitivities of the hammer and the sensors, and their origin.
//!
//! ```toml
//! method = "tumble-and-block"    # data-sheet, tumble, block, tumble-and-block or other
//! date = "2026-03-14"
//! temperature_c = 21.5
//! sensor_range_m_per_s2 = 156.9
//!
//! [sigma]                        # what the calibration has achieved, relative, 1 σ
//! gain = 0.0005
//! cross_axis = 0.002
//! hammer_gain = 0.0015
//!
//! [hammer]
//! id = "H1"
//! zero_v = 0.1
//! sensitivity_v_per_n = 0.0225
//! rc_cutoff_hz = 497.4           # of the low-pass; 0 without one, nominal when left out
//!
//! [[sensor]]                     # in the order of the rig's inputs
//! id = "A17"                     # name or serial number; a layout may name it
//! zero_v = [1.5, 1.5, 1.5]
//! sensitivity_v_per_m_per_s2 = [0.00581, 0.00581, 0.00581]
//! rc_cutoff_hz = [497.4, 497.4, 497.4]
//! # What channel x reads of an acceleration along y, over its own sensitivity, and so on.
//! cross_axis = { xy = 0.01, xz = 0.0, yx = 0.0, yz = 0.0, zx = 0.0, zy = -0.005 }
//! ```
//! Everything but `[hammer]` may be omitted. Missing sensors have the nominal values of the data sheet;
//! sensors without `cross_axis` have no cross-axis sensitivity.

use std::path::Path;

use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};
use massline_shared::signal::{Calibration, ChannelCalibration, CrossAxis};
use massline_shared::units::{Hertz, Volts};
use serde::{Deserialize, Serialize};

use crate::calibration::day::Day;
use crate::layout_file::LayoutFile;
use crate::limited::at_most;
use crate::{Error, Result, toml_file};

/// Error code of this module.
const MALFORMED: &str = "calibration_malformed";
/// Largest number of sensors of a file.
const MOST_SENSORS: usize = 4096;
/// Number of sensors of a rig.
const SENSORS: usize = massline_shared::layout::RIG_SENSORS;

/// A calibration file.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFile {
    /// The calibration, the sensors in the order of the file.
    pub record: CalibrationRecord,
    /// All sensors of the file, including those beyond the inputs of a rig.
    sensors: Vec<SensorTable>,
}

/// The TOML representation of a calibration, also used in a tape's sidecar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [calibration]")]
pub(crate) struct CalibrationTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    method: Option<String>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    date: Option<Day>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    temperature_c: Option<f32>,
    sensor_range_m_per_s2: Option<f32>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    sigma: Option<CalibrationSigma>,
    hammer: HammerTable,
    #[serde(default, deserialize_with = "at_most::<MOST_SENSORS, _, _>")]
    sensor: Vec<SensorTable>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [hammer]")]
struct HammerTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    id: Option<String>,
    zero_v: f32,
    sensitivity_v_per_n: f32,
    #[serde(default = "nominal_cutoff")]
    rc_cutoff_hz: f32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[sensor]]")]
struct SensorTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    id: Option<String>,
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

impl CalibrationFile {
    /// Reads a calibration.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be read, is not a calibration, or a sensitivity is zero.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&toml_file::read(path, MALFORMED)?, &path.display().to_string())
    }

    /// Reads the text of a calibration; `file` is its name in errors.
    ///
    /// # Errors
    /// As [`CalibrationFile::read`].
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        let table: CalibrationTable = toml_file::parse(text, file, MALFORMED)?;
        let record = table.record().map_err(|e| e.within(file))?;
        Ok(Self { record, sensors: table.sensor })
    }

    /// The calibration for a layout. A sensor of the layout that names a calibration gets that one, any other
    /// the sensor at the same position of the file.
    ///
    /// # Errors
    /// Exit 2 when the layout names a calibration that the file does not have.
    pub fn for_layout(&self, layout: &LayoutFile) -> Result<CalibrationRecord> {
        let mut record = self.record.clone();
        for (k, sensor) in layout.sensors.iter().take(SENSORS).enumerate() {
            let Some(wanted) = &sensor.calibration else { continue };
            let found = self.sensors.iter().find(|s| s.id.as_ref() == Some(wanted));
            let found = found.ok_or_else(|| {
                let ids = self.sensors.iter().filter_map(|s| s.id.as_deref());
                Error::input(
                    "calibration_unknown",
                    format!(
                        "sensor {} of the layout names the calibration \"{wanted}\", which the \
                         calibration file does not have (it has: {}); add [[sensor]] with id = \
                         \"{wanted}\"",
                        k + 1,
                        ids.collect::<Vec<_>>().join(", ")
                    ),
                )
            })?;
            found.write(k, &mut record)?;
        }
        Ok(record)
    }
}

/// The TOML text of a calibration.
pub fn to_toml(record: &CalibrationRecord) -> String {
    // Texts, numbers and tables only, so this cannot fail.
    toml::to_string(&CalibrationTable::of_record(record)).unwrap_or_default()
}

impl CalibrationTable {
    /// The calibration with its origin.
    pub(crate) fn of_record(record: &CalibrationRecord) -> Self {
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
    pub(crate) fn of(calibration: &Calibration) -> Self {
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

    pub(crate) fn calibration(&self) -> Result<Calibration> {
        Ok(self.record()?.calibration)
    }

    /// The calibration with its origin, checked.
    pub(crate) fn record(&self) -> Result<CalibrationRecord> {
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
    fn write(&self, k: usize, record: &mut CalibrationRecord) -> Result<()> {
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

#[cfg(test)]
mod tests {
    use super::*;

    fn calibration() -> CalibrationRecord {
        let mut record = CalibrationRecord {
            method: CalibrationMethod::Tumble,
            date: "2026-02-28".try_into().unwrap(),
            hammer: "H1".try_into().unwrap(),
            temperature: Some(-3.5),
            ..CalibrationRecord::default()
        };
        record.sensors[1] = "A17".try_into().unwrap();
        record.sigma.gain = 0.0007;
        let calibration = &mut record.calibration;
        calibration.cross_axis[1].zx = -0.0123;
        for (k, channel) in calibration.channels.iter_mut().enumerate() {
            channel.zero.0 += 0.001 * k as f32;
            channel.sensitivity *= 1.0 + 0.01 * k as f32;
            channel.cutoff.0 += k as f32;
        }
        record
    }

    #[test]
    fn what_is_written_reads_back_exactly() {
        let text = to_toml(&calibration());
        assert_eq!(CalibrationFile::parse(&text, "c.toml").unwrap().record, calibration());
    }

    #[test]
    fn a_date_that_is_no_day_is_not_written() {
        let mut record = calibration();
        record.date = "2026-02-31".try_into().unwrap();
        let read = CalibrationFile::parse(&to_toml(&record), "c.toml").unwrap().record;
        record.date.clear();
        assert_eq!(read, record);
    }

    #[test]
    fn missing_sensors_are_nominal() {
        let text = "[hammer]\nzero_v = 0.2\nsensitivity_v_per_n = 0.02\n";
        let read = CalibrationFile::parse(text, "c.toml").unwrap().record.calibration;
        assert_eq!(read.channels[1..], Calibration::default().channels[1..]);
        assert_eq!(read.channels[0].zero, Volts(0.2));
    }

    #[test]
    fn a_layout_picks_sensors_by_name() {
        let mut text = String::from("[hammer]\nzero_v = 0.1\nsensitivity_v_per_n = 0.02\n");
        for (id, gain) in [("a", 1), ("b", 2), ("c", 3), ("d", 4)] {
            text += &format!(
                "[[sensor]]\nid = \"{id}\"\nzero_v = [1, 1, 1]\n\
                 sensitivity_v_per_m_per_s2 = [{gain}, {gain}, {gain}]\n"
            );
        }
        let file = CalibrationFile::parse(&text, "c.toml").unwrap();
        let layout = |sensors: &str| {
            let example = include_str!("../examples/three-bar-test-1.toml");
            LayoutFile::parse(&example.replacen("sensors = [1, 2, 3]", sensors, 1), "l").unwrap()
        };
        let chosen = layout("sensors = [{ node = 1, calibration = \"d\" }, 2, 3]");
        let gains = file.for_layout(&chosen).unwrap().calibration.channels.map(|c| c.sensitivity);
        assert_eq!(gains[1..], [4.0, 4.0, 4.0, 2.0, 2.0, 2.0, 3.0, 3.0, 3.0]);
        let unknown = layout("sensors = [{ node = 1, calibration = \"x\" }, 2, 3]");
        let error = file.for_layout(&unknown).unwrap_err();
        assert!(error.to_string().contains("\"x\"") && error.to_string().contains("a, b, c, d"));
    }

    #[test]
    fn what_cannot_be_is_named() {
        let hammer = |zero: &str, gain: &str| {
            let text = format!("[hammer]\nzero_v = {zero}\nsensitivity_v_per_n = {gain}\n");
            CalibrationFile::parse(&text, "c.toml").unwrap_err().to_string()
        };
        assert!(hammer("0.1", "0").contains("sensitivity = 0"));
        assert!(hammer("nan", "0.02").contains("zero_v"));
        let cutoff = hammer("0.1", "0.02\nrc_cutoff_hz = -3");
        assert!(cutoff.contains("hammer: rc_cutoff_hz = -3"), "{cutoff}");
        let range = "sensor_range_m_per_s2 = 19.6\n[hammer]\nzero_v = 0\nsensitivity_v_per_n = 1\n";
        let error = CalibrationFile::parse(range, "c.toml").unwrap_err().to_string();
        assert!(error.contains("sensor_range_m_per_s2 = 19.6"), "{error}");
        assert!(hammer("0.1", "x").starts_with("c.toml:3: "), "{}", hammer("0.1", "x"));
    }

    #[test]
    fn a_wrong_date_method_temperature_or_sigma_is_named() {
        let error = |line: &str| {
            let text = format!("{line}\n[hammer]\nzero_v = 0\nsensitivity_v_per_n = 1\n");
            CalibrationFile::parse(&text, "c.toml").unwrap_err().to_string()
        };
        for date in ["2026-02-31", "2026-1-1", "14.3.2026", "2026-03-32", "yesterday", "+026-01-01"]
        {
            let error = error(&format!("date = \"{date}\""));
            assert!(error.starts_with("c.toml:1: date: ") && error.contains(date), "{error}");
        }
        assert!(error("method = \"guess\"").contains("tumble-and-block"));
        assert!(error("temperature_c = nan").contains("temperature_c"));
        let sigma = "sigma = { gain = -1.0, cross_axis = 0.0, hammer_gain = 0.0 }";
        assert!(error(sigma).contains("sigma"));
        let sensor = "[[sensor]]\nid = \"a name that is long\"\nzero_v = [1, 1, 1]\n\
                      sensitivity_v_per_m_per_s2 = [1, 1, 1]";
        assert!(error(sensor).contains("at most 12"), "{}", error(sensor));
        let sensor = "[[sensor]]\nzero_v = [1, 1, 1]\nsensitivity_v_per_m_per_s2 = [1, 1, 1]\n\
                      cross_axis = { xy = 0.5, xz = 0, yx = 0, yz = 0, zx = 0, zy = 0 }";
        assert!(error(sensor).contains("cross_axis"), "{}", error(sensor));
    }
}
