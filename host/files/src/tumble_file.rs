//! Six static readings of all channels, and the zeros and sensitivities that they determine.

use std::path::{Path, PathBuf};

use massline_shared::calibration::tumble::{
    Position, RestVoltages, SensorProblem, Tumble, TumbleLimits, TumbleProblem, TumbleTest,
};
use massline_shared::signal::HAMMER;
use serde::{Deserialize, Serialize};

use crate::file::{self, ExistingFile};
use crate::toml_file;
use massline_result::{Error, Result};

/// Of two positions, one axis of each sensor differs by 1 g or more; a sensor that has not been turned differs by far
/// less than this, g.
const TURNED_G: f64 = 0.5;
/// Error code for the file of readings.
const MALFORMED: &str = "readings_malformed";

/// The readings of a tumble test so far, stored in a file so that an interrupted test loses nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct TumbleFile {
    path: PathBuf,
    test: TumbleTest<f64>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct TumbleTable {
    #[serde(default)]
    reading: Vec<PositionTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PositionTable {
    position: String,
    mean_v: Vec<f64>,
    deviation_v: Vec<f64>,
    sigma_v: Vec<f64>,
}

impl TumbleFile {
    /// An empty set of readings, to be stored in `path`.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), test: TumbleTest::new() }
    }

    /// The readings of a file; an empty set when the file does not exist.
    ///
    /// # Errors
    /// Exit 2 when the file is not a set of readings, exit 3 when a tumble test rejects one of them.
    pub fn open(path: &Path) -> Result<Self> {
        let mut readings = Self::new(path);
        if !path.exists() {
            return Ok(readings);
        }
        let name = path.display().to_string();
        let text = toml_file::read(path, MALFORMED)?;
        let table: TumbleTable = toml_file::parse(&text, &name, MALFORMED)?;
        let malformed = |text: String| Error::input(MALFORMED, format!("{name}: {text}"));
        for PositionTable { position, mean_v, deviation_v, sigma_v } in table.reading {
            let named = position
                .parse()
                .map_err(|e| malformed(format!("position = \"{position}\": {e}")))?;
            let reading = RestVoltages::from_volts(&mean_v, &deviation_v, &sigma_v);
            let reading = reading.ok_or_else(|| {
                malformed(format!("position = \"{position}\": the lists are not of equal length"))
            })?;
            // The rest check does not depend on gravity and tilt, so the default limits serve.
            let taken = readings.test.add(named, reading, &TumbleLimits::default());
            taken.map_err(|problem| wrong(&sentence(&problem)).within(&name))?;
        }
        Ok(readings)
    }

    /// True when no position has been read.
    pub fn is_empty(&self) -> bool {
        self.test.readings().is_empty()
    }

    /// The positions still missing, in their order.
    pub fn missing_positions(&self) -> Vec<Position> {
        self.test.missing_positions().collect()
    }

    /// Checks that the sensors were turned since the other readings.
    ///
    /// # Errors
    /// Exit 3 with the position that reads the same.
    pub fn check_turned(
        &self,
        reading: &RestVoltages<f64>,
        limits: &TumbleLimits<f64>,
    ) -> Result<()> {
        let least = TURNED_G * limits.gravity * limits.sensitivity;
        let is_same = |other: &RestVoltages<f64>| {
            let pairs = reading.mean().iter().zip(other.mean()).skip(HAMMER + 1);
            pairs.fold(0.0, |most: f64, (a, b)| most.max((a - b).abs())) < least
        };
        match self.test.readings().iter().find(|(_, other)| is_same(other)) {
            None => Ok(()),
            Some((position, _)) => {
                Err(wrong(&format!("this reads as {position} did: turn the sensors, and let go")))
            }
        }
    }

    /// Adds a reading and writes all readings to the file.
    ///
    /// # Errors
    /// Exit 3 when the sensors moved or a channel is not finite, exit 2 when the file cannot be written.
    pub fn add(
        &mut self,
        position: Position,
        reading: RestVoltages<f64>,
        limits: &TumbleLimits<f64>,
    ) -> Result<()> {
        self.test.add(position, reading, limits).map_err(|problem| wrong(&sentence(&problem)))?;
        let reading = |(position, r): &(Position, RestVoltages<f64>)| PositionTable {
            position: position.name().into(),
            mean_v: r.mean().to_vec(),
            deviation_v: r.deviation().to_vec(),
            sigma_v: r.sigma().to_vec(),
        };
        let table = TumbleTable { reading: self.test.readings().iter().map(reading).collect() };
        // Texts and numbers only, so this cannot fail.
        let text = toml::to_string(&table).unwrap_or_default();
        file::write(&self.path, text.as_bytes(), ExistingFile::Replaced)
    }

    /// Discards all readings and their file.
    pub fn forget(&mut self) {
        self.test = TumbleTest::new();
        // The file may be missing already.
        let _ = std::fs::remove_file(&self.path);
    }

    /// The readings, in the order in which they were taken.
    pub fn readings(&self) -> &[(Position, RestVoltages<f64>)] {
        self.test.readings()
    }

    /// Zero and sensitivity of each sensor.
    ///
    /// # Errors
    /// Exit 3 with all problems of the readings, sensor by sensor.
    pub fn solve(&self, limits: &TumbleLimits<f64>) -> Result<Tumble<f64>> {
        let mut problems: Vec<String> = Vec::new();
        let result = self.test.solve(limits, |problem| problems.push(sentence(&problem)));
        result.ok_or_else(|| {
            if problems.is_empty() {
                return Error::undetermined("no_readings", "there is no reading of a sensor yet");
            }
            // A missing position is reported once, not for every sensor.
            problems.dedup();
            wrong(&format!(
                "{}; the readings are kept in {}: --restart discards them and begins anew",
                problems.join("; "),
                self.path.display()
            ))
        })
    }
}

