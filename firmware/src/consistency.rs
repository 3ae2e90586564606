//! What shows only when hits are averaged: one that differs from its siblings, a sensor that does not
//! move with the others.

use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::identify::{NOT_RIGID, ScatterAccumulator, rigid_residuals};
use massline_shared::layout::TestSettings;
use massline_shared::signal::{RESPONSES, inconsistent_from};
use nalgebra::SVector;

use crate::rig::Rig;

/// The last hit at a DOF is far from those before.
pub(crate) fn tell_inconsistent(
    rig: &Rig,
    test: &TestSettings<f32>,
    dof: usize,
    siblings: &ScatterAccumulator<f32, RESPONSES>,
    single: &SVector<f32, RESPONSES>,
) {
    let limit = inconsistent_from(u32::from(siblings.hits()), siblings.spread());
    if let Some(distance) = siblings.distance(single).filter(|&far| far > limit) {
        rig.say(late(test, Code::HitInconsistent, dof, distance));
    }
}

/// The sensor that moves least with the others, when it does not move as a part of a rigid body.
pub(crate) fn tell_not_rigid(
    rig: &Rig,
    test: &TestSettings<f32>,
    readings: &SVector<f32, RESPONSES>,
) {
    let layout = rig.layout.borrow();
    let residuals = layout.as_ref().and_then(|layout| rigid_residuals(layout, readings));
    let worst = residuals.iter().flatten().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
    if let Some((sensor, &left)) = worst.filter(|(_, left)| **left > NOT_RIGID as f32) {
        rig.say(late(test, Code::MotionNotRigid, sensor, left));
    }
}

/// A finding about hits that are averaged already: a policy that rejects them comes too late, so it
/// warns.
fn late(test: &TestSettings<f32>, code: Code, subject: usize, value: f32) -> Diagnostic {
    let severity = test.policy.verdict(code).severity().min(Severity::Warning);
    Diagnostic::about(code, severity, subject as u16, value)
}
