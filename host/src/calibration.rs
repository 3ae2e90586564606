//! From a rig's static readings and hits to its calibration.
//!
//! | module | subject |
//! | --- | --- |
//! | [`tumble`] | six static readings of all channels, stored in a file until the set is complete |
//! | [`block`] | the result of a block test |
//! | [`cutoffs`] | the low-passes of the sensors, from the spectra of a block test |
//! | [`capacitor`] | low-passes that are too slow: the breakout's own capacitor |
//! | [`electronics`] | what both tests show of multiplexer and converter |
//! | [`plausible`] | the result of a block test against data sheet and tumble test |
//! | [`verify`] | a block test that checks the calibration in force |
//!
//! The file format is in [`massline_files::calibration_file`], the mathematics in [`massline_shared::calibration`].

pub mod block;
pub mod capacitor;
pub mod cutoffs;
pub mod electronics;
pub mod orientation;
pub mod plausible;
pub mod tumble;
pub mod verify;

use massline_shared::calibration::CalibrationRecord;

/// The origin of a new calibration, except its method.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    /// Date, `yyyy-mm-dd`.
    pub date: heapless::String<10>,
    /// Name of the hammer; an empty name leaves the present one.
    pub hammer: heapless::String<12>,
    /// Names of the sensors, in the order of the inputs; sensors beyond the list keep their names.
    pub sensors: Vec<heapless::String<12>>,
    /// Temperature, °C; `None` leaves the present one.
    pub temperature: Option<f32>,
}

impl Origin {
    /// Writes the origin to a calibration.
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
