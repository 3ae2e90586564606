use super::*;
use massline_files::layout_file::template;
use massline_shared::layout::TestProfile;

/// The layout of a text with other sensors, hits and hits per DOF.
fn other(text: &str, sensors: &[u16], hits: &[&str], hits_per_dof: u8) -> HostLayout {
    let file = LayoutFile::parse(text, "l").unwrap();
    let mut layout = file.layout.clone();
    layout.test.hits_per_dof = hits_per_dof;
    let sensor = layout.sensors[0];
    layout.sensors =
        sensors.iter().map(|&node| massline_shared::layout::Sensor { node, ..sensor }).collect();
    let hit = layout.hits[0];
    layout.hits = hits
        .iter()
        .map(|dof| massline_shared::layout::Hit { dof: dof.parse().unwrap(), ..hit })
        .collect();
    layout
}

#[test]
fn the_new_file_differs_from_the_old_in_what_was_chosen_only() {
    let commented = template(TestProfile::MassLine);
    let layout = other(&commented, &[4, 2, 1], &["4:+X", "3:-Z", "1:+Y", "2:+X"], 7);
    let text = edited(&commented, &layout).unwrap();
    let differ: Vec<_> = commented.lines().zip(text.lines()).filter(|(a, b)| a != b).collect();
    assert_eq!(commented.lines().count(), text.lines().count());
    let [sensors, hits, hits_per_dof] = differ[..] else { panic!("{differ:#?}") };
    assert_eq!(sensors.1, "sensors = [4, 2, 1]");
    assert_eq!(hits.1, r#"hits = ["4:+X", "3:-Z", "1:+Y", "2:+X"]"#);
    assert_eq!(hits_per_dof.1.replace('7', "5"), hits_per_dof.0, "its comment stays");
    let read = LayoutFile::parse(&text, "l").unwrap().layout;
    assert!(read.sensors.iter().map(|s| s.node).eq([4, 2, 1]));
    assert_eq!(read.hits.len(), 4);
    assert_eq!(read.test.hits_per_dof, 7);
}

#[test]
fn entries_that_stay_are_unchanged() {
    let text = r#"
        sensors = [{ node = 1, calibration = "A17" }, 2, # a remark
                   3]
        node = [
            { id = 1, position_m = [0.0, 0.0, 0.0] },
            { id = 2, position_m = [0.2, 0.0, 0.0] },
            { id = 3, position_m = [0.0, 0.2, 0.0] },
        ]
        [[hits]]
        dof = "1:+Y"
        uncertainty = { hit_position_m = 0.001 }
        [[hits]]
        dof = "2:+Z"
        [[hits]]
        dof = "3:+X"
    "#;
    let text = edited(text, &other(text, &[3, 1], &["3:+Y", "1:+Y"], 3)).unwrap();
    let file = LayoutFile::parse(&text, "l").unwrap();
    let calibrations: Vec<_> = file.sensors.iter().map(|s| s.calibration.as_deref()).collect();
    assert_eq!(calibrations, [None, Some("A17")]);
    let positions: Vec<_> = file.layout.hits.iter().map(|h| h.uncertainty.position).collect();
    assert_eq!(positions, [0.003, 0.001]);
    // The original has no [test] table.
    assert_eq!(file.layout.test.hits_per_dof, 3);
}
