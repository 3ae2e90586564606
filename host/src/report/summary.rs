//! A result in one line: for lists of results on a rig and of archives.

use massline_protocol::object::MeasurementResult;
use massline_shared::diagnosis::Diagnostic;
use serde::Deserialize;

use super::{estimates_of, with_sigma};
use crate::clock;
use crate::document::{self, Spread};
use crate::output::{Output, Tone};
use crate::verdict::Verdict;

/// What a list says about a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Title of the layout.
    pub title: String,
    /// When the campaign was started, RFC 3339; `None` when the rig was not told the time.
    pub measured: Option<String>,
    /// The best answer.
    pub best: Option<BestAnswer>,
    /// The verdict.
    pub verdict: ResultVerdict,
}

/// The best answer to a test, as a list shows it.
#[derive(Clone, Debug, PartialEq, Deserialize)]
pub struct BestAnswer {
    /// Name of the method.
    pub method: String,
    /// The mass.
    pub mass_kg: Spread<f64>,
}

impl BestAnswer {
    fn of_rig(result: &MeasurementResult) -> Option<Self> {
        let best = estimates_of(result).into_iter().next()?;
        let sigma = best.sigma().map(|sigma| sigma[0]);
        let mass_kg = Spread { value: best.body.mass, sigma };
        Some(Self { method: best.method.name().into(), mass_kg })
    }
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

    fn tone(self) -> Tone {
        match self {
            Self::Answered(Verdict::Good) => Tone::Good,
            Self::Answered(Verdict::UseWithCare) | Self::Unsolved => Tone::Warning,
            Self::Answered(Verdict::DoNotUse) | Self::NoAnswer => Tone::Bad,
        }
    }
}

impl Summary {
    /// The summary of a rig's result with the verdict on its answer.
    pub fn of(result: &MeasurementResult, verdict: Option<Verdict>) -> Self {
        let best = BestAnswer::of_rig(result);
        let has_error = result.diagnostics.iter().any(Diagnostic::is_error);
        let verdict = match verdict {
            Some(verdict) => ResultVerdict::Answered(verdict),
            None if !result.lines.is_empty() && !has_error => ResultVerdict::Unsolved,
            None => ResultVerdict::NoAnswer,
        };
        let title = result.head.title.as_str().to_owned();
        Self { title, measured: clock::moment(result.head.started_unix_s), best, verdict }
    }

    /// The summary as an object.
    pub fn to_json(&self) -> document::Summary {
        document::Summary {
            title: self.title.clone(),
            measured: self.measured.clone(),
            method: self.best.as_ref().map(|best| best.method.clone()),
            mass_kg: self.best.as_ref().map(|best| best.mass_kg),
            verdict: self.verdict.name(),
        }
    }

    /// The columns title, measured, method, mass and verdict of a table.
    pub fn columns(&self, output: &Output) -> [String; 5] {
        let mass = |best: &BestAnswer| {
            let Spread { value, sigma } = best.mass_kg;
            match sigma.filter(|sigma| sigma.is_finite()) {
                Some(sigma) => format!("{} kg", with_sigma(value, sigma)),
                None => format!("{value:.4} kg"),
            }
        };
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
        // To the minute: 2026-11-24 08:30.
        let minute = |time: &String| time.replace('T', " ").chars().take(16).collect();
        [
            self.title.clone(),
            or_dash(self.measured.as_ref().map(minute)),
            or_dash(self.best.as_ref().map(|best| best.method.clone())),
            or_dash(self.best.as_ref().map(mass)),
            output.toned(self.verdict.text(), self.verdict.tone()),
        ]
    }
}
