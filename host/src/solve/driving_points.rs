//! Whether the points that are hit move as accelerations do: mass lines of another quantity, or of a reversed hammer,
//! are named before anything is made of them.

use massline_shared::diagnosis::{Code, Diagnostic, Severity};
use massline_shared::identify::driving_points::{self, PointMotion, point_motions};
use massline_shared::layout::HostLayout;

use super::frfs::LayoutResponses;
use super::{Options, first_error, undetermined};
use crate::{Error, ErrorKind, Result};
use massline_report::words::message_in;

/// Part of the readings a quarter of a period from the force from which they are no accelerations: those of a free body
/// are in its phase but for the lines next to elastic modes, and of noise half are.
const IN_QUADRATURE: f64 = 0.75;

/// Errors about the hits whose point moves against the force nearly everywhere in the band of the mass lines. An
/// elastic mode within the band turns points for a part of it, so the mass lines themselves do not tell.
///
/// # Errors
/// `looks_like_mobility`, and `all_points_reversed` when more than one point is hit.
pub(super) fn reversed_points(
    layout: &HostLayout,
    responses: &LayoutResponses,
    band_hz: [f64; 2],
) -> Result<Vec<Diagnostic>> {
    let error = |code: Code| {
        let diagnostic = Diagnostic::whole(code, Severity::Error, 0.0);
        first_error(&[diagnostic], |d| message_in(d, layout)).unwrap_or_else(undetermined)
    };
    if responses.quadrature_share(band_hz) > IN_QUADRATURE {
        return Err(error(Code::LooksLikeMobility));
    }
    // Without common lines, or when the sensors do not see all motions, nothing is known of the points.
    let Ok(lines) = responses.spectrum_bins(layout, band_hz, 0.0) else { return Ok(Vec::new()) };
    let (readings, reference) = (lines.responses()?, layout.sensor_centroid());
    let Some(points) = point_motions(layout, &readings, &reference, 0..lines.len()) else {
        return Ok(Vec::new());
    };
    let reversed = driving_points::reversed_points(&points, PointMotion::is_against_force);
    match reversed.iter().find(|d| d.code == Code::AllPointsReversed) {
        Some(diagnostic) => Err(error(diagnostic.code)),
        None => Ok(reversed.to_vec()),
    }
}

/// An error of mass lines with the points before it that move against their forces.
pub(super) fn after_points(reversed: &[Diagnostic], error: Error, layout: &HostLayout) -> Error {
    let messages: Vec<String> =
        reversed.iter().map(|diagnostic| message_in(diagnostic, layout)).collect();
    match (error, messages.is_empty()) {
        (Error { kind: ErrorKind::Undetermined, message, .. }, false) => {
            let text = format!("{}; {message}", messages.join("; "));
            Error::undetermined(Code::DrivingPointReversed.name(), text)
        }
        (error, _) => error,
    }
}

/// An error about the quantity of the responses says so when an option has stated it.
pub(super) fn blame_option(error: Error, options: &Options) -> Error {
    let Some(stated) = options.quantity else { return error };
    let name = stated.frf_name();
    let taken = format!("taken as {name} (--quantity {name}),");
    let out = "leave the option out, so that the file decides, or state what they are";
    let is = |code: Code| error.code() == code.name();
    let text = if is(Code::LooksLikeMobility) {
        format!("{taken} the responses move as velocities do and not as accelerations; {out}")
    } else if is(Code::AllPointsReversed) {
        format!(
            "{taken} every point that is hit moves against the force, which no body does; {out}; if it is right, the \
             hammer has reversed polarity"
        )
    } else if is(Code::DrivingPointReversed) {
        format!("{error}; the responses were taken as {name}, as --quantity says")
    } else {
        return error;
    };
    Error::undetermined(error.code().to_owned(), text)
}
