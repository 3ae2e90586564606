//! Why the rig does not do what a button asks for.

use massline_shared::measurement::StartError;
use massline_shared::measurement::campaign::CommandError;

use crate::store::StoreError;

/// Why the rig does not do it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Refused {
    /// It is there no longer.
    NotFound,
    /// Something else is going on.
    WrongPhase,
    /// No layout is kept.
    NoLayout,
    /// The layout cannot determine the ten properties.
    LayoutRefused,
    /// The store is full.
    StoreFull,
    /// The flash did not keep it.
    StoreFailed,
    /// The flash is at work.
    Busy,
    /// The converter does not answer.
    SamplerStopped,
}

impl Refused {
    /// Every reason.
    pub const ALL: [Self; 8] = [
        Self::NotFound,
        Self::WrongPhase,
        Self::NoLayout,
        Self::LayoutRefused,
        Self::StoreFull,
        Self::StoreFailed,
        Self::Busy,
        Self::SamplerStopped,
    ];
}

impl From<StartError> for Refused {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Busy => Self::Busy,
            StartError::NoLayout => Self::NoLayout,
            StartError::LayoutRefused => Self::LayoutRefused,
            StartError::NoRoom => Self::StoreFull,
            StartError::WrongPhase => Self::WrongPhase,
        }
    }
}

impl From<CommandError> for Refused {
    fn from(error: CommandError) -> Self {
        match error {
            CommandError::WrongPhase => Self::WrongPhase,
            CommandError::NoDofs => Self::NoLayout,
        }
    }
}

impl From<StoreError> for Refused {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::NotFound => Self::NotFound,
            StoreError::Full => Self::StoreFull,
            StoreError::Malformed | StoreError::Failed => Self::StoreFailed,
        }
    }
}
