use super::*;

fn object(serial: u32) -> Object {
    Object { serial, length: 9, found: 0 }
}

/// As long as a DOF with lines.
fn long_object(serial: u32) -> Object {
    Object { length: 4617, ..object(serial) }
}

fn dof(serial: u32, campaign: u32, index: u8) -> (u32, Change) {
    (serial, Change::Dof { object: long_object(serial), campaign, index })
}

fn result(serial: u32, campaign: u32, number: u32) -> (u32, Change) {
    let object = object(serial);
    (serial, Change::Result { object, number, layout: 0, mass: None, crc: 0, campaign })
}

/// The contents after these changes of a store in use.
fn after(changes: impl IntoIterator<Item = (u32, Change)>) -> Contents {
    let mut contents = Contents::default();
    changes.into_iter().for_each(|(serial, change)| contents.apply(serial, change));
    contents
}

/// The contents after a restart that finds these changes in the log.
fn restarted(changes: &[(u32, Change)]) -> Contents {
    let of_dofs =
        |wanted: bool| changes.iter().filter(move |(_, change)| change.is_dof() == wanted).cloned();
    after(of_dofs(false).chain(of_dofs(true)))
}

fn serials_of_dofs(contents: &Contents) -> Vec<u32, DOFS> {
    contents.dofs.iter().map(|stored| stored.object.serial).collect()
}

fn layout(hash: u32, serial: u32, evicted: Option<u32>) -> (u32, Change) {
    let object = object(serial);
    (
        serial,
        Change::Layout {
            hash,
            title: String::new(),
            profile: TestProfile::MassLine,
            object,
            evicted,
        },
    )
}

#[test]
fn of_two_changes_the_later_one_holds_wherever_they_lie() {
    let older = (3, Change::Calibration { object: object(3) });
    let later = (8, Change::Calibration { object: object(8) });
    let progress = |serial| (serial, Change::Progress { object: object(serial), campaign: 2 });
    for order in [[&older, &later], [&later, &older]] {
        let mut contents = Contents::default();
        order.iter().for_each(|(serial, change)| contents.apply(*serial, change.clone()));
        assert_eq!(contents.calibration, Some(object(8)));
        assert!(contents.is_live(8) && !contents.is_live(3));
    }
    for order in [[4, 6], [6, 4]] {
        let mut contents = Contents::default();
        order.map(progress).into_iter().for_each(|(serial, change)| {
            contents.apply(serial, change);
        });
        assert_eq!(contents.campaign.progress, Some(object(6)));
    }
}

#[test]
fn a_layout_that_was_evicted_and_stored_again_stays_when_the_other_change_was_moved_behind_it() {
    // As written: 7 is removed for 9 at serial 20, and stored again at 30. Then the record of 20 was moved.
    let mut contents = Contents::default();
    for (serial, change) in
        [layout(7, 10, None), layout(7, 30, None), layout(9, 20, Some(7)), layout(5, 15, None)]
    {
        contents.apply(serial, change);
    }
    let mut stored: Vec<_, LAYOUTS> = contents.layouts.iter().map(|stored| stored.hash).collect();
    stored.sort_unstable();
    assert_eq!(stored, [5, 7, 9]);
    assert_eq!(contents.layout_in_use(), Some(object(30)));
    assert!(!contents.is_live(10));
}

#[test]
fn a_layout_gives_way_before_an_older_one_whose_result_is_solved_with_it() {
    let result = Change::Result {
        object: object(25),
        number: 1,
        layout: 7,
        mass: None,
        crc: 0,
        campaign: 0,
    };
    let mut contents =
        after([layout(7, 10, None), layout(9, 20, None), (25, result), layout(5, 30, None)]);
    assert_eq!((contents.unused_layout(), contents.layout_to_evict()), (Some(9), None));
    let (serial, newest) = layout(4, 40, None);
    contents.apply(serial, newest);
    assert_eq!(contents.layout_to_evict(), Some(9));
    contents.apply(50, Change::Deleted { number: 1, campaign: 0 });
    assert_eq!(contents.layout_to_evict(), Some(7));
}

