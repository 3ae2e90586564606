//! Newtypes of the physical quantities that cross an interface, all SI.
//!
//! Solvers use plain scalars in SI internally; a quantity has its unit as a type where one part of the
//! program passes it to another.

/// Standard acceleration of gravity, m/s².
pub const STANDARD_GRAVITY: f64 = 9.806_65;

macro_rules! unit {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(transparent))]
        pub struct $name<R = f32>(pub R);
    };
}

unit!(
    /// Frequency, Hz.
    Hertz
);
unit!(
    /// Time, s.
    Seconds
);
unit!(
    /// Voltage, V.
    Volts
);
unit!(
    /// Force, N.
    Newtons
);
unit!(
    /// Acceleration, m/s².
    MetersPerSecondSquared
);
unit!(
    /// Decay rate of an exponential window, the real part of `s = σ + iω`, 1/s.
    PerSecond
);

/// Index of a scan, counted by the sampler since power-on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct ScanIndex(pub u64);
