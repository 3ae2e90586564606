//! Six static readings of all channels, and what they say of zeros and sensitivities.

use std::path::{Path, PathBuf};

use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::tumble::{
    Position, SensorSensitivity, TumbleLimits, TumbleProblem, TumbleReading, check_reading,
    sigma_of_mean, solve,
};
use massline_shared::signal::AdcProperties;
use massline_shared::signal::StaticReading;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::toml_file;

/// Word of the errors about the file of readings.
const MALFORMED: &str = "readings_malformed";

/// What all channels read at rest, V.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RestReading {
    /// Mean of each channel, V.
    mean_v: Vec<f64>,
    /// Standard deviation of the scans, V.
    deviation_v: Vec<f64>,
    /// Standard deviation of the mean, V.
    sigma_v: Vec<f64>,
}

impl RestReading {
    /// Of what the rig says in codes.
    pub fn of(reading: &StaticReading, adc: &AdcProperties) -> Self {
        let channels = usize::from(adc.channels).min(reading.mean.len());
        let code = f64::from(adc.volts_per_code());
        let rate = f64::from(adc.rate.0);
        let sigma =
            |&deviation: &f32| sigma_of_mean(f64::from(deviation), reading.scans, rate) * code;
        let volts = |values: &[f32]| -> Vec<f64> {
            values.iter().take(channels).map(|&v| f64::from(v) * code).collect()
        };
        Self {
            mean_v: volts(&reading.mean),
            deviation_v: volts(&reading.deviation),
            sigma_v: reading.deviation.iter().take(channels).map(sigma).collect(),
        }
    }

    /// Triaxial sensors in it.
    pub fn sensors(&self) -> usize {
        self.mean_v.len().min(self.deviation_v.len()).min(self.sigma_v.len()).saturating_sub(1) / 3
    }

    /// The reading of one sensor.
    fn of_sensor(&self, sensor: usize, position: Position) -> TumbleReading<f64> {
        let axes = |values: &[f64]| {
            Vector3::from_fn(|k, _| values.get(1 + 3 * sensor + k).copied().unwrap_or(f64::NAN))
        };
        TumbleReading {
            position,
            mean: axes(&self.mean_v),
            deviation: axes(&self.deviation_v),
            sigma: axes(&self.sigma_v),
        }
    }
}

