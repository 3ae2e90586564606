//! Whether the points that are hit move as accelerations do: mass lines of another quantity, or of a reversed hammer, are
//! named before anything is made of them.

use massline_shared::diagnosis::{Code, Diagnostic, Severity, Subject};
use massline_shared::layout::HostLayout;
use massline_shared::modes::reduce_line;
use nalgebra::{Complex, Vector6};

use super::frfs::LayoutResponses;
use super::{Options, first_error, undetermined};
use crate::report::message_in;
use crate::uff::Quantity;
use crate::{Error, Result};

/// Part of the readings a quarter of a period from the force from which they are no accelerations: those of a free body are
/// in its phase but for the lines next to elastic modes, and of noise half are.
const IN_QUADRATURE: f64 = 0.75;

/// Part of the lines at which a point moves against its force from which it is reversed. An elastic mode within the band
/// turns points for a part of it, so the mass lines themselves do not tell.
const REVERSED: f64 = 0.75;

/// The hits, by their places, whose point moves against the force nearly everywhere in the band of the mass lines.
///
/// # Errors
/// `looks_like_mobility`, and `all_points_reversed` when more than one point is hit.
pub(super) fn reversed_points(
    layout: &HostLayout,
    responses: &LayoutResponses,
    band_hz: [f64; 2],
) -> Result<Vec<usize>> {
    let error = |code: Code| {
        let found = Diagnostic::whole(code, Severity::Error, 0.0);
        first_error(&[found], |d| message_in(d, layout)).unwrap_or_else(undetermined)
    };
    if responses.quadrature_share(band_hz) > IN_QUADRATURE {
        return Err(error(Code::LooksLikeMobility));
    }
    // Without common lines, or when the sensors do not see all motions, nothing is known of the points.
    let Ok(lines) = responses.spectrum_bins(layout, band_hz, 0.0) else { return Ok(Vec::new()) };
    let readings = lines.responses()?;
    let reference = layout.sensor_centroid();
    let forces: Vec<_> = layout.hits.iter().map(|hit| hit.unit_force(&reference)).collect();
    let mut motions = vec![Vector6::<Complex<f64>>::zeros(); forces.len()];
    let mut against = vec![0; forces.len()];
    for line in 0..lines.len() {
        if reduce_line(layout, &readings, &reference, line, &mut motions).is_none() {
            return Ok(Vec::new());
        }
        for (count, (force, motion)) in against.iter_mut().zip(forces.iter().zip(&motions)) {
            *count += usize::from(motion.map(|y| y.re).dot(force) < 0.0);
        }
    }
    let is_reversed = |count: &usize| *count as f64 > REVERSED * lines.len() as f64;
    let reversed: Vec<usize> = against
        .iter()
        .enumerate()
        .filter(|(_, count)| is_reversed(count))
        .map(|(hit, _)| hit)
        .collect();
    if reversed.len() > 1 && reversed.len() == forces.len() {
        return Err(error(Code::AllPointsReversed));
    }
    Ok(reversed)
}

/// An error of mass lines with the points before it that move against their forces.
pub(super) fn after_points(reversed: &[usize], error: Error, layout: &HostLayout) -> Error {
    let said: Vec<String> = reversed
        .iter()
        .map(|hit| {
            let subject = Subject::hit(*hit);
            let code = Code::DrivingPointReversed;
            message_in(&Diagnostic::about(code, Severity::Error, subject, 0.0), layout)
        })
        .collect();
    match (error, said.is_empty()) {
        (Error::Undetermined { message, .. }, false) => {
            let text = format!("{}; {message}", said.join("; "));
            Error::undetermined(Code::DrivingPointReversed.name(), text)
        }
        (error, _) => error,
    }
}

/// An error about the quantity of the responses says so when an option has stated it.
pub(super) fn blame_option(error: Error, options: &Options) -> Error {
    let Some(stated) = options.quantity else { return error };
    let name = match stated {
        Quantity::Acceleration => "accelerance",
        Quantity::Velocity => "mobility",
        Quantity::Displacement => "receptance",
    };
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
