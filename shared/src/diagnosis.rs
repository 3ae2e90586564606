//! The codes that name every problem, on the screen and in a report.
//!
//! A [`Diagnostic`] names a fact (its [`Code`]), its severity, what it is about (its [`Subject`]) and the
//! number that decided. Everything known about a code is in one row of one table.

#[macro_use]
mod codes;
mod setting;
mod subject;
mod table;
mod value;

use core::fmt;

use num_enum::{IntoPrimitive, TryFromPrimitive};

use crate::real::Real;

pub use setting::{AllowedValues, MAX_HITS_PER_DOF, Setting};
pub use subject::{Subject, SubjectKind};
pub use table::Code;
pub use value::ValueUnit;

/// What a diagnostic means for the answer. The numbers never change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, IntoPrimitive, TryFromPrimitive)]
#[repr(u8)]
pub enum Severity {
    /// Worth knowing; the answer stands.
    Note = 0,
    /// The answer stands with a reservation.
    Warning = 1,
    /// There is no answer.
    Error = 2,
}

impl Severity {
    /// The name in reports and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        }
    }
}

impl Code {
    /// True when a diagnostic of this severity makes the rig interrupt a campaign until it is resumed.
    pub fn interrupts(self) -> bool {
        matches!(self, Self::ResultNotStored | Self::LinesNotStored | Self::SamplerStopped)
    }
}

/// Writes the stable name, or `code_n` for a code that this program does not know.
impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unknown(number) => write!(f, "code_{number}"),
            known => f.write_str(known.name()),
        }
    }
}

/// One named fact with the number that decided it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diagnostic {
    /// The fact.
    pub code: Code,
    /// What it means for the answer.
    pub severity: Severity,
    /// The subject: of the kind that belongs to the code, or [`Subject::Whole`].
    pub subject: Subject,
    /// The number that decided, in the unit of the code; 0 when there is none or it is not finite.
    pub value: f32,
}

// A rig stores many of them.
const _: () = assert!(size_of::<Diagnostic>() <= 12);

impl Diagnostic {
    /// A diagnostic about the whole layout, hit, data set or answer.
    pub fn whole(code: Code, severity: Severity, value: f32) -> Self {
        Self::about(code, severity, Subject::Whole, value)
    }

    /// A diagnostic about one subject, which has to be of the kind that belongs to the code.
    pub fn about(code: Code, severity: Severity, subject: Subject, value: f32) -> Self {
        debug_assert!(code.subject_kind().admits(subject), "{code} is not about {subject:?}");
        // NaN is not equal to itself, so a status that contains it would always seem to have changed.
        let value = if value.is_finite() { value } else { 0.0 };
        Self { code, severity, subject, value }
    }

    /// True when this diagnostic means that there is no answer.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// True when the rig has interrupted the campaign because of this diagnostic.
    pub fn interrupts(&self) -> bool {
        self.code.interrupts()
    }
}

/// The diagnostics of one answer.
pub type Diagnostics = heapless::Vec<Diagnostic, 16>;

/// A single error about the whole: there is no answer.
pub(crate) fn fatal<R: Real>(code: Code, value: R) -> Diagnostics {
    Diagnostics::from_array([Diagnostic::whole(code, Severity::Error, value.to_f32())])
}

#[cfg(test)]
mod tests;
