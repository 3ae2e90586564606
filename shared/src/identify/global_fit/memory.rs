//! The caller's workspace, divided.

use super::elastic::ROOM;
use super::equations::Equations;
use super::unknowns::MOST_SHARED;
use super::{Elastic, nuisances};
use crate::layout::MAX_ATTACHED;
use crate::linalg::{PackedMatrix, triangle};
use crate::real::Real;

/// Rows of the sensitivities of the ten properties.
const PROPERTIES: usize = 10;
/// Vectors over all unknowns.
const VECTORS: usize = 6 + PROPERTIES;

/// Size of the workspace for this number of sensors and hit DOFs, whatever the settings.
pub const fn workspace(sensors: usize, hits: usize) -> usize {
    let unknowns = most_unknowns(sensors, hits);
    2 * triangle(unknowns) + VECTORS * unknowns + 3 * sensors * hits * ROOM
}

const fn most_unknowns(sensors: usize, hits: usize) -> usize {
    nuisances(sensors, hits, MAX_ATTACHED) + hits + MOST_SHARED
}

/// The parts of the workspace; all vectors have the length of the most unknowns.
pub(super) struct Memory<'w, R> {
    pub(super) equations: Equations<'w, R>,
    /// Cholesky factor of the equations with noise, priors and damping.
    pub(super) factor: PackedMatrix<'w, R>,
    /// The unknowns.
    pub(super) x: &'w mut [R],
    /// The unknowns of a trial, or of a simpler model.
    pub(super) trial: &'w mut [R],
    /// Right side with the priors, then the step.
    pub(super) step: &'w mut [R],
    /// Inverse norms of the columns.
    pub(super) scale: &'w mut [R],
    pub(super) scratch: &'w mut [R],
    /// `∂theta/∂right`, ten vectors.
    pub(super) response: &'w mut [R],
}

impl<'w, R: Real> Memory<'w, R> {
    /// Divides a workspace; `None` when it is too small. With `elastic` there is room for residuals of the
    /// elastic modes.
    pub(super) fn new(
        workspace: &'w mut [R],
        sensors: usize,
        hits: usize,
        elastic: bool,
    ) -> Option<Self> {
        let unknowns = most_unknowns(sensors, hits);
        let mut rest = workspace;
        let mut take = |length: usize| {
            let (part, others) = core::mem::take(&mut rest).split_at_mut_checked(length)?;
            rest = others;
            Some(part)
        };
        let (matrix, factor) =
            (PackedMatrix(take(triangle(unknowns))?), PackedMatrix(take(triangle(unknowns))?));
        let (right, x, trial) = (take(unknowns)?, take(unknowns)?, take(unknowns)?);
        let (step, scale, scratch) = (take(unknowns)?, take(unknowns)?, take(unknowns)?);
        let response = take(PROPERTIES * unknowns)?;
        let parts = take(3 * sensors * hits * ROOM)?.as_chunks_mut::<ROOM>().0;
        let used = if elastic { parts.len() } else { 0 };
        let elastic = Elastic { parts: &mut parts[..used], norm: R::zero() };
        let equations = Equations { matrix, right, elastic, squares: R::zero() };
        Some(Self { equations, factor, x, trial, step, scale, scratch, response })
    }
}
