//! Which modes do not show, and what to hit, in words.

use std::fmt;

/// What is said of a mode, counted from 1, that no hit shows well.
pub fn hardly_shown(mode: usize, shown: f64, better: &dyn fmt::Display) -> String {
    format!(
        "mode {mode} hardly shows under any hit ({:.0} % of the largest possible): hit {better} (axes of the body)",
        100.0 * shown
    )
}

/// That so many modes do not show.
pub fn do_not_show(missing: usize) -> String {
    match missing {
        1 => "one of the six modes does not show".into(),
        missing => format!("{missing} of the six modes do not show"),
    }
}

/// What is said of modes that do not show.
pub fn not_shown(missing: usize, new: &dyn fmt::Display) -> String {
    format!(
        "{}: hit {new} (axes of the body), a force unlike those of the hits so far",
        do_not_show(missing)
    )
}
