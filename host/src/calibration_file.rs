//! The calibration file: zeros and sensitivities of the hammer and the sensors, in TOML.
//!
//! ```toml
//! sensor_range_m_per_s2 = 156.9
//!
//! [hammer]
//! zero_v = 0.1
//! sensitivity_v_per_n = 0.0225
//!
//! [[sensor]]                     # in the order of the rig's inputs
//! id = "A17"                     # a layout may name it
//! zero_v = [1.5, 1.5, 1.5]
//! sensitivity_v_per_m_per_s2 = [0.00581, 0.00581, 0.00581]
//! ```
//! Sensors that are not there have the nominal values of the data sheet.

use std::path::Path;

use massline_shared::signal::{Calibration, ChannelCalibration};
use massline_shared::units::Volts;
use serde::{Deserialize, Serialize};

use crate::layout_file::LayoutFile;
use crate::{Error, Result, toml_file};

/// Word of the errors of this module.
const MALFORMED: &str = "calibration_malformed";
/// Sensors of a rig.
const SENSORS: usize = massline_shared::layout::RIG_SENSORS;

/// A calibration with the names of its sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct CalibrationFile {
    /// Zeros and sensitivities, the sensors in the order of the file.
    pub calibration: Calibration,
    /// Names of the sensors in the order of the file.
    pub ids: Vec<Option<String>>,
    /// Sensors of the file beyond those that fit into `calibration`.
    sensors: Vec<SensorTable>,
}

