//! Holds a block test against the data sheet of the sensors and the calibration in force, before it is stored.
//!
//! All ratios of a block test are proportional to the mass that was typed in, so a wrong mass makes all of them
//! wrong by one factor, which shows against anything that is known otherwise: the hammer's gain in force where a
//! tumble test has calibrated the sensors, the data sheet of the sensors where none has.

use massline_shared::STANDARD_GRAVITY;
use massline_shared::calibration::CalibrationRecord;
use massline_shared::calibration::block::SensorRatio;
use massline_shared::signal::Calibration;

use super::block::Block;

/// Largest factor between a sensitivity and what is known about it. The data sheet of the ADXL326 permits 10 %,
/// and force transducers are sold within 15 %.
const MOST: f64 = 1.25;
/// Least ratio that a mistyped mass explains: a thousandth is that of grams typed as kilograms.
const LEAST_RATIO: f64 = 1e-4;

/// Why the result of a block test cannot be right.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Implausibility {
    /// The accelerations oppose the force or hardly follow it, which no mass explains.
    NoMassAgrees {
        /// Acceleration over what is expected.
        ratio: f64,
    },
    /// With the mass, kg, the hammer's force would be this many times what its calibration says.
    HammerDisagrees {
        /// The mass that was stated, kg.
        mass: f64,
        /// Force over that of the calibration.
        ratio: f64,
    },
    /// With the mass, kg, all sensors would have this many times the sensitivity of their data sheet.
    SensorsDisagree {
        /// The mass that was stated, kg.
        mass: f64,
        /// Sensitivity over that of the data sheet: the middle of all axes.
        ratio: f64,
    },
    /// One channel has another sensitivity than the others.
    ChannelDisagrees {
        /// The channel.
        channel: usize,
        /// Sensitivity over that of the data sheet.
        ratio: f64,
    },
}

/// Why a block test cannot be right, if so. With `new_hammer` the hammer is another than the one of the
/// calibration in force.
pub fn find_implausibility(
    block: &Block,
    before: &CalibrationRecord,
    mass: f64,
    new_hammer: bool,
) -> Option<Implausibility> {
    let wrong_mass = find_wrong_mass(block, before, mass, new_hammer);
    if wrong_mass.is_some() || block.hammer.is_some() {
        return wrong_mass;
    }
    let ratios = against_data_sheet(block, before);
    let median = median(&ratios)?;
    let mut channels = ratios.iter().flatten().copied().zip(1..);
    let (ratio, channel) = channels.find(|(ratio, _)| !is_near(ratio / median))?;
    Some(Implausibility::ChannelDisagrees { channel, ratio })
}

/// Why the mass cannot be right: all ratios are wrong by one factor, as those of a wrong mass are.
pub fn find_wrong_mass(
    block: &Block,
    before: &CalibrationRecord,
    mass: f64,
    new_hammer: bool,
) -> Option<Implausibility> {
    let (ratio, is_expected) = match &block.hammer {
        Some(hammer) => (hammer.ratio, new_hammer),
        None => (median(&against_data_sheet(block, before))?, false),
    };
    if is_near(ratio) {
        None
    } else if ratio.is_nan() || ratio < LEAST_RATIO {
        Some(Implausibility::NoMassAgrees { ratio })
    } else if is_expected {
        None
    } else if block.hammer.is_some() {
        Some(Implausibility::HammerDisagrees { mass, ratio })
    } else {
        Some(Implausibility::SensorsDisagree { mass, ratio })
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
fn against_data_sheet(block: &Block, before: &CalibrationRecord) -> Vec<[f64; 3]> {
    let nominal = Calibration::ADXL326_VOLT_PER_G / STANDARD_GRAVITY;
    let axis_ratios = |(k, sensor): (usize, &SensorRatio<f64>)| {
        let sensitivity = before.calibration.sensor_sensitivity(k) * sensor.ratio;
        [0, 1, 2].map(|axis| sensitivity[(axis, axis)] / nominal)
    };
    block.sensors.iter().enumerate().map(axis_ratios).collect()
}
