//! Why a block test is refused, in words.

use massline_analysis::calibration::plausible::Implausibility;
use massline_result::Error;
use massline_shared::signal::Calibration;

use crate::words::channel_name;

/// Sensitivity by the data sheet, V per standard gravity.
const DATA_SHEET: f64 = Calibration::ADXL326_VOLT_PER_G;

/// The error, with the mass that would agree or the channel that does not.
pub fn refusal(implausible: &Implausibility) -> Error {
    match *implausible {
        Implausibility::NoMassAgrees { ratio } => Error::undetermined(
            "no_mass_agrees",
            format!(
                "the accelerations {} the force ({ratio:.2e} of what is expected), which no mass explains: check that \
                 hammer and sensors are connected as the layout says, and that each hit has the direction of its DOF",
                if ratio < 0.0 { "oppose" } else { "hardly follow" },
            ),
        ),
        Implausibility::HammerDisagrees { mass, ratio } => Error::undetermined(
            "mass_disagrees",
            format!(
                "with a block of {mass} kg the hammer's force would be {ratio:.2} times what its calibration says; \
                 with the sensors as the tumble test found them, a block of {:.3} kg agrees: check --mass, or \
                 calibrate with `calibrate block --new-hammer` if the hammer is not the one of the calibration",
                mass / ratio,
            ),
        ),
        Implausibility::SensorsDisagree { mass, ratio } => Error::undetermined(
            "mass_disagrees",
            format!(
                "with a block of {mass} kg the sensors would have {ratio:.2} times the sensitivity of their data sheet \
                 ({DATA_SHEET:.3} V/g); a block of {:.3} kg agrees with it: check --mass, then the hammer's \
                 sensitivity in the calibration{}",
                mass / ratio,
                if ratio < 1.0 {
                    ", then whether a breakout's own capacitor is in place"
                } else {
                    ""
                },
            ),
        ),
        Implausibility::ChannelDisagrees { channel, ratio } => Error::undetermined(
            "sensor_disagrees",
            format!(
                "{} would have {ratio:.2} times the sensitivity of its data sheet ({DATA_SHEET:.3} V/g), unlike the \
                 others: check its type, cable and supply",
                channel_name(channel),
            ),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_analysis::calibration::block::Block;
    use massline_analysis::calibration::electronics::Electronics;
    use massline_analysis::calibration::plausible::find_implausibility;
    use massline_shared::calibration::CalibrationRecord;
    use massline_shared::calibration::block::{ForceRatio, SensorRatio};
    use nalgebra::Matrix3;

    fn block(ratios: [f64; 3], hammer: Option<f64>) -> Block {
        let sensor = |ratio: f64| SensorRatio {
            ratio: Matrix3::identity() * ratio,
            sigma: Matrix3::repeat(0.001),
        };
        let hammer = hammer.map(|ratio| ForceRatio { ratio, sigma: 0.001, departure: (0.0, 1.0) });
        Block {
            sensors: ratios.map(sensor).to_vec(),
            hammer,
            cutoffs: Vec::new(),
            electronics: Electronics::default(),
            warnings: Vec::new(),
        }
    }

    fn refusal_text(ratios: [f64; 3], hammer: Option<f64>, mass: f64, new_hammer: bool) -> String {
        let record = CalibrationRecord::default();
        let implausibility = find_implausibility(&block(ratios, hammer), &record, mass, new_hammer);
        implausibility.as_ref().map_or(String::new(), |why| refusal(why).to_string())
    }

    #[test]
    fn a_mass_with_a_lost_point_is_refused_with_the_mass_that_agrees() {
        // 20 kg typed for 2.0 kg makes every ratio ten times too large.
        let text = refusal_text([10.0, 10.2, 9.9], None, 20.0, false);
        assert!(text.contains("a block of 2.000 kg"), "{text}");
        let text = refusal_text([1.0; 3], Some(10.0), 20.0, false);
        assert!(text.contains("a block of 2.000 kg") && text.contains("--new-hammer"), "{text}");
    }

    #[test]
    fn another_hammer_is_taken_when_it_is_announced() {
        assert_eq!(refusal_text([1.0; 3], Some(10.0), 2.0, true), "");
        assert_eq!(refusal_text([1.0; 3], Some(1.1), 2.0, false), "");
    }

    #[test]
    fn no_mass_is_proposed_for_a_reversed_or_a_dead_channel() {
        for ratio in [-1.0, 1e-6, f64::NAN] {
            for text in [
                refusal_text([ratio; 3], None, 2.0, false),
                refusal_text([1.0; 3], Some(ratio), 2.0, false),
                refusal_text([1.0; 3], Some(ratio), 2.0, true),
            ] {
                assert!(text.contains("no mass explains"), "{text}");
            }
        }
    }

    #[test]
    fn parts_within_their_data_sheets_are_accepted_and_another_type_is_named() {
        assert_eq!(refusal_text([1.08, 0.93, 1.02], None, 2.0, false), "");
        let text = refusal_text([1.0, 5.3, 1.0], None, 2.0, false);
        assert!(text.contains("sensor 2 x"), "{text}");
    }
}
