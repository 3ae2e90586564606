//! Reads TOML; the errors name file, line and key.

use std::path::Path;

use serde::de::DeserializeOwned;

use massline_result::{Error, Result};

use crate::file;
use crate::layout_file::{self, Place};

/// The text of a file; `code` is the code of its errors.
pub fn read(path: &Path, code: &'static str) -> Result<String> {
    let bytes = file::read(path, layout_file::MAX_BYTES)
        .map_err(|e| Error::input(code, file::unreadable(path, &e)))?;
    String::from_utf8(bytes)
        .map_err(|_| Error::input(code, format!("{}: this is not UTF-8 text", path.display())))
}

/// Parses a TOML text; `file` is its name in errors.
pub fn parse<T: DeserializeOwned>(text: &str, file: &str, code: &'static str) -> Result<T> {
    massline_toml::read(text).map_err(|error| {
        let place = Place::of_toml_error(file, text, &error);
        Error::input(code, format!("{place}: {}; correct this line", error.message))
    })
}
