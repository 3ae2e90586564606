//! Checks whether the calibration has drifted: a block test against the calibration in force.

use massline_result::Verdict;
use massline_shared::calibration::block::SensorRatio;

/// The verdict on one channel, the best first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum DriftVerdict {
    /// Within the tolerance, as far as this test can resolve it.
    Good,
    /// The test is too coarse for the tolerance: more hits are needed.
    Unclear,
    /// Off by more than the tolerance, and significantly so.
    Drifted,
}

impl DriftVerdict {
    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Drifted => "drifted",
            Self::Unclear => "unclear",
        }
    }

    /// What it makes of the calibration.
    pub fn on_calibration(self) -> Verdict {
        match self {
            Self::Good => Verdict::Good,
            Self::Unclear => Verdict::UseWithCare,
            Self::Drifted => Verdict::DoNotUse,
        }
    }

    /// The same as the outcome of a check.
    pub fn outcome(self) -> &'static str {
        match self {
            Self::Good => "pass",
            Self::Drifted => "fail",
            Self::Unclear => "unclear",
        }
    }
}

/// Drift of one channel of one sensor against the hammer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drift {
    /// Sensor, 0-based.
    pub sensor: usize,
    /// Axis: 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Ratio of the response to the one expected from the hammer, minus one.
    pub drift: f64,
    /// Its standard deviation.
    pub sigma: f64,
    /// The verdict.
    pub verdict: DriftVerdict,
}

/// The verdict on one sensor: that of its worst axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorVerdict {
    /// Sensor, 0-based.
    pub sensor: usize,
    /// The largest drift of its axes, relative.
    pub largest: f64,
    /// The verdict.
    pub verdict: DriftVerdict,
}

/// The verdict on each sensor.
pub fn by_sensor(drifts: &[Drift]) -> Vec<SensorVerdict> {
    let mut sensors: Vec<SensorVerdict> = Vec::new();
    for drift in drifts {
        match sensors.iter_mut().find(|sensor| sensor.sensor == drift.sensor) {
            Some(sensor) => {
                sensor.verdict = sensor.verdict.max(drift.verdict);
                if drift.drift.abs() > sensor.largest.abs() {
                    sensor.largest = drift.drift;
                }
            }
            None => sensors.push(SensorVerdict {
                sensor: drift.sensor,
                largest: drift.drift,
                verdict: drift.verdict,
            }),
        }
    }
    sensors
}

/// The drift of every channel, judged by `tolerance` (relative).
pub fn drifts(sensors: &[SensorRatio<f64>], tolerance: f64) -> Vec<Drift> {
    let mut drifts = Vec::new();
    for (sensor, SensorRatio { ratio, sigma }) in sensors.iter().enumerate() {
        for axis in 0..3 {
            let (drift, sigma) = (ratio[(axis, axis)] - 1.0, sigma[(axis, axis)]);
            drifts.push(Drift {
                sensor,
                axis,
                drift,
                sigma,
                verdict: judge(drift, sigma, tolerance),
            });
        }
    }
    drifts
}

/// A drift is significant beyond three standard deviations. To resolve the tolerance, a test needs a standard
/// deviation below three quarters of it, because a standard deviation from few hits is itself uncertain.
fn judge(drift: f64, sigma: f64, tolerance: f64) -> DriftVerdict {
    if drift.abs() > tolerance && drift.abs() > 3.0 * sigma {
        DriftVerdict::Drifted
    } else if drift.abs() > tolerance || sigma > 0.75 * tolerance {
        DriftVerdict::Unclear
    } else {
        DriftVerdict::Good
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_is_judged_by_tolerance_and_sigma() {
        assert_eq!(judge(0.002, 0.003, 0.01), DriftVerdict::Good);
        assert_eq!(judge(-0.03, 0.003, 0.01), DriftVerdict::Drifted);
        assert_eq!(judge(0.012, 0.005, 0.01), DriftVerdict::Unclear);
        assert_eq!(judge(0.0, 0.02, 0.01), DriftVerdict::Unclear);
    }

    #[test]
    fn a_sensor_is_as_good_as_its_worst_axis() {
        let channel_drift =
            |sensor, axis, drift, verdict| Drift { sensor, axis, drift, sigma: 0.001, verdict };
        let sensors = by_sensor(&[
            channel_drift(0, 0, 0.001, DriftVerdict::Good),
            channel_drift(0, 1, -0.05, DriftVerdict::Drifted),
            channel_drift(0, 2, 0.012, DriftVerdict::Unclear),
            channel_drift(1, 0, 0.002, DriftVerdict::Good),
        ]);
        let sensor_verdict = |sensor, largest, verdict| SensorVerdict { sensor, largest, verdict };
        assert_eq!(
            sensors,
            [
                sensor_verdict(0, -0.05, DriftVerdict::Drifted),
                sensor_verdict(1, 0.002, DriftVerdict::Good)
            ]
        );
    }
}
