//! The tables of a bench file, with the defaults of the default bench: a row of `settings!` says all that there is to
//! say about a key.

use std::ops::RangeInclusive;

use serde::Deserialize;

/// Generates the struct of a table from its rows: what a key says, its name, type, default and allowed values, those of
/// each number of a list, which may depend on the `$table` itself. A table whose keys can contradict one another says
/// so in a function `contradiction`.
macro_rules! settings {
    (
        $(#[$doc:meta])*
        $name:ident $(($table:ident))?, $written:literal $(, $contradiction:ident)? {
            $($(#[$meaning:meta])* $key:ident: $type:ty = $default:expr, $allowed:expr;)*
        }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq, serde::Deserialize)]
        #[serde(deny_unknown_fields, default, expecting = $written)]
        pub struct $name {
            $($(#[$meaning])* pub $key: $type,)*
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($key: $default),* }
            }
        }

        impl $name {
            /// The first key that is wrong.
            pub(crate) fn problem(&self) -> $crate::settings::SettingProblem {
                $(let $table = self;)?
                $(
                    if let Some(problem) = $crate::settings::CheckRange::problem(&self.$key, &$allowed) {
                        return Some((stringify!($key), problem));
                    }
                )*
                None$(.or_else(|| self.$contradiction()))?
            }
        }
    };
}

mod converter;
mod elastic;
mod environment;
mod fault;
mod instruments;
mod person;
mod supply;

pub use converter::{AdcSettings, MainsSettings};
pub use elastic::{ElasticMode, Node, NodeShape};
pub use environment::EnvironmentSettings;
pub use fault::{Fault, FaultError};
pub use instruments::{HammerSettings, SensorSettings};
pub use person::{OperatorSettings, TapSettings};
pub use supply::SupplySettings;

/// What says how large the errors of a test are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ErrorsFrom {
    /// The bench file.
    #[default]
    Bench,
    /// The error budget of the layout: what its table `uncertainty` states, and the defaults.
    Layout,
}

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
/// Allowed contact time, s.
const DURATION: RangeInclusive<f64> = 1e-5..=1.0;

/// A value whose numbers have a range.
trait CheckRange {
    /// What is wrong with it, if anything.
    fn problem(&self, allowed: &RangeInclusive<f64>) -> Option<String>;
}

impl CheckRange for f64 {
    fn problem(&self, allowed: &RangeInclusive<f64>) -> Option<String> {
        (!allowed.contains(self)).then(|| refusal(*self, allowed))
    }
}

impl CheckRange for u8 {
    fn problem(&self, allowed: &RangeInclusive<f64>) -> Option<String> {
        f64::from(*self).problem(allowed)
    }
}

impl CheckRange for u16 {
    fn problem(&self, allowed: &RangeInclusive<f64>) -> Option<String> {
        f64::from(*self).problem(allowed)
    }
}

/// From and to.
impl CheckRange for [f64; 2] {
    fn problem(&self, allowed: &RangeInclusive<f64>) -> Option<String> {
        let [low, high] = self;
        let good = low <= high && allowed.contains(low) && allowed.contains(high);
        (!good).then(|| {
            let (from, to) = (allowed.start(), allowed.end());
            format!("[{low:?}, {high:?}] must be [from, to] with {from} <= from <= to <= {to}")
        })
    }
}

impl CheckRange for [f64; 3] {
    fn problem(&self, allowed: &RangeInclusive<f64>) -> Option<String> {
        self.iter().find_map(|number| number.problem(allowed))
    }
}

impl CheckRange for Vec<f64> {
    fn problem(&self, allowed: &RangeInclusive<f64>) -> Option<String> {
        self.iter().find_map(|number| number.problem(allowed))
    }
}

impl<T: CheckRange> CheckRange for Option<T> {
    fn problem(&self, allowed: &RangeInclusive<f64>) -> Option<String> {
        self.as_ref()?.problem(allowed)
    }
}

/// The message for a value outside its range.
pub(super) fn refusal(value: f64, range: &RangeInclusive<f64>) -> String {
    let (from, to) = (range.start(), range.end());
    format!("{value:?} is out of range; give a number from {from} to {to}")
}
