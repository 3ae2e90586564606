//! Fits a mistake of unknown size: Gauss-Newton steps of the size, each from a maximum likelihood fit of the test under
//! the present size.

use massline_shared::Progress;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Unbounded;
use massline_shared::identify::maximum_likelihood::{ErrorBudget, Fit, Start};
use massline_shared::identify::{DofMassLines, Estimate};
use massline_shared::layout::HostLayout;
use nalgebra::{Matrix2, SVector, Vector2};

use super::linear_start;
use super::sized::{Size, SizedFault, known_scale};

/// Largest number of steps; three are usual.
const MOST_STEPS: usize = 12;
/// The fit ends before a step that is shorter than this many standard deviations of the size.
const SHORT: f64 = 0.1;
/// Number of starts, the best by χ², that are followed to their ends.
const MOST_STARTS: usize = 2;
/// Displacements that a start is tried with where the readings give none, over the characteristic length.
const STARTING_DISPLACEMENTS: [f64; 7] = [0.0, 0.5, -0.5, 1.2, -1.2, 2.5, -2.5];
/// Gains that a start is tried with where the readings give none: a reversed sign, and readings in g instead of m/s²
/// and the reverse.
const STARTING_GAINS: [f64; 4] = [1.0, -1.0, 9.806_65, 1.0 / 9.806_65];

/// A mistake that has been fitted.
pub(super) struct SizedFit {
    pub(super) size: Size,
    /// Covariance of the size as [`SizedFault::slopes`] measures it.
    pub(super) covariance: Matrix2<f64>,
    /// The answer without the mistake.
    pub(super) estimate: Estimate<f64>,
}

/// The body of an answer with everything that is attached to the object.
pub(crate) fn whole(layout: &HostLayout, body: &RigidBody<f64>) -> Option<RigidBody<f64>> {
    let attached = layout.attached.iter().map(|body| SVector::from(body.phi));
    RigidBody::from_phi(&attached.fold(body.phi(), |sum, phi| sum + phi))
}

/// Fits a mistake. `without` is the answer without the readings that the mistake changes.
pub(super) fn fit(
    fault: SizedFault,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    without: Option<&Estimate<f64>>,
    room: &mut [f64],
) -> Option<SizedFit> {
    let starts = match linear_start::start(fault, layout, lines) {
        // The equations are linear in the motions, whose errors they do not weigh.
        Some((_, size)) => vec![size, fault.none()],
        None => starts(fault, layout, lines, without, room),
    };
    let starts = match starts.len() {
        0..=MOST_STARTS => starts,
        _ => best_of(&starts, fault, layout, lines, room),
    };
    let fits = starts.iter().filter_map(|start| descend(fault, layout, lines, start, room));
    fits.min_by(|a, b| chi_squared(a).total_cmp(&chi_squared(b)))
}

/// The starts whose fits have the least χ².
fn best_of(
    starts: &[Size],
    fault: SizedFault,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    room: &mut [f64],
) -> Vec<Size> {
    let mut fits: Vec<(f64, Size)> = starts
        .iter()
        .filter_map(|start| {
            let (corrected, readings) = fault.corrected(start, layout, lines)?;
            let (estimate, _) = solve(&corrected, &readings, None, room)?;
            Some((estimate.consistency?.chi_squared, *start))
        })
        .collect();
    fits.sort_by(|a, b| a.0.total_cmp(&b.0));
    fits.into_iter().take(MOST_STARTS).map(|(_, start)| start).collect()
}

fn chi_squared(fit: &SizedFit) -> f64 {
    fit.estimate.consistency.map_or(f64::INFINITY, |consistency| consistency.chi_squared)
}

/// The sizes to start from: the one that the other readings predict, otherwise the likely ones.
fn starts(
    fault: SizedFault,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    without: Option<&Estimate<f64>>,
    room: &mut [f64],
) -> Vec<Size> {
    if let Some(size) = without.and_then(|answer| predicted(fault, layout, lines, answer)) {
        return vec![size];
    }
    match fault {
        SizedFault::NodeCoordinate { node, axis } => {
            let sensors = layout.sensors.iter().map(|sensor| (sensor.node, sensor.position));
            let hits = layout.hits.iter().map(|hit| (hit.dof.node, hit.position));
            let place = sensors.chain(hits).find(|(other, _)| *other == node);
            let written = place.map_or(0.0, |(_, position)| position[axis.index()]);
            let length = layout.characteristic_length();
            let displaced = STARTING_DISPLACEMENTS.map(|over_length| over_length * length);
            // Also with the other sign.
            let displacements = displaced.into_iter().chain([-2.0 * written]);
            displacements.map(|displacement| Vector2::new(displacement, 0.0)).collect()
        }
        SizedFault::HitDisplaced { .. } => vec![fault.none()],
        SizedFault::CommonGain => common_gain(layout, lines, room).into_iter().collect(),
        _ => STARTING_GAINS.map(|gain| Vector2::new(gain, 0.0)).to_vec(),
    }
}

