//! One result with its test, read from a file: what pictures and reports are made of.

mod combined;
mod modes;
mod names;
mod responses;

use std::path::Path;

use massline_shared::body::scale;
use massline_shared::identify::Method;
use massline_shared::layout::HostLayout;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::archive::{Archive, is_archive};
use crate::document::{ErrorBudget, HitDetails, LoggedHit, SensorDetails, Solution};
use crate::embedded;
use crate::error::{Error, Result};
use crate::export::{Exported, document_of_archive, of_value, one_line, read_document};
use crate::layout_file::LayoutFile;
use crate::output::SCHEMA_VERSION;

pub use combined::Combined;
pub use modes::ShownModes;
pub use names::distinct_names;
pub use responses::{Band, DofResponses};

/// Longest title in a picture, characters.
const MOST_OF_TITLE: usize = 40;

/// The code of the error without a layout.
pub const LAYOUT_NEEDED: &str = "layout_needed";

/// A result with its test.
pub struct ResultFile {
    /// The title of the layout, or the name of the file, as long as a picture has room for.
    pub title: String,
    /// The same in full length.
    pub whole_title: String,
    /// The name of the file.
    pub name: String,
    document: Value,
    archive: Option<Archive>,
    layout: Option<HostLayout>,
    layout_file: Option<LayoutFile>,
    /// Frequency responses that the document does not hold.
    responses: Vec<DofResponses>,
    /// The ten properties of the reference, where they are known.
    reference: Option<[f64; 10]>,
}

impl ResultFile {
    /// Reads an archive or the JSON output of a command; `layout` is the layout file of the test, which an archive has.
    ///
    /// # Errors
    /// Exit 2 when the file cannot be read or is neither.
    pub fn read(path: &Path, layout: Option<&LayoutFile>) -> Result<Self> {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
        let stem = embedded::stem(path);
        if is_archive(path) {
            let archive = Archive::read(path)?;
            return Self::new(document_of_archive(&archive), Some(archive), name, &stem, layout);
        }
        Self::new(read_document(path)?, None, name, &stem, layout)
    }

    /// The result of an archive that is no file, by its name.
    ///
    /// # Errors
    /// When the layout in it cannot be read.
    pub fn of(archive: Archive, name: String) -> Result<Self> {
        Self::new(document_of_archive(&archive), Some(archive), name.clone(), &name, None)
    }

    /// The result in the document of a solution that is no file, by its name.
    ///
    /// # Errors
    /// When the document cannot be written as JSON.
    pub fn of_solution(document: &Solution, layout: &LayoutFile, name: String) -> Result<Self> {
        let mut document = serde_json::to_value(document).map_err(|e| {
            Error::internal("document_not_written", format!("{name}: {e}; report this"))
        })?;
        document["schema_version"] = SCHEMA_VERSION.into();
        Self::new(document, None, name.clone(), &name, Some(layout))
    }

    /// A document without a test, by its name.
    #[cfg(test)]
    pub(crate) fn of_document(document: Value, name: &str) -> Self {
        Self::new(document, None, name.into(), name, None).expect("there is no layout to be read")
    }

    fn new(
        document: Value,
        archive: Option<Archive>,
        name: String,
        stem: &str,
        layout: Option<&LayoutFile>,
    ) -> Result<Self> {
        let text = archive.as_ref().and_then(|archive| archive.layout.toml.as_deref());
        let of_archive = text.map(|text| LayoutFile::parse(text, &name)).transpose()?;
        let layout = layout.or(of_archive.as_ref());
        let stored = archive.as_ref().map(|archive| &archive.layout.resolved);
        let said = document["title"].as_str().filter(|title| !title.is_empty());
        let title = layout.map(|file| file.title.as_str()).filter(|title| !title.is_empty());
        let whole_title = whole_title(said, title).unwrap_or_else(|| one_line(stem));
        Ok(Self {
            title: shortened(&whole_title, MOST_OF_TITLE),
            whole_title,
            layout_file: layout.cloned(),
            layout: stored.or(layout.map(|file| &file.layout)).cloned(),
            responses: Vec::new(),
            reference: layout.and_then(|file| file.reference?.complete()),
            document,
            archive,
            name,
        })
    }

    /// The answer of a method, or the best for none.
    ///
    /// # Errors
    /// As [`of_value`].
    pub fn answer(&self, method: Option<Method>) -> Result<Exported> {
        of_value(&self.document, &self.name, method)
    }

    /// The answers of all methods, the best first.
    ///
    /// # Errors
    /// When an answer is malformed.
    pub fn answers(&self) -> Result<Vec<Exported>> {
        let mut found = Vec::new();
        // The output of `massline modes` has none.
        if self.document.get("results").is_none() && self.modes()?.is_some() {
            return Ok(found);
        }
        for method in Method::ALL {
            match self.answer(Some(method)) {
                Ok(answer) => found.push(answer),
                Err(error) if ["no_such_answer", "no_answer"].contains(&error.code()) => {}
                Err(error) => return Err(error),
            }
        }
        Ok(found)
    }

    /// The ten properties of the reference, where the layout states them all.
    pub fn reference(&self) -> Option<[f64; 10]> {
        self.reference
    }

    /// The layout, where it is known.
    pub fn layout(&self) -> Option<&HostLayout> {
        self.layout.as_ref()
    }

    /// The layout file, where there is one: in the archive, or given beside the result.
    pub fn layout_file(&self) -> Option<&LayoutFile> {
        self.layout_file.as_ref()
    }

