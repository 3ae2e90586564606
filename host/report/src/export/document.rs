//! Reads a result from the JSON document of a command.
//!
//! `massline solve`, `measure`, `results get`, `simulate` and `replay` print such documents with `--json`.

use std::io::Read;
use std::path::Path;

use massline_result::{Document, Estimate, ReadError, TestResult, Verdict, VerdictReason};
use massline_shared::identify::Method;
use massline_shared::identify::agreement::Outcome;

use super::subject::ExportedResult;
use super::test_data::one_line;
use crate::words::UNCERTAINTY_UNKNOWN;
use crate::words::reason_text;
use massline_result::{Error, Result};

/// Largest document that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 24;

/// Reads the result in a file; `-` is standard input. `method` chooses an answer other than the best.
///
/// # Errors
/// Exit 2 when the file cannot be read or is no such document, exit 3 when it has no answer.
pub fn read_subject(path: &Path, method: Option<Method>) -> Result<ExportedResult> {
    let (bytes, name) = read_named(path)?;
    let exported = of_document(&bytes, &name, method)?;
    // A document without a title is called as its file.
    match path.file_stem() {
        Some(stem) if path.as_os_str() != "-" && exported.test.title == exported.test.source => {
            Ok(exported.with_test(|test| test.titled(&stem.to_string_lossy())))
        }
        _ => Ok(exported),
    }
}

/// Reads the document in a file; `-` is standard input.
///
/// # Errors
/// Exit 2 when the file cannot be read or is no document with a result or with suspension modes.
pub fn read_document(path: &Path) -> Result<Document> {
    let (bytes, name) = read_named(path)?;
    Ok(parsed(&bytes, &name)?.0)
}

/// The bytes of a file or of standard input, and what it is called.
fn read_named(path: &Path) -> Result<(Vec<u8>, String)> {
    let stdin = path.as_os_str() == "-";
    let name = match path.file_name() {
        _ if stdin => "standard input".into(),
        Some(name) => name.to_string_lossy(),
        None => path.to_string_lossy(),
    };
    let bytes = if stdin { read_stdin() } else { massline_files::embedded::read(path, MAX_BYTES) };
    let bytes = bytes.map_err(|e| {
        let file = if stdin { name.clone() } else { path.to_string_lossy() };
        Error::input(
            "result_not_readable",
            format!("{file}: the result cannot be read: {e}; check the path"),
        )
    })?;
    Ok((bytes, name.into_owned()))
}

fn read_stdin() -> std::io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    std::io::stdin().take(MAX_BYTES + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(std::io::Error::other(format!("it is longer than {MAX_BYTES} bytes")));
    }
    Ok(bytes)
}

/// The result in the bytes of a document; `source` is its name in errors and in the file.
///
/// # Errors
/// As [`read_subject`].
pub fn of_document(bytes: &[u8], source: &str, method: Option<Method>) -> Result<ExportedResult> {
    let (document, failed) = parsed(bytes, source)?;
    let Document::Result(result) = document else {
        return Err(no_answer(source));
    };
    let mut exported = of_result(&result, source, method)?;
    // A command that fails after its answer prints the error as a second document.
    if let Some(message) = failed {
        exported.test.notes.push(format!(
            "the command that printed this result then failed: {}",
            one_line(&message)
        ));
    }
    Ok(exported)
}

/// The first document in some bytes, and the error of the command after it; `source` is the name in errors.
fn parsed(bytes: &[u8], source: &str) -> Result<(Document, Option<String>)> {
    massline_result::read(bytes).map_err(|error| {
        let code = match error {
            ReadError::Malformed(_) => "result_malformed",
            ReadError::IsArchive => "result_is_archive",
            ReadError::IsError(_) => "result_is_error",
            ReadError::TooNew(_) => "result_too_new",
            ReadError::Wrong { .. } => "result_value_wrong",
        };
        Error::input(code, format!("{source}: {}", one_line(&error.to_string())))
    })
}

