//! Quantities and units: data types, labels, dataset 164.

use super::Function;
use super::error::{UffError, UffFault};
use super::lines::Lines;
use super::values::real;
use crate::units::{
    FOOT, INCH, KILOGRAM_FORCE, Measure, POUND_FORCE, POUNDAL, Quantity, force_unit, is_unstated,
    motion_unit, unit_size,
};

/// The units of a dataset 164: the values of 1 m and 1 N in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UnitSystem {
    length: f64,
    force: f64,
}

impl Default for UnitSystem {
    fn default() -> Self {
        Self { length: 1.0, force: 1.0 }
    }
}

/// Factors that convert a function to SI.
pub(super) struct Conversion {
    pub(super) quantity: Quantity,
    pub(super) ordinate: f64,
    pub(super) hertz: f64,
}

/// The systems of dataset 164's unit codes from 1: the values of 1 m and 1 N.
const SYSTEMS: [[f64; 2]; 8] = [
    [1.0, 1.0],
    [1.0 / FOOT, 1.0 / POUND_FORCE],
    [1.0, 1.0 / KILOGRAM_FORCE],
    [1.0 / FOOT, 1.0 / POUNDAL],
    [1e3, 1e3],
    [1e2, 1e2],
    [1.0 / INCH, 1.0 / POUND_FORCE],
    [1e3, 1.0 / KILOGRAM_FORCE],
];

