//! Findings, refusals and what a test cannot see.

use schemars::JsonSchema;
use serde::Serialize;

use crate::verdict::Verdict;

/// Who has found something, where that may be the rig or the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "found_by")]
pub enum FoundBy {
    /// The rig.
    Rig,
    /// This program.
    Host,
}

/// A note, a warning or an error about a test.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "finding")]
pub struct Finding {
    /// Stable name of what was found.
    pub code: String,
    /// `note`, `warning` or `error`.
    pub severity: &'static str,
    /// A sentence for people.
    pub message: String,
}

/// Something that puts an answer in doubt.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "verdict_reason")]
pub struct VerdictReason {
    /// Stable name.
    pub code: &'static str,
    /// What it makes of the result.
    pub verdict: Verdict,
    /// A sentence or a clause for people.
    pub message: String,
}

/// A method without an answer.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "refusal")]
pub struct Refusal {
    /// Name of the method.
    pub method: &'static str,
    /// Stable name of the first reason.
    pub code: String,
    /// All reasons as sentences.
    pub message: String,
    /// Stable names of all reasons.
    pub codes: Vec<String>,
}

/// An error that the test cannot see.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[schemars(rename = "unseen")]
pub struct Unseen {
    /// Stable name.
    pub source: &'static str,
    /// What it is and how far it is covered.
    pub message: String,
}

/// The document of a command that has failed. Some commands add keys of their own.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "failure")]
pub struct Failure {
    /// The error.
    pub error: Cause,
}

/// Why a command has failed.
#[derive(Clone, Debug, PartialEq, Serialize, JsonSchema)]
#[schemars(rename = "cause")]
pub struct Cause {
    /// Stable name.
    pub code: String,
    /// A sentence for people.
    pub message: String,
    /// The exit code of the command.
    pub exit: u8,
}
