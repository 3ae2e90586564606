//! Whether the points that are hit move as accelerations do: mass lines of another quantity, or of a reversed hammer, are
//! named before anything is made of them.

use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::layout::HostLayout;

use super::frfs::{FittedLines, LayoutResponses};
use super::{Options, first_error};
use crate::report::message_in;
use crate::suspension::reciprocity_of_mass_lines;
use crate::uff::Quantity;
use crate::{Error, Result};

/// Part of the squares of the responses that their imaginary parts have, from which they are no accelerations: those of a
/// free body are real, and noise has half.
const IMAGINARY: f64 = 0.75;

/// Adds what the points that are hit say about mass lines.
///
/// # Errors
/// `looks_like_mobility`, and `all_points_reversed` when more than one point is hit.
pub(super) fn check_points(
    layout: &HostLayout,
    responses: &LayoutResponses,
    lines: &mut FittedLines,
) -> Result<()> {
    let error = |code: Code| {
        let found = Diagnostic::whole(code, Severity::Error, 0.0);
        first_error(&[found], |d| message_in(d, layout)).map_or(Ok(()), Err)
    };
    if responses.imaginary_share(lines.band_hz) > IMAGINARY {
        return error(Code::LooksLikeMobility);
    }
    let found = reciprocity_of_mass_lines(layout, &lines.lines);
    let reversed = found.iter().filter(|d| d.code == Code::DrivingPointReversed).count();
    if reversed > 1 && reversed == layout.hits.len() {
        return error(Code::AllPointsReversed);
    }
    lines.diagnostics.extend(found);
    Ok(())
}

/// An error of mass lines with the points before it that move against their forces.
pub(super) fn after_points(found: &[Diagnostic], error: Error, layout: &HostLayout) -> Error {
    let reversed = found.iter().filter(|d| d.code == Code::DrivingPointReversed);
    let said: Vec<String> = reversed.map(|d| message_in(d, layout)).collect();
    match (error, said.is_empty()) {
        (Error::Undetermined { message, .. }, false) => {
            let text = format!("{}; {message}", said.join("; "));
            Error::undetermined(Code::DrivingPointReversed.name(), text)
        }
        (error, _) => error,
    }
}

/// An error about the quantity of the responses names the option that has stated it, if one has.
pub(super) fn blame_option(error: Error, options: &Options) -> Error {
    let codes = [Code::LooksLikeMobility, Code::AllPointsReversed, Code::DrivingPointReversed]
        .map(Code::name);
    let Some(stated) = options.quantity.filter(|_| codes.contains(&error.code())) else {
        return error;
    };
    let name = match stated {
        Quantity::Acceleration => "accelerance",
        Quantity::Velocity => "mobility",
        Quantity::Displacement => "receptance",
    };
    let text = format!(
        "taken as {name} (--quantity {name}), the responses do not move as those of a body do; leave the option out, so that \
         the file decides, or state what they are"
    );
    Error::undetermined(error.code().to_owned(), text)
}
