//! The readings of a tumble test in progress: one of all channels for each position.

use heapless::Vec;
use nalgebra::Vector3;

use super::{
    Position, SensorSensitivity, SensorVoltages, TumbleLimits, TumbleProblem, check_reading,
    sigma_of_mean, solve,
};
use crate::layout::RIG_SENSORS;
use crate::real::Real;
use crate::signal::{AdcProperties, CHANNELS, HAMMER, RestStatistics};

/// Output of all channels without motion, V.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RestVoltages<R> {
    /// Number of channels, the hammer first.
    channels: u8,
    mean: [R; CHANNELS],
    deviation: [R; CHANNELS],
    sigma: [R; CHANNELS],
}

impl<R: Real> RestVoltages<R> {
    /// Converts the codes that a rig has read.
    pub fn of(reading: &RestStatistics, adc: &AdcProperties) -> Self {
        let code = R::of(f64::from(adc.volts_per_code()));
        let rate = R::of(f64::from(adc.rate.0));
        let codes = |value: f32| R::of(f64::from(value));
        Self {
            channels: adc.channels.min(CHANNELS as u8),
            mean: reading.mean.map(|mean| codes(mean) * code),
            deviation: reading.deviation.map(|deviation| codes(deviation) * code),
            sigma: reading
                .deviation
                .map(|deviation| sigma_of_mean(codes(deviation), reading.scans, rate) * code),
        }
    }

    /// Reading from voltages by channel: mean, standard deviation of the scans, standard deviation of the
    /// mean. `None` when the slices differ in length or have more channels than a rig.
    pub fn from_volts(mean: &[R], deviation: &[R], sigma: &[R]) -> Option<Self> {
        let channels = mean.len();
        if channels > CHANNELS || deviation.len() != channels || sigma.len() != channels {
            return None;
        }
        let by_channel =
            |values: &[R]| core::array::from_fn(|k| values.get(k).copied().unwrap_or_else(R::zero));
        Some(Self {
            channels: channels as u8,
            mean: by_channel(mean),
            deviation: by_channel(deviation),
            sigma: by_channel(sigma),
        })
    }

    /// Mean of each channel, V.
    pub fn mean(&self) -> &[R] {
        self.present(&self.mean)
    }

    /// Standard deviation of each channel's scans, V.
    pub fn deviation(&self) -> &[R] {
        self.present(&self.deviation)
    }

    /// Standard deviation of each mean, V.
    pub fn sigma(&self) -> &[R] {
        self.present(&self.sigma)
    }

    /// Number of triaxial sensors.
    pub fn sensors(&self) -> usize {
        usize::from(self.channels).saturating_sub(1) / 3
    }

    /// Reading of sensor `sensor` (0-based) in a position; NaN for a sensor that does not exist.
    pub fn sensor(&self, sensor: usize, position: Position) -> SensorVoltages<R> {
        let axes = |values: &[R]| {
            Vector3::from_fn(|k, _| {
                values.get(1 + 3 * sensor + k).copied().unwrap_or_else(|| R::of(f64::NAN))
            })
        };
        SensorVoltages {
            position,
            mean: axes(self.mean()),
            deviation: axes(self.deviation()),
            sigma: axes(self.sigma()),
        }
    }

    /// Checks that the reading can be used in a tumble test: no sensor moved, and all channels are finite.
    ///
    /// # Errors
    /// The problem of the first sensor that has one.
    pub fn check(
        &self,
        position: Position,
        limits: &TumbleLimits<R>,
    ) -> Result<(), SensorProblem<R>> {
        for sensor in 0..self.sensors() {
            check_reading(&self.sensor(sensor, position), limits)
                .map_err(|problem| SensorProblem { sensor, problem })?;
        }
        Ok(())
    }

    fn present<'a>(&self, values: &'a [R; CHANNELS]) -> &'a [R] {
        &values[..usize::from(self.channels)]
    }
}

