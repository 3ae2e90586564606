//! Reads results that a command has printed with `--json`.

use serde::Deserialize;
use serde::de::{DeserializeOwned, IgnoredAny};

use crate::check::Contradiction;
use crate::modes::Modes;
use crate::test_result::SCHEMA_VERSION;
use crate::test_result::TestResult;

/// What to do with a document that is not as expected.
pub const ADVICE: &str = "give an archive, or the whole output of massline solve, measure, results get, simulate or \
                          replay with --json";

/// A document with what can be shown of a test.
#[derive(Clone, Debug, PartialEq)]
pub enum Document {
    /// A result.
    Result(Box<TestResult>),
    /// Suspension modes without a result: the output of `massline modes`.
    Modes(Box<Modes>),
}

/// Why a document cannot be read. The texts name the place and what is wrong there, not the file.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// It is not JSON, or not a whole document.
    #[error("{0}; {ADVICE}")]
    Malformed(String),
    /// It is an archive.
    #[error("this is an archive, which is read from a file only: give its path")]
    IsArchive,
    /// It is the error of a command.
    #[error("the command ended with an error and no result: {0}")]
    IsError(String),
    /// A newer program has written it.
    #[error(
        "schema_version {0} is newer than this program reads ({SCHEMA_VERSION}); update massline"
    )]
    TooNew(u64),
    /// A key is missing or its value is wrong.
    #[error("{place}: {wrong}; {ADVICE}")]
    Wrong {
        /// The way to the value.
        place: String,
        /// What is wrong with it.
        wrong: String,
    },
}

/// Keys that tell what a document is.
#[derive(Deserialize)]
struct Head {
    schema_version: Option<serde_json::Number>,
    format: Option<String>,
    error: Option<Cause>,
    results: Option<IgnoredAny>,
    modes: Option<IgnoredAny>,
}

#[derive(Deserialize)]
struct Cause {
    message: String,
}

/// Reads the first document in some bytes. The second part is the error of the command, where it has failed after its
/// answer and has printed that as a second document.
///
/// # Errors
/// See [`ReadError`].
pub fn read(bytes: &[u8]) -> Result<(Document, Option<String>), ReadError> {
    let mut documents =
        serde_json::Deserializer::from_slice(bytes).into_iter::<&serde_json::value::RawValue>();
    let first = match documents.next() {
        Some(first) => {
            first.map_err(|e| malformed(format!("this is not a whole JSON document: {e}")))?
        }
        None => return Err(malformed("there is nothing in it".into())),
    };
    let second = documents.next().and_then(Result::ok);
    let failed = second.and_then(|second| serde_json::from_str::<Head>(second.get()).ok()?.error);
    let text = first.get();
    if !text.starts_with('{') {
        return Err(malformed("this is no JSON object".into()));
    }
    let head: Head = parse(text)?;
    if head.format.is_some_and(|format| format == "massline-archive") {
        return Err(ReadError::IsArchive);
    }
    if let Some(Cause { message }) = head.error {
        return Err(ReadError::IsError(message));
    }
    let version = head.schema_version.ok_or_else(|| missing("schema_version"))?;
    match version.as_u64() {
        Some(known) if known == u64::from(SCHEMA_VERSION) => {}
        Some(newer) if newer > u64::from(SCHEMA_VERSION) => return Err(ReadError::TooNew(newer)),
        _ => {
            let wrong = format!("{version} is not the number {SCHEMA_VERSION}");
            return Err(ReadError::Wrong { place: "schema_version".into(), wrong });
        }
    }
    let document = match (head.results, head.modes) {
        (None, Some(_)) => Document::Modes(Box::new(parse(text)?)),
        (None, None) => return Err(malformed("there is no result in it".into())),
        (Some(_), _) => Document::Result(Box::new(parse_result(text)?)),
    };
    Ok((document, failed.map(|cause| cause.message)))
}

fn parse_result(text: &str) -> Result<TestResult, ReadError> {
    let result: TestResult = parse(text)?;
    result.check().map_err(|Contradiction { place, wrong }| ReadError::Wrong { place, wrong })?;
    Ok(result)
}

/// Reads a type; an error names the place in the document.
fn parse<T: DeserializeOwned>(text: &str) -> Result<T, ReadError> {
    let mut document = serde_json::Deserializer::from_str(text);
    serde_path_to_error::deserialize(&mut document).map_err(|e| {
        let place = match e.path().to_string() {
            root if root == "." => "the document".to_owned(),
            place => place,
        };
        ReadError::Wrong { place, wrong: in_words(e.inner()) }
    })
}

/// What is wrong with a value of a JSON text, for people: without the names of types in this program, and without the
/// position in the text, which is of no use beside the place.
pub fn in_words(error: &serde_json::Error) -> String {
    let whole = error.to_string();
    let text = whole.split(" at line ").next().unwrap_or(&whole);
    let Some((mismatch, expected)) = text.split_once(", expected ") else { return text.to_owned() };
    let expected = match expected {
        "f32" | "f64" => "a number",
        "u8" | "u16" | "u32" | "u64" | "usize" => "a whole number that is not negative",
        "i8" | "i16" | "i32" | "i64" => "a whole number",
        type_name if type_name.starts_with("struct ") => "an object",
        other => other,
    };
    format!("{mismatch}, expected {expected}")
}

fn malformed(reason: String) -> ReadError {
    ReadError::Malformed(reason)
}

fn missing(key: &str) -> ReadError {
    ReadError::Wrong { place: key.into(), wrong: "the key is missing".into() }
}
