use super::*;
use std::string::ToString;

#[test]
fn every_code_is_found_by_its_number() {
    for &code in Code::ALL {
        assert_eq!(Code::from_number(code.number()), code);
    }
    assert_eq!(Code::from_number(999), Code::Unknown(999));
    assert_eq!(Code::Unknown(999).number(), 999);
}

#[test]
fn names_are_unique() {
    for (i, a) in Code::ALL.iter().enumerate() {
        assert!(Code::ALL[i + 1..].iter().all(|b| b.name() != a.name()));
        assert_eq!(a.to_string(), a.name());
    }
    assert_eq!(Code::Unknown(999).to_string(), "code_999");
}

#[test]
fn a_value_that_is_no_number_is_zero() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let diagnostic = Diagnostic::whole(Code::IllConditioned, Severity::Warning, value);
        assert_eq!(diagnostic, diagnostic);
        assert_eq!(diagnostic.value, 0.0);
    }
    assert_eq!(Diagnostic::whole(Code::TooWeak, Severity::Error, -1.5).value, -1.5);
}

/// Every code, and an unknown one.
fn all() -> impl Iterator<Item = Code> {
    Code::ALL.iter().copied().chain([Code::Unknown(999)])
}

#[test]
fn every_code_has_words_of_its_own_that_fit_a_panel() {
    let printable = |line: &str| line.bytes().all(|b| (b' '..=b'~').contains(&b));
    for code in all() {
        let mut lines = code.words().split('\n');
        assert!(lines.clone().count() <= 3, "{code:?}");
        assert!(
            lines.all(|line| !line.is_empty() && line.len() <= 21 && printable(line)),
            "{code:?}"
        );
        assert!(all().all(|other| other == code || other.words() != code.words()), "{code:?}");
    }
}

#[test]
fn every_code_has_a_sentence_of_its_own() {
    for code in all() {
        assert!(code.sentence().len() > 20, "{code:?}");
        assert!(
            all().all(|other| other == code || other.sentence() != code.sentence()),
            "{code:?}"
        );
    }
}

/// The placeholders of a sentence.
fn placeholders(sentence: &str) -> impl Iterator<Item = &str> {
    sentence.split('{').skip(1).map(|rest| rest.split('}').next().unwrap())
}

#[test]
fn a_sentence_names_only_what_its_code_has() {
    for &code in Code::ALL {
        for placeholder in placeholders(code.sentence()) {
            let kind = code.subject_kind();
            let has = match placeholder {
                "subject" => ![SubjectKind::Whole, SubjectKind::Response].contains(&kind),
                "hit" | "response" => kind == SubjectKind::Response,
                "value" => code.value_unit() != ValueUnit::None,
                _ => false,
            };
            assert!(has, "{code:?}: {placeholder}");
        }
    }
    let of_unknown: std::vec::Vec<_> = placeholders(Code::Unknown(999).sentence()).collect();
    assert_eq!(of_unknown, ["code", "severity", "value"]);
}

#[test]
fn a_kind_admits_its_own_subjects_and_the_whole() {
    for code in all() {
        let kind = code.subject_kind();
        assert!(kind.admits(kind.at(1)) && kind.admits(Subject::Whole), "{code:?}");
    }
    assert!(!SubjectKind::Hit.admits(Subject::Sensor(0)));
    assert!(SubjectKind::SensorOrHit.admits(Subject::Sensor(0)));
}

#[test]
fn an_index_that_is_too_large_names_the_last() {
    assert_eq!(Subject::hit(300), Subject::Hit(255));
    assert_eq!(Subject::response(1, 5), Subject::Response { hit: 1, response: 5 });
}
