//! A record of a hit in physical units.

use massline_shared::signal::{
    AdcProperties, CHANNELS, Calibration, HAMMER, RESPONSES, Samples, Scan,
};

/// What turns the codes of a rig into readings.
#[derive(Clone, Copy, Debug)]
pub struct Chain<'a> {
    /// The calibration in force.
    pub calibration: &'a Calibration,
    /// The converter.
    pub adc: AdcProperties,
    /// Scans before the trigger.
    pub pre_trigger_scans: u16,
}

/// Force and accelerations of a hit without their rest values, scan by scan.
#[derive(Clone, Debug, PartialEq)]
pub struct Readings {
    /// The force, N.
    pub force: Vec<f64>,
    /// The acceleration of each axis, m/s², without cross-axis sensitivity; zeros for a channel that the rig does not
    /// have.
    pub responses: Vec<Vec<f64>>,
}

impl Chain<'_> {
    /// The readings of a record.
    pub fn readings(&self, codes: &[Scan]) -> Readings {
        let mut channels = (0..CHANNELS).map(|channel| self.of_channel(codes, channel));
        let force = channels.by_ref().take(HAMMER + 1).last().unwrap_or_default();
        let mut responses: Vec<Vec<f64>> = channels.collect();
        for scan in 0..codes.len() {
            let mut readings = [0.0; RESPONSES];
            for (to, from) in readings.iter_mut().zip(&responses) {
                *to = from[scan];
            }
            self.calibration.undo_cross_axis(&mut readings);
            for (to, from) in responses.iter_mut().zip(readings) {
                to[scan] = from;
            }
        }
        Readings { force, responses }
    }

    /// The readings of a channel without its rest value.
    fn of_channel(&self, codes: &[Scan], channel: usize) -> Vec<f64> {
        let scale = f64::from(self.calibration.per_code(&self.adc, channel));
        let readings = Samples::<f64>::readings(codes, channel, 0);
        let mut values: Vec<f64> = readings.map(|code| scale * code).collect();
        // The scans next to the trigger may belong to the hit.
        let rest = (usize::from(self.pre_trigger_scans) * 7 / 8).clamp(1, values.len().max(1));
        let mean = values.iter().take(rest).sum::<f64>() / rest as f64;
        values.iter_mut().for_each(|value| *value -= mean);
        values
    }
}