#[test]
fn the_layout_that_gives_way_is_the_one_used_longest_ago_and_never_the_one_in_use() {
    let mut contents = after([layout(7, 10, None), layout(9, 20, None), layout(5, 30, None)]);
    for (serial, hash) in [(40, 7), (41, 9)] {
        assert_eq!(contents.unused_layout(), Some(hash));
        assert!(contents.is_of_unused_layout(10 * (serial - 39)));
        contents.apply(serial, Change::Evicted { hash });
    }
    assert_eq!((contents.unused_layout(), contents.layout_in_use()), (None, Some(object(30))));
    // Stored again, and then found before the change that had removed it.
    let moved = [layout(7, 50, None), (40, Change::Evicted { hash: 7 })];
    assert_eq!(restarted(&moved).layout_in_use(), Some(object(50)));
}

#[test]
fn what_lies_about_of_a_campaign_that_has_ended_begins_none() {
    let mut contents = Contents::default();
    contents.apply(5, Change::Dof { object: object(5), campaign: 4, index: 0 });
    contents.apply(9, Change::Ended { campaign: 4 });
    contents.apply(6, Change::Progress { object: object(6), campaign: 4 });
    contents.apply(3, Change::Dof { object: object(3), campaign: 2, index: 1 });
    assert_eq!(contents.campaign.serial, 0);
    assert!(!contents.is_live(5) && !contents.is_live(6));
}

#[test]
fn a_dof_with_lines_stays_with_its_result_and_one_without_ends_with_its_campaign() {
    let short = (6, Change::Dof { object: object(6), campaign: 4, index: 1 });
    let measured = [dof(5, 4, 0), short, dof(7, 4, 2), result(9, 4, 1)];
    for contents in [after(measured.clone()), restarted(&measured)] {
        assert_eq!(serials_of_dofs(&contents), [5, 7]);
        assert!(contents.is_live(5) && !contents.is_live(6));
        assert_eq!(contents.dofs_of_result(1).count(), 2);
        assert_eq!((contents.dofs_of_result(2).count(), contents.campaign.serial), (0, 0));
    }
    let next = [dof(12, 11, 0), (13, Change::Deleted { number: 1, campaign: 4 })];
    let changes: std::vec::Vec<_> = measured.into_iter().chain(next).collect();
    for contents in [after(changes.clone()), restarted(&changes)] {
        assert_eq!(
            (serials_of_dofs(&contents).as_slice(), contents.campaign.serial),
            (&[12][..], 11)
        );
    }
}

#[test]
fn after_a_restart_the_dofs_belong_to_their_results_in_any_order_of_the_log() {
    let log = [dof(5, 4, 0), result(9, 4, 1), dof(12, 11, 0), result(14, 11, 2), dof(17, 16, 3)];
    for moved in 0..log.len() {
        // The log moves its oldest records behind the others.
        let mut log = log.clone();
        log.rotate_left(moved);
        let contents = restarted(&log);
        let mut serials = serials_of_dofs(&contents);
        serials.sort_unstable();
        assert_eq!(
            (serials.as_slice(), contents.campaign.serial),
            (&[5, 12, 17][..], 16),
            "{moved}"
        );
        assert_eq!(contents.dofs_of_result(2).map(|dof| dof.object.serial).sum::<u32>(), 12);
    }
}

#[test]
fn what_lies_about_of_a_deleted_result_begins_no_campaign() {
    // The record of the result was behind that of the DOF; the page with it is in use for something else.
    let contents = restarted(&[dof(5, 4, 0), (13, Change::Deleted { number: 1, campaign: 4 })]);
    assert_eq!((contents.dofs.len(), contents.campaign.serial, contents.last_number), (0, 0, 1));
}

#[test]
fn a_dof_that_is_measured_again_replaces_the_older_one_and_an_open_one_is_removed() {
    let reopened = (8, Change::Reopened { campaign: 4, index: 0 });
    let measured = [dof(5, 4, 0), dof(6, 4, 1), dof(7, 4, 0), reopened];
    for contents in [after(measured.clone()), restarted(&measured)] {
        assert_eq!(serials_of_dofs(&contents), [6]);
    }
    let again: std::vec::Vec<_> = measured.into_iter().chain([dof(9, 4, 0)]).collect();
    for contents in [after(again.clone()), restarted(&again)] {
        assert_eq!(serials_of_dofs(&contents), [6, 9]);
    }
    let replaced = [dof(7, 4, 0), dof(5, 4, 0)];
    assert_eq!(serials_of_dofs(&restarted(&replaced)), [7], "an older one that was moved");
}

