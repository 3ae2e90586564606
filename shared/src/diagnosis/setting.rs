//! The numbers of a test's settings, as subjects of diagnostics: their units and the values that they may have.

use num_enum::{IntoPrimitive, TryFromPrimitive};

use crate::real::Real;

/// Largest number of hits at a DOF.
pub const MAX_HITS_PER_DOF: u8 = 50;

/// Which values a setting may have by itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AllowedValues {
    /// A whole number from 1 to [`MAX_HITS_PER_DOF`].
    HitCount,
    /// Zero or more.
    NotNegative,
    /// More than zero.
    Positive,
}

impl AllowedValues {
    /// True for a finite value that is allowed.
    pub fn contains<R: Real>(self, value: R) -> bool {
        let zero = R::zero();
        value.finite()
            && match self {
                Self::HitCount => {
                    // The cast ends at the range of a `u8`.
                    let whole = value.to_f32() as u8;
                    f32::from(whole) == value.to_f32() && (1..=MAX_HITS_PER_DOF).contains(&whole)
                }
                Self::NotNegative => value >= zero,
                Self::Positive => value > zero,
            }
    }
}

/// Generates the settings from their rows: number on the wire, which never changes, name, words for the screen, unit,
/// allowed values.
macro_rules! settings {
    ($(
        $(#[$doc:meta])*
        $name:ident = $number:literal, $key:literal, $words:literal, $unit:literal, $allowed:ident;
    )*) => {
        /// Names a setting as the subject of a diagnostic. The numbers never change.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoPrimitive, TryFromPrimitive)]
        #[repr(u8)]
        pub enum Setting {
            $($(#[$doc])* $name = $number,)*
        }

        impl Setting {
            /// Every setting.
            pub const ALL: &[Self] = &[$(Self::$name),*];

            /// Name of the setting: its key in a layout file, with an index for an end of a range.
            pub fn name(self) -> &'static str {
                match self { $(Self::$name => $key,)* }
            }

            /// What a rig's screen calls it, in at most 14 letters.
            pub fn words(self) -> &'static str {
                match self { $(Self::$name => $words,)* }
            }

            /// Unit of its value; empty for a number.
            pub fn unit(self) -> &'static str {
                match self { $(Self::$name => $unit,)* }
            }

            /// The values that it may have by itself.
            pub fn allowed(self) -> AllowedValues {
                match self { $(Self::$name => AllowedValues::$allowed,)* }
            }
        }
    };
}

settings! {
    /// Accepted hits wanted at each DOF.
    HitsPerDof = 0, "hits_per_dof", "hits per DOF", "", HitCount;
    /// Lower end of the band: below the upper end.
    BandLower = 1, "band_hz[0]", "band from", "Hz", Positive;
    /// Upper end of the band: at most the rate over 2.5, and at most the last stored bin.
    BandUpper = 2, "band_hz[1]", "band to", "Hz", Positive;
    /// σ of the exponential window; zero for none.
    ExponentialDecay = 3, "exponential_decay_per_s", "window decay", "1/s", NotNegative;
    /// Half width of the force window: within the record.
    ForceWindow = 4, "force_window_s", "force window", "s", Positive;
    /// Trigger force.
    Trigger = 5, "trigger_n", "trigger", "N", Positive;
    /// Force below which a hit is too weak.
    MinPeakForce = 6, "min_peak_force_n", "least peak", "N", NotNegative;
    /// Smallest impulse of a hit: below the largest.
    ImpulseLower = 7, "impulse_ns[0]", "least impulse", "N s", NotNegative;
    /// Largest impulse of a hit.
    ImpulseUpper = 8, "impulse_ns[1]", "most impulse", "N s", Positive;
}