/// The readings of a tumble test as far as it has come, in a file: nothing is lost when it is
/// interrupted.
#[derive(Clone, Debug, PartialEq)]
pub struct TumbleReadings {
    path: PathBuf,
    readings: Vec<(Position, RestReading)>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReadingsTable {
    #[serde(default)]
    reading: Vec<ReadingTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ReadingTable {
    position: String,
    mean_v: Vec<f64>,
    deviation_v: Vec<f64>,
    sigma_v: Vec<f64>,
}

impl TumbleReadings {
    /// No readings yet; they will be kept in `path`.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), readings: Vec::new() }
    }

    /// The readings of a file, none when there is no such file.
    ///
    /// # Errors
    /// Exit 2 when the file is no set of readings.
    pub fn open(path: &Path) -> Result<Self> {
        if !path.exists() {
            return Ok(Self::new(path));
        }
        let name = path.display().to_string();
        let text = toml_file::read(path, MALFORMED)?;
        let table: ReadingsTable = toml_file::parse(&text, &name, MALFORMED)?;
        let mut readings = Vec::new();
        for ReadingTable { position, mean_v, deviation_v, sigma_v } in table.reading {
            let named = position.parse().map_err(|e| {
                Error::input(MALFORMED, format!("{name}: position = \"{position}\": {e}"))
            })?;
            readings.push((named, RestReading { mean_v, deviation_v, sigma_v }));
        }
        Ok(Self { path: path.to_owned(), readings })
    }

    /// The positions that have been read.
    pub fn positions(&self) -> impl Iterator<Item = Position> {
        self.readings.iter().map(|&(position, _)| position)
    }

    /// The positions that are wanted still, in their order.
    pub fn wanted(&self) -> Vec<Position> {
        Position::ALL.into_iter().filter(|p| !self.positions().any(|read| read == *p)).collect()
    }

    /// Adds a reading and writes all to the file.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be written.
    pub fn add(&mut self, position: Position, reading: RestReading) -> Result<()> {
        self.readings.push((position, reading));
        let reading = |(position, r): &(Position, RestReading)| ReadingTable {
            position: position.name().into(),
            mean_v: r.mean_v.clone(),
            deviation_v: r.deviation_v.clone(),
            sigma_v: r.sigma_v.clone(),
        };
        let table = ReadingsTable { reading: self.readings.iter().map(reading).collect() };
        // Texts and numbers only: this cannot fail.
        let text = toml::to_string(&table).unwrap_or_default();
        std::fs::write(&self.path, text).map_err(|e| {
            let path = self.path.display();
            Error::input("cannot_write", format!("{path}: cannot be written: {e}"))
        })
    }

    /// Forgets all readings and their file.
    pub fn forget(&mut self) {
        self.readings.clear();
        // Not there is as good as removed.
        let _ = std::fs::remove_file(&self.path);
    }

    /// Zero and sensitivity of each sensor.
    ///
    /// # Errors
    /// Exit 3 with everything that is wrong with the readings, sensor by sensor.
    pub fn solve(&self, limits: &TumbleLimits<f64>) -> Result<Tumble> {
        let sensors = self.readings.iter().map(|(_, r)| r.sensors()).min().unwrap_or(0);
        if sensors == 0 {
            return Err(Error::undetermined("no_readings", "there is no reading of a sensor yet"));
        }
        let mut found = Vec::new();
        let mut wrong: Vec<String> = Vec::new();
        for sensor in 0..sensors {
            let readings: Vec<_> =
                self.readings.iter().map(|(p, r)| r.of_sensor(sensor, *p)).collect();
            match solve(&readings, limits) {
                Ok(sensitivity) => found.push(sensitivity),
                Err(problems) => {
                    wrong.extend(problems.iter().map(|p| sentence(sensor, p)));
                }
            }
        }
        if !wrong.is_empty() {
            // A position that is missing is so for every sensor.
            wrong.dedup();
            return Err(Error::undetermined("tumble_readings", wrong.join("; ")));
        }
        let rest = self.readings.iter().filter_map(|(_, r)| r.mean_v.first());
        let hammer_zero = rest.sum::<f64>() / self.readings.len() as f64;
        Ok(Tumble { sensors: found, hammer_zero })
    }
}

/// Whether a reading can be taken into a tumble test; `limits` as in the test.
///
/// # Errors
/// Exit 3: the sensors moved, or a channel is no number.
pub fn check_rest(
    reading: &RestReading,
    position: Position,
    limits: &TumbleLimits<f64>,
) -> Result<()> {
    for sensor in 0..reading.sensors() {
        check_reading(&reading.of_sensor(sensor, position), limits)
            .map_err(|p| Error::undetermined("tumble_readings", sentence(sensor, &p)))?;
    }
    Ok(())
}

/// What is wrong, for a person.
fn sentence(sensor: usize, problem: &TumbleProblem<f64>) -> String {
    let sensor = sensor + 1;
    match problem {
        TumbleProblem::Missing(position) => format!("position {position} is missing: read it"),
        TumbleProblem::Repeated(position) => {
            format!("position {position} is there twice: delete one of them from the readings")
        }
        TumbleProblem::NotFinite(position) => {
            format!("sensor {sensor}, position {position}: the reading is no number")
        }
        TumbleProblem::NotAtRest { position, deviation } => format!(
            "sensor {sensor}, position {position}: not at rest ({deviation:.2} m/s² rms); put it \
             down and do not touch it while it is read"
        ),
        TumbleProblem::ReadsAs { position, like } => format!(
            "sensor {sensor}, position {position}: reads as {like}; it was turned otherwise, or two \
             of its wires are swapped"
        ),
        TumbleProblem::WrongLength { position, length } => format!(
            "sensor {sensor}, position {position}: reads {length:.2} g; a channel is not connected, \
             or this is another kind of sensor"
        ),
    }
}

/// What a tumble test has found.
#[derive(Clone, Debug, PartialEq)]
pub struct Tumble {
    /// Sensor by sensor.
    pub sensors: Vec<SensorSensitivity<f64>>,
    /// Output of the hammer at rest, V.
    pub hammer_zero: f64,
}

impl Tumble {
    /// True when every position was level within the limit.
    pub fn is_level(&self, limits: &TumbleLimits<f64>) -> bool {
        self.sensors.iter().all(|sensor| sensor.is_level(limits))
    }

