//! A calibration on its way: the tumble test with six readings, or a block of known mass.

use heapless::Vec;
use massline_shared::calibration::block::{BlockError, ForceRatio};
use massline_shared::calibration::tumble::{
    Position, SensorSensitivity, TumbleLimits, TumbleProblem, TumbleReading, check_reading, solve,
};
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};
use massline_shared::layout::RIG_SENSORS;
use massline_shared::signal::StaticReading;
use massline_shared::signal::{AdcProperties, CHANNELS, HAMMER};

use super::refused::Refused;

/// How far a calibration is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trial {
    /// There is none.
    Off,
    /// The sensors are to be laid in this one of [`Position::ALL`].
    Wanted(u8),
    /// They are being read in it.
    Reading(u8),
    /// That did not work.
    Wrong(Problem),
    /// It waits to be kept.
    Proposed(Proposal),
    /// It is kept and in force.
    Kept,
}

/// Why there is no calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Problem {
    /// A reading of the tumble test.
    Tumble {
        /// Of which sensor, 0-based.
        sensor: u8,
        /// What is wrong with it.
        problem: TumbleProblem<f32>,
    },
    /// The hits of the block test.
    Block(BlockError),
    /// The block test needs sensors whose sensitivity is known.
    SensorsUnknown,
    /// The mass of the block was not typed in at this rig.
    NoMass,
    /// The numbers make no calibration that a rig can work with.
    NotUsable,
    /// The rig could not do it.
    Refused(Refused),
}

impl Problem {
    /// True when the position in hand only has to be read again.
    pub fn read_again(&self) -> bool {
        use TumbleProblem as T;
        matches!(
            self,
            Self::Tumble { problem: T::NotFinite(_) | T::NotAtRest { .. }, .. }
                | Self::Refused(Refused::SamplerStopped | Refused::Busy)
        )
    }
}

/// What a calibration would bring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// True when all positions of the tumble test were level, or all directions of the block test
    /// agree.
    pub sound: bool,
    /// The hammer's gain against what it was, of a block test.
    pub hammer_ratio: Option<f32>,
    /// What has been achieved.
    pub sigma: CalibrationSigma,
}

/// The readings of a tumble test as far as it has come.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    taken: u8,
    readings: [StaticReading; Position::ALL.len()],
}

impl Readings {
    pub const fn new() -> Self {
        const EMPTY: StaticReading =
            StaticReading { scans: 0, mean: [0.0; CHANNELS], deviation: [0.0; CHANNELS] };
        Self { taken: 0, readings: [EMPTY; Position::ALL.len()] }
    }

    /// The position that is wanted, as its place in [`Position::ALL`].
    pub fn wanted(&self) -> u8 {
        self.taken
    }

    /// Takes what the first `sensors` sensors read in the position that is wanted; true when it was the
    /// last.
    pub fn add(
        &mut self,
        reading: &StaticReading,
        sensors: usize,
        adc: &AdcProperties,
    ) -> Result<bool, Problem> {
        let place = usize::from(self.taken);
        let limits = TumbleLimits::default();
        let Some((&position, slot)) = Position::ALL.get(place).zip(self.readings.get_mut(place))
        else {
            return Ok(true);
        };
        for sensor in 0..sensors {
            check_reading(&TumbleReading::<f32>::of(position, reading, sensor, adc), &limits)
                .map_err(|problem| Problem::Tumble { sensor: sensor as u8, problem })?;
        }
        *slot = *reading;
        self.taken += 1;
        Ok(usize::from(self.taken) == Position::ALL.len())
    }

    /// The calibration that the six readings make of the one in force, with what it is worth.
    #[inline(never)]
    pub fn solve(
        &self,
        sensors: usize,
        adc: &AdcProperties,
        record: &mut CalibrationRecord,
    ) -> Result<Proposal, Problem> {
        let limits = TumbleLimits::<f32>::default();
        let mut found = Vec::<SensorSensitivity<f32>, RIG_SENSORS>::new();
        for sensor in 0..sensors {
            let of = |place: usize| {
                TumbleReading::of(Position::ALL[place], &self.readings[place], sensor, adc)
            };
            let readings: [TumbleReading<f32>; Position::ALL.len()] = core::array::from_fn(of);
            let solved = solve(&readings, &limits).map_err(|problems| {
                let first = problems.first().copied();
                first.map_or(Problem::NotUsable, |problem| Problem::Tumble {
                    sensor: sensor as u8,
                    problem,
                })
            })?;
            found.push(solved).map_err(|_| Problem::NotUsable)?;
        }
        let rest: f32 = self.readings.iter().map(|reading| reading.mean[HAMMER]).sum();
        record.take_tumble(&found, rest / Position::ALL.len() as f32 * adc.volts_per_code());
        let sound = found.iter().all(|sensor| sensor.is_level(&limits));
        propose(record, Proposal { sound, hammer_ratio: None, sigma: record.sigma })
    }
}

