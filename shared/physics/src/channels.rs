//! Values of all channels: the hammer, then the axes of the sensors.

use massline_shared::signal::CHANNELS;

/// One value per channel.
pub type Channels = [f64; CHANNELS];

/// Limits of channels that have none.
pub(super) const UNLIMITED: Channels = [f64::INFINITY; CHANNELS];

/// Outputs of the low-passes at the instants at which the channels are sampled.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampledOutputs {
    /// N and m/s².
    pub(super) value: Channels,
    /// Rates of change, N/s and m/s³.
    pub(super) slope: Channels,
}

/// One value for the hammer, one for all sensors.
pub(super) fn per_channel(hammer: f64, sensor: f64) -> Channels {
    std::array::from_fn(|k| if k == 0 { hammer } else { sensor })
}
