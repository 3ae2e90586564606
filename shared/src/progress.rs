//! Work that is done in steps.

/// Whether another step is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Another step is needed.
    Going,
    /// The work is finished.
    Done,
}
