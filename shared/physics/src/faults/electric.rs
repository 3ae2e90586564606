//! The faults of the electrical chain, channel by channel.

use massline_shared::layout::Axis;
use massline_shared::signal::CHANNELS;

use super::Fault;
use crate::bench::Bench;
use crate::channels::{Channels, UNLIMITED};

/// How far each channel can move from its value at rest, N or m/s².
pub(crate) fn rails(bench: &Bench) -> Channels {
    let mut rails = UNLIMITED;
    for fault in &bench.faults {
        let (channel, limit) = match *fault {
            Fault::SensorRail { sensor, axis, limit_m_per_s2 } => {
                (channel(sensor, axis), limit_m_per_s2)
            }
            Fault::HammerRail { limit_n } => (0, limit_n),
            _ => continue,
        };
        if let Some(rail) = rails.get_mut(channel) {
            *rail = rail.min(limit);
        }
    }
    rails
}

/// Which channels compress softly.
pub(crate) fn compresses(bench: &Bench) -> [bool; CHANNELS] {
    let mut compresses = [false; CHANNELS];
    for fault in &bench.faults {
        if let Fault::Compression { sensor, axis } = *fault
            && let Some(compresses) = compresses.get_mut(channel(sensor, axis))
        {
            *compresses = true;
        }
    }
    compresses
}

/// Amplitude of the mains because of faults, V.
pub(crate) fn hum(bench: &Bench) -> f64 {
    let amplitude = |fault: &Fault| match *fault {
        Fault::Hum { amplitude_v } => amplitude_v,
        _ => 0.0,
    };
    bench.faults.iter().map(amplitude).sum()
}

/// The channel of a sensor's axis; beyond the last one when the rig has no such sensor.
fn channel(sensor: usize, axis: Axis) -> usize {
    sensor.saturating_mul(3).saturating_add(1 + axis.index())
}
