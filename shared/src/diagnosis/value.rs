//! The unit of the number that a diagnostic carries.

use super::Subject;
use crate::body::INERTIAL_PARAMETERS;

/// The unit of a diagnostic's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueUnit {
    /// There is no value: it is zero.
    None,
    /// A fraction, shown in percent with this number of decimals.
    Share(u8),
    /// A number of items, or a rank.
    Count,
    /// The number of a node.
    Node,
    /// N.
    Newtons,
    /// N s.
    NewtonSeconds,
    /// Unit of the channel that is the subject: N for the hammer, m/s² for a sensor.
    OfChannel,
    /// Ten times the decimal logarithm of a ratio of powers, dB.
    Decibels,
    /// V.
    Volts,
    /// Hz.
    Hertz,
    /// mrad.
    Milliradians,
    /// Degrees of an angle.
    Degrees,
    /// (m/s²)/N.
    Accelerance,
    /// kg.
    Kilograms,
    /// kg, shown with its sign.
    SignedKilograms,
    /// kg m².
    KilogramSquareMeters,
    /// χ².
    ChiSquared,
    /// A multiple of the expected value.
    Times,
    /// A factor near one.
    Factor,
    /// The condition of a matrix.
    Condition,
    /// Unit of the setting that is the subject.
    OfSetting,
    /// An axis of the body frame with its sign: from 1 for +X to −3 for −Z, and 0 for none.
    SignedAxis,
    /// SI unit of the inertial parameter that is the subject: kg, m or kg m².
    OfProperty,
}

impl ValueUnit {
    /// The symbol after the number; empty for a number without a unit, and for a setting, whose name contains
    /// it.
    pub fn symbol(self, subject: Subject) -> &'static str {
        match self {
            Self::Share(_) => "%",
            Self::Newtons => "N",
            Self::NewtonSeconds => "N s",
            Self::OfChannel => match subject {
                Subject::Channel(0) => "N",
                _ => "m/s²",
            },
            Self::Decibels => "dB",
            Self::Volts => "V",
            Self::Hertz => "Hz",
            Self::Milliradians => "mrad",
            Self::Degrees => "°",
            Self::Accelerance => "(m/s²)/N",
            Self::Kilograms | Self::SignedKilograms => "kg",
            Self::KilogramSquareMeters => "kg m²",
            Self::OfProperty => match subject {
                Subject::Property(k) => {
                    INERTIAL_PARAMETERS.get(usize::from(k)).map_or("", |parameter| parameter.unit)
                }
                _ => "",
            },
            Self::None
            | Self::Count
            | Self::Node
            | Self::ChiSquared
            | Self::Times
            | Self::Factor
            | Self::Condition
            | Self::SignedAxis
            | Self::OfSetting => "",
        }
    }
}
