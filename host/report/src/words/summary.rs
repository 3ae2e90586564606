//! A result in one line: for lists of results on a rig and of archives.

use massline_result::{Estimate, SolvedBy, Spread, TestResult, Verdict};
use massline_shared::diagnosis::Severity;

use super::{as_exact_as, with_half_width};
use crate::document;
use crate::wrap::KEPT;

/// What a list says about a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Title of the layout.
    pub title: String,
    /// When the campaign was started, RFC 3339; `None` when the rig was not told the time.
    pub measured: Option<String>,
    /// Name of the method of the answer, and the mass by it.
    pub answer: Option<(&'static str, Spread<f64>)>,
    /// Half the width of the 95 % interval of that mass, kg; `None` where it is not known.
    pub half_width_kg: Option<f64>,
    /// The verdict.
    pub verdict: ResultVerdict,
}

/// Whether a result can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultVerdict {
    /// There is an answer with this verdict.
    Answered(Verdict),
    /// The lines of the suspension modes are there, and the rig has no answer to them.
    Unsolved,
    /// The data did not determine an answer.
    NoAnswer,
}

impl ResultVerdict {
    /// The verdict in words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Answered(verdict) => verdict.words(),
            Self::Unsolved => "to be solved",
            Self::NoAnswer => "no answer",
        }
    }

    /// The verdict in JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Answered(verdict) => verdict.name(),
            Self::Unsolved => "to_be_solved",
            Self::NoAnswer => "no_answer",
        }
    }
}

impl Summary {
    /// The summary of a result.
    pub fn of(result: &TestResult) -> Self {
        let has_error =
            result.diagnostics.iter().any(|diagnostic| diagnostic.severity == Severity::Error);
        let is_unsolved = result.solved_by == SolvedBy::Rig && !result.lines.is_empty();
        Self {
            title: result.title.clone(),
            measured: result.measured.clone(),
            answer: result.answer().map(|answer| (answer.method.name(), mass_of(answer))),
            half_width_kg: result.answer().and_then(|answer| Some(answer.half_widths()?[0])),
            verdict: match result.verdict {
                Some(verdict) => ResultVerdict::Answered(verdict),
                None if is_unsolved && !has_error => ResultVerdict::Unsolved,
                None => ResultVerdict::NoAnswer,
            },
        }
    }

    /// The summary as an object.
    pub fn document(&self) -> document::Summary {
        document::Summary {
            title: self.title.clone(),
            measured: self.measured.clone(),
            method: self.answer.map(|(method, _)| method.to_owned()),
            mass_kg: self.answer.map(|(_, mass)| mass),
            verdict: self.verdict.name(),
        }
    }

    /// The columns title, measured, method, mass ± 95 % and verdict of a table.
    pub fn columns(&self) -> [String; 5] {
        let mass = |Spread { value, .. }: Spread<f64>| {
            let mass = match self.half_width_kg.filter(|half| half.is_finite()) {
                Some(half) => format!("{} kg", with_half_width(value, half)),
                None => format!("{} kg", as_exact_as(value, None)),
            };
            mass.replace(' ', &KEPT.to_string())
        };
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
        // To the minute: 2026-11-24 08:30.
        let minute = |time: &String| time.replace('T', " ").chars().take(16).collect();
        [
            self.title.clone(),
            or_dash(self.measured.as_ref().map(minute)),
            or_dash(self.answer.map(|(method, _)| method.to_owned())),
            or_dash(self.answer.map(|(_, spread)| mass(spread))),
            self.verdict.text().to_owned(),
        ]
    }
}

/// The mass with its standard deviation, unless that covers the scatter between hits only.
fn mass_of(answer: &Estimate) -> Spread<f64> {
    let sigma = answer.mass_kg.sigma.filter(|_| !answer.covers_scatter_only());
    Spread { sigma, ..answer.mass_kg }
}
