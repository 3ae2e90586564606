//! What a status says about the DOFs of a campaign.

use massline_shared::diagnosis::Severity;

use super::*;

#[test]
fn what_was_skipped_is_not_left_and_what_is_being_stored_is() {
    let mut status = Status {
        phase: Phase::Armed as u8,
        dof: 3,
        // The last hits of the second DOF are being stored, and the third was skipped.
        accepted: [2, 2, 0, 1, 0].into_iter().collect(),
        rejected: 0,
        armings: 0,
        last_hit: 0,
        hits_per_dof: 2,
        layout_hash: 1,
        started_unix_s: 0,
        result: 0,
        diagnostics: Default::default(),
    };
    assert_eq!(dofs_left(&status), [0, 1, 3, 4]);
    // The first is measured again after a fault, before one that was skipped.
    status.dof = 0;
    let skipped = Subject::Hit(2);
    let skipped = Diagnostic::about(Code::DofSkipped, Severity::Note, skipped, 0.0);
    status.diagnostics.push(skipped).unwrap();
    assert_eq!(dofs_left(&status), [0, 1, 3, 4]);
}
