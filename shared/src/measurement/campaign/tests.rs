use super::*;
use Command as C;
use proptest::prelude::*;

fn hit(campaign: &mut Campaign, good: bool) {
    campaign.armed();
    campaign.triggered();
    campaign.graded(good);
    if matches!(campaign.step(), Step::Analyse { .. }) {
        campaign.analysed();
    }
}

/// Closes the DOF; the target is not reached.
fn close(campaign: &mut Campaign) {
    campaign.dof_closed();
    campaign.estimated(false);
}

fn started(dofs: usize, wanted: u8) -> Campaign {
    Campaign::new(dofs, wanted, Start::DEFAULT).unwrap()
}

#[test]
fn a_campaign_without_trouble_goes_through_every_dof() {
    let mut campaign = started(3, 2);
    for dof in 0..3 {
        for _ in 0..2 {
            assert_eq!(campaign.step(), Step::AwaitHit { dof });
            hit(&mut campaign, true);
        }
        assert_eq!(campaign.step(), Step::CloseDof { dof });
        campaign.dof_closed();
        // The last DOF goes straight to the result.
        assert_eq!(campaign.step() == Step::Estimate, dof < 2);
        campaign.estimated(false);
    }
    assert_eq!(campaign.step(), Step::Identify);
    campaign.identified(7);
    assert_eq!((campaign.phase(), campaign.result()), (Phase::Done, 7));
}

#[test]
fn a_rejected_hit_is_asked_for_again_under_a_new_arming() {
    let mut campaign = started(1, 1);
    hit(&mut campaign, false);
    assert_eq!((campaign.accepted(), campaign.rejected()), (0, 1));
    assert_eq!(campaign.phase(), Phase::Busy);
    campaign.armed();
    assert_eq!(campaign.phase(), Phase::Armed);
}

/// Restores a campaign as after a power failure.
fn cut(campaign: &Campaign) -> Campaign {
    Campaign::resume(campaign.progress().unwrap()).unwrap()
}

#[test]
fn after_a_cut_the_campaign_is_paused_with_its_finished_dofs() {
    let object = Object::Block { mass: 2.0 };
    let start = Start { object, confirm: true, ..Start::DEFAULT };
    let mut campaign = Campaign::new(4, 2, start).unwrap();
    campaign.command(C::Skip).unwrap();
    for accepted in 1..=2 {
        hit(&mut campaign, accepted == 1);
        let _ = campaign.command(C::Accept);
        campaign.analysed();
    }
    assert_eq!((campaign.dof(), campaign.accepted(), campaign.rejected()), (1, 1, 1));
    campaign.command(C::Finish).unwrap();
    campaign.dof_closed();
    // One hit of the next DOF, which is lost.
    hit(&mut campaign, true);
    campaign.command(C::Accept).unwrap();
    campaign.analysed();
    assert_eq!((campaign.dof(), campaign.accepted()), (2, 1));
    let mut restored = cut(&campaign);
    assert_eq!((restored.phase(), restored.step()), (Phase::Paused, Step::Rest));
    let (skipped, early) = (Outcome::Skipped, Outcome::Early);
    let finished = [
        DofProgress { accepted: 0, outcome: skipped },
        DofProgress { accepted: 1, outcome: early },
        DofProgress::OPEN,
        DofProgress::OPEN,
    ];
    assert_eq!(restored.dofs(), finished);
    assert_eq!((restored.hits_per_dof(), restored.rejected()), (2, 1));
    assert_eq!(restored.started(), start, "the block and its mass as well");
    restored.command(C::Resume).unwrap();
    assert_eq!(restored.step(), Step::AwaitHit { dof: 2 });
    hit(&mut restored, true);
    assert_eq!(restored.phase(), Phase::Confirming, "hits wait for a confirmation as before");
}

#[test]
fn a_dof_is_finished_when_its_mass_lines_are_there() {
    let mut campaign = started(2, 1);
    hit(&mut campaign, true);
    assert_eq!(campaign.step(), Step::CloseDof { dof: 0 });
    assert_eq!(campaign.progress().unwrap().dofs, [DofProgress::OPEN; 2]);
    campaign.dof_closed();
    assert_eq!(campaign.progress().unwrap().dofs[0].outcome, Outcome::Complete);
}