#[test]
fn without_the_campaign_and_the_oldest_results_their_objects_are_not_live() {
    let progress = (18, Change::Progress { object: object(18), campaign: 16 });
    let contents = after([
        dof(5, 4, 0),
        result(9, 4, 1),
        dof(12, 11, 0),
        result(14, 11, 2),
        dof(17, 16, 3),
        progress,
    ]);
    for (deleted, live, dofs) in [(0, &[5, 9, 12, 14][..], 2), (1, &[12, 14], 1), (2, &[], 0)] {
        let serials: Vec<u32, 20> =
            (0..20).filter(|&serial| contents.is_live_without(deleted, serial)).collect();
        assert_eq!((serials.as_slice(), contents.dofs_without(deleted)), (live, dofs));
    }
}

#[test]
fn a_list_full_of_dofs_has_a_place_only_for_one_that_is_measured_again() {
    let mut contents = Contents::default();
    for (serial, index) in (10..).zip(0..DOFS as u8) {
        assert!(contents.has_place_for_dof(4, index));
        let (serial, change) = dof(serial, 4, index);
        contents.apply(serial, change);
    }
    assert!(!contents.has_place_for_dof(4, DOFS as u8) && contents.has_place_for_dof(4, 0));
}

#[test]
fn a_dof_with_lines_that_is_torn_and_those_of_a_torn_result_are_not_kept() {
    let mut contents =
        after([dof(5, 4, 0), dof(6, 4, 1), result(9, 4, 1), dof(12, 11, 0), result(14, 11, 2)]);
    for (serial, intact) in [(5, 4617), (6, 4616), (9, 9), (12, 4617), (14, 8)] {
        contents.count_intact(serial, intact);
    }
    assert_eq!(contents.drop_torn(), 2);
    assert_eq!(serials_of_dofs(&contents), [5]);
    assert_eq!(contents.results.len(), 1);
}

#[test]
fn what_was_not_found_whole_is_not_kept() {
    let mut contents = Contents::default();
    for (serial, change) in [layout(7, 10, None), layout(9, 20, None)] {
        contents.apply(serial, change);
    }
    contents.apply(30, Change::Calibration { object: object(30) });
    contents.count_intact(10, 5);
    contents.count_intact(20, 4);
    contents.count_intact(10, 4);
    assert_eq!(contents.drop_torn(), 2);
    assert_eq!(contents.layout_in_use().map(|object| object.serial), Some(10));
    assert_eq!(contents.calibration, None);
}

#[test]
fn the_longest_change_fits_its_room() {
    let title = core::iter::repeat_n('t', 48).collect();
    let object = Object { serial: u32::MAX, length: u16::MAX, found: 0 };
    let hash = u32::MAX;
    let mass = Some(EstimatedMass { value: 1.0, sigma: Some(1.0) });
    let number = u32::MAX;
    let profile = TestProfile::Suspension;
    let layout = Change::Layout { hash, title, profile, object, evicted: Some(hash) };
    postcard::to_slice(&layout, &mut [0; MAX_CHANGE]).expect("fits");
    let (campaign, index) = (u32::MAX, u8::MAX);
    let others = [
        Change::Result { object, number, layout: hash, mass, crc: hash, campaign },
        Change::Calibration { object },
        Change::Deleted { number, campaign },
        Change::Progress { object, campaign },
        Change::Dof { object, campaign, index },
        Change::Ended { campaign },
        Change::Reopened { campaign, index },
        Change::Evicted { hash },
    ];
    for change in others {
        postcard::to_slice(&change, &mut [0; MAX_SHORT_CHANGE]).expect("fits");
    }
}

#[test]
fn the_last_statement_about_the_screen_holds_whatever_the_order_in_the_log() {
    let says = |serial, setting| (serial, Change::Screen { setting });
    let changes = [says(7, ScreenSetting::Sh1106), says(3, ScreenSetting::Ssd1306)];
    let contents = restarted(&changes);
    assert_eq!(contents.screen, Some((7, ScreenSetting::Sh1106)));
    assert!(contents.is_live(7) && !contents.is_live(3));
}
