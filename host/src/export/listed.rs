//! Which answers a document has, and which of them is the best.

use massline_shared::identify::Method;
use serde_json::Value;

use super::place::Place;
use super::test_data::one_line;
use crate::error::{Error, Result};

/// The best answer in a document as it stands there; null without one.
pub fn best_entry(value: &Value) -> &Value {
    let best = Listed::of(&Place::whole(value, "")).ok().and_then(|listed| {
        let best = listed.entries.first()?;
        Some(best.value)
    });
    best.unwrap_or(&Value::Null)
}

/// Why the host has refused every method while the rig has an answer: the reasons, each once. Empty where the host has an
/// answer, or has not solved the test again.
pub fn refused_by_host(value: &Value) -> Vec<&str> {
    let of_host = |key: &str| value["host"][key].as_array().map_or(&[][..], Vec::as_slice);
    let mut reasons = Vec::new();
    if of_host("results").is_empty() {
        for refusal in of_host("not_applicable") {
            let reason = refusal["message"].as_str().unwrap_or_default();
            if !reasons.contains(&reason) {
                reasons.push(reason);
            }
        }
    }
    reasons
}

/// The answers in a document, the best first: those of the host, then those of the rig by other methods.
pub(super) struct Listed<'a> {
    pub(super) entries: Vec<Place<'a>>,
    /// How many of them are the host's.
    of_host: usize,
}

impl<'a> Listed<'a> {
    pub(super) fn of(document: &Place<'a>) -> Result<Self> {
        let of_rig = document.key("results")?.entries()?;
        let mut entries = match document.value.get("host").filter(|host| host.is_object()) {
            Some(_) => document.key("host")?.key("results")?.entries()?,
            None => Vec::new(),
        };
        let of_host = entries.len();
        for entry in of_rig {
            let same = |other: &Place<'_>| other.value["method"] == entry.value["method"];
            if !entries[..of_host].iter().any(same) {
                entries.push(entry);
            }
        }
        Ok(Self { entries, of_host })
    }
}

/// The answer that is exported, and remarks about the choice.
pub(super) fn chosen<'a>(
    document: &Place<'a>,
    method: Option<Method>,
) -> Result<(Place<'a>, Vec<String>)> {
    let Listed { entries, of_host } = Listed::of(document)?;
    let wanted = |entry: &Value| method.is_none_or(|of| entry["method"] == of.name());
    if let Some(place) = entries.iter().position(|entry| wanted(entry.value)) {
        // Where the host alone has solved the test, its answers are listed as those of the result, too.
        let answer = entries[place].value;
        let mut of_rig = document.value["results"].as_array().into_iter().flatten();
        let note = match place < of_host {
            true if of_rig.find(|entry| wanted(entry)).is_some_and(|entry| entry != answer) => {
                Some("the answer is that of the host, in double precision, not that of the rig")
            }
            false if of_host > 0 => {
                Some("the answer is that of the rig: the host has none by this method")
            }
            _ => None,
        };
        return Ok((entries[place].clone(), note.into_iter().map(str::to_owned).collect()));
    }
    let names: Vec<&str> =
        entries.iter().filter_map(|entry| entry.value["method"].as_str()).collect();
    let source = document.source;
    Err(match method {
        Some(method) if !names.is_empty() => Error::input(
            "no_such_answer",
            format!(
                "{source}: there is no answer by {}; there are: {}",
                method.name(),
                one_line(&names.join(", "))
            ),
        ),
        _ => Error::undetermined(
            "no_answer",
            format!(
                "{source}: the document has no answer (results is empty); its not_applicable says why"
            ),
        ),
    })
}
