//! Numbers of text files, with a decimal point or comma.

use super::RecordingError;

/// The decimal sign of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decimal {
    Point,
    Comma,
}

impl Decimal {
    /// The name of the decimal sign.
    pub fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Comma => "comma",
        }
    }

    /// Parses a field; `None` when it is not a number.
    pub fn number(self, field: &str) -> Option<f64> {
        let field = field.trim().trim_matches('"');
        match self {
            Self::Point => field.parse().ok(),
            Self::Comma if field.contains('.') => None,
            Self::Comma => field.replace(',', ".").parse().ok(),
        }
    }

    /// Parses a field; the error names the line and the column.
    pub fn value(self, field: &str, line: usize, column: usize) -> Result<f64, RecordingError> {
        self.number(field).ok_or_else(|| RecordingError::NotANumber {
            line,
            column: column + 1,
            text: field.trim().chars().take(40).collect(),
            decimal: self.name(),
        })
    }
}