/// A problem with the readings of one sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorProblem<R> {
    /// The sensor, 0-based.
    pub sensor: usize,
    /// The problem.
    pub problem: TumbleProblem<R>,
}

/// Result of a tumble test.
#[derive(Clone, Debug, PartialEq)]
pub struct Tumble<R> {
    /// Zero and sensitivity of each sensor.
    pub sensors: Vec<SensorSensitivity<R>, RIG_SENSORS>,
    /// Output of the hammer without force, V.
    pub hammer_zero: R,
}

impl<R: Real> Tumble<R> {
    /// True when every position was level within the limit.
    pub fn is_level(&self, limits: &TumbleLimits<R>) -> bool {
        self.sensors.iter().all(|sensor| sensor.is_level(limits))
    }
}

/// The readings of a tumble test, one for each position, in any order.
#[derive(Clone, Debug, PartialEq)]
pub struct TumbleTest<R> {
    readings: Vec<(Position, RestVoltages<R>), { Position::ALL.len() }>,
}

impl<R> Default for TumbleTest<R> {
    fn default() -> Self {
        Self::new()
    }
}

impl<R> TumbleTest<R> {
    /// A test without readings.
    pub const fn new() -> Self {
        Self { readings: Vec::new() }
    }

    /// Readings so far, in the order in which they were taken.
    pub fn readings(&self) -> &[(Position, RestVoltages<R>)] {
        &self.readings
    }

    /// Positions still to be read, in order.
    pub fn missing_positions(&self) -> impl Iterator<Item = Position> {
        let read = |position| self.readings.iter().any(|(other, _)| *other == position);
        Position::ALL.into_iter().filter(move |&position| !read(position))
    }
}

impl<R: Real> TumbleTest<R> {
    /// Adds the reading of a position.
    ///
    /// # Errors
    /// As for [`RestVoltages::check`], and when the position has already been read; the test stays unchanged.
    pub fn add(
        &mut self,
        position: Position,
        reading: RestVoltages<R>,
        limits: &TumbleLimits<R>,
    ) -> Result<(), SensorProblem<R>> {
        reading.check(position, limits)?;
        if !self.missing_positions().any(|wanted| wanted == position) {
            return Err(SensorProblem { sensor: 0, problem: TumbleProblem::Repeated(position) });
        }
        // There is room for every position once.
        let _ = self.readings.push((position, reading));
        Ok(())
    }

    /// Number of triaxial sensors that all readings have.
    pub fn sensors(&self) -> usize {
        let sensors = self.readings.iter().map(|(_, reading)| reading.sensors()).min();
        sensors.unwrap_or(0).min(RIG_SENSORS)
    }

