//! Quantities and units: data types, labels, dataset 164.
//!
//! A label holds; where there is none, dataset 164 does; without both, SI is assumed and reported as that. A label that
//! is not understood is refused.

use super::contradiction::Contradiction;
use super::error::{UffError, UffFault};
use super::unit_system::{UnitSystem, are_close};
use super::{AxisProperties, Function};
use crate::units::{
    FOOT, INCH, KILOGRAM_FORCE, Measure, POUND_FORCE, POUNDAL, Quantity, UnitFault, amplitude,
    force_unit, is_unstated, unit_size,
};

/// Factors that convert a function to SI, and where they are from.
pub(super) struct Conversion {
    pub(super) ordinate: f64,
    pub(super) hertz: f64,
    pub(super) understood: UnderstoodFunction,
}

/// What a function was understood to be.
#[derive(Clone, Debug, PartialEq)]
pub struct UnderstoodFunction {
    /// The quantity.
    pub quantity: Quantity,
    /// The unit of the ordinate.
    pub unit: String,
    /// Where the unit was read.
    pub source: UnitSource,
    /// What contradicts that unit.
    pub contradiction: Option<Contradiction>,
}

/// Where a unit was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitSource {
    /// Labels of records 9 and 10.
    Labels,
    /// Dataset 164 alone.
    Dataset164,
    /// The label of one record, and dataset 164 for the other.
    LabelAndDataset164,
    /// The label of one record; SI is assumed for the other.
    LabelAndAssumed,
    /// Nowhere: SI is assumed.
    Assumed,
}

impl UnitSource {
    /// Its words in text and JSON.
    pub fn words(self) -> &'static str {
        match self {
            Self::Labels => "labels",
            Self::Dataset164 => "dataset 164",
            Self::LabelAndDataset164 => "label and dataset 164",
            Self::LabelAndAssumed => "label; SI assumed for the other part",
            Self::Assumed => "assumed: the file states no unit",
        }
    }
}

/// The factor that converts the ordinate of a record over time to N or m/s² by dataset 164, where the file has
/// one.
pub(super) fn time_factor(function: &Function) -> Option<f64> {
    let units = function.units?;
    match function.numerator_axis.data_type {
        9 | 13 => Some(1.0 / units.force),
        12 => Some(1.0 / units.length),
        _ => None,
    }
}

/// The conversion of `function` to SI, whose quantity is `stated` or that of its data types.
pub(super) fn conversion(
    function: &Function,
    stated: Option<Quantity>,
) -> Result<Conversion, UffError> {
    let hertz =
        hertz(function).map_err(|fault| function.axis_error(&function.abscissa_axis, fault))?;
    let quantity = match stated {
        Some(quantity) => quantity,
        None => quantity_of(function)?,
    };
    let labels = Labels::of(function, quantity)?;
    let units = function.units;
    let [of_motion, of_force] = [Measure::Motion(quantity), Measure::Force];
    let size = |units: Option<UnitSystem>, measure| units.map_or(1.0, |units| units.size(measure));
    // Labels where they are stated, else these units.
    let ordinate_by = |units| match labels {
        Labels::Ratio(ratio) => ratio,
        Labels::Parts(motion, force) => {
            motion.unwrap_or(size(units, of_motion)) / force.unwrap_or(size(units, of_force))
        }
    };
    let ordinate = ordinate_by(units);
    let is_part =
        matches!(labels, Labels::Parts(motion, force) if motion.is_none() || force.is_none());
    let source = match (labels.are_missing(), is_part, units.is_some()) {
        (true, _, true) => UnitSource::Dataset164,
        (true, _, false) => UnitSource::Assumed,
        (false, true, true) => UnitSource::LabelAndDataset164,
        (false, true, false) => UnitSource::LabelAndAssumed,
        (false, false, _) => UnitSource::Labels,
    };
    let contradiction = units.and_then(|units| {
        let by_dataset = units.size(of_motion) / units.size(of_force);
        Contradiction::of(units, ordinate, by_dataset, |other| ordinate_by(Some(other)))
    });
    let unit = unit_text(function, quantity, &labels);
    Ok(Conversion {
        ordinate,
        hertz,
        understood: UnderstoodFunction { quantity, unit, source, contradiction },
    })
}

/// The quantity by the data types of a function.
fn quantity_of(function: &Function) -> Result<Quantity, UffError> {
    let (numerator, denominator) = (&function.numerator_axis, &function.denominator_axis);
    let quantity = match numerator.data_type {
        8 => Quantity::Displacement,
        11 => Quantity::Velocity,
        12 => Quantity::Acceleration,
        other => {
            let wanted = "acceleration (12), velocity (11) or displacement (8) is needed; when it \
                          is one of these, state it with --quantity";
            let fault =
                UffFault::WrongQuantity { axis: "ordinate numerator", found: other, wanted };
            return Err(function.axis_error(numerator, fault));
        }
    };
    // A numerator that is a motion over a force needs no denominator.
    let is_ratio = unit_size(&numerator.unit, Measure::MotionOverForce(quantity)).is_ok();
    let is_general = matches!(denominator.data_type, 0 | 1);
    if denominator.data_type == 13 || (is_ratio && is_general) {
        return Ok(quantity);
    }
    let wanted = "excitation force (13) is needed; when it is a force, say what the response \
                  is with --quantity";
    let (axis, data_type) = ("ordinate denominator", denominator.data_type);
    Err(function
        .axis_error(denominator, UffFault::WrongQuantity { axis, found: data_type, wanted }))
}

