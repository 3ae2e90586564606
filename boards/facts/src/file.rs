//! Reads the facts of a board from its folder, and checks them.

use std::fs;
use std::path::Path;

use crate::board::Board;
use crate::check::check;
use crate::error::Error;

/// The name of the file in the board's folder.
pub const FILE: &str = "board.toml";

impl Board {
    /// Reads and checks the facts in the folder of a board.
    ///
    /// # Errors
    /// The error names the file and the key.
    pub fn read(folder: &Path) -> Result<Self, Error> {
        let path = folder.join(FILE);
        let name = folder.file_name().unwrap_or_default().to_string_lossy();
        let text = fs::read_to_string(&path)
            .map_err(|source| Error::NotRead { path: path.clone(), source })?;
        Self::parse(&name, &text).map_err(|error| error.in_file(&path))
    }

    /// Parses and checks the facts of the board with this name from the text of its file.
    ///
    /// # Errors
    /// The error names the key.
    pub fn parse(name: &str, text: &str) -> Result<Self, Error> {
        let board: Self = toml::from_str(text).map_err(Error::syntax)?;
        let board = Self { name: name.to_owned(), ..board };
        check(&board)?;
        Ok(board)
    }
}
