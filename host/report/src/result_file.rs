//! One result with its test, read from a file: what pictures and reports are made of.

mod measured;
mod modes;
mod names;
mod responses;
mod title;

use massline_result::{Error, LoggedHit, Result, TestResult};
use massline_shared::layout::HostLayout;

use crate::document::versioned;
use crate::export::one_line;
use massline_files::archive::Archive;
use massline_files::layout_file::{LayoutFile, all_known};

use modes::check_modes;
pub use names::distinct_names;
pub use responses::{Band, DofResponses, FileResponses, HitResponses};
use title::whole_title;
pub use title::{shorten_for_picture, shortened};

/// A result with its test.
pub struct ResultFile {
    /// The title of the layout, or the name of the file, as long as a picture has room for.
    pub title: String,
    /// The same in full length.
    pub whole_title: String,
    /// The name of the file.
    pub name: String,
    result: TestResult,
    archive: Option<Archive>,
    layout: Option<HostLayout>,
    layout_file: Option<LayoutFile>,
    /// Frequency responses that the result does not hold.
    responses: Vec<DofResponses>,
    /// What the ten properties should be, as far as it is known.
    expected: [Option<f64>; 10],
}

impl ResultFile {
    /// A result that is no file, by its name.
    ///
    /// # Errors
    /// When its suspension modes are more than a picture has room for.
    pub fn of_result(
        result: TestResult,
        layout: Option<&LayoutFile>,
        name: String,
    ) -> Result<Self> {
        Self::new(result, None, name.clone(), &name, layout)
    }

    /// A result of a file, with the archive that it is in; `stem` is what files are called that are made of it. An
    /// archive has its own layout, with which its answers were found.
    ///
    /// # Errors
    /// When the layout of an archive cannot be read, or when its suspension modes are more than a picture has room for.
    pub fn new(
        result: TestResult,
        archive: Option<Archive>,
        name: String,
        stem: &str,
        layout: Option<&LayoutFile>,
    ) -> Result<Self> {
        if let Some(modes) = &result.suspension {
            check_modes(modes).map_err(|reason| {
                let text = format!("{name}: suspension.{reason}");
                Error::input("result_value_wrong", text)
            })?;
        }
        let text = archive.as_ref().and_then(|archive| archive.layout.toml.as_deref());
        let of_archive = text.map(|text| LayoutFile::parse(text, &name)).transpose()?;
        let layout = if archive.is_some() { of_archive.as_ref() } else { layout };
        let stored = archive.as_ref().map(|archive| &archive.layout.resolved);
        let result_title = Some(result.title.as_str()).filter(|title| !title.is_empty());
        let title = layout.map(|file| file.title.as_str()).filter(|title| !title.is_empty());
        let whole_title = whole_title(result_title, title).unwrap_or_else(|| one_line(stem));
        let of_layout =
            layout.and_then(|file| file.reference).map(|reference| reference.properties());
        let stated = result.expected();
        let is_stated = stated.iter().any(Option::is_some);
        let expected = if is_stated { stated } else { of_layout.unwrap_or(stated) };
        Ok(Self {
            title: shorten_for_picture(&whole_title),
            whole_title,
            layout_file: layout.cloned(),
            layout: stored.or(layout.map(|file| &file.layout)).cloned(),
            responses: Vec::new(),
            expected,
            result,
            archive,
            name,
        })
    }

    /// The result, that of an archive solved again.
    pub fn result(&self) -> &TestResult {
        &self.result
    }

    /// What the ten properties should be, as far as it is known: those of a simulated object, or the layout's
    /// reference.
    pub fn expected(&self) -> [Option<f64>; 10] {
        self.expected
    }

    /// The same, where all ten are known.
    pub fn reference(&self) -> Option<[f64; 10]> {
        all_known(self.expected)
    }

    /// The layout, where it is known.
    pub fn layout(&self) -> Option<&HostLayout> {
        self.layout.as_ref()
    }

    /// The layout file, where there is one: in the archive, or given beside the result.
    pub fn layout_file(&self) -> Option<&LayoutFile> {
        self.layout_file.as_ref()
    }

    /// Every hit that was graded during the measurement, where the result has a log of them.
    pub fn hit_log(&self) -> &[LoggedHit] {
        self.archive.as_ref().map_or(&self.result.hit_log, |archive| &archive.hit_log)
    }

    /// The JSON text from which this result can be read again: the archive without the records of hits, which would
    /// take most of a page, or the document.
    ///
    /// # Errors
    /// When the archive cannot be written.
    pub fn json(&self) -> Result<String> {
        let Some(archive) = &self.archive else { return versioned(&self.result) };
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
        of_layout.or(self.result.characteristic_length_m).filter(|length| *length > 0.0)
    }
}