#[test]
fn a_campaign_that_was_cut_while_solving_solves_again_when_it_goes_on() {
    let mut campaign = started(1, 1);
    hit(&mut campaign, true);
    campaign.dof_closed();
    assert_eq!(campaign.step(), Step::Identify);
    let mut restored = cut(&campaign);
    assert_eq!((restored.phase(), restored.step()), (Phase::Paused, Step::Rest));
    restored.command(C::Resume).unwrap();
    assert_eq!(restored.step(), Step::Identify);
}

#[test]
fn what_has_ended_or_is_no_campaign_is_not_restored() {
    let mut campaign = started(1, 1);
    let kept = campaign.progress().unwrap();
    campaign.command(C::Abort).unwrap();
    assert_eq!(campaign.progress(), None);
    let nothing = CampaignProgress { dofs: Vec::new(), ..kept };
    assert_eq!(Campaign::resume(nothing).unwrap_err(), CommandError::NoDofs);
}

/// Runs a good hit up to its analysis.
fn hit_to_analyse(campaign: &mut Campaign) {
    campaign.armed();
    campaign.triggered();
    campaign.graded(true);
    assert!(matches!(campaign.step(), Step::Analyse { .. }));
}

#[test]
fn a_hit_that_is_withdrawn_is_asked_for_again() {
    let mut campaign = started(2, 3);
    hit(&mut campaign, true);
    hit(&mut campaign, true);
    hit_to_analyse(&mut campaign);
    campaign.withdrawn();
    assert_eq!((campaign.accepted(), campaign.rejected()), (2, 1));
    assert_eq!(campaign.step(), Step::AwaitHit { dof: 0 });
}

#[test]
fn of_two_hits_that_contradict_each_other_none_stays() {
    let mut campaign = started(2, 3);
    hit(&mut campaign, true);
    hit_to_analyse(&mut campaign);
    campaign.drop_inconsistent_pair();
    assert_eq!((campaign.accepted(), campaign.rejected()), (0, 2));
    assert_eq!(campaign.step(), Step::AwaitHit { dof: 0 });
}

#[test]
fn with_confirmation_the_operator_decides() {
    let mut campaign = Campaign::new(1, 2, Start { confirm: true, ..Start::DEFAULT }).unwrap();
    hit(&mut campaign, true);
    assert_eq!((campaign.phase(), campaign.step()), (Phase::Confirming, Step::Rest));
    campaign.command(C::Reject).unwrap();
    assert_eq!((campaign.accepted(), campaign.rejected()), (0, 1));
    hit(&mut campaign, true);
    campaign.command(C::Accept).unwrap();
    assert_eq!(campaign.step(), Step::Analyse { dof: 0 });
}

#[test]
fn redo_forgets_the_hits_of_this_dof_only() {
    let mut campaign = started(2, 2);
    hit(&mut campaign, true);
    hit(&mut campaign, true);
    close(&mut campaign);
    hit(&mut campaign, true);
    campaign.command(C::Redo).unwrap();
    assert_eq!(campaign.dofs()[0].accepted, 2);
    assert_eq!((campaign.dof(), campaign.accepted()), (1, 0));
}

#[test]
fn a_skipped_dof_is_left_out_and_one_with_hits_can_be_finished_early() {
    let mut campaign = started(2, 3);
    assert_eq!(campaign.command(C::Finish), Err(CommandError::WrongPhase));
    campaign.command(C::Skip).unwrap();
    hit(&mut campaign, true);
    campaign.command(C::Finish).unwrap();
    assert_eq!(campaign.step(), Step::CloseDof { dof: 1 });
    campaign.dof_closed();
    assert_eq!(campaign.step(), Step::Identify);
    assert_eq!(campaign.dofs()[0].outcome, Outcome::Skipped);
    assert_eq!(campaign.dofs()[1].outcome, Outcome::Early);
}

#[test]
fn a_pause_in_a_record_drops_that_record_and_nothing_else() {
    let mut campaign = started(1, 3);
    hit(&mut campaign, true);
    campaign.armed();
    campaign.triggered();
    campaign.command(C::Pause).unwrap();
    assert_eq!((campaign.phase(), campaign.step()), (Phase::Paused, Step::Rest));
    campaign.graded(true);
    campaign.command(C::Resume).unwrap();
    assert_eq!((campaign.accepted(), campaign.step()), (1, Step::AwaitHit { dof: 0 }));
}

