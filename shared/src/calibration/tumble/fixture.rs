//! The converter of the unit tests.

use crate::signal::AdcProperties;
use crate::units::{Hertz, Seconds, Volts};

/// Two sensors and a hammer on 12 bits of 3 V.
pub(super) const ADC: AdcProperties = AdcProperties {
    rate: Hertz(4000.0),
    channels: 7,
    bits: 12,
    reference: Volts(3.0),
    channel_delay: Seconds(1e-5),
};
