//! Treatment of hits with a fault: the `[policy]` table.

use crate::diagnosis::{Code, Severity};

/// Treatment of a hit with a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HitTreatment {
    /// Average the hit; the finding is a note.
    Keep,
    /// Average the hit and warn.
    Warn,
    /// Do not average the hit; it has to be repeated.
    Reject,
}

impl HitTreatment {
    /// Every treatment.
    pub const ALL: [Self; 3] = [Self::Keep, Self::Warn, Self::Reject];
    /// Their names in files.
    pub const NAMES: [&'static str; 3] = ["keep", "warn", "reject"];

    /// Name in files.
    pub fn name(self) -> &'static str {
        Self::NAMES[self as usize]
    }

    /// The treatment of this name.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|treatment| treatment.name() == name)
    }

    /// Severity of a finding with this treatment.
    pub fn severity(self) -> Severity {
        match self {
            Self::Keep => Severity::Note,
            Self::Warn => Severity::Warning,
            Self::Reject => Severity::Error,
        }
    }
}

/// A treatment for every fault that the grading can find. Faults without a treatment have [the default
/// one](HitPolicy::default_treatment).
///
/// Two bits for each code of [`HitPolicy::CODES`], the first in the lowest bits: 0 for the default, otherwise
/// 1 + the index in [`HitTreatment::ALL`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(transparent))]
pub struct HitPolicy(u32);

impl HitPolicy {
    /// The codes that have a treatment. Stored and transmitted settings depend on their order: append new ones.
    pub const CODES: [Code; 14] = [
        Code::Overload,
        Code::TooWeak,
        Code::TooHard,
        Code::DoubleHit,
        Code::ForceSpectrumLow,
        Code::PreTriggerNotQuiet,
        Code::ClippedRecord,
        Code::TriggerTooEarly,
        Code::DuplicateHit,
        Code::HitInconsistent,
        Code::MotionNotRigid,
        Code::ImpulseTooSmall,
        Code::ImpulseTooLarge,
        Code::HitElsewhere,
    ];

    /// The treatment when none is set: faults that would spoil an average are rejected.
    pub fn default_treatment(code: Code) -> HitTreatment {
        match code {
            Code::Overload
            | Code::TooWeak
            | Code::DoubleHit
            | Code::ClippedRecord
            | Code::DuplicateHit
            | Code::HitElsewhere
            | Code::ImpulseTooSmall => HitTreatment::Reject,
            _ => HitTreatment::Warn,
        }
    }

    /// The treatment for this code.
    pub fn treatment(self, code: Code) -> HitTreatment {
        let set = Self::place(code).and_then(|shift| match (self.0 >> shift) & 3 {
            1 => Some(HitTreatment::Keep),
            2 => Some(HitTreatment::Warn),
            3 => Some(HitTreatment::Reject),
            _ => None,
        });
        set.unwrap_or_else(|| Self::default_treatment(code))
    }

    /// The same with another treatment for this code; unchanged for a code that has none.
    #[must_use]
    pub fn with(self, code: Code, treatment: HitTreatment) -> Self {
        let Some(shift) = Self::place(code) else { return self };
        let bits = match treatment {
            // Every policy has only one encoding, so equal policies compare equal.
            default if default == Self::default_treatment(code) => 0,
            HitTreatment::Keep => 1,
            HitTreatment::Warn => 2,
            HitTreatment::Reject => 3,
        };
        Self((self.0 & !(3 << shift)) | (bits << shift))
    }

    fn place(code: Code) -> Option<usize> {
        Self::CODES.iter().position(|&known| known == code).map(|place| 2 * place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_code_has_its_own_verdict() {
        let mut policy = HitPolicy::default();
        for code in HitPolicy::CODES {
            assert_eq!(policy.treatment(code), HitPolicy::default_treatment(code));
        }
        for (k, code) in HitPolicy::CODES.into_iter().enumerate() {
            policy = policy.with(code, HitTreatment::ALL[k % 3]);
        }
        for (k, code) in HitPolicy::CODES.into_iter().enumerate() {
            assert_eq!(policy.treatment(code), HitTreatment::ALL[k % 3], "{code:?}");
            assert_eq!(policy.with(code, HitTreatment::Keep).treatment(code), HitTreatment::Keep);
        }
    }

    #[test]
    fn a_code_without_a_verdict_changes_nothing() {
        let policy = HitPolicy::default().with(Code::ScansLost, HitTreatment::Keep);
        assert_eq!(policy, HitPolicy::default());
    }

    #[test]
    fn the_name_of_a_verdict_is_read_as_that_verdict() {
        for treatment in HitTreatment::ALL {
            assert_eq!(HitTreatment::from_name(treatment.name()), Some(treatment));
        }
        assert_eq!(HitTreatment::from_name("ignore"), None);
    }
}
