//! `[environment]`.

use std::ops::RangeInclusive;

use serde::Deserialize;

use super::{CORRELATION, SettingProblem, out_of_range};

/// `[environment]`: what moves the object besides the hammer, before a tap as well as after it.
///
/// A draught is a random force at the centre of mass and a random moment about it, whose components along the
/// body axes are independent and normal. A creak of a cord is a short push at the point where a cord holds the
/// object: along the cord, or in any direction where a mount holds it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table [environment]")]
pub struct EnvironmentSettings {
    /// Force of the draught along each body axis, rms, N.
    pub draught_n: f64,
    /// Moment of the draught about each body axis, rms, N m.
    pub draught_n_m: f64,
    /// Time over which the draught forgets its value: its correlation falls to 1/e, s.
    pub draught_s: f64,
    /// Mean number of creaks in a second.
    pub creak_rate_per_s: f64,
    /// Impulse of a creak, which is normally distributed about zero, rms, N s.
    pub creak_n_s: f64,
}

/// Allowed force and moment of the draught, N and N m.
const DRAUGHT: RangeInclusive<f64> = 0.0..=1e3;
/// Allowed rate of creaks, 1/s.
const CREAK_RATE: RangeInclusive<f64> = 0.0..=100.0;
/// Allowed impulse of a creak, N s.
const CREAK: RangeInclusive<f64> = 0.0..=100.0;

impl Default for EnvironmentSettings {
    fn default() -> Self {
        Self {
            draught_n: 0.0,
            draught_n_m: 0.0,
            draught_s: 1.0,
            creak_rate_per_s: 0.0,
            creak_n_s: 0.0,
        }
    }
}

impl EnvironmentSettings {
    pub(crate) fn problem(&self) -> SettingProblem {
        out_of_range(&[
            (self.draught_n, "draught_n", DRAUGHT),
            (self.draught_n_m, "draught_n_m", DRAUGHT),
            (self.draught_s, "draught_s", CORRELATION),
            (self.creak_rate_per_s, "creak_rate_per_s", CREAK_RATE),
            (self.creak_n_s, "creak_n_s", CREAK),
        ])
    }
}
