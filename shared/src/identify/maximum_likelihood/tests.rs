use nalgebra::{SVector, Vector3};
use std::vec::Vec;

use super::*;
use crate::capacity::{Rig, Unbounded};
use crate::diagnosis::Subject;
use crate::estimated::EstimatedValue;
use crate::identify::MassLines;
use crate::layout::tests::{bar_body, bar_layout};
use crate::layout::{AttachedBody, Hit, HitUncertainty, Prior, SensorUncertainty};
use crate::responses::{ResponseSquare, Responses};

pub(in crate::identify) type Dofs<R> = Vec<DofMassLines<R, Rig>>;
pub(in crate::identify) type Bar<R> = Layout<R, Rig>;

/// The three-bar frame with five hits, and small errors.
pub(in crate::identify) fn five_hits() -> Bar<f64> {
    let mut layout: Bar<f64> = bar_layout().cast().unwrap();
    let [middle, end] = [layout.hits[0].position, layout.hits[2].position];
    let across = [("4:+Y", end, [0.0, 1.0, 0.0]), ("1:+Z", middle, [0.0, 0.0, 1.0])];
    for (name, position, direction) in across {
        layout.hits.push(Hit::new(name.parse().unwrap(), position, direction)).unwrap();
    }
    layout
}

/// Exact mass lines of a body; the noise is a thousandth of a reading of 1 (m/s²)/N.
pub(in crate::identify) fn exact(layout: &Layout<f64, Rig>, body: &RigidBody<f64>) -> Dofs<f64> {
    (0..layout.hits.len())
        .map(|j| {
            let readings = layout.accelerance(body, j).unwrap();
            let mut lines = MassLines::without_scatter(readings);
            let used = 3 * layout.sensors.len();
            lines.noise = Responses::from_fn(3, |k| if k < used { 1e-3 } else { 0.0 });
            lines.hits = 5;
            (j, lines)
        })
        .collect()
}

pub(in crate::identify) fn fit<R: Real>(
    layout: &Layout<R, Rig>,
    dofs: &Dofs<R>,
    start: Option<&RigidBody<R>>,
) -> Result<MaximumLikelihoodSolution<R, Rig>, Diagnostics> {
    solve(
        layout,
        dofs,
        start.map_or(Start::Crude, Start::At),
        ErrorBudget::FirstOrder,
        &mut [R::zero(); RIG_WORKSPACE],
    )
}

/// Largest error over [m, L, L, L, m L² × 6].
pub(in crate::identify) fn worst(got: &RigidBody<f64>, truth: &RigidBody<f64>, length: f64) -> f64 {
    let scale = |k: usize| match k {
        0 => truth.mass,
        1..4 => length,
        _ => truth.mass * length * length,
    };
    (got.theta() - truth.theta())
        .iter()
        .enumerate()
        .map(|(k, e)| e.abs() / scale(k))
        .fold(0.0, f64::max)
}

fn codes(diagnostics: &Diagnostics) -> Vec<Code> {
    diagnostics.iter().map(|d| d.code).collect()
}

#[test]
fn exact_readings_give_the_body_from_a_crude_start() {
    let (layout, body) = (five_hits(), bar_body());
    let solution = fit(&layout, &exact(&layout, &body), None).unwrap();
    // The last step is below 1e-5 standard deviations, which are near 1 % here.
    assert!(worst(&solution.estimate.body, &body, 0.14) < 1e-6);
    assert!(solution.estimate.consistency.unwrap().chi_squared < 1e-6);
    assert!(solution.estimate.diagnostics.is_empty());
}