/// An answer of a result, the best or that of a method, as it is exported; `source` is its title unless the result has
/// one.
///
/// # Errors
/// Exit 2 when there is no answer by the method, exit 3 without any answer.
pub fn of_result(
    result: &TestResult,
    source: &str,
    method: Option<Method>,
) -> Result<ExportedResult> {
    let answer = chosen(result, source, method)?;
    let verdict = result.verdict.ok_or_else(|| no_answer(source))?;
    let mut exported = ExportedResult::new(answer.clone(), verdict, source);
    match result.agreement.as_ref().and_then(|agreement| agreement.outcome).map(|outcome| outcome.0)
    {
        Some(Outcome::Differ) => exported
            .test
            .notes
            .push("the methods do not agree on this object: see agreement in the document".into()),
        Some(Outcome::SomeOff) => exported
            .test
            .notes
            .push("some methods are off on this object: see agreement in the document".into()),
        _ => {}
    }
    let hash = result.layout_hash.as_deref();
    exported.test.layout_hash = hash.and_then(|hash| u32::from_str_radix(hash, 16).ok());
    // The verdict is on the best answer.
    let best = result.answer().map(|best| best.method).filter(|best| *best != answer.method);
    let subject = best.map_or_else(String::new, |best| format!("of the answer by {best}: "));
    let doubt = |reason: &VerdictReason| one_line(&format!("{subject}{}", reason_text(reason)));
    exported.doubts = result.verdict_reasons.iter().map(doubt).collect();
    let agreement = result.agreement.as_ref();
    let is_off = agreement.is_some_and(|agreement| agreement.off.contains(&answer.method));
    let own = [
        // As where it is the only answer.
        (answer.complete_sigma().is_none(), UNCERTAINTY_UNKNOWN),
        (is_off, "this method differs from the others by more than chance"),
    ];
    for (_, doubt) in own.into_iter().filter(|(applies, _)| *applies) {
        exported.verdict = exported.verdict.max(Verdict::UseWithCare);
        if !exported.doubts.iter().any(|stated| stated == doubt) {
            exported.doubts.push(doubt.into());
        }
    }
    Ok(exported.with_test(|test| test.titled(&result.title)))
}

/// The best answer, or that of a method.
fn chosen<'r>(
    result: &'r TestResult,
    source: &str,
    method: Option<Method>,
) -> Result<&'r Estimate> {
    let answer = match method {
        Some(method) => result.answer_by(method),
        None => result.answer(),
    };
    answer.ok_or_else(|| match method {
        Some(method) if !result.results.is_empty() => {
            let names: Vec<_> =
                result.results.iter().map(|estimate| estimate.method.name()).collect();
            let text = format!(
                "{source}: there is no answer by {}; there are: {}",
                method.name(),
                names.join(", ")
            );
            Error::input("no_such_answer", text)
        }
        _ => no_answer(source),
    })
}

fn no_answer(source: &str) -> Error {
    let text = format!(
        "{source}: the document has no answer (results is empty); its not_applicable says why"
    );
    Error::undetermined("no_answer", text)
}

#[cfg(test)]
mod tests {
    use super::super::tests::{document, make_bare};
    use super::*;
    use serde_json::{Value, json};

    fn read(value: &Value) -> Result<ExportedResult> {
        of_document(value.to_string().as_bytes(), "r.json", None)
    }

    #[track_caller]
    fn refused(value: &Value, code: &str, words: &str) {
        let error = read(value).unwrap_err();
        assert_eq!(error.code(), code, "{error}");
        assert!(error.to_string().starts_with("r.json: "), "{error}");
        assert!(error.to_string().contains(words), "{error}");
    }

    #[test]
    fn the_best_answer_is_read_with_covariance_and_interval() {
        let value = document();
        let read = read(&value).unwrap();
        assert_eq!(read.method(), "maximum-likelihood");
        assert_eq!(read.body.inertia[(0, 1)], 0.004253);
        let interval = read.interval().unwrap();
        let stated: [f64; 2] =
            [0, 1].map(|k| value["results"][0]["interval95"]["c_z"][k].as_f64().unwrap());
        // Half of a difference, added again: rounding.
        assert!((interval[0][3] - stated[0]).abs() < 1e-15);
        assert!((interval[1][3] - stated[1]).abs() < 1e-15);
    }

    #[test]
    fn another_method_is_chosen_by_name_or_those_there_are_are_named() {
        let bytes = document().to_string();
        let read = |method| of_document(bytes.as_bytes(), "r.json", Some(method));
        assert_eq!(read(Method::InertiaRestraint).unwrap().method(), "inertia-restraint");
        let error = read(Method::ContiBretl).unwrap_err();
        assert_eq!(error.code(), "no_such_answer");
        assert!(error.to_string().contains("maximum-likelihood, inertia-restraint"), "{error}");
    }

