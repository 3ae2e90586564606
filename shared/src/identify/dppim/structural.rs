//! The structural form of direct physical parameter identification.

use super::{accepted, sides, solve_structural};
use crate::diagnosis::Diagnostics;
use crate::identify::method::{Entry, Observable};
use crate::identify::suspension::{Answer, Suspension, is_blocked};
use crate::real::Real;

/// Description of the structural form for the registry.
pub const ENTRY: Entry = Entry {
    name: "dppim-structural",
    short_name: "dppim-structural",
    title: "DPPIM structural",
    summary: "Direct identification of Huang and Lallement, structural damping",
    observes: Observable::Suspension,
    uses_priors: false,
    off_when: "the damping is viscous",
    doubted_by: &[],
    is_blocked,
    workspace: |_, _| 0,
};

/// The answer of the structural form, or why there is none.
pub(in crate::identify) fn answer<R: Real>(
    suspension: &Suspension<'_, R>,
) -> Result<Answer<R>, Diagnostics> {
    let [below, above] = sides(suspension);
    accepted(solve_structural(&below, &above, suspension.responses.length))
}
