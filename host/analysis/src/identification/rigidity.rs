//! Whether the mass lines fit a rigid body under a layout, as a rig checks it when a DOF is measured.

use massline_shared::capacity::Unbounded;
use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::identify::{DofMassLines, RIGIDITY_LIMIT, rigid_residuals};
use massline_shared::layout::HostLayout;

/// The sensors that do not move with the others: the one with the largest residual of each hit DOF, once each.
pub fn sensors_not_rigid(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
) -> Vec<Diagnostic> {
    let mut worst = vec![0.0_f64; layout.sensors.len()];
    for (_, own) in lines {
        let residuals = rigid_residuals(layout, &own.accelerance);
        let largest =
            residuals.iter().flatten().copied().enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((sensor, left)) = largest {
            worst[sensor] = worst[sensor].max(left);
        }
    }
    let severity =
        layout.test.policy.treatment(Code::MotionNotRigid).severity().min(Severity::Warning);
    let not_rigid = worst.into_iter().enumerate().filter(|(_, left)| *left > RIGIDITY_LIMIT);
    not_rigid
        .map(|(sensor, left)| {
            Diagnostic::about(Code::MotionNotRigid, severity, Subject::sensor(sensor), left as f32)
        })
        .collect()
}
