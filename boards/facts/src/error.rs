//! Errors in the facts of a board.

use std::io;
use std::path::{Path, PathBuf};

/// An error in the facts of a board, and its place.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    NotRead {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// A file that cannot be written.
    #[error("{}: {source}", path.display())]
    NotWritten {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// Invalid TOML, a missing or unknown key, or a value of the wrong type.
    #[error("{}: {source}", path.display())]
    Syntax {
        /// The file; empty if the text came without one.
        path: PathBuf,
        /// Line and key.
        source: Box<toml::de::Error>,
    },
    /// A value that contradicts another one.
    #[error("{}: {key}: {why}", path.display())]
    Contradiction {
        /// The file; empty if the text came without one.
        path: PathBuf,
        /// The key.
        key: &'static str,
        /// Why its value is wrong.
        why: String,
    },
    /// A program of the toolchain that does not say what it was asked for.
    #[error("{command}: {why}")]
    NoAnswer {
        /// The program and its subcommand.
        command: String,
        /// The cause.
        why: String,
    },
    /// Two boards that cannot be distinguished.
    #[error(
        "boards/{part} and boards/{whole}: the name of the one is part of the other's, and an image is identified by \
         the board name that it contains; rename one folder"
    )]
    Ambiguous {
        /// The shorter name.
        part: String,
        /// The longer one.
        whole: String,
    },
}

impl Error {
    pub(crate) fn syntax(source: toml::de::Error) -> Self {
        Self::Syntax { path: PathBuf::new(), source: Box::new(source) }
    }

    pub(crate) fn contradiction(key: &'static str, why: String) -> Self {
        Self::Contradiction { path: PathBuf::new(), key, why }
    }

    pub(crate) fn in_file(mut self, file: &Path) -> Self {
        if let Self::Syntax { path, .. } | Self::Contradiction { path, .. } = &mut self {
            *path = file.to_owned();
        }
        self
    }
}