/// The gain of all readings by what is known of the object, beside what the readings alone say of it: masses and
/// moments of inertia are inversely proportional to the gain.
fn common_gain(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    room: &mut [f64],
) -> Option<Size> {
    let known = known_scale(layout)?;
    let without_priors = HostLayout { priors: Default::default(), ..layout.clone() };
    let (estimate, _) = solve(&without_priors, lines, None, room)?;
    let gain = known.value / estimate.theta()[usize::from(known.property)];
    (gain.is_finite() && gain != 0.0).then(|| Vector2::new(gain, 0.0))
}

/// The size for which the readings that the mistake changes are nearest to those of an answer without them.
fn predicted(
    fault: SizedFault,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    answer: &Estimate<f64>,
) -> Option<Size> {
    let body = whole(layout, &answer.body)?;
    let mut information = Matrix2::zeros();
    let mut right = Vector2::zeros();
    for (index, own) in lines {
        let slopes = fault.slopes(layout, &body, *index);
        let readings = layout.accelerance(&body, *index)?;
        for response in 0..3 * layout.sensors.len() {
            if !fault.changes(layout, (*index, response)) {
                continue;
            }
            let slope = Vector2::new(slopes[0][response], slopes[1][response]);
            // The slope of a gain is the whole reading.
            let base = if fault.is_gain() { 0.0 } else { readings[response] };
            information += slope * slope.transpose();
            right += slope * (own.accelerance[response] - base);
        }
    }
    if fault.unknowns() == 1 {
        information[(1, 1)] = 1.0;
    }
    let size = information.try_inverse()? * right;
    size.iter().all(|number| number.is_finite()).then_some(size)
}

/// Steps from a start to the size with the least χ².
fn descend(
    fault: SizedFault,
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    start: &Size,
    room: &mut [f64],
) -> Option<SizedFit> {
    let mut size = *start;
    let mut body = None;
    let length = layout.characteristic_length();
    for _ in 0..MOST_STEPS {
        let (corrected, readings) = fault.corrected(&size, layout, lines)?;
        let (estimate, fitted) = solve(&corrected, &readings, body.as_ref(), room)?;
        let whole = whole(&corrected, &estimate.body)?;
        let slopes = |hit: usize| fault.slopes(&corrected, &whole, hit);
        let (step, covariance) = if fault.unknowns() == 1 {
            let one = |hit: usize| {
                let [first, _] = slopes(hit);
                [first]
            };
            let change = fitted.estimate_changes(&corrected, &readings, one, room)?;
            let covariance = Matrix2::new(change.covariance[0], 0.0, 0.0, 0.0);
            (Vector2::new(change.sizes[0], 0.0), covariance)
        } else {
            let change = fitted.estimate_changes(&corrected, &readings, slopes, room)?;
            (change.sizes, change.covariance)
        };
        let sigmas = (0..fault.unknowns()).map(|k| step[k].abs() / covariance[(k, k)].sqrt());
        if sigmas.fold(0.0, f64::max) < SHORT {
            return Some(SizedFit { size, covariance, estimate });
        }
        size = fault.advanced(&size, &step, length);
        body = Some(estimate.body);
    }
    None
}

/// The answer under the stated budget, and the fit that has it.
fn solve(
    layout: &HostLayout,
    lines: &[DofMassLines<f64, Unbounded>],
    start: Option<&RigidBody<f64>>,
    room: &mut [f64],
) -> Option<(Estimate<f64>, Fit<f64>)> {
    let starts = start.map(Start::At).into_iter().chain([Start::InertiaRestraint]);
    starts.into_iter().find_map(|start| {
        let mut fit = Fit::start(layout, lines, start, ErrorBudget::Stated).ok()?;
        while fit.step(layout, lines, room).ok()? == Progress::Going {}
        let estimate = fit.answer(layout, room).ok()?;
        Some((estimate, fit))
    })
}
