//! A person measures the suspension modes of the wheel with only the rig's buttons, its screen and a mallet.

use crate::pictures;
use massline_files::layout_file::LayoutFile;
use massline_firmware::panel::{Button, Cue};
use massline_physics::BenchSource;
use massline_shared::layout::{TestProfile, TestSettings};
use massline_shared::measurement::campaign::Phase;
use massline_tests::campaign::{scans, steady_hand, three_bar};
use massline_tests::held_scans::HeldScans;
use massline_tests::person::{Person, power_on, provisioned_with};
use massline_virtual::framebuffer::Framebuffer;

use Button::{Back, Next, Ok as Yes};

const SEED: u64 = 4;
/// Hits at each DOF: fewer than usual, since every record takes 40 s.
const HITS: u8 = 2;
/// The clock in the title and the level bars, which depend on the speed of this machine.
const LIVE: [pictures::Mask; 2] = [(90..128, 0..11), (0..128, 52..64)];

/// The wheel's layout, made for mass lines.
fn wheel() -> LayoutFile {
    let text = include_str!("../../../host/examples/wheel.toml");
    let mut file = LayoutFile::parse(text, "wheel.toml").expect("a layout");
    file.layout.test =
        TestSettings { hits_per_dof: HITS, ..TestSettings::of_profile(TestProfile::MassLine) };
    file
}

fn taps() -> BenchSource {
    let mut file = wheel();
    file.layout.test = file.layout.test.under(TestProfile::Suspension);
    *scans(&steady_hand("wheel"), &file, SEED)
}

#[test]
fn a_whole_measurement_of_modes_by_buttons_alone() {
    let (frame, wheel) = (three_bar().rig_layout().unwrap(), wheel().rig_layout().unwrap());
    let flash = provisioned_with(&[&wheel, &frame]);
    let (hold, looked) = HeldScans::of(taps());
    let (rig, person) = power_on(&flash, Box::new(hold));
    person.sees(|model| model.layouts == 2);
    pictures::check("modes-01-layouts", &person.presses(&[Next, Next, Yes]), &[]);
    // The first layout, and back to the first line of home: Measure.
    person.presses(&[Yes, Back, Next, Next, Next, Next, Next]);
    pictures::check("modes-02-mass-lines", &person.press(Yes), &[]);
    pictures::check("modes-03-what", &person.press(Next), &[]);
    pictures::check("modes-04-ready", &person.presses(&[Next, Yes]), &[]);
    person.press(Yes);
    let mut answered = 0;
    loop {
        let (model, framebuffer) = person.sees(|model| {
            let moves = model.levels.iter().any(|&level| level > 0);
            let next = model.phase == Phase::Armed && model.armings > answered;
            model.phase == Phase::Done || next && moves
        });
        match model.hits_done {
            _ if model.phase == Phase::Done => break,
            0 => pictures::check("modes-05-first-hit", &framebuffer, &LIVE),
            3 => pictures::check("modes-06-later-hit", &framebuffer, &LIVE),
            _ => {}
        }
        answered = model.armings;
        looked.go_on(&rig);
    }
    let (done, framebuffer) = person.sees(|model| model.phase == Phase::Done);
    pictures::check("modes-07-done", &framebuffer, &[]);
    assert_eq!(person.0.cues().last(), Some(&Cue::Done));
    assert_eq!(done.mass, None, "the program solves it");
    let pages = look_through(&person);
    for (page, framebuffer) in pages.iter().enumerate() {
        pictures::check(&format!("modes-result-{:02}", page + 1), framebuffer, &[]);
    }
    rig.stop().unwrap();

    // After a power cut the stored result has the same pages.
    let (rig, person) = power_on(&flash, Box::new(taps()));
    person.sees(|model| model.results == 1);
    person.presses(&[Next, Yes]);
    assert_eq!(look_through(&person), pages);
    rig.stop().unwrap();
}

/// Opens the first result of the list, or that of the campaign that is done, and turns all its pages.
fn look_through(person: &Person) -> Vec<Framebuffer> {
    let first = person.press(Yes);
    let (model, _) = person.sees(|model| model.pages > 0);
    let others = (1..model.pages).map(|_| person.press(Next));
    std::iter::once(first).chain(others).collect()
}
