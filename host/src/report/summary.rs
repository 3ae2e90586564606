//! A result in one line: for lists of results on a rig and of archives.

use massline_protocol::object::MeasurementResult;
use massline_shared::diagnosis::{Diagnostic, Severity};
use massline_shared::identify::Estimate;

use super::{estimates_of, with_sigma};
use crate::clock;
use crate::document::{self, Spread};
use crate::output::{Output, Tone};

/// What a list says about a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Title of the layout.
    pub title: String,
    /// When the campaign was started, RFC 3339; `None` when the rig was not told the time.
    pub measured: Option<String>,
    /// The best estimate.
    pub best: Option<Estimate<f64>>,
    /// The verdict.
    pub verdict: ResultVerdict,
}

/// Whether a result can be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResultVerdict {
    /// Nothing was found that would put the result in doubt.
    Good,
    /// So many warnings: `massline results get` shows them.
    Warned(usize),
    /// No object has such inertial parameters.
    Unphysical,
    /// The lines of the suspension modes are there, and the rig has no answer to them.
    Unsolved,
    /// The data did not determine an answer.
    NoAnswer,
}

impl ResultVerdict {
    /// The verdict in words.
    pub fn text(self) -> String {
        match self {
            Self::Good => "good".into(),
            Self::Warned(1) => "1 warning".into(),
            Self::Warned(count) => format!("{count} warnings"),
            Self::Unphysical => "unphysical".into(),
            Self::Unsolved => "to be solved".into(),
            Self::NoAnswer => "no answer".into(),
        }
    }

    fn tone(self) -> Tone {
        match self {
            Self::Good => Tone::Good,
            Self::Warned(_) | Self::Unsolved => Tone::Warning,
            Self::Unphysical | Self::NoAnswer => Tone::Bad,
        }
    }
}

impl Summary {
    /// The summary of a rig's result.
    pub fn of(result: &MeasurementResult) -> Self {
        let best = estimates_of(result).into_iter().next();
        let of_best = best.iter().flat_map(|best| &best.diagnostics);
        let is_grave = |d: &&Diagnostic| d.severity > Severity::Note;
        let warnings = of_best.chain(&result.diagnostics).filter(is_grave).count();
        let verdict = match &best {
            None if !result.lines.is_empty()
                && !result.diagnostics.iter().any(Diagnostic::is_error) =>
            {
                ResultVerdict::Unsolved
            }
            None => ResultVerdict::NoAnswer,
            Some(best) if !best.body.is_physically_consistent() => ResultVerdict::Unphysical,
            Some(_) if warnings > 0 => ResultVerdict::Warned(warnings),
            Some(_) => ResultVerdict::Good,
        };
        let title = result.head.title.as_str().to_owned();
        Self { title, measured: clock::moment(result.head.started_unix_s), best, verdict }
    }

    /// The summary as an object.
    pub fn to_json(&self) -> document::Summary {
        let mass = |best: &Estimate<f64>| Spread {
            value: best.body.mass,
            sigma: best.sigma().map(|sigma| sigma[0]),
        };
        document::Summary {
            title: self.title.clone(),
            measured: self.measured.clone(),
            method: self.best.as_ref().map(|best| best.method.name()),
            mass_kg: self.best.as_ref().map(mass),
            verdict: self.verdict.text(),
        }
    }

    /// The columns title, measured, method, mass and verdict of a table.
    pub fn columns(&self, output: &Output) -> [String; 5] {
        let mass = |best: &Estimate<f64>| {
            let sigma = best.sigma().map_or(f64::NAN, |sigma| sigma[0]);
            if sigma.is_finite() {
                format!("{} kg", with_sigma(best.body.mass, sigma))
            } else {
                format!("{:.4} kg", best.body.mass)
            }
        };
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "–".into());
        // To the minute: 2026-11-24 08:30.
        let minute = |time: &String| time.replace('T', " ").chars().take(16).collect();
        [
            self.title.clone(),
            or_dash(self.measured.as_ref().map(minute)),
            or_dash(self.best.as_ref().map(|best| best.method.name().to_owned())),
            or_dash(self.best.as_ref().map(mass)),
            output.toned(&self.verdict.text(), self.verdict.tone()),
        ]
    }
}
