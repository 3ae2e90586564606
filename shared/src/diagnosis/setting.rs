//! The settings of a test, as subjects of diagnostics.

/// Names a setting as the subject of a diagnostic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Setting {
    /// Accepted hits wanted at each DOF, 1 to 50.
    HitsPerDof,
    /// Lower end of the band, Hz: above zero and below the upper end.
    BandLower,
    /// Upper end of the band, Hz: at most the rate over 2.5 and the last line that is kept.
    BandUpper,
    /// σ of the exponential window, 1/s: zero or more.
    ExponentialDecay,
    /// Half width of the force window, s: above zero and within the record.
    ForceWindow,
    /// Trigger force, N: above zero.
    Trigger,
    /// Force below which a hit is too weak, N: zero or more.
    WeakestHit,
}

impl Setting {
    /// Every setting.
    pub const ALL: [Self; 7] = [
        Self::HitsPerDof,
        Self::BandLower,
        Self::BandUpper,
        Self::ExponentialDecay,
        Self::ForceWindow,
        Self::Trigger,
        Self::WeakestHit,
    ];

    /// Its name in the program.
    pub fn name(self) -> &'static str {
        match self {
            Self::HitsPerDof => "hits_per_dof",
            Self::BandLower => "band_hz[0]",
            Self::BandUpper => "band_hz[1]",
            Self::ExponentialDecay => "exponential_decay",
            Self::ForceWindow => "force_window_s",
            Self::Trigger => "trigger_n",
            Self::WeakestHit => "min_peak_force_n",
        }
    }
}
