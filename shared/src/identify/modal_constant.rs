//! The mass line as a constant of the modal fit: Newton and Euler for the rigid body's accelerance.
//!
//! Far above its suspension modes the body moves as if it were free. The fit of the modes contains that limit as the
//! constant of every accelerance, so the curve fit of the mass line can be replaced (theory, section 7). An elastic
//! mode above the band is in the term in s², not in the constant.

use super::inertia_restraint::Regression;
use super::method::{Entry, Observable};
use super::suspension::{Answer, Suspension};
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::modes::SUSPENSION_MODES;
use crate::real::Real;

/// Description of the method for the registry.
pub const ENTRY: Entry = Entry {
    name: "modal-constant",
    short_name: "modal-constant",
    title: "Modal constant",
    summary: "Inertia restraint on the constant of the modal fit",
    observes: Observable::Suspension,
    uses_priors: false,
    off_when: "an elastic mode is near the band",
    doubted_by: &[],
    is_blocked: |_, _| true,
    workspace: |_, _| 0,
};

/// The answer of the method, or why there is none.
pub(super) fn answer<R: Real>(suspension: &Suspension<'_, R>) -> Result<Answer<R>, Diagnostics> {
    let modes = suspension.modes.modes.len();
    if modes < SUSPENSION_MODES {
        return Err(fatal(Code::SixModesNeeded, R::of(modes as f64)));
    }
    let mut regression = Regression::new(suspension.responses.length);
    for (motion, force) in suspension.modes.rigid.iter().zip(suspension.responses.forces) {
        regression.add(motion, force);
    }
    let solution = regression.solve()?;
    if solution.body.mass <= R::zero() {
        return Err(fatal(Code::MassNotPositive, solution.body.mass));
    }
    Ok(Answer { body: solution.body, condition: solution.condition, misfit: None })
}
