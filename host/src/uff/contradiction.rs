//! What contradicts the unit of a function: dataset 164 against its labels, or one part of that dataset against another.

use super::Function;
use super::units::{UnitSystem, are_close};
use crate::units::{Measure, Quantity, force_unit, unit_size};

/// What contradicts the unit in use.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Contradiction {
    /// The number of dataset 164.
    pub(crate) dataset: usize,
    /// What states the other unit.
    pub(crate) source: OtherUnit,
    /// By how many times the values by what contradicts the unit are larger.
    pub(crate) factor: f64,
}

/// What states a unit that is not in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OtherUnit {
    /// Dataset 164, against the labels.
    Dataset,
    /// The factors of dataset 164, against its code.
    Factors,
    /// The description in dataset 164, against its code.
    DescriptionOfCode,
    /// The description in dataset 164, against its factors.
    DescriptionOfFactors,
}

impl Contradiction {
    /// The first contradiction to the size of a unit; `size` gives the size by other units.
    pub(super) fn of(
        units: UnitSystem,
        used: f64,
        by_dataset: f64,
        size: impl Fn(UnitSystem) -> f64,
    ) -> Option<Self> {
        let by = |[length, force]: [f64; 2]| size(UnitSystem { length, force, ..units });
        let description = match units.is_named {
            true => OtherUnit::DescriptionOfCode,
            false => OtherUnit::DescriptionOfFactors,
        };
        let others = [
            Some((OtherUnit::Dataset, by_dataset)),
            units.by_factors.map(|other| (OtherUnit::Factors, by(other))),
            units.by_description.map(|other| (description, by(other))),
        ];
        let (source, other) =
            others.into_iter().flatten().find(|(_, other)| !are_close(*other, used))?;
        Some(Self { dataset: units.dataset, source, factor: other / used })
    }

    /// The contradiction in words: `unit` is in use for the `values`; `number` writes the factor.
    pub(crate) fn sentence(&self, unit: &str, values: &str, number: fn(f64) -> String) -> String {
        let dataset = self.dataset;
        let (used, other) = match self.source {
            OtherUnit::Dataset => ("labels", "dataset 164"),
            OtherUnit::Factors => ("code", "the factors"),
            OtherUnit::DescriptionOfCode => ("code", "the description"),
            OtherUnit::DescriptionOfFactors => ("factors", "the description"),
        };
        let fault = match used {
            "labels" => format!(
                "the labels of the file state {unit} and its dataset {dataset} (164) states other units: the labels are used"
            ),
            "code" => format!(
                "the units code of dataset {dataset} (164) and {} belong to different units: the code is used, which is {unit}",
                other.replace("the", "its")
            ),
            _ => format!(
                "the units factors of dataset {dataset} (164) and its description belong to different units: the factors are \
                 used, which is {unit}"
            ),
        };
        format!("{fault}; by {other} the {values} would be {} times as large", number(self.factor))
    }
}

impl Function {
    /// What contradicts the unit of a record over time, whose label is `unit` where it has one.
    pub(crate) fn time_contradiction(&self) -> Option<Contradiction> {
        let units = self.units?;
        let measure = match self.numerator_axis.data_type {
            9 | 13 => Measure::Force,
            12 => Measure::Motion(Quantity::Acceleration),
            _ => return None,
        };
        let by_dataset = units.size(measure);
        match self.numerator_axis.unit.trim() {
            "" => Contradiction::of(units, by_dataset, by_dataset, |other| other.size(measure)),
            label => {
                let used = unit_size(label, measure).ok()?;
                Contradiction::of(units, used, by_dataset, |_| used)
            }
        }
    }
}

/// The values of 1 m and 1 N by the description of the units, such as `Meter (newton)` or `mm, N`, as far as it states them.
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
            for (found, expected) in described(text).into_iter().zip([length, force]) {
                let is_equal = match (found, expected) {
                    (Some(a), Some(b)) => (a / b - 1.0).abs() < 1e-9,
                    (None, None) => true,
                    _ => false,
                };
                assert!(is_equal, "{text}: {found:?}");
            }
        }
    }
}
