//! What was understood of a file with frequency responses, before it is used.

use std::collections::BTreeSet;

use nalgebra::Complex;

use super::selection::Selection;
use crate::{Error, Result};
use massline_analysis::plausibility::{Doubt, Suspicion};
use massline_files::uff::{Frf, UffFile, UnderstoodFunction, UnitSource};
use massline_result::{FrequencyResponsesRead, UnitsRead};

/// Most datasets or frequencies that a sentence lists.
const LISTED: usize = 5;

/// What was understood of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Reading {
    document: FrequencyResponsesRead,
    understood: Vec<UnderstoodFunction>,
    notes: Vec<String>,
    /// Functions with a bin at 0 Hz.
    with_zero_frequency: usize,
    /// All functions with values.
    in_file: usize,
}

/// One frequency response, with its sign corrected to the layout's directions.
pub(super) struct Response {
    pub(super) name: String,
    pub(super) dataset: usize,
    /// Frequencies in Hz, ascending, and accelerances.
    pub(super) points: Vec<(f64, Complex<f64>)>,
}

impl Reading {
    /// What is understood of a file before its functions are converted.
    pub(super) fn of(uff: &UffFile, selection: &Selection<'_>) -> Self {
        let mut reading = Self { in_file: uff.functions.len(), ..Self::default() };
        reading.notes.extend(uff.notes.iter().cloned().chain(selection.note()));
        if !uff.empty.is_empty() {
            let datasets: Vec<String> = uff.empty.iter().map(|f| f.dataset.to_string()).collect();
            let text = format!("functions without values (dataset {})", listed(&datasets));
            reading.document.left_out.push(text);
        }
        reading
    }

    /// Adds a function in use.
    pub(super) fn add(&mut self, frf: &Frf, understood: &UnderstoodFunction) {
        self.document.functions += 1;
        self.with_zero_frequency += usize::from(frf.frequency_hz.contains(&0.0));
        match self.understood.iter().position(|other| other == understood) {
            Some(place) => self
                .document
                .units
                .iter_mut()
                .skip(place)
                .take(1)
                .for_each(|units| units.functions += 1),
            None => {
                self.document.units.push(UnitsRead {
                    functions: 1,
                    quantity: understood.quantity.frf_name().into(),
                    unit: understood.unit.clone(),
                    source: understood.source.words().into(),
                });
                self.understood.push(understood.clone());
            }
        }
    }

    /// Takes the bins at which a response is no number out of all responses.
    ///
    /// # Errors
    /// When such a bin lies in `band`, which is needed.
    pub(super) fn leave_out_without_number(
        &mut self,
        responses: &mut [Response],
        band: [f64; 2],
    ) -> Result<()> {
        let mut without_number = BTreeSet::new();
        for Response { name, dataset, points } in responses.iter() {
            for (f, _) in points.iter().filter(|(_, h)| !(h.re.is_finite() && h.im.is_finite())) {
                if !f.is_finite() || (band[0] <= *f && *f <= band[1]) {
                    return Err(not_finite(name, *dataset, *f));
                }
                without_number.insert(f.to_bits());
            }
            if let Some((f, _)) = points.iter().find(|(f, _)| !f.is_finite()) {
                return Err(not_finite(name, *dataset, *f));
            }
        }
        for response in responses.iter_mut() {
            response.points.retain(|(f, _)| !without_number.contains(&f.to_bits()));
        }
        if self.with_zero_frequency > 0 {
            self.document.left_out.push("the bin at 0 Hz".to_owned());
        }
        if !without_number.is_empty() {
            let frequencies: Vec<String> =
                without_number.iter().map(|bits| f64::from_bits(*bits).to_string()).collect();
            let text = format!("bins without a number at {} Hz", listed(&frequencies));
            self.document.left_out.push(text);
        }
        let unused = self.in_file.saturating_sub(self.document.functions);
        if unused > 0 {
            self.document
                .left_out
                .push(format!("{unused} functions that the layout does not need"));
        }
        // What all responses have.
        let lengths = responses.iter().map(|response| response.points.len());
        self.document.bins = lengths.min().unwrap_or(0);
        let ends =
            |response: &Response| Some([response.points.first()?.0, response.points.last()?.0]);
        let common =
            responses.iter().filter_map(ends).reduce(|a, b| [a[0].max(b[0]), a[1].min(b[1])]);
        self.document.range_hz = common.unwrap_or_default();
        Ok(())
    }

