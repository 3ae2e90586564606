//! What was written to files, and what the program says about itself.

use serde::Serialize;

use massline_result::FilePath;
use massline_result::Verdict;

/// A file that was written.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct WrittenFile {
    /// Its path.
    pub written: FilePath,
}

/// A layout to start from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LayoutTemplate {
    /// The text of the file.
    pub layout: String,
}

/// A file for another program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExportedFile {
    /// Its path.
    pub written: FilePath,
    /// Its format.
    pub format: String,
    /// Its system of units.
    pub units: String,
    /// The frame of its coordinates.
    pub frame: String,
    /// Notes on the result.
    pub notes: Vec<String>,
    /// The answer in it; missing in a file of frequency responses.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub answer: Option<ExportedAnswer>,
}

/// An answer in a file for another program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct ExportedAnswer {
    /// Name of its method.
    pub method: String,
    /// Whether a body can have these properties.
    pub physically_consistent: bool,
    /// The verdict on the result.
    pub verdict: Verdict,
    /// What puts it in doubt.
    pub doubts: Vec<String>,
}

/// Pictures of a result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DrawnPictures {
    /// Paths of their files.
    pub written: Vec<FilePath>,
}

/// What a shell knows about the program.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Completions {
    /// Name of the shell.
    pub shell: String,
    /// The script.
    pub completions: String,
}

/// A virtual rig.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct VirtualPort {
    /// The port that other commands take.
    pub port: String,
}

/// The documents that have a schema.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SchemaList {
    /// The documents.
    pub documents: Vec<DescribedDocument>,
}

/// A document that has a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct DescribedDocument {
    /// Its name.
    pub document: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// The commands that print it; none for one that all of them print.
    pub commands: &'static [&'static str],
}
