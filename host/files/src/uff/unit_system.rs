//! Dataset 164: the units of a file.

use super::error::{UffError, UffFault};
use super::lines::Lines;
use super::values::real;
use crate::units::{
    FOOT, INCH, KILOGRAM_FORCE, Measure, POUND_FORCE, POUNDAL, Quantity, force_unit, unit_size,
};

/// The units of a dataset 164: the values of 1 m and 1 N in the file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UnitSystem {
    /// The number of the dataset.
    pub(super) dataset: usize,
    pub(super) length: f64,
    pub(super) force: f64,
    /// Whether they are those of its code; else they are those of its factors.
    pub(super) is_named: bool,
    /// Length and force by the factors of the dataset, where they belong to other units than its code.
    pub(super) by_factors: Option<[f64; 2]>,
    /// Length and force by the description of the dataset, where it states other units.
    pub(super) by_description: Option<[f64; 2]>,
}

impl UnitSystem {
    /// True for the same units.
    pub(super) fn equals(&self, other: &Self) -> bool {
        are_close(self.length, other.length) && are_close(self.force, other.force)
    }

    /// The sizes of the units of this measure: m or N, and what belongs to it.
    pub(super) fn size(&self, measure: Measure) -> f64 {
        match measure {
            Measure::Motion(_) => 1.0 / self.length,
            Measure::Force => 1.0 / self.force,
            _ => self.force / self.length,
        }
    }
}

/// Whether two units are equal to the digits that writers give their factors.
pub(super) fn are_close(a: f64, b: f64) -> bool {
    (a / b - 1.0).abs() < 1e-3
}

/// The systems of dataset 164's unit codes: the values of 1 m and 1 N.
const SYSTEMS: [(i64, [f64; 2]); 9] = [
    (1, [1.0, 1.0]),
    (2, [1.0 / FOOT, 1.0 / POUND_FORCE]),
    (3, [1.0, 1.0 / KILOGRAM_FORCE]),
    (4, [1.0 / FOOT, 1.0 / POUNDAL]),
    (5, [1e3, 1e3]),
    (6, [1e2, 1e2]),
    (7, [1.0 / INCH, 1.0 / POUND_FORCE]),
    (8, [1e3, 1.0 / KILOGRAM_FORCE]),
    (10, [1e3, 1.0]),
];

/// Reads dataset 164 from after its first line to its end.
///
/// Codes 1 to 8 and 10 define their units; for the others (9 is user defined) the factors are used. Writers disagree
/// about the factors that belong to a code, some write their reciprocals, so the code takes precedence.
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
    let description: String = text.chars().skip(10).take(20).collect();
    let text = lines.text("the unit factors")?;
    let factors: Vec<f64> = text.split_ascii_whitespace().map_while(real).collect();
    let &[length, force, ..] = factors.as_slice() else {
        let text = text.chars().take(80).collect();
        return Err(lines.error(UffFault::NotANumber { field: "the unit factors", text }));
    };
    let named = SYSTEMS.iter().find(|(other, _)| *other == code);
    let mut system = match named {
        Some(&(_, [named_length, named_force])) => {
            let belong = |length: f64, force: f64| {
                are_close(length, named_length) && are_close(force, named_force)
            };
            if !belong(length, force) {
                notes.push(format!(
                    "dataset {}: the factors of the units do not belong to units code {code}; the \
                     code was taken (length {named_length:.6} per m, force {named_force:.6} per N)",
                    lines.dataset()
                ));
            }
            let are_others = !belong(length, force)
                && !belong(1.0 / length, 1.0 / force)
                && [length, force].iter().all(|factor| factor.is_finite() && *factor > 0.0);
            UnitSystem {
                dataset: lines.dataset(),
                length: named_length,
                force: named_force,
                is_named: true,
                by_factors: are_others.then_some([length, force]),
                by_description: None,
            }
        }
        None => {
            for value in [length, force] {
                if !(value.is_finite() && value > 0.0) {
                    return Err(lines.error(UffFault::UnitFactor { value }));
                }
            }
            UnitSystem {
                dataset: lines.dataset(),
                length,
                force,
                is_named: false,
                by_factors: None,
                by_description: None,
            }
        }
    };
    let [length, force] = described(&description);
    let by_description = [length.unwrap_or(system.length), force.unwrap_or(system.force)];
    let is_other =
        !are_close(by_description[0], system.length) || !are_close(by_description[1], system.force);
    system.by_description = is_other.then_some(by_description);
    lines.skip_to_delimiter()?;
    Ok(system)
}

/// The values of 1 m and 1 N by the description of the units, such as `Meter (newton)` or `mm, N`, as far as it states
/// them.
pub(super) fn described(description: &str) -> [Option<f64>; 2] {
    let text = description.rsplit(':').next().unwrap_or_default().to_owned();
    let text =
        [("pound f", "lbf"), ("kilogram f", "kgf"), ("milli-newton", "mN"), ("centi-newton", "cN")]
            .iter()
            .fold(text, |text, (words, unit)| replaced(&text, words, unit));
    let words = || text.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let read = |word: &str, size: &dyn Fn(&str) -> Option<f64>| {
        size(word).or_else(|| size(&word.to_lowercase())).map(f64::recip)
    };
    let length = |word: &str| unit_size(word, Measure::Motion(Quantity::Displacement)).ok();
    [
        words().find_map(|word| read(word, &length)),
        words().find_map(|word| read(word, &|word| force_unit(word))),
    ]
}

/// A text with words, in whatever case, replaced.
fn replaced(text: &str, words: &str, by: &str) -> String {
    match text.to_ascii_lowercase().find(words) {
        Some(at) => {
            let (before, after) = (text.get(..at), text.get(at + words.len()..));
            format!("{}{by}{}", before.unwrap_or_default(), after.unwrap_or_default())
        }
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_read_from_their_description() {
        for (text, length, force) in [
            ("Meter (newton)", Some(1.0), Some(1.0)),
            ("SI: Meter (newton)", Some(1.0), Some(1.0)),
            ("Foot (pound f)", Some(1.0 / 0.3048), Some(1.0 / 4.448_221_615_260_5)),
            ("Meter (kilogram f)", Some(1.0), Some(1.0 / 9.806_65)),
            ("mm (milli-newton)", Some(1e3), Some(1e3)),
            ("CM (Centi-Newton)", Some(1e2), Some(1e2)),
            ("Inch (Pound f)", Some(1.0 / 0.0254), Some(1.0 / 4.448_221_615_260_5)),
            ("mm, N", Some(1e3), Some(1.0)),
            ("MM_NEWTON", Some(1e3), Some(1.0)),
            ("USER_DEFINED", None, None),
            ("units", None, None),
            ("", None, None),
        ] {
            for (size, expected) in described(text).into_iter().zip([length, force]) {
                let is_equal = match (size, expected) {
                    (Some(a), Some(b)) => (a / b - 1.0).abs() < 1e-9,
                    (None, None) => true,
                    _ => false,
                };
                assert!(is_equal, "{text}: {size:?}");
            }
        }
    }
}