#[test]
fn any_number_of_sensors_and_hits_is_solved() {
    let (few, body) = (five_hits(), bar_body());
    let mut layout: Layout<f64, Unbounded> = few.cast().unwrap();
    // More than a rig has room for; each a little beside the one before it.
    let aside = |k: usize| [0.0, 1.0, 2.0].map(|axis| 0.05 * (k as f64 + axis).sin());
    for k in 0..17 {
        let mut sensor = few.sensors[k % 3];
        sensor.node = 10 + k as u16;
        sensor.position = core::array::from_fn(|axis| sensor.position[axis] + aside(k)[axis]);
        layout.sensors.push(sensor);
    }
    for k in 0..35 {
        let mut hit = few.hits[k % 5];
        hit.dof.node = 10 + k as u16;
        hit.position = core::array::from_fn(|axis| hit.position[axis] + aside(3 * k)[axis]);
        layout.hits.push(hit);
    }
    let of_hit = |hit: usize| {
        let lines = MassLines::without_scatter(layout.accelerance(&body, hit).unwrap());
        (hit, MassLines { hits: 5, ..lines.with_noise(Responses::repeat(20, 1e-3)) })
    };
    let dofs: Vec<_> = (0..40).map(of_hit).collect();
    let mut memory = std::vec![0.0; workspace(20, 40)];
    let mut solved = |dofs: &[_]| {
        solve(&layout, dofs, Start::InertiaRestraint, ErrorBudget::FirstOrder, &mut memory)
    };
    let estimate = solved(&dofs).unwrap().estimate;
    // As from five hits; more data leave less uncertainty.
    assert!(worst(&estimate.body, &body, 0.14) < 1e-6);
    let five = fit(&few, &exact(&few, &body), None).unwrap().estimate.sigma().unwrap();
    assert!(estimate.sigma().unwrap().iter().zip(&five).all(|(more, five)| more < five));
    // Lines for another number of sensors are refused.
    let mut wrong = dofs.clone();
    wrong[7].1 = wrong[7].1.resized(19);
    assert_eq!(codes(&solved(&wrong).unwrap_err()), [Code::FrfMissing]);
}

#[test]
fn two_sensors_and_three_on_a_line_are_enough() {
    let body = bar_body();
    let mut two = five_hits();
    two.sensors.truncate(2);
    let mut in_line = five_hits();
    let [a, b] = [in_line.sensors[0].position, in_line.sensors[1].position];
    in_line.sensors[2].position = core::array::from_fn(|k| 0.3 * a[k] + 0.7 * b[k]);
    let whole = fit(&five_hits(), &exact(&five_hits(), &body), None).unwrap();
    for layout in [two, in_line] {
        let solution = fit(&layout, &exact(&layout, &body), None).unwrap();
        assert!(worst(&solution.estimate.body, &body, 0.14) < 1e-6);
        let (fewer, more) = (solution.estimate.sigma().unwrap(), whole.estimate.sigma().unwrap());
        assert!(fewer.iter().zip(more.iter()).all(|(f, m)| f > &(m * 0.99)), "{fewer} {more}");
    }
}

#[test]
fn one_sensor_two_hits_and_concurrent_hits_have_no_answer() {
    let body = bar_body();
    let mut one = five_hits();
    one.sensors.truncate(1);
    let mut two_hits = five_hits();
    two_hits.hits.truncate(2);
    let mut concurrent = five_hits();
    for hit in concurrent.hits.iter_mut() {
        hit.position = [0.2, -0.2, 0.1];
    }
    for (layout, code) in [
        (one, Code::TenParametersNotIdentifiable),
        (two_hits, Code::FewerThanThreeHits),
        (concurrent, Code::HitsConcurrent),
    ] {
        let diagnostics = fit(&layout, &exact(&layout, &body), None).unwrap_err();
        assert!(codes(&diagnostics).contains(&code), "{code:?}: {diagnostics:?}");
    }
}

