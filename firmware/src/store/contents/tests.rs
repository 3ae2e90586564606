use super::*;

fn object(serial: u32) -> Object {
    Object { serial, length: 9, found: 0 }
}

fn layout(hash: u32, serial: u32, evicted: Option<u32>) -> (u32, Change) {
    let object = object(serial);
    (serial, Change::Layout { hash, title: String::new(), object, evicted })
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
fn what_was_not_found_whole_is_not_kept() {
    let mut contents = Contents::default();
    for (serial, change) in [layout(7, 10, None), layout(9, 20, None)] {
        contents.apply(serial, change);
    }
    contents.apply(30, Change::Calibration { object: object(30) });
    contents.found(10, 5);
    contents.found(20, 4);
    contents.found(10, 4);
    assert_eq!(contents.drop_torn(), 2);
    assert_eq!(contents.layout_in_use().map(|object| object.serial), Some(10));
    assert_eq!(contents.calibration, None);
}

#[test]
fn the_longest_change_fits_its_room() {
    let title = core::iter::repeat_n('t', 48).collect();
    let all = Object { serial: u32::MAX, length: u16::MAX, found: 0 };
    let hash = u32::MAX;
    let mass = Some(EstimatedMass { value: 1.0, sigma: Some(1.0) });
    let number = u32::MAX;
    let longest = [
        Change::Layout { hash, title, object: all, evicted: Some(hash) },
        Change::Result { object: all, number, layout: hash, mass, crc: hash, campaign: hash },
    ];
    for change in longest {
        postcard::to_slice(&change, &mut [0; MAX_CHANGE]).expect("fits");
    }
}
