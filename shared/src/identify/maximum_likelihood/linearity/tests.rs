use std::vec::Vec;

use super::super::learning::tests::{Normal, calibrated, drawn_through};
use super::super::tests::Dofs;
use super::super::{BudgetScales, ErrorBudget, RIG_WORKSPACE, Start, solve};
use super::*;
use crate::capacity::Rig;
use crate::layout::tests::bar_body;
use crate::responses::Responses;

/// The channel that is named, and the change of its largest reading.
fn find_trend(dofs: &Dofs<f64>) -> Option<(Subject, f64)> {
    let (layout, mut memory) = (calibrated(), [0.0; RIG_WORKSPACE]);
    let start = Start::InertiaRestraint;
    let solution = solve(&layout, dofs, start, ErrorBudget::Learned, &mut memory).unwrap();
    let mut diagnostics = solution.estimate.diagnostics.into_iter();
    let named = diagnostics.find(|d| d.code == Code::ChannelNotLinear)?;
    Some((named.subject, named.value.into()))
}

/// Tests through a chain that changes the accelerances of a hit of this force.
fn tests(chain: impl Fn(&mut Responses<f64, Rig>, f64)) -> Vec<Dofs<f64>> {
    let (layout, body, mut normal) = (calibrated(), bar_body(), Normal::new());
    let scales = BudgetScales::default();
    (0..40).map(|_| drawn_through(&layout, &body, scales, &mut normal, &chain)).collect()
}

#[test]
fn a_linear_chain_is_not_suspected() {
    let suspected = tests(|_, _| ()).iter().filter(|dofs| find_trend(dofs).is_some()).count();
    // Chance suspects one in two hundred, so three of forty in one of a thousand.
    assert!(suspected <= 2, "{suspected}");
}

#[test]
fn a_channel_that_compresses_is_named_with_its_loss() {
    // 5 % at 80 m/s².
    let lost = |reading: f64| 0.05 * (reading / 80.0).powi(2);
    let all_dofs = tests(|a, force| a[2] *= 1.0 - lost(a[2] * force));
    let mut ratios = Vec::new();
    for dofs in all_dofs {
        let (channel, change) = find_trend(&dofs).expect("a trend");
        assert_eq!(channel, Subject::Channel(3));
        let largest = dofs.iter().map(|(_, lines)| lines.accelerance[2].abs()).fold(0.0, f64::max);
        // The mean square of forces of 14 to 22 N is 329 N².
        let expected = -lost(largest * 329_f64.sqrt());
        ratios.push(change / expected);
    }
    ratios.sort_by(f64::total_cmp);
    // The loss is known to a fifth, and comes out a third larger, because the compressed reading is cubed.
    assert!(ratios[0] > 0.4 && ratios[39] < 2.2, "{ratios:?}");
    assert!(ratios[20] > 0.9 && ratios[20] < 1.5, "{ratios:?}");
}

#[test]
fn a_hammer_that_compresses_is_named() {
    // A hammer that reads 4 % too little at 18 N makes accelerances too large.
    let all_dofs = tests(|a, force| *a *= 1.0 + 0.04 * (force / 18.0).powi(2));
    for dofs in all_dofs {
        let (channel, change) = find_trend(&dofs).expect("a trend");
        assert!(channel == Subject::Channel(0) && change < -0.02, "{channel:?} {change}");
    }
}

#[test]
fn hits_of_equal_force_show_nothing() {
    let mut dofs = tests(|a, force| a[2] *= 1.0 - 1e-4 * force * force).remove(0);
    for (_, lines) in &mut dofs {
        lines.trend.squares = 0.0;
    }
    assert_eq!(find_trend(&dofs), None);
}

/// Of nine loud responses the five loudest are tested, whatever their numbers.
#[test]
fn the_loudest_responses_are_tested_first() {
    let order_of = |largest: [f64; 9]| {
        let trends = largest.map(|largest| Trend { largest, ..Trend::none() });
        loudest(&trends).to_vec()
    };
    assert_eq!(order_of([1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7, 1.8]), [8, 7, 6, 5, 4]);
    // Those below half of the loudest are not.
    assert_eq!(order_of([9.0, 1.0, 4.0, 5.0, 0.0, 8.0, f64::NAN, 2.0, 4.5]), [0, 5, 3, 8]);
    assert_eq!(order_of([f64::NAN; 9]), Vec::<usize>::new());
}