#[test]
fn nuisance_parameters_are_found_with_their_sign() {
    let (mut layout, body) = (five_hits(), bar_body());
    // All other errors are so small that they cannot explain the data, and the prior of the tested error
    // source is so wide that it does not hold it back.
    let sure = SensorUncertainty { position: 1e-6, rotation: 1e-6, gain: 1e-6, cross_axis: 1e-6 };
    layout.sensors.iter_mut().for_each(|s| s.uncertainty = sure);
    layout.hits.iter_mut().for_each(|h| h.uncertainty = HitUncertainty::none());
    layout.apparatus.hammer_gain = 1e-6;
    let fit_nuisances =
        |layout: &Bar<f64>, dofs: &Dofs<f64>| fit(layout, dofs, Some(&body)).unwrap().nuisances;
    // The tolerance covers the pull of the prior and the second order of an error of half a per cent.
    let close = |estimated: EstimatedValue<f64>, truth: f64| {
        assert!((estimated.value - truth).abs() < 0.05 * truth.abs(), "{estimated:?} {truth}");
        assert!(estimated.sigma > 0.0);
    };

    let mut layout_of = layout.clone();
    layout_of.sensors[1].uncertainty.gain = 0.1;
    let mut dofs = exact(&layout, &body);
    dofs.iter_mut().for_each(|(_, lines)| lines.accelerance[4] *= 1.005);
    close(fit_nuisances(&layout_of, &dofs).sensors[1].sensitivity[1][1], 0.005);

    let mut layout_of = layout.clone();
    layout_of.sensors[2].uncertainty.rotation = 0.1;
    let turn = nalgebra::Rotation3::new(Vector3::new(0.0, 0.0, -0.005));
    let mut dofs = exact(&layout, &body);
    for (_, lines) in &mut dofs {
        let turned = turn * Vector3::from(lines.accelerance.of_sensor(2));
        lines.accelerance.set_sensor(2, turned.into());
    }
    close(fit_nuisances(&layout_of, &dofs).sensors[2].rotation[2], 0.005);

    let mut layout_of = layout.clone();
    layout_of.sensors[0].uncertainty.position = 0.1;
    let mut displaced = layout.clone();
    displaced.sensors[0].position[2] += 0.002;
    close(fit_nuisances(&layout_of, &exact(&displaced, &body)).sensors[0].position[2], 0.002);

    let mut layout_of = layout.clone();
    layout_of.hits[3].uncertainty.position = 0.1;
    let mut displaced = layout.clone();
    displaced.hits[3].position[0] += 0.002;
    close(fit_nuisances(&layout_of, &exact(&displaced, &body)).hits[3].position[0], 0.002);

    let mut layout_of = layout.clone();
    layout_of.apparatus.hammer_gain = 0.1;
    layout_of.priors.push(Prior { property: 0, value: body.mass, sigma: 1e-6 }).unwrap();
    let mut dofs = exact(&layout, &body);
    dofs.iter_mut().for_each(|(_, lines)| lines.accelerance *= 1.0 / 1.01);
    close(fit_nuisances(&layout_of, &dofs).hammer_gain, 0.01);
}

#[test]
fn what_hangs_on_the_object_is_subtracted() {
    let (mut layout, body) = (five_hits(), bar_body());
    let point = AttachedBody::point(0.2, 1e-6, [0.1, 0.05, -0.02]);
    let adapter = AttachedBody::point(0.1, 0.1, [0.2, -0.2, 0.1]);
    let whole = body.phi() + SVector::from(point.phi) + SVector::from(adapter.phi);
    let dofs = exact(&layout, &RigidBody::from_phi(&whole).unwrap());
    layout.attached.extend([point, adapter]);
    let solution = fit(&layout, &dofs, None).unwrap().estimate;
    assert!(worst(&solution.body, &body, 0.14) < 1e-6);
    // The mass of the adapter is known only to 10 g.
    layout.attached[1].relative_sigma = 0.0;
    let exact = fit(&layout, &dofs, None).unwrap().estimate;
    let variance = |e: &Estimate<f64>| e.covariance.unwrap()[(0, 0)];
    let added = variance(&solution) - variance(&exact);
    // The weights depend slightly on the body.
    assert!((added.sqrt() - 0.01).abs() < 1e-4, "{added}");
}

#[test]
fn a_known_mass_narrows_the_answer() {
    let (mut layout, body) = (five_hits(), bar_body());
    let dofs = exact(&layout, &body);
    let without = fit(&layout, &dofs, None).unwrap().estimate.sigma().unwrap();
    layout.priors.push(Prior { property: 0, value: body.mass, sigma: 0.001 }).unwrap();
    let with = fit(&layout, &dofs, None).unwrap().estimate.sigma().unwrap();
    assert!(with[0] < 0.001 && with.iter().zip(without.iter()).all(|(a, b)| a < b));
}

