//! A person operates the rig with only its buttons, its screen and a hammer.

use crate::pictures;
use embassy_futures::block_on;
use massline::commands::calibrate::block::LAYOUT as BLOCK;
use massline::commands::calibrate::demo::sensitivity_errors;
use massline_files::layout_file::LayoutFile;
use massline_firmware::panel::calibration_wizard::{CalibrationWizard, WizardProblem};
use massline_firmware::panel::menu::DIGITS;
use massline_firmware::panel::self_test::SelfTestState;
use massline_firmware::panel::{Button, Cue, PanelModel};
use massline_firmware::store::Store;
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource, TumbleHandle, TumbleSource};
use massline_shared::calibration::tumble::Position;
use massline_shared::calibration::{CalibrationMethod, CalibrationRecord};
use massline_shared::layout::Target;
use massline_shared::measurement::campaign::Phase;
use massline_shared::signal::{AdcProperties, Scan};
use massline_tests::campaign::{layout_file, scans, steady_hand, three_bar, with_every_dof};
use massline_tests::held_scans::HeldScans;
use massline_tests::person::{Person, power_on, provisioned_with};
use massline_virtual::flash::{Flash, FlashBacking};
use massline_virtual::framebuffer::Framebuffer;

/// The clock in the title and the level bars, which depend on the speed of this machine.
const LIVE: [pictures::Mask; 2] = [(90..128, 0..11), (0..128, 52..64)];

/// Flash with the layout of the frame stored before a power cut.
fn provisioned() -> FlashBacking {
    provisioned_with(&[&three_bar().rig_layout().unwrap()])
}

use Button::{Back, Next, Ok as Yes};

#[test]
fn a_whole_measurement_by_buttons_alone() {
    let flash = provisioned();
    let bench = Bench::named("default").unwrap();
    let (hold, looked) = HeldScans::of(*scans(&bench, &three_bar(), 1));
    let (rig, person) = power_on(&flash, Box::new(hold));
    let (_, framebuffer) = person.sees(|model| model.layouts == 1);
    pictures::check("run-1-home", &framebuffer, &[]);
    pictures::check("run-2-ready", &person.press(Yes), &[]);
    person.press(Yes);
    let mut answered = 0;
    let (done, framebuffer) = loop {
        let (model, framebuffer) = person.sees(|model| {
            let moves = model.levels.iter().any(|&level| level > 0);
            let next = model.phase == Phase::Armed && model.armings > answered;
            model.phase == Phase::Done || next && moves
        });
        match model.hits_done {
            _ if model.phase == Phase::Done => break (model, framebuffer),
            0 => pictures::check("run-3-first-hit", &framebuffer, &LIVE),
            7 => pictures::check("run-3-later-hit", &framebuffer, &LIVE),
            _ => {}
        }
        answered = model.armings;
        looked.go_on(&rig);
    };
    pictures::check("run-4-done", &framebuffer, &[]);
    let cues = person.0.cues();
    // Three hit DOFs with five hits each, and the end.
    assert_eq!(cues.iter().filter(|&&cue| cue == Cue::Accepted).count(), 15, "{cues:?}");
    assert_eq!(
        cues.iter().filter(|&&cue| cue == Cue::Armed).count(),
        15 + usize::from(done.rejected)
    );
    assert_eq!(cues.last(), Some(&Cue::Done));
    let mass = done.mass.unwrap();
    // The frame's mass is 1.23 kg; for this seed the interval contains it, as the table in the README
    // shows.
    assert!((mass.value - 1.23).abs() < 2.0 * mass.sigma.unwrap(), "{mass:?}");
    pictures::check("run-5-mass", &person.press(Yes), &[]);
    pictures::check("run-6-inertia", &person.press(Next), &[]);
    pictures::check("run-7-principal", &person.presses(&[Next, Next]), &[]);
    pictures::check("run-8-limits", &person.press(Next), &[]);
    pictures::check("run-9-results", &person.press(Back), &[]);
    assert_eq!(person.press(Back), person.press(Back));
    rig.stop().unwrap();
}

