//! Newtypes of the physical quantities that cross an interface, all SI.
//!
//! Inside a solver plain scalars in SI are used; a quantity wears its unit where it is handed from
//! one part of the program to another.

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
    /// Hz.
    Hertz
);
unit!(
    /// s.
    Seconds
);
unit!(
    /// V.
    Volts
);
unit!(
    /// N.
    Newtons
);
unit!(
    /// m/s².
    MetersPerSecondSquared
);
unit!(
    /// 1/s: decay rate of an exponential window, the real part of `s = σ + iω`.
    PerSecond
);

/// One scan's place in the sampler's count since it was powered, in scans.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct ScanIndex(pub u64);
