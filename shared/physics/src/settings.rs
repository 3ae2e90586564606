//! The tables of a bench file about sensors, hammer, converter, mains, supply, environment, taps and operator, with
//! the defaults of the default bench.

use std::ops::RangeInclusive;

mod converter;
mod environment;
mod instruments;
mod person;
mod supply;

pub use converter::{AdcSettings, MainsSettings};
pub use environment::EnvironmentSettings;
pub use instruments::{HammerSettings, SensorSettings};
pub use person::{OperatorSettings, TapSettings};
pub use supply::SupplySettings;

/// A key and what is wrong with its value, if anything.
pub(super) type SettingProblem = Option<(&'static str, String)>;

/// Allowed standard deviations in m, rad or relative.
pub(super) const SIGMA: RangeInclusive<f64> = 0.0..=1.0;
/// Allowed standard deviations and outputs at rest, V.
const VOLTS: RangeInclusive<f64> = 0.0..=100.0;
/// Allowed cutoff of a filter, Hz.
const CUTOFF: RangeInclusive<f64> = 0.1..=1e6;
/// Allowed tolerance of a cutoff, relative: parts are sorted at three times this.
const TOLERANCE: RangeInclusive<f64> = 0.0..=0.2;
/// Allowed peak of a force, N.
const FORCE: RangeInclusive<f64> = 1e-3..=1e6;
/// Allowed correlation times, s.
const CORRELATION: RangeInclusive<f64> = 1e-3..=1e6;
/// Allowed shares.
const SHARE: RangeInclusive<f64> = 0.0..=1.0;
/// Allowed distance of a force from the mark, m.
pub(super) const OFFSET: RangeInclusive<f64> = 0.0..=1.0;
/// Allowed mass of a sensor board, kg.
pub(super) const BOARD_MASS: RangeInclusive<f64> = 0.0..=1.0;
/// Allowed amplitude of the mains in a channel, V.
pub(super) const MAINS_AMPLITUDE: RangeInclusive<f64> = 0.0..=100.0;

/// The first of these values that lies outside its range.
fn out_of_range(values: &[(f64, &'static str, RangeInclusive<f64>)]) -> SettingProblem {
    let (value, key, range) = values.iter().find(|(value, _, range)| !range.contains(value))?;
    Some((key, refusal(*value, range)))
}

/// The message for a value outside its range.
pub(super) fn refusal(value: f64, range: &RangeInclusive<f64>) -> String {
    let (from, to) = (range.start(), range.end());
    format!("{value:?} is out of range; give a number from {from} to {to}")
}

fn range_problem(
    [low, high]: [f64; 2],
    key: &'static str,
    within: RangeInclusive<f64>,
) -> SettingProblem {
    let good = low <= high && within.contains(&low) && within.contains(&high);
    (!good).then(|| {
        let (from, to) = (within.start(), within.end());
        (key, format!("[{low:?}, {high:?}] must be [from, to] with {from} <= from <= to <= {to}"))
    })
}
