//! The codes by which every problem is named, on the screen and in a report.
//!
//! A [`Diagnostic`] says which fact (its [`Code`]), how grave it is, what it is about (its [`Subject`]) and
//! the number that decided. All that is known of a code stands in one row of one table.

#[macro_use]
mod codes;
mod setting;
mod subject;
mod table;
mod value;

use core::fmt;

use num_enum::{IntoPrimitive, TryFromPrimitive};

use crate::Real;

pub use setting::Setting;
pub use subject::{Subject, SubjectKind};
pub use table::Code;
pub use value::ValueUnit;

/// What a diagnostic means for the answer. The numbers are never changed.
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
    /// True when the rig interrupts a campaign because of this, until it is told to go on.
    pub fn interrupts(self) -> bool {
        matches!(self, Self::ResultNotStored | Self::SamplerStopped)
    }
}

/// The stable name; `code_n` of a code that this program does not know.
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
    /// Which fact.
    pub code: Code,
    /// What it means for the answer.
    pub severity: Severity,
    /// What it is about; of the kind that the code says, or [`Subject::Whole`].
    pub subject: Subject,
    /// The number that decided, in the unit of the code; 0 when none or not finite.
    pub value: f32,
}

// Rigs keep many of them.
const _: () = assert!(size_of::<Diagnostic>() <= 12);

impl Diagnostic {
    /// A diagnostic about the whole layout, hit, data set or answer.
    pub fn whole(code: Code, severity: Severity, value: f32) -> Self {
        Self::about(code, severity, Subject::Whole, value)
    }

    /// A diagnostic about one subject, which is of the kind that the code says.
    pub fn about(code: Code, severity: Severity, subject: Subject, value: f32) -> Self {
        debug_assert!(code.subject_kind().admits(subject), "{code} is not about {subject:?}");
        // NaN is not equal to itself: a status that carries it would differ from itself for ever.
        let value = if value.is_finite() { value } else { 0.0 };
        Self { code, severity, subject, value }
    }

    /// True when there is no answer because of this.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }

    /// True when the rig has interrupted the campaign because of this.
    pub fn interrupts(&self) -> bool {
        self.code.interrupts()
    }
}

/// As many diagnostics as one answer carries.
pub type Diagnostics = heapless::Vec<Diagnostic, 16>;

/// The one error about the whole that takes the answer away.
pub(crate) fn fatal<R: Real>(code: Code, value: R) -> Diagnostics {
    Diagnostics::from_array([Diagnostic::whole(code, Severity::Error, value.to_f32())])
}

#[cfg(test)]
mod tests;
