//! The layout and the calibration in use.

use super::{Activity, Measurement, StartError, TestLayout, note};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::{Applicability, Method, Methods};
use crate::layout::{TestSettings, assumed_body, check_settings};
use crate::signal::{AdcProperties, Calibration, RECORD_SCANS, RealFft, SPECTRUM_BINS};

impl<R: RealFft> Measurement<'_, R> {
    /// Reserves layout and calibration for a change that takes time: until [`Self::end_change`] nothing is
    /// started.
    ///
    /// # Errors
    /// [`StartError::WrongPhase`] unless nothing is measured, [`StartError::Busy`] during another change.
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

    /// Takes a layout into use; what was said and measured under an earlier one is forgotten. Only while
    /// nothing is measured.
    pub fn set_layout(&mut self, layout: TestLayout<R>) {
        self.ended = None;
        self.diagnostics.clear();
        self.averaged = None;
        self.last_hit = None;
        self.block = None;
        self.memory.forget_campaign();
        self.layout = Some(layout);
    }

    /// The layout in use.
    pub fn layout(&self) -> Option<&TestLayout<R>> {
        self.layout.as_ref()
    }

    /// Takes a calibration into use. Only while nothing is measured.
    pub fn set_calibration(&mut self, calibration: Calibration) {
        self.calibration = calibration;
        // What a block has said was about the calibration of before.
        self.block = None;
    }

    /// The calibration in force.
    pub fn calibration(&self) -> &Calibration {
        &self.calibration
    }

    /// The converter.
    pub fn adc(&self) -> &AdcProperties {
        &self.adc
    }

    /// The converter with only those channels that the layout has sensors for.
    pub fn adc_in_use(&self) -> AdcProperties {
        let sensors = self.layout.as_ref().map_or(0, |layout| layout.sensors.len());
        let responses = self.adc.responses().min(3 * sensors);
        AdcProperties { channels: responses as u8 + 1, ..self.adc }
    }

    /// What is to be said about a layout: errors when no method of a rig could give an answer, or when the
    /// converter cannot do it. The object is not known yet: any body about the sensors and hits tells what
    /// can be determined.
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
