//! Diagnostics on the wire and in stored objects. They are stored as numbers, so that an older program can
//! read those of a newer one.
//!
//! A code that this program does not know keeps its number, an unknown severity reads as the most severe, and
//! an unknown subject as the whole. Use it as `#[serde(with = "massline_protocol::diagnostic")]`.

use core::fmt;

use massline_shared::diagnosis::Setting;
use massline_shared::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A [`Diagnostic`] as it is encoded.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireDiagnostic {
    /// [`Code::number`].
    pub code: u16,
    /// Raw [`Severity`].
    pub severity: u8,
    /// Kind of the subject: 0 the whole, 1 a sensor, 2 a hit DOF, 3 a channel, 4 an inertial parameter, 5 a
    /// setting, 6 the response due to a hit DOF.
    pub subject: u8,
    /// Index of the subject from 0, or the raw [`Setting`]; for a response, the index of the hit DOF.
    pub first: u16,
    /// For a response its index, otherwise 0.
    pub second: u16,
    /// [`Diagnostic::value`].
    pub value: f32,
}

impl From<&Diagnostic> for WireDiagnostic {
    fn from(diagnostic: &Diagnostic) -> Self {
        let Diagnostic { code, severity, subject, value } = *diagnostic;
        let (subject, first, second) = match subject {
            Subject::Whole => (0, 0, 0),
            Subject::Sensor(index) => (1, index, 0),
            Subject::Hit(index) => (2, index, 0),
            Subject::Channel(index) => (3, index, 0),
            Subject::Property(index) => (4, index, 0),
            Subject::Setting(setting) => (5, setting.into(), 0),
            Subject::Response { hit, response } => (6, hit, response),
            Subject::Mode(index) => (7, index, 0),
            Subject::Hits { first, second } => (8, first, second),
        };
        let (code, severity) = (code.number(), severity.into());
        Self { code, severity, subject, first: first.into(), second: second.into(), value }
    }
}

impl From<WireDiagnostic> for Diagnostic {
    fn from(wire: WireDiagnostic) -> Self {
        let WireDiagnostic { code, severity, subject, first, second, value } = wire;
        Self {
            code: Code::from_number(code),
            severity: Severity::try_from(severity).unwrap_or(Severity::Error),
            subject: subject_of(subject, first, second).unwrap_or(Subject::Whole),
            value: if value.is_finite() { value } else { 0.0 },
        }
    }
}

fn subject_of(kind: u8, first: u16, second: u16) -> Option<Subject> {
    let (first, second) = (u8::try_from(first).ok()?, u8::try_from(second).ok()?);
    Some(match kind {
        1 => Subject::Sensor(first),
        2 => Subject::Hit(first),
        3 => Subject::Channel(first),
        4 => Subject::Property(first),
        5 => Subject::Setting(Setting::try_from(first).ok()?),
        6 => Subject::Response { hit: first, response: second },
        7 => Subject::Mode(first),
        8 => Subject::Hits { first, second },
        _ => return None,
    })
}

/// Writes a list of diagnostics.
///
/// # Errors
/// Those of the serializer.
pub fn serialize<S: Serializer>(list: &Diagnostics, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(list.iter().map(WireDiagnostic::from))
}

/// Reads a list of diagnostics.
///
/// # Errors
/// Those of the deserializer, and an error when there are more diagnostics than fit the list.
pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Diagnostics, D::Error> {
    deserializer.deserialize_seq(ListVisitor)
}

struct ListVisitor;

impl<'de> Visitor<'de> for ListVisitor {
    type Value = Diagnostics;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("at most 16 diagnostics")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Diagnostics, A::Error> {
        let mut list = Diagnostics::new();
        while let Some(wire) = items.next_element::<WireDiagnostic>()? {
            if list.push(wire.into()).is_err() {
                return Err(A::Error::invalid_length(list.len() + 1, &self));
            }
        }
        Ok(list)
    }
}

/// A list of diagnostics that is encoded by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct DiagnosticList(#[serde(with = "self")] pub Diagnostics);

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec;

    fn through_the_wire(diagnostic: Diagnostic) -> Diagnostic {
        let list = DiagnosticList([diagnostic].into_iter().collect());
        let mut bytes = [0; 32];
        let encoded = postcard::to_slice(&list, &mut bytes).unwrap();
        postcard::from_bytes::<DiagnosticList>(encoded).unwrap().0[0]
    }

    #[test]
    fn every_code_and_subject_survives_the_wire() {
        for &code in Code::ALL {
            let kind = code.subject_kind();
            for subject in (0..=u8::MAX).map(|index| kind.at(index)).chain([Subject::Whole]) {
                let diagnostic = Diagnostic::about(code, Severity::Warning, subject, -1.5);
                assert_eq!(through_the_wire(diagnostic), diagnostic);
            }
        }
    }

    #[test]
    fn settings_keep_their_numbers() {
        let raw: Vec<u8> = Setting::ALL.iter().map(|&setting| setting.into()).collect();
        assert_eq!(raw, [0, 1, 2, 3, 4, 5, 6, 7, 8]);
        assert!(Setting::ALL.iter().all(|&s| Setting::try_from(u8::from(s)) == Ok(s)));
    }

    #[test]
    fn an_unknown_severity_is_an_error_and_an_unknown_subject_the_whole() {
        let newer = WireDiagnostic {
            code: 999,
            severity: 7,
            subject: 99,
            first: 300,
            second: 1,
            value: f32::NAN,
        };
        let diagnostic = Diagnostic::from(newer);
        assert_eq!((diagnostic.code, diagnostic.severity), (Code::Unknown(999), Severity::Error));
        assert_eq!((diagnostic.subject, diagnostic.value), (Subject::Whole, 0.0));
        assert_eq!(WireDiagnostic::from(&diagnostic).code, 999, "passed on");
        // An index that no subject can have, and an unknown setting.
        for (subject, first) in [(1, 300), (5, 9)] {
            let diagnostic = Diagnostic::from(WireDiagnostic { subject, first, ..newer });
            assert_eq!(diagnostic.subject, Subject::Whole);
        }
    }

    #[test]
    fn more_diagnostics_than_there_is_room_for_are_refused() {
        let wire = WireDiagnostic::from(&Diagnostic::whole(Code::TooWeak, Severity::Error, 1.0));
        let mut bytes = [0; 512];
        let of_16 = postcard::to_slice(&[wire; 16][..], &mut bytes).unwrap();
        assert_eq!(postcard::from_bytes::<DiagnosticList>(of_16).unwrap().0.len(), 16);
        let of_17 = postcard::to_slice(&[wire; 17][..], &mut bytes).unwrap();
        assert!(postcard::from_bytes::<DiagnosticList>(of_17).is_err());
    }
}
