use massline_shared::diagnosis::{Diagnostics, Severity, Subject};
use massline_shared::layout::Dof;

use super::*;

const LAYOUT: &str = include_str!("../../../../examples/three-bar-test-1.toml");

/// A campaign as the host sees it.
struct ObservedCampaign {
    log: HitLog,
    status: Status,
}

impl ObservedCampaign {
    fn new() -> Self {
        let status = Status {
            phase: Phase::Armed.into(),
            dof: 0,
            armings: 1,
            accepted: [0; 3].into_iter().collect(),
            hits_per_dof: 5,
            rejected: 0,
            last_hit: 0,
            layout_hash: 1,
            result: 0,
            started_unix_s: 1,
            diagnostics: Diagnostics::new(),
        };
        let mut seen = Self { log: HitLog::simulated(), status };
        seen.look(Phase::Armed);
        seen
    }

    fn event(&self, code: Option<Code>) -> HitEvent {
        let about = |code| match code {
            Code::DoubleHit => Diagnostic::whole(code, Severity::Error, 0.5),
            _ => Diagnostic::about(code, Severity::Error, Subject::hit(0), 0.5),
        };
        HitEvent {
            number: self.status.last_hit,
            dof: self.status.dof,
            good: code.is_none(),
            scan: 1000 * u64::from(self.status.last_hit),
            peak_force: 20.0,
            peak_acceleration: 50.0,
            swing: None,
            findings: code.map(about).into_iter().collect(),
        }
    }

    fn look(&mut self, phase: Phase) {
        self.status.phase = phase.into();
        self.log.status(&self.status);
    }

    /// A hit that the grading has found to be like this; it is not averaged yet.
    fn hit(&mut self, code: Option<Code>) {
        self.status.last_hit += 1;
        let event = self.event(code);
        self.log.hit(&event);
        self.status.rejected += u16::from(code.is_some());
        self.look(if code.is_some() { Phase::Armed } else { Phase::Confirming });
    }

    fn accept(&mut self) {
        self.look(Phase::Busy);
        self.status.accepted[usize::from(self.status.dof)] += 1;
        self.look(Phase::Armed);
    }

    fn good(&mut self) {
        self.hit(None);
        self.accept();
    }

    fn verdicts(&self) -> Vec<HitVerdict> {
        self.log.entries.iter().map(|entry| entry.verdict).collect()
    }
}

use HitVerdict::{Accepted, Dropped, OutlierRemoved, Redone, Rejected, Skipped, Undone};

#[test]
fn a_bad_hit_and_one_that_the_operator_rejects_are_rejected() {
    let mut seen = ObservedCampaign::new();
    seen.good();
    seen.hit(Some(Code::DoubleHit));
    seen.hit(None);
    seen.status.rejected += 1;
    seen.look(Phase::Busy);
    seen.look(Phase::Armed);
    seen.good();
    assert_eq!(seen.verdicts(), [Accepted, Rejected, Rejected, Accepted]);
    let hits = seen.log.logged(&layout());
    assert_eq!(hits[1].findings[0].code, Code::DoubleHit);
    assert!(hits[1].findings[0].message.contains("touched twice"), "{:?}", hits[1]);
    assert!(hits[2].findings.is_empty());
    assert_eq!((hits[0].dof.as_str(), hits[0].peak_force_n), ("1:+Y", Some(20.0)));
}

#[test]
fn an_outlier_is_removed_whether_its_event_or_the_status_comes_first() {
    for event_first in [true, false] {
        let mut seen = ObservedCampaign::new();
        seen.good();
        seen.hit(None);
        seen.status.rejected += 1;
        let withdrawn = seen.event(Some(Code::HitInconsistent));
        if event_first {
            seen.log.hit(&withdrawn);
        }
        seen.look(Phase::Armed);
        if !event_first {
            seen.log.hit(&withdrawn);
        }
        assert_eq!(seen.verdicts(), [Accepted, OutlierRemoved], "{event_first}");
    }
}