#[test]
fn a_bad_hit_is_heard_and_explained_and_the_campaign_can_be_ended() {
    // Every hit is so hard that it overloads a sensor.
    let mut bench = Bench::named("ideal").unwrap();
    bench.operator.too_hard_rate = 1.0;
    let source = scans(&bench, &three_bar(), 1);
    let (rig, person) = power_on(&provisioned(), source);
    person.sees(|model| model.layouts == 1);
    person.presses(&[Yes, Yes]);
    let rejected = |model: &PanelModel| model.verdict.is_some_and(|v| v.reason.is_some());
    let (_, framebuffer) = person.sees(|model| rejected(model) && model.phase == Phase::Armed);
    pictures::check("run-rejected", &framebuffer, &LIVE);
    assert!(person.0.cues().contains(&Cue::Rejected));
    person.press(Next);
    let (model, _) = person.sees(|model| model.phase == Phase::Paused);
    // The menu: continue, repeat, skip, the findings when there are any, and last: end.
    assert_eq!(model.accepted, 0);
    (0..3 + usize::from(model.findings > 0)).for_each(|_| drop(person.press(Next)));
    pictures::check("run-end", &person.press(Yes), &[]);
    person.press(Yes);
    person.sees(|model| model.phase == Phase::Idle);
    rig.stop().unwrap();
}

#[test]
fn the_last_hit_is_undone_with_buttons_alone() {
    let bench = steady_hand("default");
    let (hold, looked) = HeldScans::of(*scans(&bench, &three_bar(), 1));
    let (rig, person) = power_on(&provisioned(), Box::new(hold));
    person.sees(|model| model.layouts == 1);
    person.presses(&[Yes, Yes]);
    let mut answered = 0;
    let mut next_hit = || {
        let (model, framebuffer) = person.sees(|model| {
            model.phase == Phase::Done || model.phase == Phase::Armed && model.armings > answered
        });
        answered = model.armings;
        (model, framebuffer)
    };
    // Five hits finish the first place.
    for hit in 0..5 {
        assert_eq!(next_hit().0.averaged, hit);
        looked.go_on(&rig);
    }
    let (model, _) = next_hit();
    assert_eq!((model.dof.unwrap().0, model.averaged), (1, 5));
    person.press(Next);
    person.sees(|model| model.phase == Phase::Paused);
    pictures::check("run-undo-menu", &person.press(Next), &[]);
    person.press(Yes);
    let (model, framebuffer) = person.sees(|model| model.averaged == 4);
    assert_eq!((model.phase, model.dof.unwrap().0, model.accepted), (Phase::Paused, 0, 4));
    pictures::check("run-undo-done", &framebuffer, &[]);
    pictures::check("run-undo-refused", &person.press(Yes), &[]);
    // Home, the campaign, and on.
    person.presses(&[Yes, Yes, Yes]);
    let (_, framebuffer) = next_hit();
    pictures::check("run-undo-again", &framebuffer, &LIVE);
    looked.go_on(&rig);
    let done = loop {
        let (model, _) = next_hit();
        if model.phase == Phase::Done {
            break model;
        }
        looked.go_on(&rig);
    };
    assert_eq!((done.averaged, done.rejected), (15, 0));
    let cues = person.0.cues();
    assert_eq!(cues.iter().filter(|&&cue| cue == Cue::Accepted).count(), 16, "{cues:?}");
    rig.stop().unwrap();
}

/// Calibrates the sensors of a bench by gravity; returns the screen that proposes the result, and the
/// stored calibration.
fn tumble(flash: &FlashBacking, bench: &Bench, seed: u64) -> (Framebuffer, CalibrationRecord) {
    let source = TumbleSource::new(bench, 3, seed).unwrap();
    let hand: TumbleHandle = source.handle();
    let (rig, person) = power_on(flash, Box::new(source));
    person.sees(|model| model.layouts == 1);
    // The home menu: measure, results, layouts, calibrate. Choose the first line of calibrate.
    person.presses(&[Next, Next, Next, Yes]);
    let mut framebuffer = person.press(Yes);
    for (place, position) in Position::ALL.into_iter().enumerate() {
        person.sees(|model| model.calibration_wizard == CalibrationWizard::Wanted(place as u8));
        hand.turn_to(position);
        person.press(Yes);
        let (model, shown) =
            person.sees(|model| !matches!(model.calibration_wizard, CalibrationWizard::Reading(_)));
        assert!(
            matches!(
                model.calibration_wizard,
                CalibrationWizard::Wanted(_) | CalibrationWizard::Proposed(_)
            ),
            "{position}: {:?}",
            model.calibration_wizard
        );
        framebuffer = shown;
    }
    person.press(Yes);
    person.sees(|model| model.calibration_wizard == CalibrationWizard::Stored);
    rig.stop().unwrap();
    (framebuffer, stored_calibration(flash).unwrap())
}

/// The calibration in the flash of a rig that is switched off.
fn stored_calibration(flash: &FlashBacking) -> Option<CalibrationRecord> {
    let mut store = Store::new(Flash::open(flash).unwrap(), || false);
    block_on(store.open());
    block_on(store.calibration())
}