#[test]
fn a_body_that_cannot_be_is_replaced_by_one_that_can() {
    let (mut layout, body) = (five_hits(), bar_body());
    layout.hits.iter_mut().for_each(|h| h.uncertainty = HitUncertainty::none());
    // A flat body, and one slightly beyond that.
    let mut theta = body.theta();
    for k in 4..10 {
        theta[k] = [2e-3, 0.01, 0.0125, 0.0, 0.0, 0.0][k - 4];
    }
    let flat = RigidBody::from_theta(&theta);
    assert!(!flat.is_physically_consistent());
    let solution = fit(&layout, &exact(&layout, &flat), Some(&flat)).unwrap().estimate;
    assert!(solution.body.is_physically_consistent());
    assert!(codes(&solution.diagnostics).contains(&Code::HeldToConsistency));
    assert!(worst(&solution.body, &flat, 0.14) < 0.05);
}

#[test]
fn single_precision_agrees_to_a_hundredth_of_a_standard_deviation() {
    let (layout, body) = (five_hits(), bar_body());
    let mut dofs = exact(&layout, &body);
    // Errors of the size of the budget, so that the weights matter.
    for (j, lines) in &mut dofs {
        for (i, value) in lines.accelerance.iter_mut().enumerate() {
            *value += 0.01 * ((7 * i + 13 * *j) as f64).sin();
        }
    }
    let single: Dofs<f32> = dofs
        .iter()
        .map(|(j, l)| (*j, MassLines { scatter: ResponseSquare::zeros(3), ..l.cast() }))
        .collect();
    let wide = fit(&layout, &dofs, None).unwrap().estimate;
    let narrow = fit(&layout.cast::<f32, Rig>().unwrap(), &single, None).unwrap().estimate;
    let sigma = wide.sigma().unwrap();
    for k in 0..10 {
        let difference = f64::from(narrow.theta()[k]) - wide.theta()[k];
        // The project's bound for the device.
        assert!(difference.abs() < 0.01 * sigma[k], "{k}: {difference} of {}", sigma[k]);
        assert!((f64::from(narrow.sigma().unwrap()[k]) / sigma[k] - 1.0).abs() < 0.01);
    }
}

#[test]
fn data_that_contradict_the_budget_say_where() {
    let (layout, body) = (five_hits(), bar_body());
    let mut displaced = layout.clone();
    // Ten times the usual position error of a hit.
    displaced.hits[2].position[1] += 0.04;
    let solution = fit(&layout, &exact(&displaced, &body), None).unwrap();
    let diagnostics = &solution.estimate.diagnostics;
    assert!(codes(diagnostics).contains(&Code::DataInconsistentWithBudget), "{diagnostics:?}");
    let suspect = diagnostics.iter().find(|d| d.code == Code::LargeHitPull).unwrap();
    assert_eq!(suspect.subject, Subject::Hit(2));
}

#[test]
fn mass_lines_that_are_not_finite_or_absent_are_refused() {
    let (layout, body) = (five_hits(), bar_body());
    for spoil in [
        |l: &mut MassLines<f64, Rig>| l.accelerance[3] = f64::NAN,
        |l: &mut MassLines<f64, Rig>| l.noise[0] = f64::INFINITY,
    ] {
        let mut dofs = exact(&layout, &body);
        spoil(&mut dofs[1].1);
        let diagnostics = fit(&layout, &dofs, None).unwrap_err();
        assert_eq!(codes(&diagnostics), [Code::DataNotFinite]);
    }
    assert!(fit(&layout, &Vec::new(), None).is_err());
    let dofs = exact(&layout, &body);
    assert!(solve(&layout, &dofs, Start::Crude, ErrorBudget::FirstOrder, &mut [0.0; 100]).is_err());
}

#[test]
fn what_hangs_on_the_object_cannot_outweigh_it() {
    let (mut layout, body) = (five_hits(), bar_body());
    let dofs = exact(&layout, &body);
    layout.attached.push(AttachedBody::point(5.0, 0.01, [0.1, -0.05, 0.0])).unwrap();
    let diagnostics = fit(&layout, &dofs, Some(&body)).unwrap_err();
    assert!(codes(&diagnostics).contains(&Code::AttachedTooHeavy), "{diagnostics:?}");
}
