use massline_shared::diagnosis::Diagnostics;
use massline_shared::layout::HostLayout;

use super::*;
use massline_files::layout_file::LayoutFile;

pub(in crate::screen) const ALL: GuideOptions =
    GuideOptions { answer: Some(AnswerSoFar::Intervals), verdicts: true };

pub(in crate::screen) fn layout() -> HostLayout {
    let text = include_str!("../../../examples/three-bar-test-1.toml");
    LayoutFile::parse(text, "test").unwrap().layout
}

/// A status with these accepted hits at DOF `dof`.
pub(in crate::screen) fn status(dof: u8, accepted: &[u8]) -> Status {
    Status {
        phase: Phase::Armed.into(),
        dof,
        armings: 1,
        accepted: accepted.iter().copied().collect(),
        hits_per_dof: 5,
        rejected: 0,
        last_hit: 3,
        layout_hash: 1,
        result: 0,
        started_unix_s: 1,
        diagnostics: Diagnostics::new(),
    }
}

/// A guide of the example.
pub(in crate::screen) fn guide() -> Guide {
    Guide::new("frame", "measurement", &layout().cast().unwrap(), 12, ALL)
}

#[test]
fn hits_of_a_dof_that_is_redone_or_skipped_are_said_to_be_discarded_and_not_counted_on() {
    for (dof, action, hits) in [(0, "measured again", [0, 15]), (1, "skipped", [0, 10])] {
        let mut guide = guide();
        guide.status(&status(0, &[3, 0, 0]), Duration::ZERO);
        assert_eq!(guide.hits(), [3, 15]);
        guide.status(&status(dof, &[0, 0, 0]), Duration::ZERO);
        let note = guide.note.clone().unwrap();
        assert!(note.contains(action) && note.contains("1:+Y"), "{note}");
        assert_eq!(guide.hits(), hits);
        guide.acted();
        assert_eq!(guide.note, None);
    }
}

#[test]
fn a_campaign_that_is_finished_early_has_all_its_hits() {
    let mut guide = guide();
    let mut now = status(2, &[5, 5, 3]);
    guide.status(&now, Duration::ZERO);
    assert_eq!(guide.hits(), [13, 15]);
    for phase in [Phase::TargetReached, Phase::Solving, Phase::Done] {
        now.phase = phase.into();
        guide.status(&now, Duration::ZERO);
        assert_eq!(guide.hits(), [13, 13]);
    }
}
