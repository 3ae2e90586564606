//! The results on a rig and the archives in a folder.

use serde::Serialize;

use massline_result::FilePath;
use massline_result::Spread;

/// The results that a rig keeps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ResultsList {
    /// The results.
    pub results: Vec<KeptResult>,
}

/// A result on a rig.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KeptResult {
    /// What it says.
    #[serde(flatten)]
    pub summary: Summary,
    /// Its number.
    pub number: u32,
    /// The layout's hash, eight hexadecimal digits.
    pub layout_hash: Option<String>,
    /// Its length in the rig's flash.
    pub bytes: u32,
}

/// The archives in a folder.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct History {
    /// The archives, the oldest first.
    pub archives: Vec<ListedArchive>,
    /// Files with the name of an archive that cannot be read.
    pub unreadable: Vec<UnreadableFile>,
}

/// An archive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ListedArchive {
    /// What its result says.
    #[serde(flatten)]
    pub summary: Summary,
    /// Its path.
    pub file: FilePath,
}

/// A file that cannot be read.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct UnreadableFile {
    /// Its path.
    pub file: FilePath,
    /// Stable name of the reason.
    pub code: String,
    /// A sentence for people.
    pub message: String,
}

/// What a list says about a result.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Title of the layout.
    pub title: String,
    /// When the campaign was started, RFC 3339 in UTC; `null` when the rig was not told the time.
    pub measured: Option<String>,
    /// Name of the method with the best answer; `null` without an answer.
    pub method: Option<String>,
    /// The mass by this method.
    pub mass_kg: Option<Spread<f64>>,
    /// Whether the result can be used: `good`, `use_with_care`, `do_not_use`, `to_be_solved` or `no_answer`.
    pub verdict: &'static str,
}

/// The results that were deleted on a rig.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeletedResults {
    /// Their numbers.
    pub deleted: Vec<u32>,
}
