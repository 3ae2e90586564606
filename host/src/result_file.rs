//! One result with its test, read from a file: what pictures and reports are made of.

mod answers;
mod measured;
mod modes;
mod names;
mod responses;
mod title;

use std::path::{Path, PathBuf};

use massline_shared::body::scale;
use massline_shared::layout::HostLayout;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::archive::{Archive, is_archive};
use crate::document::{LoggedHit, Solution};
use crate::embedded;
use crate::error::{Error, Result};
use crate::export::{document_of_archive, one_line, read_document};
use crate::layout_file::{LayoutFile, all_known};
use crate::output::SCHEMA_VERSION;

pub use answers::Combined;
pub use measured::{ShownDetails, ShownDof, ShownMassLine};
pub use modes::ShownModes;
pub use names::distinct_names;
pub use responses::{Band, DofResponses};
use title::whole_title;
pub(crate) use title::{shortened, shown};

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
    /// What the ten properties should be, as far as it is known.
    expected: [Option<f64>; 10],
}

impl ResultFile {
    /// Reads several results; `layout` is the layout file of those that are no archives.
    ///
    /// # Errors
    /// As [`Self::read`], and exit 2 for a layout where all are archives.
    pub fn read_all(paths: &[PathBuf], layout: Option<&LayoutFile>) -> Result<Vec<Self>> {
        let read = |path: &PathBuf| Self::read(path, layout);
        let sources = paths.iter().map(read).collect::<Result<Vec<_>>>()?;
        if layout.is_some() && sources.iter().all(|source| source.archive.is_some()) {
            let names: Vec<&str> = sources.iter().map(|source| source.name.as_str()).collect();
            let text = format!(
                "{}: an archive has the layout of its test, which --layout does not replace; leave it out, or solve the \
                 archive with another layout: `massline solve LAYOUT.toml ARCHIVE`",
                names.join(", ")
            );
            return Err(Error::input("layout_not_for_archive", text));
        }
        Ok(sources)
    }

    /// Reads an archive or the JSON output of a command; `layout` is the layout file of the test. An archive has its own,
    /// with which its answers were found.
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
        let layout = if archive.is_some() { of_archive.as_ref() } else { layout };
        let stored = archive.as_ref().map(|archive| &archive.layout.resolved);
        let said = document["title"].as_str().filter(|title| !title.is_empty());
        let title = layout.map(|file| file.title.as_str()).filter(|title| !title.is_empty());
        let whole_title = whole_title(said, title).unwrap_or_else(|| one_line(stem));
        let stated = layout.and_then(|file| file.reference).map(|of| of.properties());
        let expected = truth_in(&document).map(|truth| truth.map(Some)).or(stated);
        let expected = expected.unwrap_or([None; 10]);
        Ok(Self {
            title: shown(&whole_title),
            whole_title,
            layout_file: layout.cloned(),
            layout: stored.or(layout.map(|file| &file.layout)).cloned(),
            responses: Vec::new(),
            expected,
            document,
            archive,
            name,
        })
    }

    /// What the ten properties should be, as far as it is known: those of a simulated object, or the layout's reference.
    pub fn expected(&self) -> [Option<f64>; 10] {
        self.expected
    }

    /// The same, where all ten are known.
    pub fn reference(&self) -> Option<[f64; 10]> {
        all_known(self.expected)
    }

    /// The ten properties of a simulated object, which only its document states; `None` for an object that was measured.
    pub fn truth(&self) -> Option<[f64; 10]> {
        truth_in(&self.document)
    }

    /// The layout, where it is known.
    pub fn layout(&self) -> Option<&HostLayout> {
        self.layout.as_ref()
    }

    /// The layout file, where there is one: in the archive, or given beside the result.
    pub fn layout_file(&self) -> Option<&LayoutFile> {
        self.layout_file.as_ref()
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

    /// The root mean square distance of the sensors from their centre, m, where it is known.
    pub fn characteristic_length(&self) -> Option<f64> {
        let of_layout = self.layout().map(HostLayout::characteristic_length);
        let stated = || self.document["characteristic_length_m"].as_f64();
        of_layout.or_else(stated).filter(|length| *length > 0.0)
    }

    /// The scale of the ten properties for this mass, kg.
    ///
    /// # Errors
    /// Exit 2 where it is not known how far the sensors are apart.
    pub fn scale(&self, mass: f64) -> Result<[f64; 10]> {
        let length = self.characteristic_length().ok_or_else(|| {
            let text = format!(
                "{}: the result does not say where the sensors are, which its scale needs; give the layout file of \
                 the test with --layout",
                self.name
            );
            Error::input(LAYOUT_NEEDED, text)
        })?;
        Ok(scale(mass, length).into())
    }

    fn part<T: DeserializeOwned>(&self, of: &Value, what: &str, key: &str) -> Result<T> {
        T::deserialize(&of[key]).map_err(|e| {
            let text = format!("{}: {key} of the {what}: {e}", self.name);
            Error::input("result_malformed", text)
        })
    }
}

/// The ten properties of a simulated object, where a document states them.
fn truth_in(document: &Value) -> Option<[f64; 10]> {
    Deserialize::deserialize(&document["truth"]).ok()
}
