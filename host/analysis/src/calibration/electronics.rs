//! What calibrations show of the electronics between the sensors and the codes: memory of the multiplexer and
//! asymmetry.
//!
//! | seen | in | as |
//! | --- | --- | --- |
//! | what the hammer's channel keeps of the sensor axis before it | tumble test | change of the hammer's rest level |
//! | what a sensor axis keeps of the hammer before it | block test, both sides | a response with the sign of the force |
//! | a slope that differs above and below the rest level | block test, both sides | responses that differ from side to side |
//!
//! What a sensor axis keeps of another one cannot be told from its cross-axis sensitivity, and what nonlinearity does
//! to both sides alike cannot be told from a gain. Which channel comes before which depends on the board.

use massline_shared::EstimatedValue;
use massline_shared::calibration::memory::{LARGE_MEMORY, kept_by_hammer};
use massline_shared::calibration::opposite_hits::OppositeHits;
use massline_shared::calibration::tumble::{Position, RestVoltages};
use massline_shared::signal::{CHANNELS, HAMMER};
use nalgebra::Vector3;

/// A value of more standard deviations than this is significant.
const SIGNIFICANT: f64 = 4.0;
/// Difference between responses to pushes from opposite sides above which it matters: it changes single responses
/// by half as much, which is a quarter of the default uncertainty of a gain.
pub const LARGE_ASYMMETRY: f64 = 0.005;

/// For each converter of a rig, the channels in the order in which it converts them, over and over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConversionOrder(pub Vec<Vec<u8>>);

impl ConversionOrder {
    /// The channel that is converted before this one; `None` for an input of constant voltage.
    pub fn before(&self, channel: usize) -> Option<usize> {
        self.neighbor(channel, |at, count| (at + count - 1) % count)
    }

    /// The channel that is converted after this one, by the same converter.
    pub fn after(&self, channel: usize) -> Option<usize> {
        self.neighbor(channel, |at, count| (at + 1) % count)
    }

    fn neighbor(&self, channel: usize, step: fn(usize, usize) -> usize) -> Option<usize> {
        let has_channel = |&converted: &u8| usize::from(converted) == channel;
        let converter = self.0.iter().find(|channels| channels.iter().any(has_channel))?;
        let at = converter.iter().position(has_channel)?;
        let other = usize::from(*converter.get(step(at, converter.len()))?);
        let is_channel = other < CHANNELS && other != channel;
        is_channel.then_some(other)
    }
}

/// The share of a channel's voltage that the channel converted after it keeps.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Memory {
    /// The channel that keeps it.
    pub channel: usize,
    /// The channel before it.
    pub before: usize,
    /// The share.
    pub share: EstimatedValue<f64>,
}

impl Memory {
    /// True when it is significant and large enough to move an answer.
    pub fn is_large(&self) -> bool {
        is_large(&self.share, LARGE_MEMORY)
    }

    /// What the hammer's channel keeps in these readings of a tumble test; `None` where no channel is converted
    /// before it.
    pub fn of_readings(
        readings: &[(Position, RestVoltages<f64>)],
        order: &ConversionOrder,
    ) -> Option<Self> {
        let before = order.before(HAMMER)?;
        let share = kept_by_hammer(readings, before)?;
        Some(Self { channel: HAMMER, before, share })
    }
}

/// The difference between responses to pushes from the two sides of a direction, relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asymmetry {
    /// The direction, a unit vector in the frame of the block.
    pub direction: Vector3<f64>,
    /// Response to pushes along it over that to pushes against it, minus one.
    pub difference: EstimatedValue<f64>,
}

impl Asymmetry {
    /// True when it is significant and large enough to move an answer.
    pub fn is_large(&self) -> bool {
        is_large(&self.difference, LARGE_ASYMMETRY)
    }
}

/// What a block test shows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Electronics {
    /// What the channel after the hammer's keeps of it; `None` where this is not seen.
    pub memory: Option<Memory>,
    /// Difference between the two sides of each direction.
    pub asymmetry: Vec<Asymmetry>,
}

impl Electronics {
    /// The findings of a block test on a rig with this order; nothing where the hits do not show it.
    pub fn of(hits: Option<&OppositeHits<f64>>, order: &ConversionOrder) -> Self {
        let Some(hits) = hits else { return Self::default() };
        let asymmetry = |&(direction, difference): &(_, _)| Asymmetry { direction, difference };
        let memory = hits.memory.zip(order.after(HAMMER));
        Self {
            memory: memory.map(|(share, channel)| Memory { channel, before: HAMMER, share }),
            asymmetry: hits.asymmetry.iter().map(asymmetry).collect(),
        }
    }
}

fn is_large(estimate: &EstimatedValue<f64>, limit: f64) -> bool {
    estimate.value.abs() > limit && estimate.value.abs() > SIGNIFICANT * estimate.sigma
}
