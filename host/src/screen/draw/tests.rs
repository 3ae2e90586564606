use std::ops::RangeInclusive;

use crossterm::event::KeyCode;
use massline_protocol::event::HitEvent;
use massline_shared::calibration::tumble::Position;
use massline_shared::layout::{HostLayout, TestProfile, TestSettings};
use massline_shared::measurement::campaign::Phase;
use massline_shared::signal::Swing;
use nalgebra::Vector3;
use ratatui::Terminal;
use ratatui::backend::TestBackend;

use super::curves::{Curves, plot};
use super::*;
use crate::output::harmless;
use crate::screen::guide::HitReadings;
use crate::screen::guide::tests::{ALL, guide, layout, status};
use crate::screen::positions::SensorOrientation;
use massline_report::readings::Readings;

/// Sizes below that of the full view.
const SMALL: [[u16; 2]; 3] = [[20, 5], [40, 12], [59, 17]];

/// What is on a terminal of this size.
fn render(view: &impl View, [width, height]: [u16; 2]) -> String {
    let mut terminal = Terminal::new(TestBackend::new(width, height)).unwrap();
    terminal.draw(|frame| view.draw(frame, Theme { color: true })).unwrap();
    terminal.backend().to_string()
}

/// The words on it, without the ends of its lines.
fn words(view: &impl View, size: [u16; 2]) -> String {
    let screen = render(view, size).replace(['"', '\n'], " ");
    screen.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[test]
fn titles_are_text_at_every_size() {
    let layout = layout().cast().unwrap();
    let long = "long ".repeat(820);
    let wide = "試験体の慣性".repeat(20);
    for title in ["<script>alert(1)</script>", "\u{202e}abc\u{1b}[2J", &long, &wide] {
        let title = harmless(title);
        let mut guide = Guide::new(&title, "measurement", &layout, 12, ALL);
        for size in [[1, 1], [40, 10], [60, 18], [80, 24], [200, 40], [200, 60]] {
            for help in [false, true] {
                guide.pages.help = help;
                let screen = render(&guide, size);
                assert!(!screen.contains(['\u{202e}', '\u{1b}']), "{screen}");
                if size[0] < 60 {
                    continue;
                }
                let begin: String = title.chars().take(8).collect();
                assert!(screen.contains(&begin), "{screen}");
                assert!(screen.contains(" measurement: 0 of 15 hits "), "{screen}");
                let is_cut = screen.lines().next().unwrap().contains('…');
                assert_eq!(is_cut, title.chars().count() > 100, "{screen}");
            }
        }
    }
}

#[test]
fn a_small_terminal_shows_what_is_asked_and_said_and_how_to_leave() {
    for size in SMALL {
        let mut guide = guide();
        guide.status(&status(1, &[5, 2, 0]), std::time::Duration::ZERO);
        assert!(words(&guide, size).contains("2:+Z"), "{}", render(&guide, size));
        guide.keep_note("q again aborts the campaign and discards its 7 accepted hits");
        let text = words(&guide, size);
        for word in ["q again aborts the campaign", "p pause", "q abort"] {
            assert!(text.contains(word), "{word}: {}", render(&guide, size));
        }
        let at_target = Phase::TargetReached.into();
        let reached =
            massline_protocol::message::Status { phase: at_target, ..status(1, &[5, 5, 0]) };
        guide.status(&reached, std::time::Duration::ZERO);
        guide.question(format!("target reached {}; finish now? [Y/n]", "±1 % ".repeat(20)));
        let asked = words(&guide, size);
        for word in ["finish now? [Y/n]", "y finish", "n go on"] {
            assert!(asked.contains(word), "{word}: {}", render(&guide, size));
        }
    }
}

#[test]
fn the_keys_are_explained_as_far_as_there_is_room_and_the_way_back_is_shown() {
    let mut guide = guide();
    assert!(guide.key(KeyCode::Char('?')));
    for size in SMALL {
        let screen = render(&guide, size);
        assert!(screen.contains("? back") && screen.contains("accept"), "{screen}");
    }
    let text = words(&guide, SMALLEST);
    for word in ["accept the hit", "this page", "finished."] {
        assert!(text.contains(word), "{word}: {}", render(&guide, SMALLEST));
    }
}

#[test]
fn the_full_view_fits_at_its_smallest_size() {
    let mut guide = guide();
    guide.status(&status(0, &[2, 0, 0]), std::time::Duration::ZERO);
    guide.levels([3; 10]);
    let screen = render(&guide, SMALLEST);
    let words = ["hit 1:+Y now", "arrow: force on the body", "hammer", "z ", "p pause", "Tab page"];
    for word in words {
        assert!(screen.contains(word), "{word}: {screen}");
    }
    assert!(screen.matches('█').count() >= 10, "a bar for each channel: {screen}");
}

/// Rows and columns of a large terminal go to the charts.
#[test]
fn charts_grow_with_the_terminal() {
    let mut guide = guide();
    guide.status(&status(0, &[2, 0, 0]), std::time::Duration::ZERO);
    guide.levels([12; 10]);
    let wave = |k: usize| 40.0 * (k as f64 / 20.0).sin();
    let readings =
        Readings { force: (0..600).map(wave).collect(), responses: vec![vec![1.0; 600]; 9] };
    let (scan_interval_s, pre_trigger_s) = (5e-5, 4e-3);
    guide.readings = Some(HitReadings { number: 2, readings, scan_interval_s, pre_trigger_s });
    let [small, large] = [[80, 24], [200, 60]].map(|size| render(&guide, size));
    let count = |screen: &str, signs: RangeInclusive<char>| {
        screen.chars().filter(|sign| signs.contains(sign)).count()
    };
    let [before, after] = [&small, &large].map(|screen| count(screen, '⠁'..='⣿'));
    assert!(after > 2 * before, "curves: {before} and {after}\n{large}");
    let [before, after] = [&small, &large].map(|screen| count(screen, '█'..='█'));
    assert!(after > 6 * before, "levels: {before} and {after}\n{large}");
    // Between the numbers at the ends of an axis, -4.0 and 26.0.
    assert!(large.contains("11.0") && !small.contains("11.0"), "{large}");
}

#[test]
fn a_tall_terminal_draws_the_orientation_of_sensors_as_bars() {
    let mut view = Positions::new(&Position::ALL, true);
    view.ask(Position::ALL[0]);
    view.lies(vec![SensorOrientation { reads: Vector3::new(-1.0, 0.5, 0.0), moves: false }; 3]);
    let screen = render(&view, [80, 40]);
    for (bar, axis) in [("█│·", "x -1.00"), ("│█", "y +0.50"), ("·│·", "z +0.00")] {
        let line = screen.lines().find(|line| line.contains(axis)).unwrap_or_default();
        assert!(line.contains(bar), "{axis}: {screen}");
    }
}

#[test]
fn without_colours_the_legend_tells_curves_by_their_markers_also_where_they_coincide() {
    let flat: Vec<(f64, f64)> = (0..=100).map(|k| (f64::from(k) / 100.0, 0.5)).collect();
    let curves = Curves {
        title: " curves ",
        names: ["1X", "2Y", "3Z"].map(String::from).into(),
        points: vec![flat; 3],
        x: [0.0, 1.0],
        y: Some([0.0, 1.0]),
    };
    let mut terminal = Terminal::new(TestBackend::new(40, 14)).unwrap();
    let theme = Theme { color: false };
    terminal.draw(|frame| plot(&curves, frame, frame.area(), theme)).unwrap();
    let screen = terminal.backend().to_string();
    for (signs, name) in [('⠁'..='⣿', "⠒ 1X"), ('•'..='•', "• 2Y"), ('+'..='+', "+ 3Z")]
    {
        assert!(screen.contains(name), "{screen}");
        let cells = screen.chars().filter(|sign| signs.contains(sign)).count();
        assert!(cells > 4, "{name}: {screen}");
    }
}

#[test]
fn a_tumble_test_on_a_small_terminal_says_what_to_do_first() {
    let mut view = Positions::new(&Position::ALL, true);
    view.ask(Position::ALL[0]);
    let sensor = SensorOrientation { reads: Vector3::new(0.7, 0.7, 0.0), moves: false };
    view.lies(vec![sensor; 3]);
    for size in SMALL {
        let text = words(&view, size);
        for word in ["+X: X axes of all sensors up, then press Enter", "Enter read"] {
            assert!(text.contains(word), "{word}: {}", render(&view, size));
        }
    }
    let text = words(&view, SMALL[1]);
    for word in ["sensor 3: not aligned with an axis", "0 of 6 positions read", "p pause"] {
        assert!(text.contains(word), "{word}: {}", render(&view, SMALL[1]));
    }
}

#[test]
fn a_record_of_the_suspension_profile_is_counted_down_and_its_hit_has_an_impulse() {
    let layout = HostLayout { test: TestSettings::of_profile(TestProfile::Suspension), ..layout() };
    let mut guide = Guide::new("wheel", "measurement", &layout.cast().unwrap(), 12, ALL);
    let mut now = status(1, &[5, 2, 0]);
    guide.status(&now, std::time::Duration::ZERO);
    assert_eq!(place::words(&guide), "when it hangs still, hit 2:+Z: hit 3 of 5");
    now.phase = Phase::Busy.into();
    guide.status(&now, std::time::Duration::ZERO);
    assert!(guide.rings(Some(31)) && !guide.rings(Some(31)), "drawn again only when it changes");
    assert_eq!(place::words(&guide), "ringing, 31 s left: do not touch it");
    assert!(
        words(&guide, SMALL[1]).contains(&place::words(&guide)),
        "{}",
        render(&guide, SMALL[1])
    );
    guide.rings(None);
    guide.hit(&HitEvent {
        number: 8,
        dof: 1,
        good: true,
        scan: 0,
        peak_force: 96.0,
        peak_acceleration: 4.1,
        swing: Some(Swing { impulse: 1.02, rest: 0.0031, remainder: 0.0008 }),
        findings: Default::default(),
    });
    assert_eq!(place::words(&guide), "measuring at 2:+Z");
    let screen = render(&guide, [200, 60]);
    let numbers = "2:+Z: 96.0 N, 4.1 m/s², 1.02 N s, moved 0.31 % before it, 0.080 % left";
    assert!(screen.contains(numbers), "{screen}");
    assert!(screen.contains("the records of 40 s stay on the rig"), "{screen}");
    assert!(words(&guide, [80, 24]).contains("show what they give"), "it is wrapped");
}
