//! From readings and hits of a rig to its calibration.
//!
//! | module | subject |
//! | --- | --- |
//! | [`tumble`] | six static readings of all channels, kept in a file until they are whole |
//! | [`block`] | the result of a block test |
//! | [`cutoffs`] | the low-passes of the sensors, from the spectra of a block test |
//! | [`day`] | days of the calendar |
//! | [`verify`] | a block test against the calibration in force |
//!
//! Its file is [`crate::calibration_file`], the maths are in [`massline_shared::calibration`].

pub mod block;
pub mod cutoffs;
pub mod day;
pub mod tumble;
pub mod verify;

use massline_shared::calibration::CalibrationRecord;

/// Where a new calibration comes from, besides its method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    /// Day, `yyyy-mm-dd`.
    pub date: heapless::String<10>,
    /// Name of the hammer; empty leaves the one there is.
    pub hammer: heapless::String<12>,
    /// Names of the sensors, in the order of the inputs; fewer leave those there are.
    pub sensors: Vec<heapless::String<12>>,
    /// °C; none leaves the one there is.
    pub temperature: Option<f32>,
}

impl Origin {
    /// Becomes the origin of a calibration.
    pub fn write(&self, record: &mut CalibrationRecord) {
        record.date = self.date.clone();
        if self.temperature.is_some() {
            record.temperature = self.temperature;
        }
        if !self.hammer.is_empty() {
            record.hammer = self.hammer.clone();
        }
        for (to, from) in record.sensors.iter_mut().zip(&self.sensors) {
            *to = from.clone();
        }
    }
}
