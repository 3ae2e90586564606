//! The gains of the error budget: those that the file states, or those of the calibration.

use massline_shared::calibration::{CalibrationMethod, CalibrationRecord, CalibrationSigma};

use super::LayoutFile;

/// Which gains of the error budget a layout file states explicitly.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StatedGains {
    /// `hammer_gain`.
    pub hammer: bool,
    /// `gain` and `cross_axis` of each sensor.
    pub sensors: Vec<[bool; 2]>,
}

impl LayoutFile {
    /// Sets the gains that the file does not state to the uncertainties of a calibration. A calibration from
    /// data sheets or of unknown origin changes nothing.
    pub fn apply_budget(&mut self, record: &CalibrationRecord) {
        if matches!(record.method, CalibrationMethod::DataSheet | CalibrationMethod::Other) {
            return;
        }
        let CalibrationSigma { gain, cross_axis, hammer_gain } = record.sigma;
        for (sensor, [gain_stated, cross_stated]) in
            self.layout.sensors.iter_mut().zip(&self.stated.sensors)
        {
            if !gain_stated {
                sensor.uncertainty.gain = f64::from(gain);
            }
            if !cross_stated {
                sensor.uncertainty.cross_axis = f64::from(cross_axis);
            }
        }
        if !self.stated.hammer {
            self.layout.hammer_gain = f64::from(hammer_gain);
        }
    }
}