/// The calibration in force with the hammer as a block of known mass has shown it.
pub(super) fn of_block(
    ratio: &ForceRatio<f32>,
    record: &mut CalibrationRecord,
) -> Result<Proposal, Problem> {
    if !record.method().knows_sensors() {
        return Err(Problem::SensorsUnknown);
    }
    record.calibration.channels[HAMMER].sensitivity /= ratio.ratio;
    record.method = CalibrationMethod::TumbleAndBlock as u8;
    record.sigma.hammer_gain = ratio.sigma / ratio.ratio;
    let hammer_ratio = Some(ratio.ratio);
    let proposal = Proposal { sound: ratio.is_consistent(), hammer_ratio, sigma: record.sigma };
    propose(record, proposal)
}

fn propose(record: &mut CalibrationRecord, proposal: Proposal) -> Result<Proposal, Problem> {
    // The rig has no calendar.
    record.date.clear();
    record.temperature = None;
    if record.is_usable() { Ok(proposal) } else { Err(Problem::NotUsable) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::units::{Hertz, Seconds, Volts};

    const ADC: AdcProperties = AdcProperties {
        rate: Hertz(4000.0),
        channels: 7,
        bits: 12,
        reference: Volts(3.0),
        channel_delay: Seconds(1e-5),
    };

    /// Two nominal sensors at rest, and a hammer at 0.12 V.
    fn reading(position: Position, deviation: f32) -> StaticReading {
        let up = position.up::<f32>();
        let mut mean = [0.0; CHANNELS];
        mean[0] = 0.12 / 3.0 * 4096.0;
        for k in 0..6 {
            mean[1 + k] = (1.5 + 0.057 * up[k % 3]) / 3.0 * 4096.0;
        }
        StaticReading { scans: 2048, mean, deviation: [deviation; CHANNELS] }
    }

    fn all(order: [usize; 6]) -> Readings {
        let mut readings = Readings::new();
        for (count, place) in (1..).zip(order) {
            let last = readings.add(&reading(Position::ALL[place], 0.65), 2, &ADC).unwrap();
            assert_eq!(last, count == 6);
        }
        readings
    }

    #[test]
    fn six_readings_of_the_data_sheet_give_the_data_sheet() {
        let mut record = CalibrationRecord::default();
        let proposal = all([0, 1, 2, 3, 4, 5]).solve(2, &ADC, &mut record).unwrap();
        let nominal = CalibrationRecord::default().calibration;
        for k in 1..7 {
            let ratio =
                record.calibration.channels[k].sensitivity / nominal.channels[k].sensitivity;
            // Codes in single precision: 1e-7 of 2 V, over 0.1 V, a few roundings.
            assert!((ratio - 1.0).abs() < 2e-5, "{ratio}");
        }
        assert!((record.calibration.channels[0].zero.0 - 0.12).abs() < 1e-5);
        assert_eq!(record.method(), CalibrationMethod::Tumble);
        assert!(proposal.sound);
        // 0.65 codes over 2048 scans of which every 2.7th is independent, of 78 codes per g.
        assert!((1e-4..4e-4).contains(&proposal.sigma.gain), "{}", proposal.sigma.gain);
        // Bound to the tumble test, the hammer is as unknown as its data sheet says.
        assert_eq!(proposal.sigma.hammer_gain, CalibrationSigma::default().hammer_gain);
    }

    #[test]
    fn a_sensor_that_moves_is_to_be_read_again() {
        let mut readings = Readings::new();
        let problem = readings.add(&reading(Position::ALL[0], 40.0), 2, &ADC).unwrap_err();
        assert!(problem.read_again(), "{problem:?}");
        assert_eq!(readings.wanted(), 0);
    }

    #[test]
    fn a_position_that_was_turned_otherwise_is_found() {
        let mut record = CalibrationRecord::default();
        let problem = all([0, 1, 3, 2, 4, 5]).solve(2, &ADC, &mut record).unwrap_err();
        assert!(matches!(
            problem,
            Problem::Tumble { sensor: 0, problem: TumbleProblem::ReadsAs { .. } }
        ));
        assert!(!problem.read_again());
    }

    #[test]
    fn a_block_calibrates_the_hammer_against_known_sensors_only() {
        let ratio = ForceRatio { ratio: 1.02, sigma: 0.003, departure: (0.0, 1.0) };
        let mut record = CalibrationRecord::default();
        assert_eq!(of_block(&ratio, &mut record), Err(Problem::SensorsUnknown));
        record.method = CalibrationMethod::Tumble as u8;
        let before = record.calibration.channels[HAMMER].sensitivity;
        let proposal = of_block(&ratio, &mut record).unwrap();
        assert_eq!(record.calibration.channels[HAMMER].sensitivity, before / 1.02);
        assert_eq!(record.method(), CalibrationMethod::TumbleAndBlock);
        assert_eq!(proposal.sigma.hammer_gain, 0.003 / 1.02);
    }
}
