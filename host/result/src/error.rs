//! Why a command has no result: one error type for everything that can make it fail, and the exit code of each kind.
//!
//! | exit | kind | meaning |
//! | --- | --- | --- |
//! | 0 | | success |
//! | 1 | [`ErrorKind::Internal`] | a bug in this program |
//! | 2 | [`ErrorKind::Input`] | a file or an argument is wrong |
//! | 3 | [`ErrorKind::Undetermined`] | the data give no answer that can be used: none at all, or one whose [verdict](crate::Verdict) is `DoNotUse` |
//! | 4 | [`ErrorKind::Device`] | a rig, a port or a link fails |
//! | 130 | [`ErrorKind::Interrupted`] | Ctrl-C |
//!
//! A message says what was tried, what was found and what to do. The code is a stable identifier for
//! programs: a diagnosis code such as `sensors_collinear`, or a code of the program such as `port_not_found`.

use std::borrow::Cow;

/// The stable identifier by which a program distinguishes errors.
pub type ErrorCode = Cow<'static, str>;

/// What kind of thing went wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// A bug in this program. Exit 1.
    Internal,
    /// A file or an argument is wrong. Exit 2.
    Input,
    /// The data cannot determine the answer. Exit 3.
    Undetermined,
    /// A rig, a port or a link fails. Exit 4.
    Device,
    /// The user pressed Ctrl-C. Exit 130.
    Interrupted,
}

/// Why a command failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Error {
    /// What kind of thing went wrong.
    pub kind: ErrorKind,
    /// The stable identifier.
    pub code: ErrorCode,
    /// Message for people; of an interrupted command, what was left unfinished and how to resume it.
    pub message: String,
}

/// The result type of fallible functions of the program.
pub type Result<T, E = Error> = std::result::Result<T, E>;

impl Error {
    /// The code of [`ErrorKind::Interrupted`].
    pub const INTERRUPTED: &'static str = "interrupted";

    /// An error of this kind.
    pub fn new(kind: ErrorKind, code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self { kind, code: code.into(), message: message.into() }
    }

    /// A bug in this program.
    pub fn internal(code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Internal, code, message)
    }

    /// A file or an argument is wrong.
    pub fn input(code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Input, code, message)
    }

    /// The data cannot determine the answer.
    pub fn undetermined(code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Undetermined, code, message)
    }

    /// A rig, a port or a link fails.
    pub fn device(code: impl Into<ErrorCode>, message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Device, code, message)
    }

    /// The user pressed Ctrl-C.
    pub fn interrupted(message: impl Into<String>) -> Self {
        Self::new(ErrorKind::Interrupted, Self::INTERRUPTED, message)
    }

    /// The exit code of the process.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            ErrorKind::Internal => 1,
            ErrorKind::Input => 2,
            ErrorKind::Undetermined => 3,
            ErrorKind::Device => 4,
            ErrorKind::Interrupted => 130,
        }
    }

    /// The stable identifier.
    pub fn code(&self) -> &str {
        &self.code
    }

    /// The same error with `context` in front of its message: `context: message`.
    #[must_use]
    pub fn within(mut self, context: impl std::fmt::Display) -> Self {
        self.message = format!("{context}: {}", self.message);
        self
    }

    /// The same error with `advice` after its message: `message; advice`.
    #[must_use]
    pub fn advising(mut self, advice: impl std::fmt::Display) -> Self {
        self.message = format!("{}; {advice}", self.message);
        self
    }
}

#[cfg(test)]
mod tests {
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

    #[test]
    fn context_stands_before_a_message_and_advice_after_it() {
        let error = Error::device("no_answer", "no").within("/dev/ttyACM0").advising("wait");
        assert_eq!(
            (error.code(), error.to_string().as_str()),
            ("no_answer", "/dev/ttyACM0: no; wait")
        );
    }
}