    #[test]
    fn what_is_missing_or_wrong_is_named_by_its_path() {
        let changed = |change: &dyn Fn(&mut Value)| {
            let mut value = document();
            change(&mut value);
            value
        };
        let removed =
            changed(&|v| drop(v["results"][0].as_object_mut().unwrap().remove("mass_kg")));
        refused(&removed, "result_value_wrong", "results[0]: missing field `mass_kg`");
        let null = changed(&|v| v["results"][0]["inertia_kg_m2"]["value"][1][2] = Value::Null);
        refused(
            &null,
            "result_value_wrong",
            "results[0].inertia_kg_m2.value[1][2]: invalid type: null, expected a number",
        );
        let skew = changed(&|v| v["results"][0]["inertia_kg_m2"]["value"][1][0] = json!(-0.004253));
        refused(&skew, "result_value_wrong", "symmetric");
        let negative = changed(&|v| v["results"][0]["covariance"][2][2] = json!(-1.0));
        refused(
            &negative,
            "result_value_wrong",
            "results[0].covariance[2][2]: -1 is not a variance",
        );
        let other = changed(&|v| v["results"][0]["mass_kg"]["sigma"] = json!(2e-2));
        refused(&other, "result_value_wrong", "0.02 is not the root of covariance[0][0]");
        let below_zero = changed(&|v| {
            make_bare(&mut v["results"][0]);
            let answer = &mut v["results"][0];
            answer["mass_kg"]["sigma"] = json!(0.01);
            answer["center_of_mass_m"]["sigma"] = json!([0.001, -0.001, 0.001]);
            answer["inertia_kg_m2"]["sigma"] = json!(vec![vec![0.0; 3]; 3]);
        });
        refused(&below_zero, "result_value_wrong", "center_of_mass_m.sigma: of c_y: -0.001");
        let newer = changed(&|v| v["schema_version"] = json!(2));
        refused(&newer, "result_too_new", "update massline");
        let unversioned = changed(&|v| v["schema_version"] = json!("1"));
        refused(&unversioned, "result_value_wrong", "schema_version");
        let error = json!({ "schema_version": 1, "error": { "message": "no rig" } });
        refused(&error, "result_is_error", "no rig");
        let none = changed(&|v| {
            v["results"] = json!([]);
            v["verdict"] = Value::Null;
        });
        refused(&none, "no_answer", "not_applicable");
        refused(&json!({ "format": "massline-archive" }), "result_is_archive", "its path");
        refused(&json!([1]), "result_malformed", "no JSON object");
        let empty = json!({ "schema_version": 1, "answer": {} });
        refused(&empty, "result_malformed", "there is no result in it");
        refused(&json!({}), "result_value_wrong", "schema_version: the key is missing");
    }

    #[test]
    fn a_document_that_is_cut_or_empty_is_malformed() {
        let bytes = document().to_string().into_bytes();
        for length in [0, 1, bytes.len() / 2, bytes.len() - 1] {
            let error = of_document(&bytes[..length], "r.json", None).unwrap_err();
            assert_eq!(error.code(), "result_malformed", "{length}: {error}");
        }
    }

    #[test]
    fn an_error_after_the_answer_is_noted() {
        let error = json!({ "schema_version": 1, "error": { "message": "the rig is gone" } });
        let both = format!("{}\n{error}\n", document());
        let read = of_document(both.as_bytes(), "r.json", None).unwrap();
        assert!(read.test.notes[0].contains("the rig is gone"), "{:?}", read.test.notes);
    }

    #[test]
    fn disagreement_of_the_methods_is_noted() {
        let mut value = document();
        value["agreement"] = json!({
            "outcome": "agree", "off": [], "verdict": "", "methods": [], "pairs": [],
        });
        assert!(read(&value).unwrap().test.notes.is_empty());
        for (outcome, words) in
            [("differ", "the methods do not agree"), ("some_off", "some methods are off")]
        {
            value["agreement"]["outcome"] = json!(outcome);
            let notes = read(&value).unwrap().test.notes;
            assert!(notes[0].contains(words), "{notes:?}");
        }
    }

    #[test]
    fn without_standard_deviations_there_are_no_intervals() {
        let mut value = document();
        make_bare(&mut value["results"][0]);
        let read = read(&value).unwrap();
        assert!(read.sigma().is_none() && read.interval().is_none());
    }
}