    /// What was understood, for JSON.
    pub(super) fn document(&self) -> &FrequencyResponsesRead {
        &self.document
    }

    /// What a person should know of how the file was read.
    pub(super) fn notes(&self) -> &[String] {
        &self.notes
    }

    /// True when the file states the whole unit of some response.
    fn states_units(&self) -> bool {
        let is_assumed =
            |source| matches!(source, UnitSource::Assumed | UnitSource::LabelAndAssumed);
        self.understood.iter().any(|of_response| !is_assumed(of_response.source))
    }

    /// Units that are assumed, or that the file contradicts.
    pub(super) fn suspicions(&self) -> impl Iterator<Item = Suspicion> + '_ {
        self.understood.iter().filter_map(|UnderstoodFunction { unit, source, contradiction, .. }| {
            match (contradiction, source) {
                (Some(contradiction), _) => {
                    let message = contradiction.sentence(unit, "accelerances", number);
                    Some(Suspicion::new(Doubt::UnitContradicted, message))
                }
                (None, UnitSource::Assumed | UnitSource::LabelAndAssumed) => {
                    let stated = match source {
                        UnitSource::Assumed => "no unit",
                        _ => "only a part of the unit",
                    };
                    // A unit that some functions state makes the silence of the others suspicious.
                    let (doubt, which) = match self.states_units() {
                        false => (Doubt::UnitAssumed, "its"),
                        true => (Doubt::UnitOfSomeResponses, "some"),
                    };
                    let message = format!(
                        "the file states {stated} of {which} responses, neither by a label nor by dataset 164: they \
                         are taken to be in {unit}"
                    );
                    Some(Suspicion::new(doubt, message))
                }
                (None, _) => None,
            }
        })
    }
}

/// What was understood, in one line for people.
pub(super) fn reading_text(read: &FrequencyResponsesRead) -> String {
    let [low, high] = read.range_hz.map(number);
    let unit =
        |units: &UnitsRead| format!("{} in {} ({})", units.quantity, units.unit, units.source);
    let units = match &read.units[..] {
        [one] => unit(one),
        several => several
            .iter()
            .map(|units| format!("{} of {}", units.functions, unit(units)))
            .collect::<Vec<_>>()
            .join(", "),
    };
    let left_out = match read.left_out.as_slice() {
        [] => String::new(),
        list => format!("; left out: {}", list.join(", ")),
    };
    format!(
        "{} frequency responses: {units}; {} bins from {low} to {high} Hz{left_out}",
        read.functions, read.bins
    )
}

fn not_finite(name: &str, dataset: usize, frequency: f64) -> Error {
    let message = format!(
        "the frequency response of {name} (dataset {dataset}) is NaN or infinite at {frequency} Hz; measure or export \
         it again"
    );
    Error::input("data_not_finite", message)
}

/// The first of these texts, and how many there are besides.
fn listed(texts: &[String]) -> String {
    let more = texts.len().saturating_sub(LISTED);
    let first = texts.iter().take(LISTED).cloned().collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{first} and {more} others") } else { first }
}

/// A number with four digits.
fn number(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let digits = 3 - value.abs().log10().floor() as i32;
    match digits {
        -3..=8 => {
            let text = format!("{value:.*}", digits.max(0) as usize);
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_owned()
            } else {
                text
            }
        }
        _ => format!("{value:.3e}"),
    }
}
