//! Why the rig refuses an action of the panel.

use massline_shared::measurement::StartError;
use massline_shared::measurement::campaign::CommandError;

use crate::store::StoreError;

/// Why the rig refuses an action.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RefusalReason {
    /// The item no longer exists.
    NotFound,
    /// The rig is doing something else.
    WrongPhase,
    /// No layout is stored.
    NoLayout,
    /// The layout cannot determine the ten properties.
    LayoutRefused,
    /// The store is full.
    StoreFull,
    /// There is too little room for the campaign, until so many results are deleted; zero when even without results
    /// there is.
    TooLittleRoom(u8),
    /// A block of known mass is weighed by mass lines, and the layout has the suspension profile.
    BlockNeedsMassLines,
    /// Writing or reading the flash failed.
    StoreFailed,
    /// The supply is too low to write flash.
    SupplyLow,
    /// The flash is being written.
    Busy,
    /// The converter does not answer.
    SamplerStopped,
    /// There is no accepted hit to undo.
    NothingToUndo,
    /// A later hit has overwritten the record of the last accepted one.
    HitOverwritten,
}

impl RefusalReason {
    /// Every reason.
    pub const ALL: [Self; 13] = [
        Self::NotFound,
        Self::WrongPhase,
        Self::NoLayout,
        Self::LayoutRefused,
        Self::StoreFull,
        Self::TooLittleRoom(1),
        Self::BlockNeedsMassLines,
        Self::StoreFailed,
        Self::SupplyLow,
        Self::Busy,
        Self::SamplerStopped,
        Self::NothingToUndo,
        Self::HitOverwritten,
    ];
}

impl From<StartError> for RefusalReason {
    fn from(error: StartError) -> Self {
        match error {
            StartError::Busy => Self::Busy,
            StartError::NoLayout => Self::NoLayout,
            StartError::LayoutRefused => Self::LayoutRefused,
            StartError::BlockNeedsMassLines => Self::BlockNeedsMassLines,
            StartError::NoRoom => Self::StoreFull,
            StartError::WrongPhase => Self::WrongPhase,
        }
    }
}

impl From<CommandError> for RefusalReason {
    fn from(error: CommandError) -> Self {
        match error {
            CommandError::WrongPhase => Self::WrongPhase,
            CommandError::NoDofs => Self::NoLayout,
            CommandError::NothingToUndo => Self::NothingToUndo,
            CommandError::HitOverwritten => Self::HitOverwritten,
        }
    }
}

impl From<StoreError> for RefusalReason {
    fn from(error: StoreError) -> Self {
        match error {
            StoreError::NotFound => Self::NotFound,
            StoreError::Full => Self::StoreFull,
            StoreError::Malformed | StoreError::Failed => Self::StoreFailed,
            StoreError::SupplyLow => Self::SupplyLow,
        }
    }
}