/// The sizes of the units that the labels of records 9 and 10 state.
#[derive(Clone, Copy)]
enum Labels {
    /// That of a motion over a force.
    Ratio(f64),
    /// That of the motion and that of the force, each where it is stated.
    Parts(Option<f64>, Option<f64>),
}

impl Labels {
    fn of(function: &Function, quantity: Quantity) -> Result<Self, UffError> {
        let (numerator, denominator) = (&function.numerator_axis, &function.denominator_axis);
        let fault = |axis: &AxisProperties, measure: Measure| {
            function.axis_error(axis, wrong_unit(&axis.unit, measure))
        };
        let amplitudes = [numerator, denominator].map(|axis| amplitude(&axis.unit));
        if let [Some(first), Some(second)] = amplitudes
            && (first == "rms") != (second == "rms")
        {
            let unit = denominator.unit.clone();
            return Err(function.axis_error(denominator, UffFault::MixedAmplitudes { unit }));
        }
        let force = match denominator.unit.as_str() {
            "" => None,
            unit => Some(force_unit(unit).ok_or_else(|| fault(denominator, Measure::Force))?),
        };
        if numerator.unit.is_empty() {
            return Ok(Self::Parts(None, force));
        }
        if let Ok(motion) = unit_size(&numerator.unit, Measure::Motion(quantity)) {
            return Ok(Self::Parts(Some(motion), force));
        }
        let ratio = unit_size(&numerator.unit, Measure::MotionOverForce(quantity))
            .map_err(|_| fault(numerator, Measure::Motion(quantity)))?;
        // The denominator repeats the force of the ratio, which is newton where it names none, as in 1/kg.
        let mut forces = forces_in(&numerator.unit).peekable();
        let repeats = match (force, forces.peek()) {
            (None, _) => true,
            (Some(force), None) => force == 1.0,
            (Some(force), Some(_)) => forces.any(|other| other == force),
        };
        if repeats { Ok(Self::Ratio(ratio)) } else { Err(fault(denominator, Measure::Force)) }
    }

    fn are_missing(&self) -> bool {
        matches!(self, Self::Parts(None, None))
    }
}

/// The sizes of the units of force in a label.
fn forces_in(label: &str) -> impl Iterator<Item = f64> {
    label.split(|c: char| !c.is_alphabetic()).filter_map(force_unit)
}

/// The unit of a function as text: labels as they are written, units of dataset 164 and assumed ones by their names.
fn unit_text(function: &Function, quantity: Quantity, labels: &Labels) -> String {
    let [numerator, denominator] =
        [&function.numerator_axis, &function.denominator_axis].map(|axis| axis.unit.trim());
    if matches!(labels, Labels::Ratio(_)) {
        return numerator.to_owned();
    }
    let name = |label: &str, names: &[(&str, f64)], size: f64| {
        let known = names.iter().find(|(_, known)| are_close(*known, size));
        match (label, known) {
            ("", Some((name, _))) => (*name).to_owned(),
            ("", None) => format!("({size:.6} {})", names.first().map_or("", |(name, _)| name)),
            (label, _) => label.to_owned(),
        }
    };
    let size = |measure| function.units.map_or(1.0, |units| units.size(measure));
    let over_time = match (numerator, quantity) {
        ("", Quantity::Acceleration) => "/s^2",
        ("", Quantity::Velocity) => "/s",
        _ => "",
    };
    let motion = name(numerator, &LENGTHS, size(Measure::Motion(quantity)));
    let motion = format!("{motion}{over_time}");
    let motion = if motion.contains(['/', ' ', '*', '.']) && !motion.starts_with('(') {
        format!("({motion})")
    } else {
        motion
    };
    format!("{motion}/{}", name(denominator, &FORCES, size(Measure::Force)))
}

/// Names of the units of dataset 164.
const LENGTHS: [(&str, f64); 5] =
    [("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("in", INCH), ("ft", FOOT)];
const FORCES: [(&str, f64); 7] = [
    ("N", 1.0),
    ("mN", 1e-3),
    ("cN", 1e-2),
    ("kN", 1e3),
    ("lbf", POUND_FORCE),
    ("kgf", KILOGRAM_FORCE),
    ("pdl", POUNDAL),
];

/// The unit of the abscissa, Hz.
fn hertz(function: &Function) -> Result<f64, UffFault> {
    let axis = &function.abscissa_axis;
    if !matches!(axis.data_type, 0 | 1 | 18) {
        let (data_type, wanted) = (axis.data_type, "frequency (18) is needed");
        return Err(UffFault::WrongQuantity { axis: "abscissa", found: data_type, wanted });
    }
    if is_unstated(&axis.unit) {
        return Ok(1.0);
    }
    unit_size(&axis.unit, Measure::Frequency)
        .map_err(|_| wrong_unit(&axis.unit, Measure::Frequency))
}

/// The fault of a label that is no unit of this measure.
fn wrong_unit(unit: &str, measure: Measure) -> UffFault {
    let unit = unit.to_owned();
    match unit_size(&unit, measure) {
        Err(fault @ (UnitFault::NeedsSensitivity | UnitFault::PeakToPeak)) => {
            UffFault::UnusableUnit { unit, fault: fault.to_string() }
        }
        _ => UffFault::WrongUnit { unit, quantity: measure.name(), known: measure.known() },
    }
}