    /// Zero and sensitivity of each sensor. `None` when there is no sensor or the readings have problems,
    /// each of which is passed to `report`.
    pub fn solve(
        &self,
        limits: &TumbleLimits<R>,
        mut report: impl FnMut(SensorProblem<R>),
    ) -> Option<Tumble<R>> {
        let mut sensors = Vec::new();
        for sensor in 0..self.sensors() {
            let of_sensor = self.readings.iter().map(|(p, reading)| reading.sensor(sensor, *p));
            let readings: Vec<_, { Position::ALL.len() }> = of_sensor.collect();
            match solve(&readings, limits) {
                Ok(sensitivity) => sensors.push(sensitivity).ok()?,
                Err(problems) => {
                    problems.iter().for_each(|&problem| report(SensorProblem { sensor, problem }));
                }
            }
        }
        let rest = self.readings.iter().filter_map(|(_, reading)| reading.mean().get(HAMMER));
        let sum = rest.fold(R::zero(), |sum, volts| sum + *volts);
        let hammer_zero = sum / R::of(self.readings.len().max(1) as f64);
        let whole = !sensors.is_empty() && sensors.len() == self.sensors();
        whole.then_some(Tumble { sensors, hammer_zero })
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixture::ADC;
    use super::*;

    /// Two nominal sensors without motion, and a hammer at 0.12 V.
    fn reading(position: Position, deviation: f32) -> RestVoltages<f32> {
        let up = position.up::<f32>();
        let mut mean = [0.0; CHANNELS];
        mean[0] = 0.12 / 3.0 * 4096.0;
        for k in 0..6 {
            mean[1 + k] = (1.5 + 0.057 * up[k % 3]) / 3.0 * 4096.0;
        }
        let codes = RestStatistics { scans: 2048, mean, deviation: [deviation; CHANNELS] };
        RestVoltages::of(&codes, &ADC)
    }

    fn limits() -> TumbleLimits<f32> {
        TumbleLimits::default()
    }

    #[test]
    fn six_readings_in_any_order_give_every_sensor_and_the_zero_of_the_hammer() {
        let mut test = TumbleTest::new();
        for place in [3, 0, 5, 1, 2, 4] {
            assert_eq!(test.solve(&limits(), |_| ()), None);
            test.add(Position::ALL[place], reading(Position::ALL[place], 0.65), &limits()).unwrap();
        }
        assert_eq!((test.missing_positions().count(), test.sensors()), (0, 2));
        let tumble = test.solve(&limits(), |problem| panic!("{problem:?}")).unwrap();
        assert_eq!(tumble.sensors.len(), 2);
        // Codes in single precision: 1e-7 of 2 V over 0.1 V, for a few roundings.
        let nominal = 0.057 / crate::units::STANDARD_GRAVITY as f32;
        for sensor in tumble.sensors.iter() {
            assert!((sensor.sensitivity[(1, 1)] / nominal - 1.0).abs() < 2e-5, "{sensor:?}");
        }
        assert!((tumble.hammer_zero - 0.12).abs() < 1e-6 && tumble.is_level(&limits()));
    }

    #[test]
    fn a_sensor_that_moves_and_a_position_that_is_read_twice_are_refused() {
        let mut test = TumbleTest::new();
        let first = Position::ALL[0];
        let moved = test.add(first, reading(first, 40.0), &limits()).unwrap_err();
        assert!(
            matches!(moved.problem, TumbleProblem::NotAtRest { position, .. } if position == first)
        );
        assert_eq!(test.missing_positions().next(), Some(first));
        test.add(first, reading(first, 0.65), &limits()).unwrap();
        let again = test.add(first, reading(first, 0.65), &limits()).unwrap_err();
        assert_eq!(again.problem, TumbleProblem::Repeated(first));
        assert_eq!(test.readings().len(), 1);
    }

    #[test]
    fn everything_that_is_wrong_is_reported_with_its_sensor() {
        let mut test = TumbleTest::new();
        for place in [0, 1, 3, 2, 4, 5] {
            let turned = reading(Position::ALL[place], 0.65);
            let asked = test.missing_positions().next().unwrap();
            test.add(asked, turned, &limits()).unwrap();
        }
        let mut wrong = std::vec::Vec::new();
        assert_eq!(test.solve(&limits(), |problem| wrong.push(problem)), None);
        assert_eq!(wrong.len(), 4, "two positions of two sensors: {wrong:?}");
        assert!(wrong.iter().all(|w| matches!(w.problem, TumbleProblem::ReadsAs { .. })));
    }

    #[test]
    fn volts_of_a_file_have_to_be_of_equally_many_channels() {
        let volts = [1.5_f64; 7];
        let read = RestVoltages::from_volts(&volts, &volts, &volts).unwrap();
        assert_eq!((read.sensors(), read.mean()), (2, &volts[..]));
        assert_eq!(RestVoltages::from_volts(&volts, &volts[1..], &volts), None);
        assert_eq!(RestVoltages::from_volts(&[0.0; 11], &[0.0; 11], &[0.0; 11]), None);
    }
}
