//! `b_ml_` and `b_mlfull_`: maximum likelihood with noise, with errors of the hits, and with the complete
//! error budget.

use massline_shared::Real;
use massline_shared::body::RigidBody;
use massline_shared::identify::inertia_restraint::{self, ReferencePoint};
use massline_shared::identify::maximum_likelihood::{
    ErrorBudget, RIG_WORKSPACE, Start, bound, readings_covariance, solve,
};
use massline_shared::identify::{HALF_WIDTH_95, MassLines};
use massline_shared::layout::{HitUncertainty, Prior, SensorUncertainty};
use nalgebra::SVector;

use crate::Check;
use crate::inertia_restraint::column;
use crate::layout::{GoldenDofs, GoldenLayout, GoldenResponses, RESPONSES, SENSORS};

/// Maximum likelihood with the standard deviations of all responses and of the hits.
pub(crate) fn run<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let mut layout = exact_layout(check)?;
    let hits = hit_errors(check, "hit_error", &mut layout).unwrap_or(1);
    add_priors(check, &mut layout);
    let mut dofs = GoldenDofs::new();
    for index in 0..layout.hits.len() {
        let accelerance = column(check, "H", layout.hits.len(), index)?;
        let noise = column(check, "sigma", layout.hits.len(), index)?;
        let lines = MassLines { noise, hits, ..MassLines::without_scatter(accelerance) };
        dofs.push((index, lines)).ok()?;
    }
    answer(check, &layout, &dofs)?;
    let noise = |index: usize| dofs[index].1.noise.clone();
    let truth = RigidBody::from_theta(&SVector::from(check.input_array::<10>("theta_true")?));
    let mut memory = [R::zero(); RIG_WORKSPACE];
    let at_truth = bound(&layout, &truth, noise, hits, &mut memory)?;
    check.numbers("crlb_sd_at_truth", at_truth.sigma().as_slice());
    Some(())
}

/// Maximum likelihood with the complete error budget.
pub(crate) fn run_full<R: Real>(check: &mut Check<'_, '_, R>) -> Option<()> {
    let mut layout = exact_layout(check)?;
    let hits = hit_errors(check, "budget", &mut layout)?;
    for sensor in &mut layout.sensors {
        sensor.uncertainty = SensorUncertainty {
            position: check.input_number("budget.sig_pos")?,
            rotation: check.input_number("budget.sig_rot")?,
            gain: check.input_number("budget.sig_gain")?,
            cross_axis: check.input_number("budget.sig_cross")?,
        };
    }
    layout.apparatus.hammer_gain = check.input_number("budget.sig_hammer").unwrap_or(R::zero());
    let sigma = check.input_number("budget.sigma")?;
    let mut dofs = GoldenDofs::new();
    for index in 0..layout.hits.len() {
        let accelerance = column(check, "H", layout.hits.len(), index)?;
        let noise = GoldenResponses::repeat(SENSORS, sigma);
        let lines = MassLines { noise, hits, ..MassLines::without_scatter(accelerance) };
        dofs.push((index, lines)).ok()?;
    }
    answer(check, &layout, &dofs)?;
    let truth = RigidBody::from_theta(&SVector::from(check.input_array::<10>("theta_true")?));
    let (mut diagonal, mut first_row) =
        (heapless::Vec::<R, 36>::new(), heapless::Vec::<R, 36>::new());
    for index in 0..layout.hits.len() {
        let (_, lines) = dofs.get(index)?;
        let block = readings_covariance(&layout, &truth, (index, lines), index)?;
        diagonal.extend_from_slice(block.diagonal().as_slice()).ok()?;
        let (_, first) = dofs.first()?;
        let block = readings_covariance(&layout, &truth, (0, first), index)?;
        first_row.extend((0..RESPONSES).map(|k| block[(0, k)]));
    }
    check.numbers("cov_total_at_truth_diag", &diagonal);
    check.numbers("cov_total_at_truth_first_row", &first_row);
    Some(())
}

fn answer<R: Real>(
    check: &mut Check<'_, '_, R>,
    layout: &GoldenLayout<R>,
    dofs: &GoldenDofs<R>,
) -> Option<()> {
    let mut memory = [R::zero(); RIG_WORKSPACE];
    let start = inertia_restraint::solve(layout, dofs, ReferencePoint::Centroid).ok()?;
    let solution =
        solve(layout, dofs, Start::At(&start.body), ErrorBudget::FirstOrder, &mut memory).ok()?;
    let estimate = &solution.estimate;
    let (theta, sigma) = (estimate.theta(), estimate.sigma()?);
    check.numbers("theta", theta.as_slice());
    check.numbers("sd", sigma.as_slice());
    let mut interval = heapless::Vec::<R, 20>::new();
    for (value, sigma) in theta.iter().zip(sigma.iter()) {
        let half = *sigma * R::of(HALF_WIDTH_95);
        interval.extend_from_slice(&[*value - half, *value + half]).ok()?;
    }
    check.numbers("ci95", &interval);
    let consistency = estimate.consistency?;
    check.numbers("cost", &[consistency.chi_squared]);
    check.numbers("chi2_red", &[consistency.reduced()]);
    Some(())
}

/// The layout without any errors.
fn exact_layout<R: Real>(check: &Check<'_, '_, R>) -> Option<GoldenLayout<R>> {
    let mut layout = check.layout()?;
    layout.set_exact();
    Some(layout)
}

/// Sets the errors of the hits from this name of the inputs; returns how many hits are averaged.
fn hit_errors<R: Real>(
    check: &Check<'_, '_, R>,
    name: &str,
    layout: &mut GoldenLayout<R>,
) -> Option<u16> {
    let number = |key: &str| {
        let mut path = heapless::String::<32>::new();
        path.push_str(name).ok()?;
        path.push('.').ok()?;
        path.push_str(key).ok()?;
        check.input_number(&path)
    };
    let (position, direction) = (number("sig_q")?, number("sig_d")?);
    for hit in &mut layout.hits {
        hit.uncertainty = HitUncertainty { position, direction, ..HitUncertainty::none() };
    }
    Some(number("n_hits")?.to_f64() as u16)
}

fn add_priors<R: Real>(check: &Check<'_, '_, R>, layout: &mut GoldenLayout<R>) {
    let fields = ["index", "mean", "sigma"].map(|key| {
        let mut path = heapless::String::<32>::new();
        let _ = path.push_str("prior.");
        let _ = path.push_str(key);
        check.input_number(&path)
    });
    if let [Some(index), Some(value), Some(sigma)] = fields {
        // A case has at most one prior.
        let _ = layout.priors.push(Prior { property: index.to_f64() as u8, value, sigma });
    }
}
