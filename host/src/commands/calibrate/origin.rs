//! Where a calibration comes from.

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
