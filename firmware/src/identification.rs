//! From the mass lines of a campaign to its answers: the ten properties, method by method.

use embassy_futures::yield_now;
use heapless::Vec;
use massline_protocol::message::Measured;
use massline_protocol::object::{DofResult, MeasurementResult, StoredEstimate};
use massline_shared::body::RigidBody;
use massline_shared::diagnosis::{Diagnostic, Diagnostics, Severity};
use massline_shared::identify::inertia_restraint::{self, Settings};
use massline_shared::identify::maximum_likelihood::{Fit, Progress};
use massline_shared::identify::{Estimate, MassLines, Method, lower_triangle};
use massline_shared::layout::RigLayout;
use massline_shared::signal::RESPONSES;
use nalgebra::ComplexField;

use crate::deadline::Deadline;
use crate::rig::Rig;

/// The methods that the rig identifies with, the best first.
pub(crate) const METHODS: [Method; 2] = [Method::MaximumLikelihood, Method::InertiaRestraint];

/// Computes what every method answers from the DOFs of the result, the best first. A method that has
/// no answer says why: as an error only when no other has one either.
///
/// Yields between the steps of the fit. Deadline: [`crate::deadline::DEADLINE`] between two yields.
/// `workspace` has the numbers that [`maximum_likelihood::RIG_WORKSPACE`] asks for.
///
/// [`maximum_likelihood::RIG_WORKSPACE`]: massline_shared::identify::maximum_likelihood::RIG_WORKSPACE
pub(crate) async fn answer(rig: &Rig, result: &mut MeasurementResult, workspace: &mut [f32]) {
    result.estimates.clear();
    let restraint = inertia_restraint(rig, result);
    yield_now().await;
    let likelihood = maximum_likelihood(rig, result, restraint, workspace).await;
    if let Err(reasons) = likelihood {
        let severity =
            if result.estimates.is_empty() { Severity::Error } else { Severity::Warning };
        say(rig, reasons, severity);
    }
}

/// The answer of the inertia restraint method, into the result. It is also where the fit starts.
#[inline(never)]
fn inertia_restraint(rig: &Rig, result: &mut MeasurementResult) -> Option<RigidBody<f32>> {
    let _deadline = Deadline::begin(rig);
    let layout = rig.layout.borrow();
    let dofs = mass_lines(&result.dofs);
    match inertia_restraint::solve(layout.as_ref()?, dofs, Settings::weighted()) {
        Ok(estimate) => {
            // There is room for both methods.
            let _ = result.estimates.push(stored(Method::InertiaRestraint, &estimate));
            Some(estimate.body)
        }
        Err(reasons) => {
            say(rig, reasons, Severity::Warning);
            None
        }
    }
}

/// The answer of maximum likelihood, before all others into the result.
async fn maximum_likelihood(
    rig: &Rig,
    result: &mut MeasurementResult,
    start: Option<RigidBody<f32>>,
    workspace: &mut [f32],
) -> Result<(), Diagnostics> {
    let mut fit = start_fit(rig, result, start.as_ref())?;
    let mut progress = Progress::Going;
    while progress == Progress::Going {
        yield_now().await;
        progress = step(rig, result, &mut fit, workspace)?;
    }
    yield_now().await;
    finish(rig, result, fit, workspace)
}

// Plain functions: what an async function computes is compiled with the board, for size. Never inlined: what one
// of them holds on the stack is not held while another one computes.

#[inline(never)]
fn start_fit(
    rig: &Rig,
    result: &MeasurementResult,
    start: Option<&RigidBody<f32>>,
) -> Result<Fit<f32>, Diagnostics> {
    let dofs = mass_lines(&result.dofs);
    with_layout(rig, |layout| Fit::start(layout, dofs, start))
}

#[inline(never)]
fn step(
    rig: &Rig,
    result: &MeasurementResult,
    fit: &mut Fit<f32>,
    workspace: &mut [f32],
) -> Result<Progress, Diagnostics> {
    let dofs = mass_lines(&result.dofs);
    with_layout(rig, |layout| fit.step(layout, dofs, workspace))
}

#[inline(never)]
fn finish(
    rig: &Rig,
    result: &mut MeasurementResult,
    fit: Fit<f32>,
    workspace: &mut [f32],
) -> Result<(), Diagnostics> {
    let dofs = mass_lines(&result.dofs);
    let estimate = with_layout(rig, |layout| fit.answer(layout, dofs, workspace))?;
    // There is room for both methods.
    let _ = result.estimates.insert(0, stored(Method::MaximumLikelihood, &estimate));
    Ok(())
}

/// Computes with the layout, which stays the same while the rig solves.
fn with_layout<T>(
    rig: &Rig,
    compute: impl FnOnce(&RigLayout) -> Result<T, Diagnostics>,
) -> Result<T, Diagnostics> {
    let _deadline = Deadline::begin(rig);
    rig.layout.borrow().as_ref().map_or(Err(Diagnostics::new()), compute)
}

/// The mass lines of the DOFs by their index in the layout.
fn mass_lines(
    dofs: &[DofResult],
) -> impl Iterator<Item = (usize, MassLines<f32, RESPONSES>)> + Clone {
    dofs.iter().filter_map(|dof| {
        let DofResult { accelerance, noise, scatter, .. } = dof;
        let hits = u16::from(dof.hits);
        let lines = MassLines::<f32, RESPONSES>::from_parts(accelerance, noise, scatter, hits)?;
        Some((usize::from(dof.index), lines))
    })
}

fn stored(method: Method, estimate: &Estimate<f32>) -> StoredEstimate {
    let covariance = estimate.covariance.as_ref();
    StoredEstimate {
        method: method as u8,
        properties: estimate.theta().into(),
        covariance: covariance.map_or(Vec::new(), |c| lower_triangle(c, 10).collect()),
        condition: estimate.condition,
        consistency: estimate.consistency,
        diagnostics: estimate.diagnostics.clone(),
    }
}

fn say(rig: &Rig, reasons: Diagnostics, severity: Severity) {
    for reason in reasons {
        rig.say(Diagnostic { severity, ..reason });
    }
}

/// The mass of an answer.
pub(crate) fn mass_of(estimate: &StoredEstimate) -> Measured {
    let variance = estimate.covariance.first();
    Measured {
        value: estimate.properties[0],
        sigma: variance.map(|variance| ComplexField::sqrt(variance.max(0.0))),
    }
}
