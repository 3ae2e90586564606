//! The unit of the number that a diagnostic carries.

use super::Subject;
use crate::body::INERTIAL_PARAMETERS;

/// The unit of a diagnostic's value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueUnit {
    /// There is no value: it is zero.
    None,
    /// A part of one, shown in percent with so many decimals.
    Share(u8),
    /// How many, or a rank.
    Count,
    /// The number of a node.
    Node,
    /// N.
    Newtons,
    /// Of the channel that is the subject: N of the hammer, m/s² of a sensor.
    OfChannel,
    /// Ten times the decimal logarithm of a ratio of powers, dB.
    Decibels,
    /// kg.
    Kilograms,
    /// kg, shown with its sign.
    SignedKilograms,
    /// kg m².
    KilogramSquareMeters,
    /// χ².
    ChiSquared,
    /// How many times what it should be.
    Times,
    /// A factor near one.
    Factor,
    /// The condition of a matrix.
    Condition,
    /// Of the setting that is the subject.
    OfSetting,
    /// SI unit of the inertial parameter that is the subject: kg, m or kg m².
    OfProperty,
}

impl ValueUnit {
    /// The symbol that follows the number; empty for what has none, and for a setting, whose name says it.
    pub fn symbol(self, subject: Subject) -> &'static str {
        match self {
            Self::Share(_) => "%",
            Self::Newtons => "N",
            Self::OfChannel => match subject {
                Subject::Channel(0) => "N",
                _ => "m/s²",
            },
            Self::Decibels => "dB",
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
            | Self::OfSetting => "",
        }
    }
}
