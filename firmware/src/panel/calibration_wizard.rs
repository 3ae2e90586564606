//! A calibration in progress: the tumble test with six readings, or a block of known mass.

use massline_shared::calibration::block::{BlockError, ForceRatio};
use massline_shared::calibration::tumble::{
    RestVoltages, SensorProblem, TumbleLimits, TumbleProblem, TumbleTest,
};
use massline_shared::calibration::{CalibrationRecord, CalibrationSigma};
use massline_shared::signal::{AdcProperties, RestStatistics};

use super::refused::RefusalReason;

/// State of a calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CalibrationWizard {
    /// No calibration is in progress.
    Off,
    /// The operator is to lay the sensors in this position of the tumble test, by its index.
    Wanted(u8),
    /// The sensors are being read in this position.
    Reading(u8),
    /// The calibration has failed.
    Wrong(WizardProblem),
    /// A calibration was computed and waits for the operator to confirm it.
    Proposed(Proposal),
    /// The calibration is stored and in force.
    Stored,
}

/// Why a calibration has failed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum WizardProblem {
    /// A reading of the tumble test is unusable.
    Tumble {
        /// Index of the sensor, from 0.
        sensor: u8,
        /// The problem of the reading.
        problem: TumbleProblem<f32>,
    },
    /// The hits of the block test are unusable.
    Block(BlockError),
    /// The block test needs calibrated sensors.
    SensorsUnknown,
    /// The mass of the block was not entered at this rig.
    NoMass,
    /// The computed calibration is not usable.
    NotUsable,
    /// The rig has refused a step.
    Refused(RefusalReason),
}

impl WizardProblem {
    /// True when only the current position has to be read again.
    pub fn read_again(&self) -> bool {
        use TumbleProblem as T;
        matches!(
            self,
            Self::Tumble { problem: T::NotFinite(_) | T::NotAtRest { .. }, .. }
                | Self::Refused(RefusalReason::SamplerStopped | RefusalReason::Busy)
        )
    }
}

/// What a computed calibration would change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// True when all positions of the tumble test were level, or all directions of the block test agree.
    pub sound: bool,
    /// New hammer gain divided by the old one, of a block test.
    pub hammer_ratio: Option<f32>,
    /// Standard deviations that were achieved.
    pub sigma: CalibrationSigma,
}

/// Adds the reading of `adc`'s channels in the current position; returns true after the last position.
pub(super) fn add_reading(
    test: &mut TumbleTest<f32>,
    reading: &RestStatistics,
    adc: &AdcProperties,
) -> Result<bool, WizardProblem> {
    let wanted = test.missing_positions().next();
    if let Some(position) = wanted {
        let reading = RestVoltages::of(reading, adc);
        test.add(position, reading, &TumbleLimits::default()).map_err(WizardProblem::from)?;
    }
    Ok(test.missing_positions().next().is_none())
}

/// The calibration in force, updated from the six readings, and its proposal.
pub(super) fn of_tumble(
    test: &TumbleTest<f32>,
    record: &mut CalibrationRecord,
) -> Result<Proposal, WizardProblem> {
    let limits = TumbleLimits::default();
    let mut wrong: Option<SensorProblem<f32>> = None;
    let solution = test.solve(&limits, |problem| wrong = wrong.or(Some(problem)));
    let solution =
        solution.ok_or_else(|| wrong.map_or(WizardProblem::NotUsable, WizardProblem::from))?;
    record.take_tumble(&solution.sensors, solution.hammer_zero);
    let sound = solution.is_level(&limits);
    propose(record, Proposal { sound, hammer_ratio: None, sigma: record.sigma })
}

impl From<SensorProblem<f32>> for WizardProblem {
    fn from(SensorProblem { sensor, problem }: SensorProblem<f32>) -> Self {
        Self::Tumble { sensor: sensor as u8, problem }
    }
}

/// The calibration in force, with the hammer's gain updated from a block of known mass.
pub(super) fn of_block(
    ratio: &ForceRatio<f32>,
    record: &mut CalibrationRecord,
) -> Result<Proposal, WizardProblem> {
    if !record.method.knows_sensors() {
        return Err(WizardProblem::SensorsUnknown);
    }
    record.take_block(ratio);
    let hammer_ratio = Some(ratio.ratio);
    let proposal = Proposal { sound: ratio.is_consistent(), hammer_ratio, sigma: record.sigma };
    propose(record, proposal)
}

