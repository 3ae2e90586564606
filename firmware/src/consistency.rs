//! What shows only when hits are averaged: one that differs from its siblings, a sensor that does not
//! move with the others.

use massline_shared::averaging;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::identify::{NOT_RIGID, ScatterAccumulator, rigid_residuals};
use massline_shared::layout::{TestSettings, Verdict};
use massline_shared::signal::{RESPONSES, Standing};
use nalgebra::SVector;

use crate::rig::Rig;

/// Puts a hit beside its siblings, `single` its own mass lines; tells when it does not agree and is
/// averaged all the same. A policy that rejects such hits makes [`Standing::Astray`] and
/// [`Standing::Contradicts`] of them, any other [`Standing::Agrees`].
pub(crate) fn join(
    rig: &Rig,
    test: &TestSettings<f32>,
    dof: usize,
    siblings: &mut ScatterAccumulator<f32, RESPONSES>,
    single: &SVector<f32, RESPONSES>,
) -> Standing<f32> {
    let verdict = test.policy.verdict(Code::HitInconsistent);
    let standing = averaging::join(siblings, single, verdict);
    let (Standing::Astray(distance) | Standing::Contradicts(distance)) = standing else {
        return standing;
    };
    if verdict == Verdict::Reject {
        return standing;
    }
    let subject = Subject::hit(dof);
    rig.say(Diagnostic::about(Code::HitInconsistent, verdict.severity(), subject, distance));
    Standing::Agrees
}

/// The sensor that moves least with the others, when it does not move as a part of a rigid body.
pub(crate) fn tell_not_rigid(
    rig: &Rig,
    test: &TestSettings<f32>,
    readings: &SVector<f32, RESPONSES>,
) {
    let layout = rig.layout.borrow();
    let residuals = layout.as_ref().and_then(|layout| rigid_residuals(layout, readings));
    let numbers = residuals.iter().flatten().enumerate().filter(|(_, left)| left.is_finite());
    let worst = numbers.max_by(|a, b| a.1.total_cmp(b.1));
    if let Some((sensor, &left)) = worst.filter(|(_, left)| **left > NOT_RIGID as f32) {
        // About the sensor, not about a hit: hitting again would not help, so it warns at most.
        let verdict = test.policy.verdict(Code::MotionNotRigid);
        let severity = verdict.severity().min(Severity::Warning);
        rig.say(Diagnostic::about(Code::MotionNotRigid, severity, Subject::sensor(sensor), left));
    }
}
