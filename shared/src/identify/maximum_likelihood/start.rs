//! The start of the fit, and whether the problem is identifiable.

use nalgebra::{Matrix3, Vector3};

use super::fit_problem::FitProblem;
use super::model::Model;
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::DofMassLines;
use crate::identify::applicability::spectrum_under;
use crate::layout::{Prior, assumed_body, check_hits};
use crate::linalg::Spectrum;
use crate::real::Real;

/// Moments of inertia over m L² of the bodies tried for a crude start.
const GYRATION: [f64; 4] = [0.1, 0.4, 1.2, 4.0];

/// True when the fit can start from this body.
pub(super) fn is_usable<R: Real>(body: &RigidBody<R>) -> bool {
    body.is_finite() && body.mass > R::zero() && body.inverse_mass_matrix().is_some()
}

/// A ball about the middle of sensors and hits with the mass that fits best; the best of a few sizes.
pub(super) fn crude<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    dofs: &[DofMassLines<R, C>],
) -> Option<RigidBody<R>> {
    let mut middle = Vector3::zeros();
    let mut count = R::zero();
    let layout = problem.layout;
    let sensors = layout.sensors.iter().map(|s| &s.position);
    for position in sensors.chain(layout.hits.iter().map(|h| &h.position)) {
        middle += problem.balance.point(position);
        count += R::one();
    }
    middle /= count.max(R::one());
    let extent = layout.hits.iter().fold(R::one(), |largest, hit| {
        largest.max((problem.balance.point(&hit.position) - middle).norm_squared())
    });
    let mut best: Option<(R, RigidBody<R>)> = None;
    for gyration in GYRATION {
        let inertia = Matrix3::from_diagonal_element(R::of(gyration) * extent);
        let unit = RigidBody { mass: R::one(), center_of_mass: middle, inertia };
        let Some((mass, left)) = heaviness(problem, dofs, &unit) else { continue };
        if best.as_ref().is_none_or(|(least, _)| left < *least) {
            best = Some((left, RigidBody { mass, inertia: inertia * mass, ..unit }));
        }
    }
    best.map(|(_, body)| body)
}

/// The assumed body for checking layouts before anything is measured.
pub(super) fn assumed<R: Real, C: Capacity>(problem: &FitProblem<'_, R, C>) -> RigidBody<R> {
    let sensors = problem.layout.sensors.iter().map(|sensor| sensor.position);
    let places = sensors.chain(problem.layout.hits.iter().map(|hit| hit.position));
    problem.balance.body(&assumed_body(None, places))
}

/// The mass with which a body of this shape fits best, and the sum of the squared residuals.
fn heaviness<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    dofs: &[DofMassLines<R, C>],
    unit: &RigidBody<R>,
) -> Option<(R, R)> {
    let model = Model::<R, C>::new(problem.layout, &problem.balance, unit)?;
    let (mut of_model, mut mixed, mut of_data) = (R::zero(), R::zero(), R::zero());
    for (index, lines) in dofs {
        let hit = problem.layout.hits.get(*index)?;
        let reading = model.reading(hit, &problem.balance)?;
        of_model += reading.norm_squared();
        mixed += reading.dot(&lines.accelerance);
        of_data += lines.accelerance.norm_squared();
    }
    // All cables may have the wrong sign; the mass is positive all the same.
    let mass = of_model / mixed.abs();
    (mass.finite() && mass > R::zero()).then(|| (mass, of_data - mixed * mixed / of_model))
}

/// The spectrum of the derivative, with warnings; errors when the ten properties cannot be determined.
pub(super) fn identifiable<R: Real, C: Capacity>(
    problem: &FitProblem<'_, R, C>,
    dofs: &[DofMassLines<R, C>],
    body: &RigidBody<R>,
) -> Result<(Spectrum<R>, Diagnostics), Diagnostics> {
    let layout = problem.layout;
    let hits = dofs.iter().filter_map(|(index, _)| layout.hits.get(*index));
    let mut diagnostics = check_hits(hits, problem.balance.length, None);
    let hits = dofs.iter().filter_map(|(index, _)| layout.hits.get(*index));
    let spectrum = spectrum_under(layout, hits, &problem.balance.body_back(body));
    let rank = spectrum.map_or(0, |s| s.rank);
    match spectrum {
        Some(spectrum)
            if rank == 10
                && (diagnostics.is_empty() || layout.priors.iter().any(Prior::is_of_inertia)) =>
        {
            for diagnostic in &mut diagnostics {
                diagnostic.severity = Severity::Warning;
            }
            Ok((spectrum, diagnostics))
        }
        _ => {
            if rank < 10 {
                let code = Code::TenParametersNotIdentifiable;
                let _ = diagnostics.push(Diagnostic::whole(code, Severity::Error, rank as f32));
            }
            Err(diagnostics)
        }
    }
}
