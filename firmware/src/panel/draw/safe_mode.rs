//! The screen of a rig in safe mode.

use super::canvas::{Canvas, Screen, clipped, wrapped};
use crate::panel::words::WIDTH;

/// What has become of the store.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StoreState {
    /// Nobody has asked for it to be erased.
    Unread,
    /// The operator is asked whether it is to be erased.
    Asked,
    /// It is being erased.
    Erasing,
    /// It is empty.
    Erased,
    /// The flash could not be erased.
    Failed,
}

/// Draws what has become of the store, and the failure that ended the last run.
pub fn safe_mode(screen: &mut impl Screen, state: StoreState, failure: &str) {
    let mut canvas = Canvas(screen);
    canvas.clear();
    canvas.title("Safe mode", "");
    let (first, text) = match state {
        StoreState::Unread => {
            canvas.line(0, "Three starts failed:");
            let (line, rest) = wrapped(if failure.is_empty() { "it hung" } else { failure });
            canvas.line(1, line);
            canvas.line(2, &clipped(rest, WIDTH));
            (3, "Reset: start again.\nOK: erase the store")
        }
        StoreState::Asked => {
            (0, "Erase all results,\nlayouts, calibration?\n\nOK: erase\nBack: keep")
        }
        StoreState::Erasing => (1, "Erasing ..."),
        StoreState::Erased => (1, "The store is empty.\n\nPress reset to start."),
        StoreState::Failed => (1, "The flash could not\nbe erased.\nOK: try again"),
    };
    canvas.lines(first, text);
}
