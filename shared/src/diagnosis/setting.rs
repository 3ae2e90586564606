//! The settings of a test, as subjects of diagnostics.

use num_enum::{IntoPrimitive, TryFromPrimitive};

/// Names a setting as the subject of a diagnostic. The numbers never change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, IntoPrimitive, TryFromPrimitive)]
#[repr(u8)]
pub enum Setting {
    /// Accepted hits wanted at each DOF, 1 to 50.
    HitsPerDof = 0,
    /// Lower end of the band, Hz: above zero and below the upper end.
    BandLower = 1,
    /// Upper end of the band, Hz: at most the rate over 2.5, and at most the last stored bin.
    BandUpper = 2,
    /// σ of the exponential window, 1/s: zero or more.
    ExponentialDecay = 3,
    /// Half width of the force window, s: above zero and within the record.
    ForceWindow = 4,
    /// Trigger force, N: above zero.
    Trigger = 5,
    /// Force below which a hit is too weak, N: zero or more.
    MinPeakForce = 6,
    /// Smallest impulse of a hit, N s: zero or more, and below the largest.
    ImpulseLower = 7,
    /// Largest impulse of a hit, N s: above zero.
    ImpulseUpper = 8,
}

impl Setting {
    /// Every setting.
    pub const ALL: [Self; 9] = [
        Self::HitsPerDof,
        Self::BandLower,
        Self::BandUpper,
        Self::ExponentialDecay,
        Self::ForceWindow,
        Self::Trigger,
        Self::MinPeakForce,
        Self::ImpulseLower,
        Self::ImpulseUpper,
    ];

    /// Unit of its value; empty for a number.
    pub fn unit(self) -> &'static str {
        match self {
            Self::HitsPerDof => "",
            Self::BandLower | Self::BandUpper => "Hz",
            Self::ExponentialDecay => "1/s",
            Self::ForceWindow => "s",
            Self::Trigger | Self::MinPeakForce => "N",
            Self::ImpulseLower | Self::ImpulseUpper => "N s",
        }
    }

    /// Name of the setting in the program.
    pub fn name(self) -> &'static str {
        match self {
            Self::HitsPerDof => "hits_per_dof",
            Self::BandLower => "band_hz[0]",
            Self::BandUpper => "band_hz[1]",
            Self::ExponentialDecay => "exponential_decay",
            Self::ForceWindow => "force_window_s",
            Self::Trigger => "trigger_n",
            Self::MinPeakForce => "min_peak_force_n",
            Self::ImpulseLower => "impulse_ns[0]",
            Self::ImpulseUpper => "impulse_ns[1]",
        }
    }
}
