use std::vec::Vec;

use super::super::learning::tests::{Normal, calibrated, drawn_through};
use super::super::tests::Dofs;
use super::super::{BudgetScales, ErrorBudget, RIG_WORKSPACE, Start, solve};
use super::*;
use crate::layout::tests::bar_body;
use crate::responses::Responses;

fn found(dofs: &Dofs<f64>) -> Option<NonlinearChannel<f64>> {
    let (layout, mut memory) = (calibrated(), [0.0; RIG_WORKSPACE]);
    let start = Start::InertiaRestraint;
    let solution = solve(&layout, dofs, start, ErrorBudget::Learned, &mut memory).unwrap();
    nonlinear_channel(&layout, dofs, &solution.estimate)
}

/// Tests through a chain that changes the accelerances of a hit of this force.
fn tests(chain: impl Fn(&mut Responses<f64, 3>, f64)) -> Vec<Dofs<f64>> {
    let (layout, body, mut normal) = (calibrated(), bar_body(), Normal::new());
    let scales = BudgetScales::default();
    (0..40).map(|_| drawn_through(&layout, &body, scales, &mut normal, &chain)).collect()
}

#[test]
fn a_linear_chain_is_not_suspected() {
    let suspected = tests(|_, _| ()).iter().filter(|dofs| found(dofs).is_some()).count();
    // Chance suspects one in 1600, so two of forty in one of three thousand.
    assert!(suspected <= 1, "{suspected}");
}

#[test]
fn a_channel_that_compresses_is_named_with_its_loss() {
    // 5 % at 80 m/s².
    let lost = |reading: f64| 0.05 * (reading / 80.0).powi(2);
    let all = tests(|a, force| a[2] *= 1.0 - lost(a[2] * force));
    for dofs in all {
        let found = found(&dofs).expect("a trend");
        assert_eq!(found.response, Some(2));
        let largest = dofs.iter().map(|(_, lines)| lines.accelerance[2].abs()).fold(0.0, f64::max);
        // The mean square of forces of 14 to 22 N is 329 N². The loss is known to one part in `significance`.
        let expected = -lost(largest * 329_f64.sqrt());
        let sigma = (found.change / found.significance).abs();
        assert!(
            (found.change - expected).abs() < 5.0 * sigma + 0.1 * expected.abs(),
            "{found:?} {expected}"
        );
    }
}

#[test]
fn a_hammer_that_compresses_is_named() {
    // A hammer that reads 4 % too little at 18 N makes accelerances too large.
    let all = tests(|a, force| *a *= 1.0 + 0.04 * (force / 18.0).powi(2));
    for dofs in all {
        let found = found(&dofs).expect("a trend");
        assert!(found.response.is_none() && found.change < -0.02, "{found:?}");
    }
}

#[test]
fn hits_of_equal_force_show_nothing() {
    let mut dofs = tests(|a, force| a[2] *= 1.0 - 1e-4 * force * force).remove(0);
    for (_, lines) in &mut dofs {
        lines.trend.squares = 0.0;
    }
    assert_eq!(found(&dofs), None);
}
