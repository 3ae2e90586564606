//! The layout and the calibration in use.

use super::{Activity, Measurement, StartError, TestLayout, note};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::{Applicability, Method, Methods};
use crate::layout::{TestSettings, assumed_body, check_settings};
use crate::signal::{AdcProperties, Calibration, RECORD_SCANS, RealFft, SPECTRUM_BINS};

impl<R: RealFft> Measurement<'_, R> {
    /// Reserves layout and calibration for a change that takes time: nothing can be started until
    /// [`Self::end_change`].
    ///
    /// # Errors
    /// [`StartError::WrongPhase`] unless the rig is idle, [`StartError::Busy`] during another change.
    pub fn begin_change(&mut self) -> Result<(), StartError> {
        match self.activity {
            Activity::Idle => {
                self.activity = Activity::Changing;
                Ok(())
            }
            Activity::Changing => Err(StartError::Busy),
            _ => Err(StartError::WrongPhase),
        }
    }

    /// Ends a change.
    pub fn end_change(&mut self) {
        if let Activity::Changing = self.activity {
            self.activity = Activity::Idle;
        }
    }

    /// Replaces the layout and discards the diagnostics and data of the previous one. Allowed only while the
    /// rig is idle.
    pub fn set_layout(&mut self, layout: TestLayout<R>) {
        self.ended = None;
        self.diagnostics.clear();
        self.averaged = None;
        self.last_hit = None;
        self.block = None;
        self.memory.discard_campaign();
        self.layout = Some(layout);
    }

    /// The layout in use.
    pub fn layout(&self) -> Option<&TestLayout<R>> {
        self.layout.as_ref()
    }

    /// Replaces the calibration. Allowed only while the rig is idle.
    pub fn set_calibration(&mut self, calibration: Calibration) {
        self.calibration = calibration;
        // The result of a block test refers to the previous calibration.
        self.block = None;
    }

    /// The calibration in use.
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// Properties of the converter.
    pub fn adc(&self) -> &AdcProperties {
        &self.adc
    }

    /// Properties of the converter, reduced to the channels of the sensors in the layout.
    pub fn adc_in_use(&self) -> AdcProperties {
        let sensors = self.layout.as_ref().map_or(0, |layout| layout.sensors.len());
        let responses = self.adc.responses().min(3 * sensors);
        AdcProperties { channels: responses as u8 + 1, ..self.adc }
    }

    /// Findings about a layout: errors when no method of a rig could give an estimate, or when the converter
    /// cannot do it. The object is still unknown; an assumed body about the sensors and hits shows what can
    /// be determined.
    pub fn check(&self, layout: &TestLayout<R>) -> Diagnostics {
        let sensors = layout.sensors.iter().map(|sensor| sensor.position);
        let places = sensors.chain(layout.hits.iter().map(|hit| hit.position));
        let methods: Methods = Method::of_mass_lines().collect();
        let body = assumed_body(None, places);
        let mut diagnostics = Applicability::new(layout, &body, &methods).diagnostics;
        let rate = R::of(f64::from(self.adc.rate.0));
        for found in check_settings(&layout.test, rate, RECORD_SCANS, SPECTRUM_BINS) {
            note(&mut diagnostics, found);
        }
        if layout.sensors.len() * 3 > self.adc.responses() {
            let channels = self.adc.responses() as f32;
            let missing = Diagnostic::whole(Code::SettingOutOfRange, Severity::Error, channels);
            note(&mut diagnostics, missing);
        }
        diagnostics
    }

    /// The settings of the test.
    pub(super) fn test(&self) -> TestSettings<R> {
        self.layout.as_ref().map_or_else(TestSettings::default, |layout| layout.test)
    }
}
