//! The layout and the calibration in use.

use super::{Activity, Measurement, StartError, TestLayout, note};
use crate::calibration::{CalibrationSigma, without_calibration};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::{Applicability, Method, Methods};
use crate::layout::{TestProfile, TestSettings, assumed_body, check_settings};
use crate::signal::{AdcProperties, Calibration, RealFft, SPECTRUM_BINS, transform_of};

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
        self.precision = None;
        self.last_accepted.forget();
        self.memory.discard_campaign();
        self.layout = Some(layout);
    }

    /// The layout as it was given to [`Self::set_layout`].
    pub fn stated_layout(&self) -> Option<TestLayout<R>> {
        let mut layout = self.layout.clone()?;
        without_calibration(&mut layout);
        Some(layout)
    }

    /// The layout in use: the standard deviations that the calibration supplies are those of the last
    /// campaign.
    pub fn layout(&self) -> Option<&TestLayout<R>> {
        self.layout.as_ref()
    }

    /// Replaces the calibration; `gains` is [what it contributes to the error
    /// budget](crate::calibration::CalibrationRecord::budget). Allowed only while the rig is idle.
    pub fn set_calibration(&mut self, calibration: Calibration, gains: Option<CalibrationSigma>) {
        self.calibration = calibration;
        self.gains = gains;
        // The result of a block test refers to the previous calibration.
        self.block = None;
    }

    /// What the calibration contributes to the error budget of the present campaign.
    pub(super) fn gains(&self) -> Option<CalibrationSigma> {
        let days = self.campaign().map_or(0, |campaign| campaign.started().calibration_age_days);
        self.gains.map(|gains| gains.aged(days))
    }

    /// Supplies the standard deviations that the layout takes from the calibration.
    pub(super) fn take_gains(&mut self) {
        let gains = self.gains();
        if let Some(layout) = &mut self.layout {
            match gains {
                Some(gains) => gains.apply_to(layout),
                None => without_calibration(layout),
            }
        }
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
        let profile = layout.test.profile;
        let methods: Methods = match profile {
            TestProfile::MassLine => Method::of_mass_lines().collect(),
            TestProfile::Suspension => Method::of_modes().collect(),
        };
        let body = assumed_body(None, places);
        let mut diagnostics = Applicability::new(layout, &body, &methods).findings(profile);
        let (rate, points) = transform_of(self.adc.rate.0, profile);
        let rate = R::of(f64::from(rate));
        for diagnostic in check_settings(&layout.test, rate, points, SPECTRUM_BINS) {
            note(&mut diagnostics, diagnostic);
        }
        if layout.sensors.len() * 3 > self.adc.responses() {
            let channels = self.adc.responses() as f32;
            let missing = Diagnostic::whole(Code::SettingOutOfRange, Severity::Error, channels);
            note(&mut diagnostics, missing);
        }
        diagnostics
    }

    /// Scatter of the accelerances from hit to hit at a DOF that the layout states, relative.
    pub(super) fn expected_scatter(&self, dof: usize) -> R {
        let Some(layout) = &self.layout else { return R::zero() };
        let hit = layout.hits.get(dof).map(|hit| hit.uncertainty);
        let distance = layout.characteristic_length();
        hit.map_or_else(R::zero, |hit| hit.relative_scatter(distance))
    }

    /// The profile of the layout.
    pub fn profile(&self) -> TestProfile {
        self.layout.as_ref().map_or_else(TestProfile::default, |layout| layout.test.profile)
    }

    /// True in the suspension profile.
    pub(super) fn is_long(&self) -> bool {
        self.profile() == TestProfile::Suspension
    }

    /// The settings of the test.
    pub(super) fn test(&self) -> TestSettings<R> {
        self.layout.as_ref().map_or_else(TestSettings::default, |layout| layout.test)
    }
}
