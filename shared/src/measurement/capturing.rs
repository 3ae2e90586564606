//! The capture of a hit under either profile.

use crate::layout::TestProfile;
use crate::signal::{
    AdcProperties, Calibration, Capture, CaptureState, FullRateExtremes, LongCapture, Record, Scan,
    Trigger,
};
use crate::units::{Newtons, ScanIndex};

/// The capture of a hit.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "there is one at a time, and no allocator")]
pub(super) enum HitCapture {
    /// Of half a second.
    MassLine(Capture),
    /// Of forty seconds.
    Long(LongCapture),
}

impl HitCapture {
    /// An armed capture; the record must be [waiting](Record::begin_wait).
    pub fn new(
        adc: &AdcProperties,
        calibration: &Calibration,
        level: Newtons,
        profile: TestProfile,
    ) -> Self {
        let trigger = Trigger::new(adc, calibration, level);
        match profile {
            TestProfile::MassLine => Self::MassLine(Capture::new(trigger)),
            TestProfile::Suspension => Self::Long(LongCapture::new(trigger, adc)),
        }
    }

    /// Takes the next scan into the record.
    pub fn feed(&mut self, record: &mut Record, scan: &Scan, index: ScanIndex) -> CaptureState {
        match self {
            Self::MassLine(capture) => capture.feed(record, scan, index),
            Self::Long(capture) => capture.feed(record, scan, index),
        }
    }

    /// Extremes at the full rate of a long record.
    pub fn extremes(&self) -> Option<FullRateExtremes> {
        match self {
            Self::MassLine(_) => None,
            Self::Long(capture) => Some(*capture.extremes()),
        }
    }
}
