//! What the person at the rig sees and presses, without pixels.

use massline_shared::layout::Dof;
use massline_shared::protocol::message::{Measured, Phase};

/// What the panel shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PanelModel {
    /// What the campaign is doing.
    pub phase: Phase,
    /// The DOF in hand, its index and its name; none without a layout.
    pub dof: Option<(u8, Dof)>,
    /// Counts every arming since power-on.
    pub armings: u32,
    /// Accepted hits at this DOF.
    pub accepted: u8,
    /// Accepted hits wanted at this DOF.
    pub wanted: u8,
    /// DOFs of the layout.
    pub dofs: u8,
    /// Raw code of what made the rig reject the last hit.
    pub rejected_for: Option<u16>,
    /// Mass by the best answer of the last result, kg.
    pub mass: Option<Measured>,
}

impl PanelModel {
    /// What a rig shows that has just started.
    pub const START: Self = Self {
        phase: Phase::Idle,
        dof: None,
        armings: 0,
        accepted: 0,
        wanted: 0,
        dofs: 0,
        rejected_for: None,
        mass: None,
    };
}

/// A button of the rig.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Button {
    /// Accept, start, go on.
    Ok,
    /// Reject, measure again.
    Back,
    /// Pause, skip.
    Next,
}