#[test]
fn the_first_two_hits_that_disagree_are_both_removed() {
    for event_first in [true, false] {
        let mut seen = ObservedCampaign::new();
        seen.good();
        seen.hit(None);
        (seen.status.rejected, seen.status.accepted[0]) = (2, 0);
        let withdrawn = seen.event(Some(Code::HitsDisagree));
        if event_first {
            seen.log.hit(&withdrawn);
        }
        seen.look(Phase::Armed);
        if !event_first {
            seen.log.hit(&withdrawn);
        }
        assert_eq!(seen.verdicts(), [OutlierRemoved; 2], "{event_first}");
        assert!(seen.log.logged(&layout()).iter().all(|hit| hit.findings.len() == 1));
    }
}

/// The third hit shows that one of the first two landed elsewhere: it stays as the first.
#[test]
fn two_hits_that_a_third_replaces_are_removed() {
    let mut seen = ObservedCampaign::new();
    seen.good();
    seen.good();
    seen.hit(None);
    seen.look(Phase::Busy);
    let mut replaced = seen.event(Some(Code::HitsDisagree));
    replaced.good = true;
    seen.log.hit(&replaced);
    (seen.status.rejected, seen.status.accepted[0]) = (2, 1);
    seen.look(Phase::Armed);
    assert_eq!(seen.verdicts(), [OutlierRemoved, OutlierRemoved, Accepted]);
    seen.good();
    assert_eq!(seen.verdicts(), [OutlierRemoved, OutlierRemoved, Accepted, Accepted]);
}

#[test]
fn a_hit_can_be_taken_back_and_a_dof_begun_again() {
    let mut seen = ObservedCampaign::new();
    seen.good();
    seen.good();
    seen.status.accepted[0] = 1;
    seen.look(Phase::Armed);
    assert_eq!(seen.verdicts(), [Accepted, Undone]);
    seen.good();
    seen.status.accepted[0] = 0;
    seen.look(Phase::Armed);
    assert_eq!(seen.verdicts(), [Redone, Undone, Redone]);
}

/// Also the only hit of a DOF, whether its event or the status comes first.
#[test]
fn a_hit_whose_undo_is_reported_is_undone() {
    for status_first in [false, true] {
        let mut seen = ObservedCampaign::new();
        seen.hit(None);
        seen.status.accepted[0] = 1;
        seen.look(Phase::Armed);
        let event = seen.event(Some(Code::HitUndone));
        seen.status.accepted[0] = 0;
        if status_first {
            seen.look(Phase::Armed);
        }
        seen.log.hit(&event);
        seen.look(Phase::Armed);
        assert_eq!(seen.verdicts(), [Undone]);
    }
}

#[test]
fn the_hits_of_a_skipped_dof_and_one_without_a_verdict_are_not_in_the_answer() {
    let mut seen = ObservedCampaign::new();
    seen.good();
    (seen.status.accepted[0], seen.status.dof) = (0, 1);
    seen.look(Phase::Armed);
    seen.hit(None);
    seen.look(Phase::Paused);
    assert_eq!(seen.verdicts(), [Skipped, Dropped]);
}

#[test]
fn hits_before_the_log_began_are_not_taken_for_its_own() {
    let mut seen = ObservedCampaign::new();
    seen.log = HitLog::simulated();
    seen.status.accepted[0] = 3;
    seen.look(Phase::Armed);
    seen.hit(None);
    seen.status.rejected += 1;
    seen.look(Phase::Armed);
    seen.good();
    assert_eq!(seen.verdicts(), [Rejected, Accepted]);
}

fn layout() -> RigLayout {
    let file = massline_files::layout_file::LayoutFile::parse(LAYOUT, "frame.toml").unwrap();
    assert_eq!(file.layout.hits[0].dof, "1:+Y".parse::<Dof>().unwrap());
    file.layout.cast().unwrap()
}
