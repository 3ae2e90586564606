//! How sensors lie in a tumble test, by the calibration that the rig has: what the screen shows and what is stored
//! follow it.

use massline_protocol::message::Identity;
use massline_shared::STANDARD_GRAVITY;
use massline_shared::calibration::tumble::{Position, RestVoltages};
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord};
use massline_shared::layout::Axis;
use massline_shared::signal::{HAMMER, RESPONSES};
use nalgebra::Vector3;

/// What the axes that are level may read at most, and by how much the upright one may differ from 1 g.
const OTHERS_G: f64 = 0.3;

/// Whether the zeros of the sensors are known, so that one reading tells how a sensor lies. By its data sheet, the zero
/// of an axis is known to 1 g only.
pub fn is_known(record: &CalibrationRecord) -> bool {
    record.method != CalibrationMethod::DataSheet
}

/// What each sensor reads in its own axes, g. `volts` is the output of every channel, the hammer first.
pub fn readings(
    volts: &[f64],
    record: &CalibrationRecord,
    identity: &Identity,
) -> Vec<Vector3<f64>> {
    let calibration = &record.calibration;
    let per_volt = |channel: usize| {
        f64::from(calibration.per_code(&identity.adc, channel))
            / f64::from(identity.adc.volts_per_code())
    };
    let reading = |channel: usize| {
        let zero = f64::from(calibration.channels[channel].zero.0);
        let volts = volts.get(channel).copied().unwrap_or(zero);
        per_volt(channel) * (volts - zero) / STANDARD_GRAVITY
    };
    let sensors = usize::from(identity.max_sensors).min(RESPONSES / 3);
    let first = |sensor: usize| HAMMER + 1 + 3 * sensor;
    (0..sensors).map(|sensor| Vector3::from_fn(|axis, _| reading(first(sensor) + axis))).collect()
}

/// The axis that points up or down, when a sensor reads this, g; `None` for one that is between two positions.
pub fn lies_as(reads: &Vector3<f64>) -> Option<Position> {
    let axis = reads.iamax();
    let others = reads.iter().enumerate().filter(|(k, _)| *k != axis).map(|(_, value)| value.abs());
    let is_one =
        others.fold(0.0, f64::max) < OTHERS_G && (reads[axis].abs() - 1.0).abs() < OTHERS_G;
    let points = |position: &Position| {
        position.up::<f64>()[axis] * reads[axis] > 0.0 && position.axis == Axis::ALL[axis]
    };
    Position::ALL.into_iter().find(points).filter(|_| is_one)
}

/// The first sensor, counted from 1, that lies in another position than it should, and how it lies, where the
/// calibration on the rig can tell.
pub fn find_misplaced_sensor(
    reading: &RestVoltages<f64>,
    position: Position,
    record: &CalibrationRecord,
    identity: &Identity,
) -> Option<(usize, Position)> {
    if !is_known(record) {
        return None;
    }
    let lies = readings(reading.mean(), record, identity);
    let mut lies =
        lies.iter().zip(1..).filter_map(|(reads, sensor)| Some((sensor, lies_as(reads)?)));
    lies.find(|(_, lies)| *lies != position)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sensor_lies_as_its_largest_axis_says_unless_it_is_not_aligned_with_one() {
        for position in Position::ALL {
            let reads = position.up::<f64>() + Vector3::new(0.02, -0.04, 0.03);
            assert_eq!(lies_as(&reads), Some(position));
        }
        assert_eq!(lies_as(&Vector3::new(0.7, 0.7, 0.0)), None);
        assert_eq!(lies_as(&Vector3::zeros()), None);
    }
}