#[test]
fn sensors_are_calibrated_by_gravity_with_buttons_alone() {
    let bench = Bench::named("default").unwrap();
    let (proposal, kept) = tumble(&provisioned(), &bench, 5);
    pictures::check("run-tumble-proposal", &proposal, &[]);
    assert_eq!(kept.method, CalibrationMethod::Tumble);
    // The largest of nine errors: four standard deviations.
    let errors = sensitivity_errors(&bench, 5, &kept).unwrap();
    let [gain, ..] = errors.largest_percent();
    assert!(gain < 400.0 * f64::from(kept.sigma.gain), "{errors:?}");
}

/// The bench of a block of 2 kg and its layout.
fn block() -> (Bench, LayoutFile) {
    (Bench::named("block").unwrap(), layout_file(BLOCK))
}

/// Enters 2000.0 g into the wizard, which begins with 1000.0 g, and starts the test.
fn type_mass_and_start(person: &Person) {
    person.sees(|model| model.layouts == 1);
    // The home menu: measure, results, layouts, calibrate. Choose the second line of calibrate.
    person.presses(&[Next, Next, Next, Yes, Next, Yes]);
    person.presses(&[Yes, Next]);
    (1..DIGITS).for_each(|_| drop(person.press(Yes)));
}

#[test]
fn the_hammer_is_calibrated_against_a_block_with_buttons_alone() {
    const SEED: u64 = 2;
    let (bench, file) = block();
    let flash = provisioned_with(&[&file.rig_layout().unwrap()]);
    let (_, tumbled) = tumble(&flash, &bench, SEED);
    let source = scans(&bench, &file, SEED);
    let (rig, person) = power_on(&flash, source);
    type_mass_and_start(&person);
    let (done, _) = person.sees(|model| model.phase == Phase::Done);
    assert!(done.block && done.mass.is_none(), "{done:?}");
    let cues = person.0.cues();
    // Six hit DOFs with five hits each.
    assert_eq!(cues.iter().filter(|&&cue| cue == Cue::Accepted).count(), 30, "{cues:?}");
    person.press(Yes);
    let (model, framebuffer) =
        person.sees(|model| model.calibration_wizard != CalibrationWizard::Off);
    let CalibrationWizard::Proposed(proposal) = model.calibration_wizard else {
        panic!("no proposal: {model:?}")
    };
    assert!(proposal.sound && proposal.hammer_ratio.is_some());
    pictures::check("run-block-proposal", &framebuffer, &[]);
    person.press(Yes);
    person.sees(|model| model.calibration_wizard == CalibrationWizard::Stored);
    rig.stop().unwrap();

    let kept = stored_calibration(&flash).unwrap();
    assert_eq!(kept.method, CalibrationMethod::TumbleAndBlock);
    for k in 0..3 {
        let sensor = |record: &CalibrationRecord| record.calibration.sensor_sensitivity(k);
        assert_eq!(sensor(&kept), sensor(&tumbled), "the block does not touch the sensors");
    }
    // A single number: four standard deviations. It must also be an improvement: the hammer as delivered
    // is 2 % (1 σ) off.
    let [before, after] =
        [&tumbled, &kept].map(|record| sensitivity_errors(&bench, SEED, record).unwrap());
    let [[.., before], [.., after]] = [before, after].map(|errors| errors.largest_percent());
    assert!(after < 400.0 * f64::from(kept.sigma.hammer_gain), "{after} % of {:?}", kept.sigma);
    assert!(after < before && kept.sigma.hammer_gain < 0.005, "{before} % to {after} %");
}

#[test]
fn a_block_against_sensors_that_nobody_has_calibrated_is_refused_with_the_reason() {
    let (bench, file) = block();
    let flash = provisioned_with(&[&file.rig_layout().unwrap()]);
    let source = scans(&bench, &file, 2);
    let (rig, person) = power_on(&flash, source);
    type_mass_and_start(&person);
    person.sees(|model| model.phase == Phase::Done);
    person.press(Yes);
    let (model, _) = person.sees(|model| model.calibration_wizard != CalibrationWizard::Off);
    assert_eq!(model.calibration_wizard, CalibrationWizard::Wrong(WizardProblem::SensorsUnknown));
    person.press(Yes);
    person.sees(|model| model.calibration_wizard == CalibrationWizard::Off);
    rig.stop().unwrap();
    assert_eq!(stored_calibration(&flash), None);
}

/// The first test of the frame with every DOF, two hits each, and a target that is reached on the way.
fn with_a_target() -> LayoutFile {
    let mut file = three_bar();
    let every = with_every_dof(file.layout.cast().unwrap());
    file.layout = every.cast().unwrap();
    file.layout.test.hits_per_dof = 2;
    file.layout.target = Target { center: Some(0.002), ..Target::default() };
    file
}