    /// Becomes part of a calibration.
    pub fn write(&self, record: &mut CalibrationRecord) {
        record.take_tumble(&self.sensors, self.hammer_zero);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::calibration::CalibrationMethod;
    use massline_shared::signal::CHANNELS;
    use massline_shared::units::{Hertz, Seconds, Volts};

    const ADC: AdcProperties = AdcProperties {
        rate: Hertz(4000.0),
        channels: 7,
        bits: 12,
        reference: Volts(3.0),
        channel_delay: Seconds(1e-5),
    };

    /// Two nominal sensors at rest, and a hammer at 0.12 V.
    fn reading(position: Position, deviation: f32) -> RestReading {
        let up = position.up::<f64>();
        let mut mean = [0.0; CHANNELS];
        mean[0] = (0.12 / 3.0 * 4096.0) as f32;
        for k in 0..6 {
            mean[1 + k] = ((1.5 + 0.057 * up[k % 3]) / 3.0 * 4096.0) as f32;
        }
        let reading = StaticReading { scans: 2048, mean, deviation: [deviation; CHANNELS] };
        RestReading::of(&reading, &ADC)
    }

    #[test]
    fn readings_survive_in_their_file_and_give_the_sensors_of_the_data_sheet() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("tumble.toml");
        let mut readings = TumbleReadings::open(&path).unwrap();
        for position in Position::ALL {
            assert_eq!(readings.wanted().first(), Some(&position));
            readings.add(position, reading(position, 0.65)).unwrap();
            readings = TumbleReadings::open(&path).unwrap();
        }
        assert!(readings.wanted().is_empty());
        let found = readings.solve(&TumbleLimits::default()).unwrap();
        let mut record = CalibrationRecord::default();
        found.write(&mut record);
        // Codes in single precision: 1e-7 of 2 V, over 0.1 V.
        let nominal = CalibrationRecord::default().calibration;
        for k in 1..7 {
            let ratio =
                record.calibration.channels[k].sensitivity / nominal.channels[k].sensitivity;
            assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
        }
        assert!((record.calibration.channels[0].zero.0 - 0.12).abs() < 1e-5);
        assert_eq!(record.method(), CalibrationMethod::Tumble);
        // 0.65 codes over 2048 scans of which every 2.7th is independent, of 78 codes per g.
        assert!((1e-4..4e-4).contains(&record.sigma.gain), "{}", record.sigma.gain);
        readings.forget();
        assert!(!path.exists());
    }

    #[test]
    fn what_is_wrong_is_said_with_sensor_and_position() {
        let mut readings = TumbleReadings::new(&tempfile::tempdir().unwrap().path().join("x"));
        for position in Position::ALL {
            readings.readings.push((position, reading(position, 0.65)));
        }
        readings.readings[1].1 = readings.readings[0].1.clone();
        let error = readings.solve(&TumbleLimits::default()).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        assert!(error.to_string().contains("sensor 2, position -X: reads as +X"), "{error}");
        readings.readings.pop();
        let error = readings.solve(&TumbleLimits::default()).unwrap_err();
        assert!(error.to_string().contains("position -Z is missing"), "{error}");
        let moved = reading(Position::ALL[0], 9.0);
        let error = check_rest(&moved, Position::ALL[0], &TumbleLimits::default()).unwrap_err();
        assert!(error.to_string().contains("not at rest"), "{error}");
    }
}
