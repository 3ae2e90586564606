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

use massline_protocol::message::Identity;
use massline_shared::Estimated;
use massline_shared::calibration::memory::LARGE_MEMORY;
use massline_shared::calibration::opposite_hits::OppositeHits;
use massline_shared::signal::HAMMER;
use nalgebra::Vector3;

use massline_client::flash::board::conversion_order;
use massline_report::document;
use massline_report::words::{channel_name, deviation, with_sigma};

/// A value of more standard deviations than this is significant.
const SIGNIFICANT: f64 = 4.0;
/// Difference between responses to pushes from opposite sides above which it matters: it changes single responses
/// by half as much, which is a quarter of the default uncertainty of a gain.
const LARGE_ASYMMETRY: f64 = 0.005;

/// For each converter of a rig, the channels in the order in which it converts them, over and over.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConversionOrder(Vec<Vec<u8>>);

impl ConversionOrder {
    /// The order of a rig: that of its board, or, on a board without a chip, all channels one after the other.
    pub fn of(identity: &Identity) -> Self {
        let in_order = || vec![(0..identity.adc.channels).collect()];
        Self(conversion_order(&identity.board).unwrap_or_else(in_order))
    }

    /// The channel that is converted before this one; `None` for an input of constant voltage.
    pub fn before(&self, channel: usize) -> Option<usize> {
        self.neighbor(channel, |at, count| (at + count - 1) % count)
    }

    /// The channel that is converted after this one, by the same converter.
    pub fn after(&self, channel: usize) -> Option<usize> {
        self.neighbor(channel, |at, count| (at + 1) % count)
    }

    fn neighbor(&self, channel: usize, step: fn(usize, usize) -> usize) -> Option<usize> {
        let of = self.0.iter().find(|of| of.iter().any(|&c| usize::from(c) == channel))?;
        let at = of.iter().position(|&c| usize::from(c) == channel)?;
        let other = usize::from(*of.get(step(at, of.len()))?);
        let is_channel = other < massline_shared::signal::CHANNELS && other != channel;
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
    pub share: Estimated<f64>,
}

impl Memory {
    /// True when it is significant and large enough to move an answer.
    pub fn is_large(&self) -> bool {
        is_large(&self.share, LARGE_MEMORY)
    }

    /// It as text.
    pub fn text(&self) -> String {
        format!(
            "{} keeps {} % of the voltage of {}, which is converted before it",
            channel_name(self.channel),
            with_sigma(100.0 * self.share.value, 100.0 * self.share.sigma),
            channel_name(self.before),
        )
    }

    /// A warning with what to do; `None` when it is not large.
    pub fn warning(&self) -> Option<String> {
        self.is_large().then(|| {
            format!(
                "{} (more than {} % matters): the converter's input does not settle; check the follower between filter \
                 and converter, its 100 Ω, and the 10 nF at the input, and calibrate again",
                self.text(),
                100.0 * LARGE_MEMORY,
            )
        })
    }

    /// It as JSON.
    pub fn to_json(self) -> document::Memory {
        document::Memory {
            channel: channel_name(self.channel),
            before: channel_name(self.before),
            share: self.share.value,
            sigma: self.share.sigma,
            large: self.is_large(),
        }
    }
}

/// The difference between responses to pushes from the two sides of a direction, relative.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asymmetry {
    /// The direction, a unit vector in the frame of the block.
    pub direction: Vector3<f64>,
    /// Response to pushes along it over that to pushes against it, minus one.
    pub difference: Estimated<f64>,
}

impl Asymmetry {
    fn is_large(&self) -> bool {
        is_large(&self.difference, LARGE_ASYMMETRY)
    }

    /// It as text.
    pub fn text(&self) -> String {
        let [x, y, z] = self.direction.map(|v| format!("{v:.2}")).into();
        let along = match named(&self.direction) {
            Some(axis) => format!("along {axis}"),
            None => format!("along ({x} {y} {z})"),
        };
        format!(
            "pushes {along} against those from the other side: {} %",
            deviation(100.0 * self.difference.value, 100.0 * self.difference.sigma)
        )
    }

    /// A warning with what to do; `None` when it is not large.
    pub fn warning(&self) -> Option<String> {
        self.is_large().then(|| {
            format!(
                "{} in response (more than {} % matters): the chain is not linear near the level at rest; look for a \
                 converter with a large INL or bow, a channel that is compressed, or a rest level near the end of a \
                 buffer's range",
                self.text(),
                100.0 * LARGE_ASYMMETRY,
            )
        })
    }

