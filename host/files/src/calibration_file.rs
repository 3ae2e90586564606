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

mod table;

use std::path::Path;

use massline_shared::calibration::CalibrationRecord;

use crate::layout_file::LayoutFile;
use crate::toml_file;
use massline_result::{Error, Result};
pub use table::CalibrationTable;
use table::SensorTable;
pub use table::short;

/// Error code of this module.
const MALFORMED: &str = "calibration_malformed";
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
        Ok(Self { record: table.record(), sensors: table.sensor })
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
            let table = self.sensors.iter().find(|s| s.id() == Some(wanted.as_str()));
            let table = table.ok_or_else(|| {
                let ids = self.sensors.iter().filter_map(SensorTable::id);
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
            table.write(k, &mut record);
        }
        Ok(record)
    }
}

/// The TOML text of a calibration.
pub fn to_toml(record: &CalibrationRecord) -> String {
    // Texts, numbers and tables only, so this cannot fail.
    toml::to_string(&CalibrationTable::of_record(record)).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use massline_shared::calibration::CalibrationMethod;
    use massline_shared::signal::Calibration;
    use massline_shared::units::Volts;

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
            let example = include_str!("../../examples/three-bar-test-1.toml");
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
        for gain in ["0", "0.0", "1e-50", "1e39"] {
            let error = hammer("0.1", gain);
            let beginning = "c.toml:3: hammer.sensitivity_v_per_n: ";
            assert!(
                error.starts_with(beginning) && error.contains("a number that is not zero"),
                "{error}"
            );
        }
        assert!(hammer("nan", "0.02").starts_with("c.toml:2: hammer.zero_v: NaN is not valid"));
        let cutoff = hammer("0.1", "0.02\nrc_cutoff_hz = -0.3");
        assert!(cutoff.starts_with("c.toml:4: hammer.rc_cutoff_hz: -0.3 is not valid"), "{cutoff}");
        let range = "sensor_range_m_per_s2 = 19.6\n[hammer]\nzero_v = 0\nsensitivity_v_per_n = 1\n";
        let error = CalibrationFile::parse(range, "c.toml").unwrap_err().to_string();
        assert!(error.starts_with("c.toml:1: sensor_range_m_per_s2: 19.6 is not valid"), "{error}");
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
        let beginning = "c.toml:4: sensor.cross_axis: ";
        assert!(error(sensor).starts_with(beginning), "{}", error(sensor));
        let sensor =
            "[[sensor]]\nzero_v = [1,\n  0.5,\n  1e39]\nsensitivity_v_per_m_per_s2 = [1, 1, 1]";
        assert!(error(sensor).starts_with("c.toml:4: "), "{}", error(sensor));
    }
}
