//! Holds a block test against the data sheet of the sensors and the calibration in force, before it is stored.
//!
//! All ratios of a block test are proportional to the mass that was typed in, so a wrong mass makes all of them
//! wrong by one factor, which shows against anything that is known otherwise: the hammer's gain in force where a
//! tumble test has calibrated the sensors, the data sheet of the sensors where none has.

use massline_shared::STANDARD_GRAVITY;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::signal::Calibration;

use super::block::Block;
use crate::{Error, Result};
use massline_report::words::channel_name;

/// Largest factor between a sensitivity and what is known about it. The data sheet of the ADXL326 permits 10 %,
/// and force transducers are sold within 15 %.
const MOST: f64 = 1.25;

/// Sensitivity by the data sheet, V per standard gravity.
const DATA_SHEET: f64 = Calibration::ADXL326_VOLT_PER_G;

/// Refuses a block test whose result cannot be right. With `new_hammer` the hammer is another than the one of the
/// calibration in force.
///
/// # Errors
/// Exit 3 with the mass that would agree, or with the sensor that does not.
pub fn check(found: &Block, before: &CalibrationRecord, mass: f64, new_hammer: bool) -> Result<()> {
    check_mass(found, before, mass, new_hammer)?;
    if found.hammer.is_some() {
        return Ok(());
    }
    let ratios = against_data_sheet(found, before);
    let Some(median) = median(&ratios) else { return Ok(()) };
    let far = |of_sensor: &[f64; 3]| of_sensor.iter().position(|ratio| !is_near(ratio / median));
    match ratios.iter().enumerate().find_map(|(k, of_sensor)| Some((k, far(of_sensor)?))) {
        None => Ok(()),
        Some((sensor, axis)) => Err(Error::undetermined(
            "sensor_disagrees",
            format!(
                "{} would have {:.2} times the sensitivity of its data sheet ({DATA_SHEET:.3} V/g), unlike the others: check \
                 its type, cable and supply",
                channel_name(1 + 3 * sensor + axis),
                ratios[sensor][axis],
            ),
        )),
    }
}

/// Least ratio that a mistyped mass explains: a thousandth is that of grams typed as kilograms.
const LEAST_RATIO: f64 = 1e-4;

/// Refuses a ratio that no mass explains: one that is negative or nearly zero.
fn check_sign(ratio: f64) -> Result<()> {
    if ratio >= LEAST_RATIO {
        return Ok(());
    }
    let what = if ratio < 0.0 { "oppose" } else { "hardly follow" };
    Err(Error::undetermined(
        "no_mass_agrees",
        format!(
            "the accelerations {what} the force ({ratio:.2e} of what is expected), which no mass explains: \
             check that hammer and sensors are connected as the layout says, and that each hit has the direction \
             of its DOF"
        ),
    ))
}

/// Refuses a block test whose ratios are all wrong by one factor, as those of a wrong mass are.
///
/// # Errors
/// Exit 3 with the mass that would agree.
pub fn check_mass(
    found: &Block,
    before: &CalibrationRecord,
    mass: f64,
    new_hammer: bool,
) -> Result<()> {
    if let Some(hammer) = &found.hammer {
        if is_near(hammer.ratio) {
            return Ok(());
        }
        check_sign(hammer.ratio)?;
        if new_hammer {
            return Ok(());
        }
        return Err(Error::undetermined(
            "mass_disagrees",
            format!(
                "with a block of {mass} kg the hammer's force would be {:.2} times what its calibration \
                 says; with the sensors as the tumble test found them, a block of {:.3} kg agrees: check \
                 --mass, or calibrate with `calibrate block --new-hammer` if the hammer is not the one of the \
                 calibration",
                hammer.ratio,
                mass / hammer.ratio,
            ),
        ));
    }
    let median = median(&against_data_sheet(found, before));
    median.map_or(Ok(()), check_sign)?;
    match median {
        Some(median) if !is_near(median) => Err(Error::undetermined(
            "mass_disagrees",
            format!(
                "with a block of {mass} kg the sensors would have {median:.2} times the sensitivity of their \
                 data sheet ({DATA_SHEET:.3} V/g); a block of {:.3} kg agrees with it: check --mass, then the hammer's \
                 sensitivity in the calibration{}",
                mass / median,
                if median < 1.0 {
                    ", then whether a breakout's own capacitor is in place"
                } else {
                    ""
                },
            ),
        )),
        _ => Ok(()),
    }
}

