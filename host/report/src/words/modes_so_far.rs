//! What the points of a campaign have shown so far, and what readings lack, in words.

use massline_analysis::modes_so_far::{MissingModes, WELL};
use massline_result::{ModesSoFar, NextPoint, SeenMode};

use super::two_digits;
use super::where_to_hit::do_not_show;
use crate::words::counted;

/// What readings lack, and a hit that would show it.
pub fn lacking(missing_modes: &MissingModes) -> String {
    let shown = match missing_modes.hardly {
        Some((frequency_hz, share)) => format!(
            "the mode of {frequency_hz:.2} Hz hardly shows ({:.0} % of the largest possible)",
            100.0 * share
        ),
        None => do_not_show(missing_modes.missing),
    };
    match &missing_modes.hit {
        None => shown,
        Some(dof) => format!("{shown}; a hit at {dof} (axes of the body) would show more"),
    }
}

/// `2 of 5 points`.
pub fn progress(modes: &ModesSoFar) -> String {
    format!("{} of {} points", modes.dofs_measured, modes.dofs)
}

/// A line for each mode: frequency, the hit that shows it best, its Norm Indicator.
pub fn rows(modes: &ModesSoFar) -> Vec<String> {
    let row = |mode: &SeenMode| {
        let SeenMode { frequency_hz, dof, norm_indicator, share_of_possible, .. } = mode;
        format!(
            "{:>7} Hz  {dof:8} {} ({:.0} % of the largest possible)",
            format!("{frequency_hz:.2}"),
            two_digits(*norm_indicator),
            100.0 * share_of_possible,
        )
    };
    modes.modes.iter().map(row).collect()
}

/// What is missing, and what to hit next.
pub fn advice(modes: &ModesSoFar) -> String {
    let seen = match modes.modes_missing {
        0 => all_show(modes),
        missing if modes.dofs_measured < modes.dofs => {
            format!("{} yet", do_not_show(missing))
        }
        missing => do_not_show(missing),
    };
    let why = match modes.modes_missing {
        0 => "shows that mode better",
        _ => "pushes most unlike the points so far",
    };
    match &modes.next {
        None if modes.modes_missing > 0 => {
            format!("{seen}, and the points push in all directions: hit harder or more often")
        }
        None if modes.dofs_measured < modes.dofs => {
            format!("{seen}; the points to come make the answer more certain")
        }
        None => seen,
        Some(NextPoint { dof, points_before: Some(0) }) => {
            format!("{seen}; hit {dof} next: it {why}")
        }
        Some(NextPoint { dof, points_before: Some(before) }) => {
            let later = counted(*before as u32, "more point");
            format!("{seen}; {dof}, after {later}, {why}: do not leave it out")
        }
        Some(NextPoint { dof, points_before: None }) => {
            format!("{seen}; add {dof} (axes of the body) to the layout: it {why}")
        }
    }
}

/// That all six modes show, and which of them does not show well.
fn all_show(modes: &ModesSoFar) -> String {
    let worst =
        modes.modes.iter().min_by(|a, b| a.share_of_possible.total_cmp(&b.share_of_possible));
    match worst.filter(|mode| mode.share_of_possible < WELL) {
        None => "all six modes show".into(),
        Some(mode) => format!(
            "all six modes show, that of {:.2} Hz with only {:.0} % of the largest possible",
            mode.frequency_hz,
            100.0 * mode.share_of_possible
        ),
    }
}

/// The report as text: a heading, a line for each mode, the advice.
pub fn text(modes: &ModesSoFar) -> String {
    let heading = format!(
        "after {}, modes seen, each with the hit that shows it best and its Norm Indicator:",
        progress(modes)
    );
    let heading =
        if modes.modes.is_empty() { format!("after {}:", progress(modes)) } else { heading };
    let lines = [vec![heading], rows(modes), vec![advice(modes)]].concat();
    lines.join("\n  ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mode(frequency_hz: f64, share_of_possible: f64) -> SeenMode {
        SeenMode {
            frequency_hz,
            damping_ratio: 0.01,
            dof: "101:+X".into(),
            norm_indicator: 0.42,
            share_of_possible,
        }
    }

    fn next(dof: &str, points_before: Option<usize>) -> Option<NextPoint> {
        Some(NextPoint { dof: dof.into(), points_before })
    }

    #[test]
    fn what_is_missing_and_the_point_that_helps_are_named() {
        let third = ModesSoFar {
            dofs_measured: 3,
            dofs: 5,
            modes: vec![mode(2.82, 0.9), mode(3.22, 0.8)],
            modes_missing: 4,
            next: next("104:+Y", Some(0)),
        };
        let text = text(&third);
        assert!(text.starts_with("after 3 of 5 points, modes seen, each with"), "{text}");
        assert!(
            text.contains("   2.82 Hz  101:+X   0.42 (90 % of the largest possible)"),
            "{text}"
        );
        let end = "4 of the six modes do not show yet; hit 104:+Y next: it pushes most unlike the points so far";
        assert!(text.ends_with(end), "{text}");
        let later = ModesSoFar { next: next("104:+Y", Some(2)), ..third.clone() };
        assert!(advice(&later).ends_with(
            "104:+Y, after 2 more points, pushes most unlike the points so far: do not leave it out"
        ));
        let last = ModesSoFar { dofs: 3, modes_missing: 1, next: next("7:+Z", None), ..third };
        let end = "one of the six modes does not show; add 7:+Z (axes of the body) to the layout: it pushes most \
                    unlike the points so far";
        assert_eq!(advice(&last), end);
    }

    #[test]
    fn where_all_modes_show_the_worst_of_them_is_named_if_it_is_bad() {
        let good = ModesSoFar {
            dofs_measured: 5,
            dofs: 5,
            modes: vec![mode(2.82, 0.9); 6],
            modes_missing: 0,
            next: None,
        };
        assert_eq!(advice(&good), "all six modes show");
        let mut hardly = good.clone();
        hardly.modes[1] = mode(3.22, 0.17);
        hardly.next = next("105:+X", Some(0));
        let end = "all six modes show, that of 3.22 Hz with only 17 % of the largest possible; hit 105:+X next: it \
                    shows that mode better";
        assert_eq!(advice(&hardly), end);
        let early = ModesSoFar { dofs_measured: 4, ..good };
        assert_eq!(
            advice(&early),
            "all six modes show; the points to come make the answer more certain"
        );
    }
}
