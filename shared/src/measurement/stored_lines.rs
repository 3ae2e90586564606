//! What is kept in memory of a DOF whose lines are stored.

use super::long_hit::LineScatter;

/// What is kept in memory of a DOF whose lines are stored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StoredLines<R> {
    /// Index of the DOF in the layout.
    pub dof: u8,
    /// Number of hits averaged.
    pub hits: u16,
    /// How they scatter.
    pub scatter: LineScatter<R>,
}
