//! What limits an answer.

use serde::{Deserialize, Serialize};

use crate::properties::Properties;

/// What an error source contributes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ErrorSource {
    /// Its name.
    pub source: String,
    /// Its share of the sum of the ten relative variances, from 0 to 1.
    pub share: f64,
    /// Its share of the variance of each property, from 0 to 1.
    pub shares: Properties<f64>,
}
