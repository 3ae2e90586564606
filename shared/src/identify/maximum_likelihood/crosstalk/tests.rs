use std::vec::Vec;

use super::super::learning::tests::{Normal, calibrated, drawn_through};
use super::super::{BudgetScales, ErrorBudget, RIG_WORKSPACE, Start, solve};
use super::*;
use crate::capacity::Rig;
use crate::layout::tests::bar_body;

/// What is found in 40 tests through a chain that changes the accelerances.
fn find_crosstalk(
    budget: ErrorBudget,
    chain: impl Fn(&mut Responses<f64, Rig>, f64),
) -> Vec<Option<Diagnostic>> {
    let (layout, body, mut normal) = (calibrated(), bar_body(), Normal::new());
    let mut memory = [0.0; RIG_WORKSPACE];
    let mut one = || {
        let dofs = drawn_through(&layout, &body, BudgetScales::default(), &mut normal, &chain);
        let solution = solve(&layout, &dofs, Start::InertiaRestraint, budget, &mut memory).unwrap();
        let mut diagnostics = solution.estimate.diagnostics.into_iter();
        diagnostics
            .find(|d| matches!(d.code, Code::HammerInResponse | Code::MultiplexerKeepsVoltage))
    };
    (0..40).map(|_| one()).collect()
}

#[test]
fn nothing_is_found_in_a_healthy_chain() {
    for budget in [ErrorBudget::Stated, ErrorBudget::Learned] {
        let suspected = find_crosstalk(budget, |_, _| ()).into_iter().flatten().count();
        // Chance suspects one in 300, so two of forty in one of a hundred.
        assert!(suspected <= 1, "{suspected} of {budget:?}");
    }
}

#[test]
fn a_part_of_the_hammer_is_named_with_its_size() {
    const PART: f64 = 0.15;
    for budget in [ErrorBudget::Stated, ErrorBudget::Learned] {
        let diagnostics = find_crosstalk(budget, |a, _| a[3] += PART);
        let named: Vec<_> = diagnostics.into_iter().flatten().collect();
        // The part is about eight of its standard deviations.
        assert!(named.len() >= 36, "{} of {budget:?}", named.len());
        for one in named {
            assert_eq!(one.subject, Subject::Channel(4));
            // Found to three of its standard deviations.
            assert!((f64::from(one.value) - PART).abs() < 0.5 * PART, "{one:?}");
        }
    }
}

#[test]
fn a_memory_of_the_multiplexer_is_named_with_its_size() {
    const PART: f64 = 0.015;
    for stride in STRIDES {
        let diagnostics = find_crosstalk(ErrorBudget::Learned, |a, _| {
            let before = channels_before(a, 9, stride);
            a.add_multiple(&before, PART);
        });
        let named: Vec<_> = diagnostics.into_iter().flatten().collect();
        assert_eq!(named.len(), 40, "stride {stride}");
        for one in named {
            // The part is about seven of its standard deviations.
            assert_eq!(one.code, Code::MultiplexerKeepsVoltage, "{one:?}");
            assert!((f64::from(one.value) - PART).abs() < 0.5 * PART, "{one:?}");
        }
    }
}

#[test]
fn every_channel_follows_one_of_its_converter() {
    let numbered = Responses::<f64, Rig>::from_fn(3, |k| (1 + k) as f64);
    let before = |responses, stride| -> Vec<f64> {
        channels_before(&numbered, responses, stride).iter().copied().collect()
    };
    assert_eq!(before(9, 1), [HAMMER, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]);
    // Channel 1 follows channel 9 of the scan before.
    assert_eq!(before(9, 2), [9.0, HAMMER, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    assert_eq!(before(6, 2), [5.0, HAMMER, 1.0, 2.0, 3.0, 4.0, 0.0, 0.0, 0.0]);
}
