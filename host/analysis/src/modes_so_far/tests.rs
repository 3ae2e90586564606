//! The wheel with points in an order that hides modes: its lines are computed from its body and springs.

use massline_physics::responses::{ObjectExtras, add_noise, frequency_responses};
use massline_physics::source::ScanSource;
use massline_physics::{Bench, BenchSource};
use massline_shared::signal::{SPECTRUM_BINS, resolution};
use nalgebra::Complex;

use super::*;
use massline_files::layout_file::LayoutFile;

/// Three marks within a millimetre of the axis through the centre of mass.
const MIDDLE: &str = "
[[node]]
id = 121
position_m = [0.0, 0.0, 0.03]
[[node]]
id = 122
position_m = [0.001, 0.0, 0.03]
[[node]]
id = 123
position_m = [0.0, 0.001, 0.03]
";

/// The wheel's layout with these hits.
fn layout(hits: &str) -> HostLayout {
    let text = include_str!("../../../examples/wheel.toml").to_owned() + MIDDLE;
    let points = r#"["101:+X", "102:+Z", "103:+Z", "104:+Y", "105:+X"]"#;
    assert!(text.contains(points));
    LayoutFile::parse(&text.replace(points, hits), "wheel").unwrap().layout
}

/// Lines of these DOFs of the wheel, as a rig would store them, with this noise, (m/s²)/N.
fn lines(layout: &HostLayout, adc: &AdcProperties, noise: f64) -> Vec<DofLines> {
    let bench = Bench::named("wheel").unwrap();
    let spacing: f64 = resolution(adc, layout.test.profile);
    let frequencies: Vec<f64> = (1..SPECTRUM_BINS).map(|bin| bin as f64 * spacing).collect();
    let decay = layout.test.exponential_decay;
    let mut accelerances =
        frequency_responses(&bench, layout, &frequencies, decay, &ObjectExtras::default()).unwrap();
    add_noise(&mut accelerances, noise, 1, 0);
    let (channels, hits) = (3 * layout.sensors.len(), layout.hits.len());
    let lines_of = |dof: usize| {
        let at = |channel: usize, bin: usize| match bin {
            // An accelerance vanishes at zero.
            0 => Complex::new(0.0, 0.0),
            _ => accelerances[((bin - 1) * channels + channel) * hits + dof],
        };
        let responses =
            (0..channels).flat_map(|channel| (0..SPECTRUM_BINS).map(move |bin| at(channel, bin)));
        DofLines { dof, lines: responses.collect() }
    };
    (0..hits).map(lines_of).collect()
}

/// The reports after each point of this layout.
fn reports(hits: &str, noise: f64) -> Vec<ModesSoFar> {
    let layout = layout(hits);
    let source = BenchSource::new(&Bench::named("wheel").unwrap(), &layout, 1).unwrap();
    let mut monitor = ModesMonitor::new(layout.clone(), source.adc());
    for dof in lines(&layout, &source.adc(), noise) {
        let left: Vec<usize> = (dof.dof + 1..layout.hits.len()).collect();
        monitor.add(dof);
        monitor.report(&left);
    }
    monitor.into_reports()
}

/// How many points of how many were measured.
fn counted(report: &ModesSoFar) -> (usize, usize) {
    (report.dofs_measured, report.dofs)
}

/// Noise of a good test, and so much that a mode has to be hit well to be seen.
const LITTLE: f64 = 0.002;
const MUCH: f64 = 0.1;
/// Pushes along the axis of the wheel hardly turn it.
const MIDDLE_FIRST: &str = r#"["121:+Z", "122:+Z", "123:+Z", "104:+Y", "105:+X"]"#;

#[test]
fn after_points_that_miss_modes_the_one_that_pushes_in_a_new_direction_is_named() {
    let reports = reports(MIDDLE_FIRST, MUCH);
    let third = &reports[2];
    assert!(third.modes_missing > 0, "{third:?}");
    let next = third.next.as_ref().expect("a point");
    assert!(
        next.points_before.is_some() && ["104:+Y", "105:+X"].contains(&next.dof.as_str()),
        "{next:?}"
    );
    assert_eq!((third.dofs_measured, third.dofs), (3, 5));
    assert!(reports[4].modes_missing < third.modes_missing, "{:?}", reports[4]);
}