fn propose(record: &mut CalibrationRecord, proposal: Proposal) -> Result<Proposal, WizardProblem> {
    // The rig has no calendar.
    record.date.clear();
    record.temperature = None;
    if record.is_usable() { Ok(proposal) } else { Err(WizardProblem::NotUsable) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::calibration::CalibrationMethod;
    use massline_shared::calibration::tumble::Position;
    use massline_shared::signal::{CHANNELS, HAMMER};
    use massline_shared::units::{Hertz, Seconds, Volts};

    const ADC: AdcProperties = AdcProperties {
        rate: Hertz(4000.0),
        channels: 7,
        bits: 12,
        reference: Volts(3.0),
        channel_delay: Seconds(1e-5),
    };

    /// Two nominal sensors without motion, and a hammer at 0.12 V.
    fn reading(position: Position, deviation: f32) -> RestStatistics {
        let up = position.up::<f32>();
        let mut mean = [0.0; CHANNELS];
        mean[0] = 0.12 / 3.0 * 4096.0;
        for k in 0..6 {
            mean[1 + k] = (1.5 + 0.057 * up[k % 3]) / 3.0 * 4096.0;
        }
        RestStatistics { scans: 2048, mean, deviation: [deviation; CHANNELS] }
    }

    fn tumble_test(order: [usize; 6]) -> TumbleTest<f32> {
        let mut readings = TumbleTest::new();
        for (count, place) in (1..).zip(order) {
            let last =
                add_reading(&mut readings, &reading(Position::ALL[place], 0.65), &ADC).unwrap();
            assert_eq!(last, count == 6);
        }
        readings
    }

    #[test]
    fn six_readings_of_the_data_sheet_give_the_data_sheet() {
        let mut record = CalibrationRecord::default();
        let proposal = of_tumble(&tumble_test([0, 1, 2, 3, 4, 5]), &mut record).unwrap();
        let nominal = CalibrationRecord::default().calibration;
        for k in 1..7 {
            let ratio =
                record.calibration.channels[k].sensitivity / nominal.channels[k].sensitivity;
            // Single-precision rounding of the codes: 1e-7 of 2 V, divided by 0.1 V, several times.
            assert!((ratio - 1.0).abs() < 2e-5, "{ratio}");
        }
        assert!((record.calibration.channels[0].zero.0 - 0.12).abs() < 1e-5);
        assert_eq!(record.method, CalibrationMethod::Tumble);
        assert!(proposal.sound);
        // 0.65 codes of noise, 2048 scans of which one in 2.7 is independent, 78 codes per g.
        assert!((1e-4..4e-4).contains(&proposal.sigma.gain), "{}", proposal.sigma.gain);
        // The tumble test leaves the hammer's uncertainty at that of its data sheet.
        assert_eq!(proposal.sigma.hammer_gain, CalibrationSigma::default().hammer_gain);
    }

    #[test]
    fn a_sensor_that_moves_is_to_be_read_again() {
        let mut readings = TumbleTest::new();
        let moving = reading(Position::ALL[0], 40.0);
        let problem = add_reading(&mut readings, &moving, &ADC).unwrap_err();
        assert!(problem.read_again(), "{problem:?}");
        assert_eq!(readings.missing_positions().next(), Some(Position::ALL[0]));
    }

    #[test]
    fn a_position_that_was_turned_otherwise_is_found() {
        let mut record = CalibrationRecord::default();
        let problem = of_tumble(&tumble_test([0, 1, 3, 2, 4, 5]), &mut record).unwrap_err();
        assert!(matches!(
            problem,
            WizardProblem::Tumble { sensor: 0, problem: TumbleProblem::ReadsAs { .. } }
        ));
        assert!(!problem.read_again());
    }

    #[test]
    fn a_block_calibrates_the_hammer_against_known_sensors_only() {
        let ratio = ForceRatio { ratio: 1.02, sigma: 0.003, departure: (0.0, 1.0) };
        let mut record = CalibrationRecord::default();
        assert_eq!(of_block(&ratio, &mut record), Err(WizardProblem::SensorsUnknown));
        record.method = CalibrationMethod::Tumble;
        let before = record.calibration.channels[HAMMER].sensitivity;
        let proposal = of_block(&ratio, &mut record).unwrap();
        assert_eq!(record.calibration.channels[HAMMER].sensitivity, before / 1.02);
        assert_eq!(record.method, CalibrationMethod::TumbleAndBlock);
        assert_eq!(proposal.sigma.hammer_gain, 0.003 / 1.02);
    }
}
