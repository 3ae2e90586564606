//! The document of a command that has failed.

use massline_result::Error;
use serde::{Deserialize, Serialize};

/// The document of a command that has failed. Some commands add keys of their own.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Failure {
    /// The error.
    pub error: Cause,
}

/// Why a command has failed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Cause {
    /// Stable name.
    pub code: String,
    /// A sentence for people.
    pub message: String,
    /// The exit code of the command.
    pub exit: u8,
}

impl From<&Error> for Failure {
    fn from(error: &Error) -> Self {
        let (code, message) = (error.code().to_owned(), error.to_string());
        Self { error: Cause { code, message, exit: error.exit_code() } }
    }
}