#[test]
fn at_the_target_a_button_finishes_or_goes_on() {
    for (button, measured) in [(Yes, None), (Next, Some(12))] {
        let file = with_a_target();
        let bench = steady_hand("ideal");
        let (rig, person) =
            power_on(&provisioned_with(&[&file.rig_layout().unwrap()]), scans(&bench, &file, 1));
        person.sees(|model| model.layouts == 1);
        person.presses(&[Yes, Yes]);
        let (asked, _) = person.sees(|model| model.phase == Phase::TargetReached);
        let known = asked.precision.unwrap();
        // The frame's ten properties need three DOFs at least.
        assert!((3..12).contains(&known.dofs), "{known:?}");
        assert!(known.widths.unwrap().center <= 0.002);
        assert_eq!(person.0.cues().last(), Some(&Cue::Done));
        person.press(button);
        let (done, _) = person.sees(|model| model.phase == Phase::Done);
        let measured = measured.unwrap_or(known.dofs);
        assert_eq!(done.precision.unwrap().dofs, measured);
        assert_eq!(done.averaged, 2 * u16::from(measured));
        rig.stop().unwrap();
    }
}

/// Goes from home to the self-test and waits for its end.
fn tests_itself(person: &Person) -> (PanelModel, Framebuffer) {
    person.sees(|model| model.layouts == 1);
    person.presses(&[Next, Next, Next, Next, Yes]);
    person.sees(|model| matches!(model.self_test, SelfTestState::Done { .. }))
}

#[test]
fn a_sound_rig_tests_itself_by_buttons_alone() {
    let source = scans(&steady_hand("default"), &three_bar(), 1);
    let (rig, person) = power_on(&provisioned(), source);
    let (model, framebuffer) = tests_itself(&person);
    assert_eq!(model.self_test, SelfTestState::Done { findings: 0, channels: 10 });
    pictures::check("run-self-test-sound", &framebuffer, &[]);
    pictures::check("run-self-test-channels", &person.press(Next), &[]);
    // Three pages of channels, then the first page again.
    assert_eq!(person.presses(&[Next, Next, Next]), framebuffer);
    person.press(Back);
    assert_eq!(person.0.model().self_test, SelfTestState::Off);
    rig.stop().unwrap();
}

#[test]
fn a_self_test_names_the_hum_in_all_channels_once() {
    let mut bench = steady_hand("default");
    bench.mains.amplitude_v = 1e-3;
    bench.mains.frequency_hz = 60.0;
    let (rig, person) = power_on(&provisioned(), scans(&bench, &three_bar(), 1));
    let (model, framebuffer) = tests_itself(&person);
    assert_eq!(model.self_test, SelfTestState::Done { findings: 1, channels: 10 });
    pictures::check("run-self-test-hum", &framebuffer, &[]);
    rig.stop().unwrap();
}

#[test]
fn a_self_test_is_refused_during_a_campaign() {
    let (rig, person) = power_on(&provisioned(), scans(&steady_hand("default"), &three_bar(), 1));
    person.sees(|model| model.layouts == 1);
    person.presses(&[Yes, Yes]);
    person.sees(|model| model.phase == Phase::Armed);
    // Back pauses the campaign and leads home.
    person.press(Back);
    person.sees(|model| model.phase == Phase::Paused);
    let refused = person.presses(&[Next, Next, Next, Next, Yes]);
    pictures::check("run-self-test-refused", &refused, &[]);
    assert_eq!(person.0.model().self_test, SelfTestState::Off);
    assert_eq!(person.0.model().phase, Phase::Paused);
    rig.stop().unwrap();
}

/// Scans that end after so many.
struct Ending(Box<BenchSource>, usize);

impl ScanSource for Ending {
    fn adc(&self) -> AdcProperties {
        self.0.adc()
    }

    fn armed(&mut self, arming: u32, dof: usize) {
        self.0.armed(arming, dof);
    }

    fn next_scan(&mut self) -> Option<Scan> {
        self.1 = self.1.checked_sub(1)?;
        self.0.next_scan()
    }
}

#[test]
fn back_stops_a_self_test_that_still_reads() {
    let source = Ending(scans(&steady_hand("default"), &three_bar(), 1), 1000);
    let (rig, person) = power_on(&provisioned(), Box::new(source));
    person.sees(|model| model.layouts == 1);
    // A second one can be begun, because the rig no longer reads for the first.
    for to_the_line in [&[Next, Next, Next, Next, Yes][..], &[Yes]] {
        person.presses(to_the_line);
        let (model, _) = person.sees(|model| model.self_test != SelfTestState::Off);
        assert_eq!(model.self_test, SelfTestState::Running { percent: 0 });
        person.press(Back);
        person.sees(|model| model.self_test == SelfTestState::Off && model.idle);
    }
    rig.stop().unwrap();
}