    /// It as JSON.
    pub fn to_json(self) -> document::Asymmetry {
        document::Asymmetry {
            direction: self.direction.into(),
            difference: self.difference.value,
            sigma: self.difference.sigma,
            large: self.is_large(),
        }
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
    pub fn of(found: Option<&OppositeHits<f64>>, order: &ConversionOrder) -> Self {
        let Some(found) = found else { return Self::default() };
        let of = |&(direction, difference): &(_, _)| Asymmetry { direction, difference };
        let memory = found.memory.zip(order.after(HAMMER));
        Self {
            memory: memory.map(|(share, channel)| Memory { channel, before: HAMMER, share }),
            asymmetry: found.asymmetry.iter().map(of).collect(),
        }
    }

    /// All warnings.
    pub fn warnings(&self) -> Vec<String> {
        let memory = self.memory.iter().filter_map(Memory::warning);
        memory.chain(self.asymmetry.iter().filter_map(Asymmetry::warning)).collect()
    }

    /// All findings, a line for each.
    pub fn text(&self) -> String {
        let memory = match &self.memory {
            Some(memory) => memory.text(),
            None => "memory of the multiplexer: not seen, for want of a sensor axis that is converted after the \
                     hammer, or of three sensors and hits from both sides"
                .into(),
        };
        let lines = self.asymmetry.iter().map(Asymmetry::text);
        std::iter::once(memory).chain(lines).collect::<Vec<_>>().join("\n")
    }

    /// All findings as JSON.
    pub fn to_json(&self) -> document::Electronics {
        document::Electronics {
            memory: self.memory.map(Memory::to_json),
            asymmetry: self.asymmetry.iter().map(|of| of.to_json()).collect(),
        }
    }
}

fn is_large(found: &Estimated<f64>, limit: f64) -> bool {
    found.value.abs() > limit && found.value.abs() > SIGNIFICANT * found.sigma
}

/// `+X` for a direction along an axis.
fn named(direction: &Vector3<f64>) -> Option<String> {
    let axis = direction.iamax();
    let sign = if direction[axis] < 0.0 { '-' } else { '+' };
    (direction[axis].abs() > 0.999).then(|| format!("{sign}{}", ["X", "Y", "Z"][axis]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(board: &str) -> ConversionOrder {
        ConversionOrder(conversion_order(board).unwrap())
    }

    #[test]
    fn who_follows_whom_depends_on_the_board() {
        // Constant reference before the hammer; sensor 1 x after it.
        let black_pill = order("blackpill-f411");
        assert_eq!((black_pill.before(0), black_pill.after(0)), (None, Some(1)));
        // Even and odd channels have a converter each, and each comes past an input of constant voltage.
        let nucleo = order("nucleo-g474re");
        assert_eq!((nucleo.before(0), nucleo.after(0)), (None, Some(2)));
        assert_eq!((nucleo.before(1), nucleo.before(3)), (None, Some(1)));
        // Round and round.
        let pico = order("pico2");
        assert_eq!((pico.before(0), pico.after(0), pico.after(9)), (Some(9), Some(1), Some(0)));
        assert_eq!(conversion_order("virtual"), None);
    }

    #[test]
    fn a_share_is_large_when_it_is_significant() {
        let warning = |value, sigma| {
            let share = Estimated { value, sigma };
            Memory { channel: 1, before: 0, share }.warning()
        };
        assert_eq!(warning(0.0015, 1e-5), None);
        assert_eq!(warning(0.01, 0.004), None);
        let text = warning(0.01, 0.0002).unwrap();
        assert!(
            text.contains("sensor 1 x keeps 1.000 ± 0.020 % of the voltage of the hammer"),
            "{text}"
        );
    }

    #[test]
    fn a_direction_has_the_name_of_its_axis() {
        let text = |direction: [f64; 3]| {
            let difference = Estimated { value: 0.012, sigma: 0.001 };
            Asymmetry { direction: direction.into(), difference }.text()
        };
        assert!(text([0.0, -1.0, 0.0]).contains("along -Y against"), "{}", text([0.0, -1.0, 0.0]));
        assert!(text([0.6, 0.8, 0.0]).contains("along (0.60 0.80 0.00)"));
    }
}