/// Reads dataset 164 from after its first line to its end.
///
/// Codes 1 to 8 define their units; for the others (9 is user defined) the factors are used. Writers disagree
/// about the factors that belong to a code, so the code takes precedence.
pub(super) fn read_units(
    lines: &mut Lines<'_>,
    notes: &mut Vec<String>,
) -> Result<UnitSystem, UffError> {
    let text = lines.text("the units code")?;
    let words = text.get(..10).unwrap_or(&text).trim();
    let code: i64 = words.parse().map_err(|_| {
        let text = words.chars().take(80).collect();
        lines.error(UffFault::NotANumber { field: "the units code", text })
    })?;
    let text = lines.text("the unit factors")?;
    let factors: Vec<f64> = text.split_ascii_whitespace().map_while(real).collect();
    let &[length, force, ..] = factors.as_slice() else {
        let text = text.chars().take(80).collect();
        return Err(lines.error(UffFault::NotANumber { field: "the unit factors", text }));
    };
    let named = usize::try_from(code - 1).ok().and_then(|k| SYSTEMS.get(k));
    let system = match named {
        Some(&[named_length, named_force]) => {
            let close = |a: f64, b: f64| (a / b - 1.0).abs() < 1e-3;
            if !close(length, named_length) || !close(force, named_force) {
                notes.push(format!(
                    "dataset {}: the factors of the units do not belong to units code {code}; the \
                     code was taken (length {named_length:.6} per m, force {named_force:.6} per N)",
                    lines.dataset()
                ));
            }
            UnitSystem { length: named_length, force: named_force }
        }
        None => {
            for value in [length, force] {
                if !(value.is_finite() && value > 0.0) {
                    return Err(lines.error(UffFault::UnitFactor { value }));
                }
            }
            UnitSystem { length, force }
        }
    };
    lines.skip_to_delimiter()?;
    Ok(system)
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

/// The conversion of `function` to SI: by `quantity` and dataset 164, or by its own records.
pub(super) fn conversion(
    function: &Function,
    quantity: Option<Quantity>,
) -> Result<Conversion, UffError> {
    let hertz =
        hertz(function).map_err(|fault| function.axis_error(&function.abscissa_axis, fault))?;
    let units = function.units.unwrap_or_default();
    let length = 1.0 / units.length;
    let force = 1.0 / units.force;
    if let Some(quantity) = quantity {
        return Ok(Conversion { quantity, ordinate: length / force, hertz });
    }
    let numerator = &function.numerator_axis;
    let quantity = match numerator.data_type {
        8 => Quantity::Displacement,
        11 => Quantity::Velocity,
        12 => Quantity::Acceleration,
        found => {
            let wanted = "acceleration (12), velocity (11) or displacement (8) is needed; when it \
                          is one of these, state it with --quantity";
            let fault = UffFault::WrongQuantity { axis: "ordinate numerator", found, wanted };
            return Err(function.axis_error(numerator, fault));
        }
    };
    let denominator = &function.denominator_axis;
    if denominator.data_type != 13 {
        let wanted = "excitation force (13) is needed; when it is a force, say what the response \
                      is with --quantity";
        let (axis, found) = ("ordinate denominator", denominator.data_type);
        let fault = UffFault::WrongQuantity { axis, found, wanted };
        return Err(function.axis_error(denominator, fault));
    }
    let (motion, over) = split_ratio(&numerator.unit);
    let motion = match motion {
        "" => length,
        unit => motion_unit(unit, quantity)
            .ok_or_else(|| function.axis_error(numerator, unknown_motion(unit, quantity)))?,
    };
    let unknown = |axis, unit| function.axis_error(axis, unknown_force(unit));
    let over = match (over, denominator.unit.as_str()) {
        ("", "") => force,
        ("", unit) => force_unit(unit).ok_or_else(|| unknown(denominator, unit))?,
        (unit, "") => force_unit(unit).ok_or_else(|| unknown(numerator, unit))?,
        (a, b) => {
            let of_numerator = force_unit(a).ok_or_else(|| unknown(numerator, a))?;
            let of_denominator = force_unit(b).ok_or_else(|| unknown(denominator, b))?;
            if of_numerator != of_denominator {
                return Err(unknown(denominator, b));
            }
            of_numerator
        }
    };
    Ok(Conversion { quantity, ordinate: motion / over, hertz })
}

/// The unit of the abscissa, Hz.
fn hertz(function: &Function) -> Result<f64, UffFault> {
    let axis = &function.abscissa_axis;
    if !matches!(axis.data_type, 0 | 1 | 18) {
        let (found, wanted) = (axis.data_type, "frequency (18) is needed");
        return Err(UffFault::WrongQuantity { axis: "abscissa", found, wanted });
    }
    if is_unstated(&axis.unit) {
        return Ok(1.0);
    }
    unit_size(&axis.unit, Measure::Frequency).map_err(|_| UffFault::WrongUnit {
        unit: axis.unit.clone(),
        quantity: Measure::Frequency.name(),
        known: Measure::Frequency.known(),
    })
}

/// Splits `m/s^2/N` into the units of acceleration and force; the second part is empty when there is none.
fn split_ratio(label: &str) -> (&str, &str) {
    match label.rsplit_once('/') {
        Some((motion, force)) if force_unit(force).is_some() => (motion, force),
        _ => (label, ""),
    }
}

fn unknown_motion(unit: &str, quantity: Quantity) -> UffFault {
    let (quantity, known) = match quantity {
        Quantity::Acceleration => {
            ("acceleration", "m/s^2, cm/s^2, mm/s^2, in/s^2, ft/s^2 and g are")
        }
        Quantity::Velocity => ("velocity", "m/s, cm/s, mm/s, in/s and ft/s are"),
        Quantity::Displacement => ("displacement", "m, cm, mm, um, in and ft are"),
    };
    UffFault::WrongUnit { unit: unit.to_owned(), quantity, known }
}

fn unknown_force(unit: &str) -> UffFault {
    let known = "N, mN, kN, lbf, kgf and pdl are, the same in both records";
    UffFault::WrongUnit { unit: unit.to_owned(), quantity: "force", known }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_ratio_is_split_into_numerator_and_denominator() {
        assert_eq!(split_ratio("(m/s^2)/N"), ("(m/s^2)", "N"));
        assert_eq!(split_ratio("m/s^2"), ("m/s^2", ""));
        assert_eq!(split_ratio("g/lbf"), ("g", "lbf"));
    }
}
