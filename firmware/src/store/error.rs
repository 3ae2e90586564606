//! Errors of the store.

use core::fmt;

/// Why an operation of the store failed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// The requested item is not stored.
    NotFound,
    /// The bytes cannot be decoded as what was to be stored.
    Malformed,
    /// There is not enough room.
    Full,
    /// Writing or reading the flash failed.
    Failed,
    /// The supply is too low to write flash.
    SupplyLow,
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFound => "not found in the store",
            Self::Malformed => "the data cannot be decoded",
            Self::Full => "the store is full",
            Self::Failed => "writing or reading the flash failed",
            Self::SupplyLow => "the supply is too low to write flash",
        })
    }
}

impl core::error::Error for StoreError {}
