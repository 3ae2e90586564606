//! The calibration wizard.

use massline_shared::calibration::tumble::Position;

use super::View;
use super::canvas::{Canvas, Screen, text, top};
use crate::panel::calibration_wizard::{CalibrationWizard, Proposal, WizardProblem};
use crate::panel::menu::DIGITS;
use crate::panel::number::{fixed, percent};
use crate::panel::words;

/// Entry of the block's mass, with the current digit underlined.
pub(super) fn block_mass<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    canvas.title("Mass of the block", "");
    let decigrams = view.menu.decigrams();
    canvas.big(10, top(0) + 1, &text(format_args!("{:05}.{} g", decigrams / 10, decigrams % 10)));
    let digit = i32::from(view.menu.cursor().min(DIGITS - 1));
    // The decimal point comes before the last digit.
    let column = digit + i32::from(digit + 1 == i32::from(DIGITS));
    canvas.fill(10 + 10 * column, top(2), 9, 2);
    canvas.line(3, "Next: +1  OK: confirm");
    canvas.line(4, "incl. glued sensors");
}

/// A calibration in progress.
pub(super) fn calibration_wizard<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    match view.model.calibration_wizard {
        CalibrationWizard::Off => {}
        CalibrationWizard::Wanted(place) => {
            title(canvas, place);
            canvas.line(0, "Lay sensors still:");
            canvas.big(0, top(1), &way_up(place));
            canvas.line(4, "OK: read");
        }
        CalibrationWizard::Reading(place) => {
            title(canvas, place);
            canvas.big(0, top(1), "Hands off");
            canvas.line(4, "reading ...");
        }
        CalibrationWizard::Wrong(problem) => wrong(canvas, &problem),
        CalibrationWizard::Proposed(proposal) => proposed(canvas, &proposal),
        CalibrationWizard::Stored => {
            canvas.title("Calibrated", "");
            canvas.lines(1, "The new calibration\nis stored and in use.");
            canvas.line(4, "OK");
        }
    }
}

fn title<D: Screen>(canvas: &mut Canvas<'_, D>, place: u8) {
    canvas.title("By gravity", &text(format_args!("{}/{}", place + 1, Position::ALL.len())));
}

fn way_up(place: u8) -> crate::panel::number::Text {
    match Position::ALL.get(usize::from(place)) {
        Some(position) => text(format_args!("{position} up")),
        None => text(format_args!("")),
    }
}

fn wrong<D: Screen>(canvas: &mut Canvas<'_, D>, problem: &WizardProblem) {
    canvas.title("Not calibrated", "");
    if let WizardProblem::Tumble { sensor, .. } = problem {
        canvas.format(0, format_args!("sensor {}", sensor + 1));
    }
    canvas.lines(1, words::of_problem(problem));
    canvas.line(4, if problem.read_again() { "OK: read again" } else { "OK" });
}

fn proposed<D: Screen>(canvas: &mut Canvas<'_, D>, proposal: &Proposal) {
    canvas.title("Keep this?", "");
    match proposal.hammer_ratio {
        Some(ratio) => {
            canvas.pair(0, "force was x", &fixed(ratio, 4));
            canvas.pair(1, "\u{b1} hammer", &percent(proposal.sigma.hammer_gain));
            canvas
                .line(2, if proposal.sound { "directions agree" } else { "DISAGREE: hit again?" });
        }
        None => {
            canvas.pair(0, "\u{b1} gains", &percent(proposal.sigma.gain));
            canvas.pair(1, "\u{b1} cross axis", &percent(proposal.sigma.cross_axis));
            canvas.line(2, if proposal.sound { "positions level" } else { "NOT LEVEL: repeat?" });
        }
    }
    canvas.line(3, "OK: keep");
    canvas.line(4, "Back: drop");
}
