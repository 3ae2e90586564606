//! Commands of the operator to a campaign.

/// The object on the cords.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Object {
    /// An object to be identified.
    Unknown,
    /// A block of known mass: its hits determine the hammer's gain against the sensors'. The layout need not determine
    /// the ten properties, they are not identified, and the result is marked with
    /// [`Code::BlockTest`](crate::diagnosis::Code::BlockTest).
    Block {
        /// Mass of the block, kg.
        mass: f32,
    },
}

/// Options of a campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Start {
    /// The object that is hit.
    pub object: Object,
    /// True when every hit waits for `Accept` or `Reject`.
    pub confirm: bool,
    /// Age of the calibration, days; zero when it is not known, as on a rig without a host.
    pub calibration_age_days: u16,
    /// Time of the start, seconds since 1970-01-01 00:00 UTC; zero when it is not known, as on a rig without a
    /// host.
    pub started_unix_s: u32,
}

impl Start {
    /// The default: an unknown object, and no confirmation.
    pub const DEFAULT: Self = Self {
        object: Object::Unknown,
        confirm: false,
        calibration_age_days: 0,
        started_unix_s: 0,
    };
}

/// A command of the operator to a campaign in progress.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Command {
    /// Accept the hit that is waiting for confirmation.
    Accept,
    /// Reject the hit that is waiting for confirmation.
    Reject,
    /// Discard all hits of the current DOF and measure it again.
    Redo,
    /// Leave out the current DOF.
    Skip,
    /// Continue with the next DOF, using the hits accepted so far.
    Finish,
    /// Interrupt the campaign: stop sampling or computing, but keep all accepted hits. A computation begins anew with
    /// [`Self::Resume`].
    Pause,
    /// Continue after an interruption.
    Resume,
    /// End the campaign without a result.
    Abort,
    /// At the target: leave out the other DOFs and compute the result.
    Conclude,
    /// At the target: measure the other DOFs as well.
    Continue,
    /// Take back the last accepted hit while the rig waits for the next one, also the last hit of a DOF that it has
    /// finished: this DOF is then open again.
    Undo,
}

impl Command {
    /// Every command.
    pub const ALL: [Self; 11] = [
        Self::Accept,
        Self::Reject,
        Self::Redo,
        Self::Skip,
        Self::Finish,
        Self::Pause,
        Self::Resume,
        Self::Abort,
        Self::Conclude,
        Self::Continue,
        Self::Undo,
    ];
}

/// Why a command was not executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandError {
    /// The command is not possible in this phase.
    WrongPhase,
    /// The layout has no hit DOF, or more than the rig has memory for.
    NoDofs,
    /// No hit has been accepted since power-on, the start of the campaign, the last undo, or a DOF that was skipped
    /// or is measured again.
    NothingToUndo,
    /// A later hit has overwritten the record of the last accepted one.
    HitOverwritten,
}

impl core::fmt::Display for CommandError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::WrongPhase => "the command has no meaning in this phase of the campaign",
            Self::NoDofs => "the layout has no hit DOF, or more than a rig has memory for",
            Self::NothingToUndo => "there is no accepted hit to undo",
            Self::HitOverwritten => {
                "a later hit has overwritten the record of the last accepted hit"
            }
        })
    }
}

impl core::error::Error for CommandError {}