/// The TOML of a calibration, also part of a tape's sidecar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct CalibrationTable {
    sensor_range_m_per_s2: Option<f32>,
    hammer: HammerTable,
    #[serde(default)]
    sensor: Vec<SensorTable>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct HammerTable {
    zero_v: f32,
    sensitivity_v_per_n: f32,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SensorTable {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    id: Option<String>,
    zero_v: [f32; 3],
    sensitivity_v_per_m_per_s2: [f32; 3],
}

impl CalibrationFile {
    /// Reads a calibration.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be read, is no calibration, or a sensitivity is zero.
    pub fn read(path: &Path) -> Result<Self> {
        Self::parse(&toml_file::read(path, MALFORMED)?, &path.display().to_string())
    }

    /// Reads the text of a calibration; `file` is its name in errors.
    ///
    /// # Errors
    /// As [`CalibrationFile::read`].
    pub fn parse(text: &str, file: &str) -> Result<Self> {
        let table: CalibrationTable = toml_file::parse(text, file, MALFORMED)?;
        let calibration = table.calibration().map_err(|e| e.within(file))?;
        let ids = table.sensor.iter().map(|s| s.id.clone()).collect();
        Ok(Self { calibration, ids, sensors: table.sensor })
    }

    /// The calibration for a layout: where a sensor of the layout names a calibration, that one,
    /// else the sensor of the same place in the file.
    ///
    /// # Errors
    /// Exit 2 when the layout names a calibration that the file does not have.
    pub fn for_layout(&self, layout: &LayoutFile) -> Result<Calibration> {
        let mut calibration = self.calibration;
        for (k, sensor) in layout.sensors.iter().take(SENSORS).enumerate() {
            let Some(wanted) = &sensor.calibration else { continue };
            let found = self.sensors.iter().find(|s| s.id.as_ref() == Some(wanted));
            let found = found.ok_or_else(|| {
                let known: Vec<_> = self.ids.iter().flatten().map(String::as_str).collect();
                Error::input(
                    "calibration_unknown",
                    format!(
                        "sensor {} of the layout names the calibration \"{wanted}\", which the \
                         calibration file does not have (it has: {}); add [[sensor]] with id = \
                         \"{wanted}\"",
                        k + 1,
                        known.join(", ")
                    ),
                )
            })?;
            found.write(k, &mut calibration);
        }
        Ok(calibration)
    }
}

/// The TOML text of a calibration.
pub fn to_toml(calibration: &Calibration) -> String {
    // Numbers and tables only: this cannot fail.
    toml::to_string(&CalibrationTable::of(calibration)).unwrap_or_default()
}

impl CalibrationTable {
    pub(crate) fn of(calibration: &Calibration) -> Self {
        let [hammer, sensors @ ..] = &calibration.channels;
        let sensor = sensors
            .chunks_exact(3)
            .map(|axes| SensorTable {
                id: None,
                zero_v: [0, 1, 2].map(|k| axes[k].zero.0),
                sensitivity_v_per_m_per_s2: [0, 1, 2].map(|k| axes[k].sensitivity),
            })
            .collect();
        Self {
            sensor_range_m_per_s2: Some(calibration.sensor_range),
            hammer: HammerTable { zero_v: hammer.zero.0, sensitivity_v_per_n: hammer.sensitivity },
            sensor,
        }
    }

    pub(crate) fn calibration(&self) -> Result<Calibration> {
        let mut calibration = Calibration::default();
        if let Some(range) = self.sensor_range_m_per_s2 {
            if !(range.is_finite() && range > Calibration::SMALLEST_RANGE) {
                return Err(bad("sensor_range_m_per_s2", range, "more than 2 g, that is 19.6133"));
            }
            calibration.sensor_range = range;
        }
        let hammer = &self.hammer;
        check("hammer", hammer.zero_v, "hammer", hammer.sensitivity_v_per_n)?;
        calibration.channels[0] = ChannelCalibration {
            zero: Volts(hammer.zero_v),
            sensitivity: hammer.sensitivity_v_per_n,
        };
        for (k, sensor) in self.sensor.iter().enumerate() {
            let name = format!("sensor {}", k + 1);
            for (zero, sensitivity) in
                sensor.zero_v.into_iter().zip(sensor.sensitivity_v_per_m_per_s2)
            {
                check(&name, zero, &name, sensitivity)?;
            }
            sensor.write(k, &mut calibration);
        }
        Ok(calibration)
    }
}

impl SensorTable {
    /// Becomes the sensor of place `k`; nothing when the rig has no such place.
    fn write(&self, k: usize, calibration: &mut Calibration) {
        let channels = calibration.channels.iter_mut().skip(1 + 3 * k);
        for (channel, (zero, sensitivity)) in
            channels.zip(self.zero_v.into_iter().zip(self.sensitivity_v_per_m_per_s2))
        {
            *channel = ChannelCalibration { zero: Volts(zero), sensitivity };
        }
    }
}

fn check(zero_of: &str, zero: f32, of: &str, sensitivity: f32) -> Result<()> {
    if !zero.is_finite() {
        return Err(bad(&format!("{zero_of}: zero_v"), zero, "the output at rest in volts"));
    }
    if !sensitivity.is_normal() {
        return Err(bad(&format!("{of}: sensitivity"), sensitivity, "a number that is not zero"));
    }
    Ok(())
}

fn bad(key: &str, value: f32, wanted: &str) -> Error {
    Error::input(MALFORMED, format!("{key} = {value} cannot be; give {wanted}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn calibration() -> Calibration {
        let mut calibration = Calibration::default();
        for (k, channel) in calibration.channels.iter_mut().enumerate() {
            channel.zero.0 += 0.001 * k as f32;
            channel.sensitivity *= 1.0 + 0.01 * k as f32;
        }
        calibration
    }

    #[test]
    fn what_is_written_reads_back_exactly() {
        let text = to_toml(&calibration());
        assert_eq!(CalibrationFile::parse(&text, "c.toml").unwrap().calibration, calibration());
    }

    #[test]
    fn missing_sensors_are_nominal() {
        let text = "[hammer]\nzero_v = 0.2\nsensitivity_v_per_n = 0.02\n";
        let read = CalibrationFile::parse(text, "c.toml").unwrap().calibration;
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
        let gains = file.for_layout(&chosen).unwrap().channels.map(|c| c.sensitivity);
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
        let range = "sensor_range_m_per_s2 = 19.6\n[hammer]\nzero_v = 0\nsensitivity_v_per_n = 1\n";
        let error = CalibrationFile::parse(range, "c.toml").unwrap_err().to_string();
        assert!(error.contains("sensor_range_m_per_s2 = 19.6"), "{error}");
        assert!(hammer("0.1", "x").starts_with("c.toml:3: "), "{}", hammer("0.1", "x"));
    }
}