/// Checks whether a tumble test accepts a reading; `limits` as in the test.
///
/// # Errors
/// Exit 3 when the sensors moved or a channel is not finite.
pub fn check_rest(
    reading: &RestVoltages<f64>,
    position: Position,
    limits: &TumbleLimits<f64>,
) -> Result<()> {
    reading.check(position, limits).map_err(|problem| wrong(&sentence(&problem)))
}

fn wrong(text: &str) -> Error {
    Error::undetermined("tumble_readings", text)
}

/// A problem as text for people.
fn sentence(problem: &SensorProblem<f64>) -> String {
    let sensor = problem.sensor + 1;
    match &problem.problem {
        TumbleProblem::Missing(position) => format!("position {position} is missing: read it"),
        TumbleProblem::Repeated(position) => {
            format!("position {position} is there twice: delete one of them from the readings")
        }
        TumbleProblem::NotFinite(position) => {
            format!("sensor {sensor}, position {position}: the reading is not a number")
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

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::calibration::{CalibrationMethod, CalibrationRecord};

    /// Noise of a sensor without motion, V.
    const NOISE: f64 = 0.5e-3;

    /// Two nominal sensors and a hammer at 0.12 V.
    fn reading(position: Position, noise: f64) -> RestVoltages<f64> {
        let up = position.up::<f64>();
        let mean: [f64; 7] =
            std::array::from_fn(|k| if k == 0 { 0.12 } else { 1.5 + 0.057 * up[(k - 1) % 3] });
        // The mean of half a second at 4 kS/s, of which every third scan is independent.
        RestVoltages::from_volts(&mean, &[noise; 7], &[noise / 26.0; 7]).unwrap()
    }

    #[test]
    fn sensors_that_were_not_turned_are_noticed_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = TumbleFile::new(&folder.path().join("readings.toml"));
        let limits = TumbleLimits::default();
        let first = Position::ALL[0];
        file.add(first, reading(first, NOISE), &limits).unwrap();
        let same = file.check_turned(&reading(first, 2.0 * NOISE), &limits).unwrap_err();
        assert!(same.to_string().contains(&format!("reads as {first} did")), "{same}");
        for other in &Position::ALL[1..] {
            file.check_turned(&reading(*other, NOISE), &limits).unwrap();
        }
    }

    #[test]
    fn readings_survive_in_their_file_and_give_the_sensors_of_the_data_sheet() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("tumble.toml");
        let mut readings = TumbleFile::open(&path).unwrap();
        for position in Position::ALL {
            assert_eq!(readings.missing_positions().first(), Some(&position));
            readings.add(position, reading(position, NOISE), &TumbleLimits::default()).unwrap();
            readings = TumbleFile::open(&path).unwrap();
        }
        assert!(readings.missing_positions().is_empty());
        let tumble = readings.solve(&TumbleLimits::default()).unwrap();
        let mut record = CalibrationRecord::default();
        record.take_tumble(&tumble.sensors, tumble.hammer_zero);
        // The record is in single precision: 1e-7 of 2 V, relative to 0.1 V.
        let nominal = CalibrationRecord::default().calibration;
        for k in 1..7 {
            let ratio =
                record.calibration.channels[k].sensitivity / nominal.channels[k].sensitivity;
            assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
        }
        assert!((record.calibration.channels[0].zero.0 - 0.12).abs() < 1e-5);
        assert_eq!(record.method, CalibrationMethod::Tumble);
        // 0.5 mV / 26 relative to 57 mV per g, in two positions.
        assert!((1e-4..4e-4).contains(&record.sigma.gain), "{}", record.sigma.gain);
        readings.forget();
        assert!(!path.exists());
    }

    #[test]
    fn what_is_wrong_is_said_with_sensor_and_position() {
        let directory = tempfile::tempdir().unwrap();
        let mut readings = TumbleFile::new(&directory.path().join("tumble.toml"));
        let limits = TumbleLimits::default();
        for position in &Position::ALL[..5] {
            // At the second position the sensors have not been turned.
            let lies = if *position == Position::ALL[1] { Position::ALL[0] } else { *position };
            readings.add(*position, reading(lies, NOISE), &limits).unwrap();
        }
        let error = readings.solve(&limits).unwrap_err();
        assert!(error.to_string().contains("position -Z is missing"), "{error}");
        readings.add(Position::ALL[5], reading(Position::ALL[5], NOISE), &limits).unwrap();
        let error = readings.solve(&limits).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        assert!(error.to_string().contains("sensor 2, position -X: reads as +X"), "{error}");
        let moved = reading(Position::ALL[0], 6e-3);
        let error = check_rest(&moved, Position::ALL[0], &limits).unwrap_err();
        assert!(error.to_string().contains("not at rest"), "{error}");
    }

    #[test]
    fn a_file_with_a_position_twice_is_refused_with_what_to_do() {
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("tumble.toml");
        let first = Position::ALL[0];
        let mut readings = TumbleFile::new(&path);
        readings.add(first, reading(first, NOISE), &TumbleLimits::default()).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.repeat(2)).unwrap();
        let error = TumbleFile::open(&path).unwrap_err();
        assert_eq!(error.code(), "tumble_readings");
        assert!(error.to_string().contains("+X is there twice: delete one"), "{error}");
        std::fs::write(&path, text.replacen("mean_v = [", "mean_v = [1.0, ", 1)).unwrap();
        assert_eq!(TumbleFile::open(&path).unwrap_err().code(), MALFORMED);
    }
}