    /// The best answer in the document, as it stands there; null without one.
    pub fn best_entry(&self) -> &Value {
        let of_host = &self.document["host"]["results"][0];
        if of_host.is_object() { of_host } else { &self.document["results"][0] }
    }

    /// The document of the result, that of an archive solved again.
    pub fn document(&self) -> &Value {
        &self.document
    }

    /// Every hit that was graded during the measurement, where the result has a log of them.
    pub fn hit_log(&self) -> Vec<LoggedHit> {
        match &self.archive {
            Some(archive) => archive.hit_log.clone(),
            None => Vec::deserialize(&self.document["hit_log"]).unwrap_or_default(),
        }
    }

    /// The JSON text from which this result can be read again: the archive without the records of hits, which would take most
    /// of a page, or the document.
    ///
    /// # Errors
    /// When the archive cannot be written.
    pub fn json(&self) -> Result<String> {
        let Some(archive) = &self.archive else { return Ok(self.document.to_string()) };
        let mut lean = archive.clone();
        lean.hit_records.clear();
        Ok(String::from_utf8_lossy(&lean.to_bytes(&self.name)?).into_owned())
    }

    /// The archive, for a result that is one.
    pub fn archive(&self) -> Option<&Archive> {
        self.archive.as_ref()
    }

    /// The scale of the ten properties for this mass, kg.
    ///
    /// # Errors
    /// Exit 2 without a layout.
    pub fn scale(&self, mass: f64) -> Result<[f64; 10]> {
        let length = self.layout().map(HostLayout::characteristic_length).ok_or_else(|| {
            let text = format!(
                "{}: the result does not say where the sensors are, which its scale needs; give the layout file of \
                 the test with --layout",
                self.name
            );
            Error::input(LAYOUT_NEEDED, text)
        })?;
        Ok(scale(mass, length).into())
    }

    /// The suspension modes, where the result has them.
    ///
    /// # Errors
    /// Exit 2 when they are malformed.
    pub fn modes(&self) -> Result<Option<ShownModes>> {
        let modes = match &self.document["suspension"] {
            Value::Object(_) => &self.document["suspension"],
            // The output of `massline modes` is nothing else.
            _ if self.document["modes"].is_array() => &self.document,
            _ => return Ok(None),
        };
        let part = "suspension modes";
        let shown = ShownModes {
            band_hz: self.part(modes, part, "band_hz")?,
            modes: self.part(modes, part, "modes")?,
            modal_assurance: self.part(modes, part, "modal_assurance")?,
            orders: self.part(modes, part, "orders")?,
        };
        shown.check().map_err(|what| {
            let text = format!("{}: {part}: {what}", self.name);
            Error::input("result_malformed", text)
        })?;
        Ok(Some(shown))
    }

    /// What the fit has found about sensors and hits, where the result has it: of the host, else of its document.
    ///
    /// # Errors
    /// Exit 2 when it is malformed.
    pub fn details(&self) -> Result<Option<ShownDetails>> {
        let of_host = self.document.get("host").and_then(|host| host.get("details"));
        let details = [of_host, self.document.get("details")];
        let Some(details) = details.into_iter().flatten().find(|of| of.is_object()) else {
            return Ok(None);
        };
        let part = "details";
        Ok(Some(ShownDetails {
            sensors: self.part(details, part, "sensors")?,
            hits: self.part(details, part, "hits")?,
            error_budget: self.part(details, part, "error_budget")?,
        }))
    }

    fn part<T: DeserializeOwned>(&self, of: &Value, what: &str, key: &str) -> Result<T> {
        T::deserialize(&of[key]).map_err(|e| {
            let text = format!("{}: {key} of the {what}: {e}", self.name);
            Error::input("result_malformed", text)
        })
    }
}

/// The title of a result: what its document says, or the layout's where the document has only its beginning, which is all
/// that a rig has room for.
fn whole_title(document: Option<&str>, layout: Option<&str>) -> Option<String> {
    let [said, whole] = [document, layout].map(|title| title.map(one_line));
    match (said, whole) {
        (Some(said), Some(whole)) if whole.starts_with(said.trim_end()) => Some(whole),
        (said, whole) => said.or(whole),
    }
}

/// Text of a file as a picture shows it: in one line, and not too long.
pub(crate) fn shown(words: &str) -> String {
    shortened(&one_line(words), MOST_OF_TITLE)
}

/// A text of at most so many characters; one that is cut ends with an ellipsis.
pub(crate) fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        Some((end, _)) => format!("{}…", text[..end].trim_end()),
        None => text.to_owned(),
    }
}

/// What pictures show of the details of a fit.
pub struct ShownDetails {
    /// The sensors.
    pub sensors: Vec<SensorDetails>,
    /// The hits.
    pub hits: Vec<HitDetails>,
    /// The error budget as stated and as learned.
    pub error_budget: Option<ErrorBudget>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_beginning_of_a_title_gives_way_to_the_whole() {
        let whole = "three-bar frame, twelve hits, second day, after the repair of node 3";
        let title = |document, layout| whole_title(document, layout).unwrap_or_default();
        assert_eq!(title(Some(&whole[..48]), Some(whole)), whole);
        assert_eq!(title(Some("another"), Some(whole)), "another");
        assert_eq!(title(Some("another"), None), "another");
        assert_eq!(title(None, Some(whole)), whole);
        assert_eq!(shortened(whole, 40), "three-bar frame, twelve hits, second day…");
    }
}
