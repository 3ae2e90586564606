//! What a campaign on a block of known mass says of the hammer, when the mass was typed in at the rig.

use heapless::Vec;
use massline_protocol::object::MeasurementResult;
use massline_shared::calibration::block::{
    BlockError, BlockHit, BlockMass, ForceRatio, force_ratio,
};
use massline_shared::identify::MassLines;
use massline_shared::layout::RIG_HITS;
use massline_shared::signal::RESPONSES;
use nalgebra::Vector3;

use crate::rig::Rig;

/// How well a mass that is typed in is taken to be known, relative: a kitchen scale.
const MASS_SIGMA: f32 = 1e-3;

/// The hammer against the sensors, from the mass lines of the campaign.
///
/// Uses 5 KB of stack.
#[inline(never)]
pub(crate) fn weigh(
    rig: &Rig,
    result: &MeasurementResult,
    mass: f32,
) -> Result<ForceRatio<f32>, BlockError> {
    let layout = rig.layout.borrow();
    let layout = layout.as_ref().ok_or(BlockError::DirectionsMissing)?;
    let mut hits = Vec::<BlockHit<f32, RESPONSES>, RIG_HITS>::new();
    for dof in &result.dofs {
        // The scatter of less than three hits is not known; without it they count as one.
        let count = if dof.scatter.is_empty() { 1 } else { u16::from(dof.hits) };
        let lines = MassLines::from_parts(&dof.accelerance, &dof.noise, &dof.scatter, count)
            .ok_or(BlockError::NotFinite)?;
        let hit = layout.hits.get(usize::from(dof.index)).ok_or(BlockError::DirectionsMissing)?;
        // There is room for every DOF of a layout.
        let _ = hits.push(BlockHit { direction: Vector3::from(hit.direction), lines });
    }
    let sensors = layout.sensors.len();
    force_ratio(&hits, sensors, BlockMass { mass, sigma: mass * MASS_SIGMA })
}
