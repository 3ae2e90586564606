//! Units of force, motion, time and frequency, as people and programs write them.
//!
//! `unit_size` reads a label by a small grammar: symbols with prefixes, powers, products and quotients
//! (`units/grammar.rs`), and the symbols of a table (`units/symbols.rs`). A label is read or refused with a
//! `UnitFault`; what an empty label means is the reader's decision.

mod grammar;
mod symbols;

use massline_shared::STANDARD_GRAVITY;
use thiserror::Error;

/// Gravity on Earth, m/s²: from 9.76 on the highest mountains near the equator to 9.83 at the poles, and what two
/// digits make of it.
pub const GRAVITY_ON_EARTH: std::ops::RangeInclusive<f64> = 9.75..=9.85;

/// Metres in a foot.
pub const FOOT: f64 = 0.3048;
/// Metres in an inch.
pub const INCH: f64 = 0.0254;
/// Kilograms in a pound.
pub const POUND: f64 = 0.453_592_37;
/// Newtons in a kilogram-force.
pub const KILOGRAM_FORCE: f64 = STANDARD_GRAVITY;
/// Newtons in a pound-force.
pub const POUND_FORCE: f64 = POUND * STANDARD_GRAVITY;
/// Newtons in a poundal.
pub const POUNDAL: f64 = POUND * FOOT;

/// The response quantity of a frequency response function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Accelerance, acceleration over force.
    Acceleration,
    /// Mobility, velocity over force.
    Velocity,
    /// Receptance, displacement over force.
    Displacement,
}

impl Quantity {
    /// Every quantity.
    pub const ALL: [Self; 3] = [Self::Acceleration, Self::Velocity, Self::Displacement];

    /// The name of this quantity over force.
    pub fn frf_name(self) -> &'static str {
        match self {
            Self::Acceleration => "accelerance",
            Self::Velocity => "mobility",
            Self::Displacement => "receptance",
        }
    }
}

/// What a unit measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// Acceleration, velocity or displacement.
    Motion(Quantity),
    /// Force.
    Force,
    /// A motion over a force.
    MotionOverForce(Quantity),
    /// Time.
    Time,
    /// Frequency, in cycles.
    Frequency,
}

impl Measure {
    /// Its name in messages.
    pub fn name(self) -> &'static str {
        match self {
            Self::Motion(Quantity::Acceleration) => "acceleration",
            Self::Motion(Quantity::Velocity) => "velocity",
            Self::Motion(Quantity::Displacement) => "displacement",
            Self::Force => "force",
            Self::MotionOverForce(quantity) => quantity.frf_name(),
            Self::Time => "time",
            Self::Frequency => "frequency",
        }
    }

    /// The units that are known, for messages.
    pub fn known(self) -> &'static str {
        match self {
            Self::Motion(Quantity::Acceleration) => {
                "m/s^2, cm/s^2, mm/s^2, in/s^2, ft/s^2, g, mg and Gal"
            }
            Self::Motion(Quantity::Velocity) => "m/s, cm/s, mm/s, um/s, in/s and ft/s",
            Self::Motion(Quantity::Displacement) => "m, cm, mm, um, nm, in, mil and ft",
            Self::Force => "N, mN, kN, MN, daN, lbf, kip, kgf, gf, ozf, dyn and pdl",
            Self::MotionOverForce(Quantity::Acceleration) => {
                "m/s^2/N, mm/s^2/N, g/N, g/lbf, in/s^2/lbf and 1/kg"
            }
            Self::MotionOverForce(Quantity::Velocity) => "m/s/N, mm/s/N and in/s/lbf",
            Self::MotionOverForce(Quantity::Displacement) => "m/N, mm/N, um/N and in/lbf",
            Self::Time => "s, ms, us, ns, min and h",
            Self::Frequency => "Hz, kHz, 1/s, rpm and rad/s",
        }
    }

    /// The powers of mass, length and time.
    fn dimensions(self) -> [i32; 3] {
        match self {
            Self::Motion(quantity) => [0, 1, time_of(quantity)],
            Self::Force => [1, 1, -2],
            Self::MotionOverForce(quantity) => [-1, 0, time_of(quantity) + 2],
            Self::Time => [0, 0, 1],
            Self::Frequency => [0, 0, -1],
        }
    }
}

/// The power of time in a motion.
fn time_of(quantity: Quantity) -> i32 {
    match quantity {
        Quantity::Displacement => 0,
        Quantity::Velocity => -1,
        Quantity::Acceleration => -2,
    }
}

/// Why a label is not read as a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum UnitFault {
    /// The label is no unit of this quantity.
    #[error("it is not a known unit of {} ({} are)", .0.name(), .0.known())]
    Unknown(Measure),
    /// The unit of a signal before its sensitivity is applied: volts, counts, charge.
    #[error("it is the unit of an unscaled signal, which needs the sensitivity of its sensor")]
    NeedsSensitivity,
    /// A peak-to-peak value.
    #[error("it is a peak-to-peak value, and amplitudes are needed")]
    PeakToPeak,
}

/// What a label means: its units, or why it has none.
#[derive(Clone, Debug, PartialEq)]
pub struct LabelMeaning(Result<Vec<symbols::Unit>, UnitFault>);

/// The size of the unit `label` in SI (Hz for a frequency).
///
/// # Errors
/// When it is not a unit of this measure; an empty label is none.
pub fn unit_size(label: &str, measure: Measure) -> Result<f64, UnitFault> {
    let mut sizes = grammar::readings(label)?
        .into_iter()
        .filter(|unit| unit.dimensions == measure.dimensions())
        .map(|unit| unit.size);
    let first = sizes.next().ok_or(UnitFault::Unknown(measure))?;
    sizes.all(|size| size == first).then_some(first).ok_or(UnitFault::Unknown(measure))
}

/// True for a label that states no unit.
pub fn is_unstated(label: &str) -> bool {
    let label = label.trim().trim_matches(|c: char| "()[]".contains(c)).trim();
    label.is_empty() || ["none", "-", "--", "n/a"].iter().any(|no| label.eq_ignore_ascii_case(no))
}

/// True for the unit of a signal before its sensitivity is applied, such as mV, pC or counts.
pub fn is_unscaled(label: &str) -> bool {
    grammar::readings(label) == Err(UnitFault::NeedsSensitivity)
}

/// What a label means, to compare labels; none for a label that is not understood.
pub fn label_meaning(label: &str) -> Option<LabelMeaning> {
    match grammar::readings(label) {
        Ok(units) if units.is_empty() => None,
        meaning => Some(LabelMeaning(meaning)),
    }
}

/// The amplitude that a label states, `rms` or a word for a peak.
pub fn amplitude(label: &str) -> Option<&'static str> {
    grammar::amplitude(label)
}

/// The size of a motion unit in m, m/s or m/s².
pub fn motion_unit(label: &str, quantity: Quantity) -> Option<f64> {
    unit_size(label, Measure::Motion(quantity)).ok()
}

/// The size of a force unit, N.
pub fn force_unit(label: &str) -> Option<f64> {
    unit_size(label, Measure::Force).ok()
}

/// The size of a unit of time, s.
pub fn time_unit(label: &str) -> Option<f64> {
    unit_size(label, Measure::Time).ok()
}

#[cfg(test)]
mod tests;
