//! Reads results that a command has printed with `--json`.

use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::check::Contradiction;
use crate::json::{Json, JsonError};
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
    let failed = second
        .and_then(|second| Json::parse(second.get().as_bytes()).ok()?.read::<Head>().ok()?.error);
    if !first.get().starts_with('{') {
        return Err(malformed("this is no JSON object".into()));
    }
    let document = Json::parse(first.get().as_bytes())?;
    let head: Head = document.read()?;
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
    let answer = match (head.results, head.modes) {
        (None, Some(_)) => Document::Modes(Box::new(document.read()?)),
        (None, None) => return Err(malformed("there is no result in it".into())),
        (Some(_), _) => Document::Result(Box::new(read_result(&document)?)),
    };
    Ok((answer, failed.map(|cause| cause.message)))
}

fn read_result(document: &Json) -> Result<TestResult, ReadError> {
    let result: TestResult = document.read()?;
    result.check().map_err(|Contradiction { place, wrong }| ReadError::Wrong { place, wrong })?;
    Ok(result)
}

impl From<JsonError> for ReadError {
    fn from(JsonError { place, wrong }: JsonError) -> Self {
        Self::Wrong { place, wrong }
    }
}

fn malformed(reason: String) -> ReadError {
    ReadError::Malformed(reason)
}

fn missing(key: &str) -> ReadError {
    ReadError::Wrong { place: key.into(), wrong: "the key is missing".into() }
}
