//! Why the store did not do it.

use core::fmt;

/// Why the store did not do it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreError {
    /// There is no such thing.
    NotFound,
    /// The bytes are not what was to be kept.
    Malformed,
    /// There is no room.
    Full,
    /// The flash did not keep it or did not give it back.
    Failed,
}

impl fmt::Display for StoreError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotFound => "the store has no such thing",
            Self::Malformed => "the bytes are not what was to be kept",
            Self::Full => "the store is full",
            Self::Failed => "the flash did not keep it or did not give it back",
        })
    }
}

impl core::error::Error for StoreError {}