#[test]
fn a_pause_while_a_hit_is_analysed_keeps_that_hit() {
    let mut campaign = started(1, 2);
    campaign.armed();
    campaign.triggered();
    campaign.graded(true);
    campaign.command(C::Pause).unwrap();
    assert_eq!(campaign.step(), Step::Analyse { dof: 0 });
    campaign.analysed();
    assert_eq!((campaign.accepted(), campaign.step()), (1, Step::Rest));
}

#[test]
fn a_start_does_not_run_over_a_campaign_that_is_measuring() {
    let mut campaign = started(1, 2);
    assert!(!campaign.can_be_replaced());
    campaign.command(C::Pause).unwrap();
    assert!(campaign.can_be_replaced());
}

#[test]
fn an_abort_while_analysing_is_not_undone_by_the_analysis() {
    let mut campaign = started(1, 1);
    campaign.armed();
    campaign.triggered();
    campaign.graded(true);
    campaign.command(C::Abort).unwrap();
    campaign.analysed();
    assert_eq!((campaign.phase(), campaign.step()), (Phase::Idle, Step::Rest));
}

#[test]
fn a_result_that_could_not_be_kept_is_tried_again_on_resume() {
    let mut campaign = started(1, 1);
    hit(&mut campaign, true);
    campaign.dof_closed();
    campaign.not_stored();
    assert_eq!((campaign.phase(), campaign.step()), (Phase::Paused, Step::Rest));
    campaign.command(C::Resume).unwrap();
    assert_eq!(campaign.step(), Step::Identify);
}

proptest! {
    /// For any sequence of commands and hits, the counts stay within the requested number, and a campaign at
    /// `Identify` has no open DOF.
    #[test]
    fn counts_stay_valid_for_any_order_of_commands_and_hits(words in proptest::collection::vec(0_u8..22, 0..200)) {
        let mut campaign = started(3, 2);
        for word in words {
            match word {
                0 => if campaign.can_be_replaced() { campaign = started(3, 2) },
                1..=11 => { let _ = campaign.command(C::ALL[usize::from(word) - 1]); }
                12 => campaign.armed(),
                13 => campaign.triggered(),
                14 => campaign.graded(true),
                15 => campaign.graded(false),
                16 => campaign.analysed(),
                17 => campaign.estimated(true),
                18 => campaign.estimated(false),
                19 => campaign.undone(campaign.dof(), campaign.accepted().saturating_sub(1)),
                _ => campaign.dof_closed(),
            }
            prop_assert!(campaign.dofs().iter().all(|dof| dof.accepted <= campaign.hits_per_dof()));
            if campaign.step() == Step::Identify {
                prop_assert!(campaign.dofs().iter().all(|dof| dof.outcome != Outcome::Open));
            }
        }
    }
}

#[test]
fn a_computation_is_paused_and_begins_anew() {
    let mut campaign = started(1, 1);
    hit(&mut campaign, true);
    campaign.dof_closed();
    assert_eq!((campaign.phase(), campaign.step()), (Phase::Solving, Step::Identify));
    campaign.command(C::Pause).unwrap();
    assert_eq!((campaign.phase(), campaign.step()), (Phase::Paused, Step::Rest));
    // Its DOFs stay finished, also after a power cut.
    assert_eq!(campaign.progress().unwrap().dofs[0].outcome, Outcome::Complete);
    assert_eq!(cut(&campaign).dofs(), campaign.dofs());
    for command in [C::Redo, C::Skip, C::Finish, C::Undo] {
        assert_eq!(campaign.command(command), Err(CommandError::WrongPhase), "{command:?}");
    }
    campaign.command(C::Resume).unwrap();
    assert_eq!(campaign.step(), Step::Identify);
}

#[test]
fn a_result_that_could_not_be_stored_is_discarded_by_an_abort() {
    let mut campaign = started(1, 1);
    hit(&mut campaign, true);
    campaign.dof_closed();
    campaign.not_stored();
    assert_eq!(campaign.command(C::Abort), Ok(()));
    // Reports on the storing of its result do not restart it.
    assert_eq!(campaign.phase(), Phase::Idle);
    campaign.not_stored();
    assert_eq!(campaign.phase(), Phase::Idle);
}

