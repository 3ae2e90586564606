//! What was understood of a file with frequency responses.

use serde::{Deserialize, Serialize};

/// What was understood of a file with frequency responses.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FrequencyResponsesRead {
    /// Number of frequency responses in use.
    pub functions: usize,
    /// Their quantities and units.
    pub units: Vec<UnitsRead>,
    /// Number of bins in use.
    pub bins: usize,
    /// The first and the last of them.
    pub range_hz: [f64; 2],
    /// What of the file is not used.
    pub left_out: Vec<String>,
}

/// Quantity and unit of frequency responses.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UnitsRead {
    /// Number of frequency responses with this unit.
    pub functions: usize,
    /// `accelerance`, `mobility` or `receptance`.
    pub quantity: String,
    /// The unit in the file.
    pub unit: String,
    /// Where the unit was read: labels, dataset 164, or nowhere.
    pub source: String,
}
