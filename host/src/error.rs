//! One error type for everything that can make a command fail, and the exit code of each kind.
//!
//! | exit | kind | meaning |
//! | --- | --- | --- |
//! | 0 | | success |
//! | 1 | [`Error::Internal`] | a bug in this program |
//! | 2 | [`Error::Input`] | a file or an argument is wrong |
//! | 3 | [`Error::Undetermined`] | the data give no answer that can be used: none at all, or one whose [verdict](massline_result::Verdict) is `DoNotUse` |
//! | 4 | [`Error::Device`] | a rig, a port or a link fails |
//! | 130 | [`Error::Interrupted`] | Ctrl-C |
//!
//! A message says what was tried, what was found and what to do. The code is a stable identifier for
//! programs: a diagnosis code such as `sensors_collinear`, or a code of this crate such as `port_not_found`.

use std::borrow::Cow;

use crate::document::{Cause, Failure};

/// The stable identifier by which a program distinguishes errors.
pub type ErrorCode = Cow<'static, str>;

/// Why a command failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Error {
    /// A bug in this program. Exit 1.
    #[error("{message}")]
    Internal {
        /// Stable identifier.
        code: ErrorCode,
        /// Message for people.
        message: String,
    },
    /// A file or an argument is wrong. Exit 2.
    #[error("{message}")]
    Input {
        /// Stable identifier.
        code: ErrorCode,
        /// Message for people.
        message: String,
    },
    /// The data cannot determine the answer. Exit 3.
    #[error("{message}")]
    Undetermined {
        /// Stable identifier.
        code: ErrorCode,
        /// Message for people.
        message: String,
    },
    /// A rig, a port or a link fails. Exit 4.
    #[error("{message}")]
    Device {
        /// Stable identifier.
        code: ErrorCode,
        /// Message for people.
        message: String,
    },
    /// The user pressed Ctrl-C. Exit 130.
    #[error("{message}")]
    Interrupted {
        /// What was left unfinished and how to resume it.
        message: String,
    },
}

/// The result type of this crate's fallible functions.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// The code of [`Error::Interrupted`].
    pub const INTERRUPTED: &'static str = "interrupted";

    /// A bug in this program.
    pub fn internal(code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self::Internal { code: code.into(), message: message.into() }
    }

    /// A file or an argument is wrong.
    pub fn input(code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self::Input { code: code.into(), message: message.into() }
    }

    /// The data cannot determine the answer.
    pub fn undetermined(code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self::Undetermined { code: code.into(), message: message.into() }
    }

    /// A rig, a port or a link fails.
    pub fn device(code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self::Device { code: code.into(), message: message.into() }
    }

    /// The user pressed Ctrl-C.
    pub fn interrupted(message: impl Into<String>) -> Self {
        Self::Interrupted { message: message.into() }
    }

    /// The exit code of the process.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Internal { .. } => 1,
            Self::Input { .. } => 2,
            Self::Undetermined { .. } => 3,
            Self::Device { .. } => 4,
            Self::Interrupted { .. } => 130,
        }
    }

    /// The stable identifier.
    pub fn code(&self) -> &str {
        match self {
            Self::Internal { code, .. }
            | Self::Input { code, .. }
            | Self::Undetermined { code, .. }
            | Self::Device { code, .. } => code,
            Self::Interrupted { .. } => Self::INTERRUPTED,
        }
    }

    /// What `--json` prints.
    pub fn document(&self) -> Failure {
        Failure {
            error: Cause {
                code: self.code().to_owned(),
                message: self.to_string(),
                exit: self.exit_code(),
            },
        }
    }

    /// The same error with `context` in front of its message: `context: message`.
    #[must_use]
    pub fn within(mut self, context: impl std::fmt::Display) -> Self {
        let message = self.message_mut();
        *message = format!("{context}: {message}");
        self
    }

    /// The same error with `advice` after its message: `message; advice`.
    #[must_use]
    pub fn advising(mut self, advice: impl std::fmt::Display) -> Self {
        let message = self.message_mut();
        *message = format!("{message}; {advice}");
        self
    }

    fn message_mut(&mut self) -> &mut String {
        match self {
            Self::Internal { message, .. }
            | Self::Input { message, .. }
            | Self::Undetermined { message, .. }
            | Self::Device { message, .. }
            | Self::Interrupted { message } => message,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn every_kind_has_its_exit_code() {
        let errors = [
            Error::internal("a", ""),
            Error::input("a", ""),
            Error::undetermined("a", ""),
            Error::device("a", ""),
            Error::interrupted(""),
        ];
        assert_eq!(errors.map(|e| e.exit_code()), [1, 2, 3, 4, 130]);
    }

    /// Two backslashes at the end of a line print one, and the line end and the indentation of the next line after it.
    #[test]
    fn no_line_of_a_text_ends_with_an_escaped_backslash() {
        let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("src")];
        let mut files = 0;
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|extension| extension == "rs") {
                    files += 1;
                    let source = fs::read_to_string(&path).unwrap();
                    let line = source.lines().position(|line| line.ends_with(r"\\"));
                    assert_eq!(line, None, "{}, counted from 0", path.display());
                }
            }
        }
        assert!(files > 100, "{files} files found");
    }

    #[test]
    fn the_document_carries_code_message_and_exit() {
        let document = Error::device("port_busy", "no").within("/dev/ttyACM0").document();
        let Cause { code, message, exit } = document.error;
        assert_eq!((code.as_str(), message.as_str(), exit), ("port_busy", "/dev/ttyACM0: no", 4));
        let advising = Error::device("no_answer", "no").advising("wait");
        assert_eq!((advising.code(), advising.to_string().as_str()), ("no_answer", "no; wait"));
    }
}
