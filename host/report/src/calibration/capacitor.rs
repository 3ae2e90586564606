//! The capacitor of a breakout board, in words.

use massline_analysis::calibration::capacitor::ExtraCapacitor;
use massline_result::Error;
use massline_shared::layout::AXIS_LETTERS;
use massline_shared::signal::Calibration;

/// A sentence about these axes, with what to do; `None` without any.
pub fn sentence(capacitors: &[ExtraCapacitor]) -> Option<String> {
    let lowest = capacitors.iter().min_by(|a, b| a.cutoff_hz.total_cmp(&b.cutoff_hz))?;
    let of_sensor = |chunk: &[ExtraCapacitor]| {
        let axes: Vec<String> = chunk
            .iter()
            .map(|one| format!("{} {:.0}", AXIS_LETTERS[one.axis], one.cutoff_hz))
            .collect();
        format!("sensor {} {} Hz", chunk[0].sensor + 1, axes.join(", "))
    };
    let sensors: Vec<String> =
        capacitors.chunk_by(|a, b| a.sensor == b.sensor).map(of_sensor).collect();
    Some(format!(
        "cutoffs are too low ({}): the breakout's own capacitor is still in place. Behind the 32 kΩ in each output of \
         the ADXL326, {:.0} nF make {:.0} Hz, and the rig's 10 nF alone {:.0} Hz; take the breakout's capacitors off \
         (often 100 nF, one at each output), leave the rig's 10 nF, and calibrate again",
        sensors.join("; "),
        1e9 * lowest.farad(),
        lowest.cutoff_hz,
        Calibration::RC_CUTOFF.0,
    ))
}

/// The error for axes whose cutoff has turned out to be low; `None` when every low cutoff is already that of the
/// calibration in force.
pub fn refusal(capacitors: &[ExtraCapacitor]) -> Option<Error> {
    let new: Vec<ExtraCapacitor> = capacitors.iter().copied().filter(|one| one.is_new).collect();
    sentence(&new).map(|text| Error::undetermined("breakout_capacitor", text))
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_analysis::calibration::capacitor::extra_capacitors;
    use massline_analysis::calibration::cutoffs::{FoundCutoff, RcCutoff};

    fn cutoff(axis: usize, cutoff_hz: f64, changed: bool) -> RcCutoff {
        let measured = Ok(FoundCutoff { cutoff_hz, sigma_hz: 1.0, changed });
        RcCutoff { sensor: 1, axis, before_hz: 497.4, found: measured }
    }

    #[test]
    fn a_hundred_nanofarads_are_named_with_sensor_and_axis() {
        let capacitors = extra_capacitors(&[cutoff(0, 49.7, true), cutoff(1, 497.0, false)]);
        // 1 / (2π · 32 kΩ · 49.7 Hz) = 100.07 nF.
        assert!((capacitors[0].farad() - 100.07e-9).abs() < 0.01e-9, "{capacitors:?}");
        let error = refusal(&capacitors).unwrap();
        assert_eq!((error.code(), error.exit_code()), ("breakout_capacitor", 3));
        let text = error.to_string();
        assert!(
            text.contains("(sensor 2 x 50 Hz)") && text.contains("100 nF make 50 Hz"),
            "{text}"
        );
    }

    #[test]
    fn a_low_cutoff_that_the_calibration_knows_is_no_error() {
        let capacitors = extra_capacitors(&[cutoff(2, 60.0, false)]);
        assert_eq!(refusal(&capacitors), None);
        assert!(sentence(&capacitors).unwrap().contains("sensor 2 z 60 Hz"));
    }

    #[test]
    fn the_tolerance_of_the_output_resistance_is_no_capacitor() {
        // 32 kΩ + 15 % leave 432 Hz; the 1 nF of ten metres of cable takes another tenth.
        assert_eq!(extra_capacitors(&[cutoff(0, 432.0, true), cutoff(1, 393.0, true)]), []);
    }
}