/// The middle of all ratios.
fn median(ratios: &[[f64; 3]]) -> Option<f64> {
    let mut sorted: Vec<f64> = ratios.iter().flatten().copied().collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied()
}

/// True for a ratio near one.
fn is_near(ratio: f64) -> bool {
    (1.0 / MOST..=MOST).contains(&ratio)
}

/// Sensitivity of each axis as the block test finds it over that of the data sheet.
fn against_data_sheet(found: &Block, before: &CalibrationRecord) -> Vec<[f64; 3]> {
    let nominal = DATA_SHEET / STANDARD_GRAVITY;
    let of = |(k, sensor): (usize, &massline_shared::calibration::block::SensorRatio<f64>)| {
        let sensitivity = before.calibration.sensor_sensitivity(k) * sensor.ratio;
        [0, 1, 2].map(|axis| sensitivity[(axis, axis)] / nominal)
    };
    found.sensors.iter().enumerate().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibration::electronics::Electronics;
    use massline_shared::calibration::block::{ForceRatio, SensorRatio};
    use nalgebra::Matrix3;

    fn block(ratios: [f64; 3], hammer: Option<f64>) -> Block {
        let of = |ratio: f64| SensorRatio {
            ratio: Matrix3::identity() * ratio,
            sigma: Matrix3::repeat(0.001),
        };
        let hammer = hammer.map(|ratio| ForceRatio { ratio, sigma: 0.001, departure: (0.0, 1.0) });
        Block {
            sensors: ratios.map(of).to_vec(),
            hammer,
            cutoffs: Vec::new(),
            electronics: Electronics::default(),
            warnings: Vec::new(),
        }
    }

    fn said(ratios: [f64; 3], hammer: Option<f64>, mass: f64, new_hammer: bool) -> String {
        let record = CalibrationRecord::default();
        match check(&block(ratios, hammer), &record, mass, new_hammer) {
            Ok(()) => String::new(),
            Err(error) => error.to_string(),
        }
    }

    #[test]
    fn a_mass_with_a_lost_point_is_refused_with_the_mass_that_agrees() {
        // 20 kg typed for 2.0 kg makes every ratio ten times too large.
        let text = said([10.0, 10.2, 9.9], None, 20.0, false);
        assert!(text.contains("a block of 2.000 kg"), "{text}");
        let text = said([1.0; 3], Some(10.0), 20.0, false);
        assert!(text.contains("a block of 2.000 kg") && text.contains("--new-hammer"), "{text}");
    }

    #[test]
    fn another_hammer_is_taken_when_it_is_announced() {
        assert_eq!(said([1.0; 3], Some(10.0), 2.0, true), "");
        assert_eq!(said([1.0; 3], Some(1.1), 2.0, false), "");
    }

    #[test]
    fn no_mass_is_proposed_for_a_reversed_or_a_dead_channel() {
        for ratio in [-1.0, 1e-6] {
            for text in [
                said([ratio; 3], None, 2.0, false),
                said([1.0; 3], Some(ratio), 2.0, false),
                said([1.0; 3], Some(ratio), 2.0, true),
            ] {
                assert!(text.contains("no mass explains"), "{text}");
            }
        }
    }

    #[test]
    fn parts_within_their_data_sheets_are_accepted_and_another_type_is_named() {
        assert_eq!(said([1.08, 0.93, 1.02], None, 2.0, false), "");
        let text = said([1.0, 5.3, 1.0], None, 2.0, false);
        assert!(text.contains("sensor 2 x"), "{text}");
    }
}
