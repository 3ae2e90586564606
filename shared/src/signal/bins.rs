//! Where the bins of a profile lie.

use super::{AdcProperties, DECIMATION, LONG_POINTS, PRE_TRIGGER_SCANS, RECORD_SCANS};
use crate::layout::TestProfile;
use crate::real::Real;

/// Rate of the responses and number of points of their transform, for this many scans per second: those of a whole
/// record, or of the long record's pieces.
pub fn transform_of(rate: f32, profile: TestProfile) -> (f32, usize) {
    match profile {
        TestProfile::MassLine => (rate, RECORD_SCANS),
        TestProfile::Suspension => (rate / DECIMATION as f32, LONG_POINTS),
    }
}

/// Spacing of the bins of the averaged spectra, Hz.
///
/// ```
/// # use massline_shared::layout::TestProfile;
/// # use massline_shared::signal::{AdcProperties, resolution};
/// # use massline_shared::units::*;
/// # let adc = AdcProperties { rate: Hertz(4000.0), channels: 10, bits: 12,
/// #     reference: Volts(3.0), channel_delay: Seconds(1e-5) };
/// assert_eq!(resolution::<f64>(&adc, TestProfile::MassLine), 1.953_125);
/// assert_eq!(resolution::<f64>(&adc, TestProfile::Suspension), 0.097_656_25);
/// ```
pub fn resolution<R: Real>(adc: &AdcProperties, profile: TestProfile) -> R {
    let (rate, points) = transform_of(adc.rate.0, profile);
    R::of(f64::from(rate)) / R::of(points as f64)
}

/// How long the responses of a long record are taken from the trigger on, s: 39.4 s at 4 kS/s.
pub fn ringing_s(adc: &AdcProperties) -> f64 {
    (RECORD_SCANS - PRE_TRIGGER_SCANS) as f64 / f64::from(adc.of_rows().rate.0)
}