#[test]
fn after_points_that_hardly_show_a_mode_the_one_that_shows_it_is_named() {
    let reports = reports(MIDDLE_FIRST, LITTLE);
    let third = &reports[2];
    let worst = third.modes.iter().map(|mode| mode.share_of_possible).fold(1.0, f64::min);
    assert!(third.modes_missing == 0 && worst < 0.2, "{third:?}");
    assert!(third.next.as_ref().is_some_and(|next| next.points_before.is_some()), "{third:?}");
    let last = reports[4].modes.iter().map(|mode| mode.share_of_possible).fold(1.0, f64::min);
    assert!(last > 2.0 * worst, "{:?}", reports[4]);
}

#[test]
fn the_points_of_the_example_show_all_modes() {
    let reports = reports(r#"["101:+X", "102:+Z", "103:+Z", "104:+Y", "105:+X"]"#, LITTLE);
    let last = &reports[4];
    assert_eq!((last.modes_missing, &last.next), (0, &None), "{last:?}");
    // The wheel's modes.
    for (seen, expected) in last.modes.iter().zip([2.82, 3.22, 3.56, 6.14, 7.16, 7.66]) {
        assert!((seen.frequency_hz / expected - 1.0).abs() < 0.005, "{seen:?}");
        assert!((0.0..=1.0).contains(&seen.share_of_possible), "{seen:?}");
    }
}

#[test]
fn where_no_point_of_the_layout_is_left_one_to_add_is_named() {
    for (noise, all_show) in [(LITTLE, true), (MUCH, false)] {
        let reports = reports(r#"["121:+Z", "122:+Z", "123:+Z"]"#, noise);
        let last = &reports[2];
        assert!(last.next.as_ref().is_some_and(|next| next.points_before.is_none()), "{last:?}");
        assert_eq!(last.modes_missing == 0, all_show, "{last:?}");
    }
}

#[test]
fn a_point_that_is_measured_again_counts_anew() {
    let layout = layout(r#"["101:+X", "102:+Z", "103:+Z"]"#);
    let source = BenchSource::new(&Bench::named("wheel").unwrap(), &layout, 1).unwrap();
    let mut monitor = ModesMonitor::new(layout.clone(), source.adc());
    lines(&layout, &source.adc(), LITTLE).into_iter().for_each(|dof| monitor.add(dof));
    assert!(monitor.knows(2) && monitor.forget(2) && !monitor.knows(2) && !monitor.forget(2));
    assert_eq!(counted(monitor.report(&[2])), (2, 3));
}

#[test]
fn a_skipped_point_is_neither_counted_nor_named_as_the_next() {
    let layout = layout(MIDDLE_FIRST);
    let source = BenchSource::new(&Bench::named("wheel").unwrap(), &layout, 1).unwrap();
    let mut monitor = ModesMonitor::new(layout.clone(), source.adc());
    let mut dofs = lines(&layout, &source.adc(), MUCH).into_iter();
    dofs.by_ref().take(3).for_each(|dof| monitor.add(dof));
    let place = |report: &ModesSoFar| {
        report.next.as_ref().map(|next| (next.dof.clone(), next.points_before))
    };
    let asked = |at: usize| layout.hits[at].dof.to_string();
    // The one that is named when both are left is skipped when the rig is at the other, or behind both.
    let both = monitor.report(&[3, 4]).clone();
    assert_eq!(counted(&both), (3, 5));
    assert!(!monitor.is_outdated(&[3, 4]) && monitor.is_outdated(&[4]));
    let one = monitor.report(&[4]).clone();
    assert_eq!((counted(&one), place(&one)), ((3, 4), Some((asked(4), Some(0)))));
    let none = monitor.report(&[]);
    assert_eq!(counted(none), (3, 3));
    assert!(none.next.as_ref().is_some_and(|next| next.points_before.is_none()), "{none:?}");
}
