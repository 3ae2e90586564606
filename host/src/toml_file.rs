//! Reads TOML; the errors name file, line and key.

use std::path::Path;

use serde::de::DeserializeOwned;

use crate::layout_file::Place;
use crate::{Error, Result};

/// Largest TOML file that is read, bytes.
const MAX_BYTES: u64 = 1 << 24;

/// The text of a file; `code` is the code of its errors.
pub(crate) fn read(path: &Path, code: &'static str) -> Result<String> {
    let file = path.display();
    let bytes = crate::file::read(path, MAX_BYTES)
        .map_err(|e| Error::input(code, format!("{file}: cannot be read: {e}; check the path")))?;
    String::from_utf8(bytes)
        .map_err(|_| Error::input(code, format!("{file}: this is not UTF-8 text")))
}

/// Parses a TOML text; `file` is its name in errors.
pub(crate) fn parse<T: DeserializeOwned>(text: &str, file: &str, code: &'static str) -> Result<T> {
    toml::from_str(text).map_err(|error| {
        let (place, message) = Place::of_toml_error(file, text, &error);
        Error::input(code, format!("{place}: {message}; correct this line"))
    })
}
