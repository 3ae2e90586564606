//! What the operator can say to a campaign.

/// What hangs on the cords.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum Object {
    /// What is to be identified.
    Unknown,
    /// A block of known mass, kg: its hits say what the hammer's gain is against the sensors'.
    Block {
        /// kg.
        mass: f32,
    },
}

/// How a campaign was started.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Start {
    /// What is hit.
    pub object: Object,
    /// Every hit waits for `Accept` or `Reject`.
    pub confirm: bool,
}

impl Start {
    /// An unknown object, and no confirmation.
    pub const USUAL: Self = Self { object: Object::Unknown, confirm: false };
}

/// What the operator wants of a campaign that has been started.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// Accept the hit that waits for confirmation.
    Accept,
    /// Reject the hit that waits for confirmation.
    Reject,
    /// Forget all hits of the DOF in hand and measure it again.
    Redo,
    /// Leave the DOF in hand out.
    Skip,
    /// Go on with the hits that this DOF has.
    Finish,
    /// Interrupt: stop sampling, keep everything accepted.
    Pause,
    /// Go on after an interruption.
    Resume,
    /// End the campaign without a result.
    Abort,
}

impl Command {
    /// Every command.
    pub const ALL: [Self; 8] = [
        Self::Accept,
        Self::Reject,
        Self::Redo,
        Self::Skip,
        Self::Finish,
        Self::Pause,
        Self::Resume,
        Self::Abort,
    ];
}

/// Why a command was not executed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CommandError {
    /// It has no meaning now.
    WrongPhase,
    /// The layout has no hit DOF, or more than a rig has memory for.
    NoDofs,
}

impl core::fmt::Display for CommandError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::WrongPhase => "the command has no meaning in this phase of the campaign",
            Self::NoDofs => "the layout has no hit DOF, or more than a rig has memory for",
        })
    }
}

impl core::error::Error for CommandError {}
