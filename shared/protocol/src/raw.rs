//! Numbers that stand for the growable enums of the domain on the wire: an older program passes a number on
//! that it does not know.

use massline_shared::diagnosis::Setting;
use massline_shared::diagnosis::Severity;
use massline_shared::measurement::campaign::Phase;

/// An enum that travels as a number.
pub trait Raw: Sized {
    /// The number's type.
    type Number;

    /// The number that stands for it. Never changed once it has shipped.
    fn raw(self) -> Self::Number;

    /// What a number stands for; `None` when this program does not know it.
    fn from_raw(raw: Self::Number) -> Option<Self>;
}

macro_rules! raw {
    ($name:ident: $number:ty { $($variant:ident = $value:literal),* $(,)? }) => {
        impl Raw for $name {
            type Number = $number;

            fn raw(self) -> $number {
                match self { $(Self::$variant => $value),* }
            }

            fn from_raw(raw: $number) -> Option<Self> {
                match raw { $($value => Some(Self::$variant),)* _ => None }
            }
        }
    };
}

raw!(Phase: u8 { Idle = 0, Armed = 1, Busy = 2, Confirming = 3, Paused = 4, Solving = 5, Done = 6 });
raw!(Severity: u8 { Note = 0, Warning = 1, Error = 2 });
raw!(Setting: u8 {
    HitsPerDof = 0,
    BandLower = 1,
    BandUpper = 2,
    ExponentialDecay = 3,
    ForceWindow = 4,
    Trigger = 5,
    MinPeakForce = 6,
});
