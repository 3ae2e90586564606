//! Findings, refusals and what a test cannot see.

use massline_shared::diagnosis::Severity;
use massline_shared::identify::Method;
use serde::{Deserialize, Serialize};

use crate::finding_code::FindingCode;
use crate::named::NamedValue;
use crate::verdict::Verdict;

/// A note, a warning or an error about a test.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// What was found.
    pub code: FindingCode,
    /// `note`, `warning` or `error`.
    pub severity: NamedValue<Severity>,
    /// A sentence for people.
    pub message: String,
}

impl Finding {
    /// Whether it puts the answer in doubt.
    pub fn is_grave(&self) -> bool {
        self.severity.0 > Severity::Note
    }
}

/// Something that puts an answer in doubt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct VerdictReason {
    /// What it is.
    pub code: FindingCode,
    /// What it makes of the result.
    pub verdict: Verdict,
    /// A sentence for people.
    pub message: String,
    /// How many more findings of its code there are, none of them with a larger value; those about the whole test are
    /// in `diagnostics`, those about the answer in that of `results`.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub alike: usize,
}

fn is_zero(count: &usize) -> bool {
    *count == 0
}

impl VerdictReason {
    /// Whether it says what a finding says.
    pub fn says(&self, finding: &Finding) -> bool {
        self.code == finding.code && (self.alike == 0 || self.message == finding.message)
    }
}

/// A method without an answer.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Refusal {
    /// The method.
    pub method: NamedValue<Method>,
    /// Stable name of the first reason.
    pub code: String,
    /// All reasons as sentences.
    pub message: String,
    /// Stable names of all reasons.
    pub codes: Vec<String>,
}

/// An error that the test cannot see.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UnseenError {
    /// Stable name.
    pub source: String,
    /// What it is and how far it is covered.
    pub message: String,
}