/// A campaign of four DOFs of one hit that has reached its target after the second.
fn at_target() -> Campaign {
    let mut campaign = started(4, 1);
    hit(&mut campaign, true);
    close(&mut campaign);
    hit(&mut campaign, true);
    campaign.dof_closed();
    campaign.estimated(true);
    assert_eq!((campaign.phase(), campaign.step()), (Phase::TargetReached, Step::Rest));
    campaign
}

#[test]
fn at_the_target_the_operator_may_leave_out_the_other_dofs() {
    let mut campaign = at_target();
    campaign.command(C::Conclude).unwrap();
    assert_eq!(campaign.step(), Step::Identify);
    let outcomes = campaign.dofs().iter().map(|dof| dof.outcome);
    let (complete, left_out) = (Outcome::Complete, Outcome::NotNeeded);
    assert!(outcomes.eq([complete, complete, left_out, left_out]));
    // It stays so after a power cut.
    assert_eq!(cut(&campaign).dofs(), campaign.dofs());
}

#[test]
fn an_operator_who_continues_is_not_asked_again() {
    let mut campaign = at_target();
    campaign.command(C::Continue).unwrap();
    assert_eq!(campaign.step(), Step::AwaitHit { dof: 2 });
    hit(&mut campaign, true);
    campaign.dof_closed();
    campaign.estimated(true);
    assert_eq!(campaign.step(), Step::AwaitHit { dof: 3 });
}

#[test]
fn a_pause_at_the_target_asks_again_on_resume() {
    let mut campaign = at_target();
    campaign.command(C::Pause).unwrap();
    assert_eq!(campaign.phase(), Phase::Paused);
    for command in [C::Conclude, C::Continue, C::Skip, C::Redo, C::Finish] {
        assert_eq!(campaign.command(command), Err(CommandError::WrongPhase), "{command:?}");
    }
    campaign.command(C::Resume).unwrap();
    assert_eq!(campaign.phase(), Phase::TargetReached);
}

#[test]
fn an_undo_at_the_target_opens_the_last_dof_again_and_asks_again() {
    for paused in [false, true] {
        let mut campaign = at_target();
        if paused {
            campaign.command(C::Pause).unwrap();
        }
        campaign.command(C::Undo).unwrap();
        assert_eq!(campaign.step(), Step::Undo);
        campaign.undone(1, 0);
        assert_eq!(campaign.phase(), if paused { Phase::Paused } else { Phase::Busy });
        let _ = campaign.command(C::Resume);
        assert_eq!(campaign.step(), Step::AwaitHit { dof: 1 });
        assert_eq!(cut(&campaign).dofs()[1], DofProgress::OPEN);
        hit(&mut campaign, true);
        campaign.dof_closed();
        campaign.estimated(true);
        assert_eq!(campaign.phase(), Phase::TargetReached);
    }
}

#[test]
fn an_undo_is_not_possible_while_a_hit_is_taken_or_the_result_is_computed() {
    let mut campaign = started(1, 1);
    campaign.armed();
    campaign.triggered();
    assert_eq!(campaign.command(C::Undo), Err(CommandError::WrongPhase));
    campaign.graded(true);
    assert_eq!(campaign.command(C::Undo), Err(CommandError::WrongPhase));
    campaign.analysed();
    assert_eq!(campaign.command(C::Undo), Err(CommandError::WrongPhase));
    campaign.dof_closed();
    assert_eq!(
        (campaign.step(), campaign.command(C::Undo)),
        (Step::Identify, Err(CommandError::WrongPhase))
    );
}

#[test]
fn a_block_of_known_mass_has_no_target() {
    let start = Start { object: Object::Block { mass: 2.0 }, ..Start::DEFAULT };
    let mut campaign = Campaign::new(2, 1, start).unwrap();
    hit(&mut campaign, true);
    campaign.dof_closed();
    assert_eq!(campaign.step(), Step::AwaitHit { dof: 1 });
}

#[test]
fn only_the_target_can_be_concluded() {
    let mut campaign = started(2, 1);
    assert_eq!(campaign.command(C::Conclude), Err(CommandError::WrongPhase));
    assert_eq!(campaign.command(C::Continue), Err(CommandError::WrongPhase));
}
