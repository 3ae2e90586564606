//! What contradicts the unit of a function: dataset 164 against its labels, or one part of that dataset against
//! another.

use super::Function;
use super::unit_system::{UnitSystem, are_close};
use crate::units::{Measure, Quantity, unit_size};

/// What contradicts the unit in use.
#[derive(Clone, Debug, PartialEq)]
pub struct Contradiction {
    /// The number of dataset 164.
    pub dataset: usize,
    /// What states the other unit.
    pub source: OtherUnit,
    /// By how many times the values by what contradicts the unit are larger.
    pub factor: f64,
}

/// What states a unit that is not in use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OtherUnit {
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
    pub fn sentence(&self, unit: &str, values: &str, number: fn(f64) -> String) -> String {
        let dataset = self.dataset;
        let (used, other) = match self.source {
            OtherUnit::Dataset => ("labels", "dataset 164"),
            OtherUnit::Factors => ("code", "the factors"),
            OtherUnit::DescriptionOfCode => ("code", "the description"),
            OtherUnit::DescriptionOfFactors => ("factors", "the description"),
        };
        let fault = match used {
            "labels" => format!(
                "the labels of the file state {unit} and its dataset {dataset} (164) states other units: the labels \
                 are used"
            ),
            "code" => format!(
                "the units code of dataset {dataset} (164) and {} belong to different units: the code is used, which \
                 is {unit}",
                other.replace("the", "its")
            ),
            _ => format!(
                "the units factors of dataset {dataset} (164) and its description belong to different units: the \
                 factors are used, which is {unit}"
            ),
        };
        format!("{fault}; by {other} the {values} would be {} times as large", number(self.factor))
    }
}

impl Function {
    /// What contradicts the unit of a record over time, whose label is `unit` where it has one.
    pub fn time_contradiction(&self) -> Option<Contradiction> {
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
