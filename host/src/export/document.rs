//! Reads a result from the JSON document of a command.
//!
//! `massline solve`, `measure`, `results get`, `simulate` and `replay` print such documents with `--json`. Their answers are
//! in `results`, the best first. A rig's result has those of the host, in double precision, in `host.results`.

use std::io::Read;
use std::path::Path;

use massline_shared::body::{INERTIA_ELEMENTS, INERTIAL_PARAMETERS, RigidBody, tensor};
use massline_shared::identify::agreement::Outcome;
use massline_shared::identify::{HALF_WIDTH_95, Method};
use nalgebra::{Vector3, Vector6};
use serde_json::Value;

use super::frame::Placement;
use super::listed::{Listed, chosen};
use super::place::{ADVICE, Place};
use super::subject::{Exported, Matrix10, Vector10};
use super::test_data::{TestData, one_line};
use super::units::UnitSystem;
use crate::error::{Error, Result};
use crate::output::SCHEMA_VERSION;
use crate::verdict::Verdict;

/// Largest document that is read, bytes.
pub const MAX_BYTES: u64 = 1 << 24;

/// Reads the result in a file; `-` is standard input. `method` chooses an answer other than the best.
///
/// # Errors
/// Exit 2 when the file cannot be read or is no such document, exit 3 when it has no answer.
pub fn read_subject(path: &Path, method: Option<Method>) -> Result<Exported> {
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
/// Exit 2 when the file cannot be read or is not JSON.
pub fn read_document(path: &Path) -> Result<Value> {
    let (bytes, name) = read_named(path)?;
    Ok(first_document(&bytes, &name)?.0)
}

/// The bytes of a file or of standard input, and what it is called.
fn read_named(path: &Path) -> Result<(Vec<u8>, String)> {
    let stdin = path.as_os_str() == "-";
    let name = match path.file_name() {
        _ if stdin => "standard input".into(),
        Some(name) => name.to_string_lossy(),
        None => path.to_string_lossy(),
    };
    let bytes = if stdin { read_stdin() } else { crate::embedded::read(path, MAX_BYTES) };
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
pub fn of_document(bytes: &[u8], source: &str, method: Option<Method>) -> Result<Exported> {
    let (value, second) = first_document(bytes, source)?;
    let mut exported = of_value(&value, source, method)?;
    // A command that fails after its answer prints the error as a second document.
    if let Some(message) = second["error"]["message"].as_str() {
        exported.test.notes.push(format!(
            "the command that printed this result then failed: {}",
            one_line(message)
        ));
    }
    Ok(exported)
}

/// The first document in some bytes and the one after it, null without one.
fn first_document(bytes: &[u8], source: &str) -> Result<(Value, Value)> {
    let mut documents = serde_json::Deserializer::from_slice(bytes).into_iter::<Value>();
    let first = match documents.next() {
        Some(Ok(value)) => value,
        Some(Err(e)) => {
            let message = format!("{source}: this is not a whole JSON document: {e}; {ADVICE}");
            return Err(Error::input("result_malformed", message));
        }
        None => {
            let message = format!("{source}: there is nothing in it; {ADVICE}");
            return Err(Error::input("result_malformed", message));
        }
    };
    let second = documents.next().and_then(std::result::Result::ok).unwrap_or_default();
    Ok((first, second))
}

/// The result in a document that has been read already; `source` is its title unless the document has one.
///
/// # Errors
/// As [`read_subject`].
pub fn of_value(value: &Value, source: &str, method: Option<Method>) -> Result<Exported> {
    let document = checked(value, source)?;
    let (answer, mut notes) = chosen(&document, method)?;
    let outcome = &value["agreement"]["outcome"];
    if *outcome == Outcome::Differ.name() {
        notes.push("the methods do not agree on this object: see agreement in the document".into());
    }
    if *outcome == Outcome::SomeOff.name() {
        notes.push("some methods are off on this object: see agreement in the document".into());
    }
    let mut exported = answer_of(&answer, source)?;
    exported.test.layout_hash = hash_of(&value["layout_hash"]);
    exported.test.notes = notes;
    (exported.verdict, exported.doubts) = verdict_of(&document, value)?;
    let title = value["title"].as_str().unwrap_or_default();
    Ok(exported.with_test(|test| test.titled(title)))
}

/// The verdict that a document states, and its reasons.
fn verdict_of(document: &Place<'_>, value: &Value) -> Result<(Option<Verdict>, Vec<String>)> {
    if value["verdict"].is_null() {
        return Ok((None, Vec::new()));
    }
    let place = document.key("verdict")?;
    let verdict = place.value.as_str().and_then(Verdict::from_name);
    let names = || Verdict::ALL.map(Verdict::name).join(", ");
    let verdict = verdict.ok_or_else(|| place.wrong(&format!("one of {}", names())))?;
    let reasons = value["verdict_reasons"].as_array().map_or(&[][..], Vec::as_slice);
    let message = |reason: &Value| reason["message"].as_str().map(one_line);
    Ok((Some(verdict), reasons.iter().filter_map(message).collect()))
}

/// The answers of all methods in a document, the best first with the verdict on it; `source` is its name in errors.
///
/// # Errors
/// Exit 2 when this is no such document, or an answer is malformed.
pub fn answers_of_value(value: &Value, source: &str) -> Result<Vec<Exported>> {
    let document = checked(value, source)?;
    let listed = Listed::of(&document)?;
    let answers = listed.entries.iter().map(|entry| answer_of(entry, source));
    let mut answers = answers.collect::<Result<Vec<_>>>()?;
    if let Some(best) = answers.first_mut() {
        (best.verdict, best.doubts) = verdict_of(&document, value)?;
    }
    Ok(answers)
}

/// The document, if a command has printed it and this program can read it.
fn checked<'a>(value: &'a Value, source: &'a str) -> Result<Place<'a>> {
    if !value.is_object() {
        let message = format!("{source}: this is no JSON object; {ADVICE}");
        return Err(Error::input("result_malformed", message));
    }
    if value["format"] == crate::archive::FORMAT {
        let message =
            format!("{source}: this is an archive, which is read from a file only: give its path");
        return Err(Error::input("result_is_archive", message));
    }
    let document = Place::whole(value, source);
    if let Some(message) = value["error"]["message"].as_str() {
        let message = format!(
            "{source}: the command ended with an error and no result: {}",
            one_line(message)
        );
        return Err(Error::input("result_is_error", message));
    }
    let version = document.key("schema_version")?;
    match version.value.as_u64() {
        Some(found) if found == u64::from(SCHEMA_VERSION) => Ok(document),
        Some(found) if found > u64::from(SCHEMA_VERSION) => Err(Error::input(
            "result_too_new",
            format!(
                "{source}: schema_version {found} is newer than this program reads ({SCHEMA_VERSION}); \
                 update massline"
            ),
        )),
        _ => Err(version.wrong(&format!("the number {SCHEMA_VERSION}"))),
    }
}

/// A hash, as the eight digits or as the number that documents have.
fn hash_of(value: &Value) -> Option<u32> {
    match value.as_str() {
        Some(digits) => u32::from_str_radix(digits, 16).ok(),
        None => value.as_u64().and_then(|hash| u32::try_from(hash).ok()),
    }
}

/// One entry of `results`.
fn answer_of(entry: &Place<'_>, source: &str) -> Result<Exported> {
    let method = entry.key("method")?;
    let method = method.value.as_str().ok_or_else(|| method.wrong("the name of a method"))?;
    let mass = entry.key("mass_kg")?.key("value")?.number()?;
    let center: [f64; 3] = entry.key("center_of_mass_m")?.key("value")?.numbers()?;
    let inertia = entry.key("inertia_kg_m2")?.key("value")?;
    let rows: [[f64; 3]; 3] = inertia.rows()?;
    inertia.is_symmetric(&rows, |i| rows[i][i])?;
    let six = INERTIA_ELEMENTS.map(|(i, j)| rows[i][j]);
    let body = RigidBody {
        mass,
        center_of_mass: Vector3::from(center),
        inertia: tensor(&Vector6::from(six)),
    };
    let covariance = covariance_of(&entry.key("covariance")?)?;
    let half_widths = match covariance {
        Some(covariance) => Some(half_widths_of(&entry.key("interval95")?, &covariance)?),
        None => None,
    };
    let consistent = entry.key("physically_consistent")?;
    let stated_consistent =
        consistent.value.as_bool().ok_or_else(|| consistent.wrong("true or false"))?;
    Ok(Exported {
        method: one_line(method),
        body,
        covariance,
        half_widths,
        stated_consistent,
        verdict: None,
        doubts: Vec::new(),
        placement: Placement::body(),
        units: UnitSystem::Si,
        test: TestData::of_source(source),
    })
}

fn covariance_of(place: &Place<'_>) -> Result<Option<Matrix10>> {
    if place.value.is_null() {
        return Ok(None);
    }
    let rows: [[f64; 10]; 10] = place.rows()?;
    if let Some(k) = (0..10).find(|&k| rows[k][k] < 0.0) {
        return Err(place.at(k).at(k).wrong("a variance, which is not negative"));
    }
    place.is_symmetric(&rows, |i| rows[i][i])?;
    Ok(Some(Matrix10::from_fn(|i, j| rows[i.max(j)][i.min(j)])))
}

/// Half widths of the intervals; 95 % of a normal distribution where there are none.
fn half_widths_of(place: &Place<'_>, covariance: &Matrix10) -> Result<Vector10> {
    let mut half_widths = covariance.diagonal().map(|variance| HALF_WIDTH_95 * variance.sqrt());
    if place.value.is_null() {
        return Ok(half_widths);
    }
    for (half, parameter) in half_widths.iter_mut().zip(INERTIAL_PARAMETERS) {
        let ends = place.key(parameter.name)?;
        let [low, high]: [f64; 2] = ends.numbers()?;
        if low > high {
            return Err(ends.wrong("the lower end, then the upper end of an interval"));
        }
        *half = (high - low) / 2.0;
    }
    Ok(half_widths)
}

#[cfg(test)]
mod tests {
    use super::super::tests::document;
    use super::*;
    use serde_json::json;

    fn read(value: &Value) -> Result<Exported> {
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
        assert_eq!(read.method, "maximum-likelihood");
        assert_eq!(read.body.inertia[(0, 1)], 0.004253);
        let interval = read.interval().unwrap();
        let stated: [f64; 2] =
            [0, 1].map(|k| value["results"][0]["interval95"]["cz"][k].as_f64().unwrap());
        // Half of a difference, added again: rounding.
        assert!((interval[0][3] - stated[0]).abs() < 1e-15);
        assert!((interval[1][3] - stated[1]).abs() < 1e-15);
    }

    #[test]
    fn the_answer_of_the_host_is_preferred_and_said_to_be() {
        let mut value = document();
        let mut host = value["results"][0].clone();
        host["mass_kg"]["value"] = json!(1.25);
        value["host"] = json!({ "results": [host] });
        let read = read(&value).unwrap();
        assert_eq!(read.body.mass, 1.25);
        assert!(read.test.notes[0].contains("not that of the rig"), "{:?}", read.test.notes);
    }

    #[test]
    fn another_method_is_chosen_by_name_or_those_there_are_are_named() {
        let bytes = document().to_string();
        let read = |method| of_document(bytes.as_bytes(), "r.json", Some(method));
        assert_eq!(read(Method::InertiaRestraint).unwrap().method, "inertia-restraint");
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
        refused(&removed, "result_key_missing", "results[0].mass_kg: the key is missing");
        let null = changed(&|v| v["results"][0]["inertia_kg_m2"]["value"][1][2] = Value::Null);
        refused(
            &null,
            "result_value_wrong",
            "results[0].inertia_kg_m2.value[1][2]: null is not a number",
        );
        let skew = changed(&|v| v["results"][0]["inertia_kg_m2"]["value"][1][0] = json!(-0.004253));
        refused(&skew, "result_value_wrong", "symmetric");
        let negative = changed(&|v| v["results"][0]["covariance"][2][2] = json!(-1.0));
        refused(&negative, "result_value_wrong", "covariance[2][2]: -1.0 is not a variance");
        let newer = changed(&|v| v["schema_version"] = json!(2));
        refused(&newer, "result_too_new", "update massline");
        let unversioned = changed(&|v| v["schema_version"] = json!("1"));
        refused(&unversioned, "result_value_wrong", "schema_version");
        let error = json!({ "schema_version": 1, "error": { "message": "no rig" } });
        refused(&error, "result_is_error", "no rig");
        let none = changed(&|v| v["results"] = json!([]));
        refused(&none, "no_answer", "not_applicable");
        refused(&json!({ "format": "massline-archive" }), "result_is_archive", "its path");
        refused(&json!([1]), "result_malformed", "no JSON object");
        refused(&json!({}), "result_key_missing", "schema_version");
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
        value["agreement"] = json!({ "outcome": "agree" });
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
    fn without_covariance_there_are_no_intervals() {
        let mut value = document();
        for key in ["covariance", "interval95"] {
            value["results"][0][key] = Value::Null;
        }
        let read = read(&value).unwrap();
        assert!(read.sigma().is_none() && read.interval().is_none());
    }
}
