use nalgebra::SVector;

use super::*;
use crate::identify::random_signs;
use crate::layout::Layout;

/// What a method adds to the truth: its own bias, and how much of the noise that all share and of its own it has.
#[derive(Clone, Copy)]
struct Answerer {
    bias: f64,
    shared: f64,
    own: f64,
}

const fn answerer(bias: f64, shared: f64, own: f64) -> Answerer {
    Answerer { bias, shared, own }
}

/// Answers of these methods to a property that is 5, and what draws of noise show of their covariance.
fn compared<const M: usize>(methods: [Answerer; M]) -> ([f64; M], Option<Agreement<f64>>) {
    // Without sensors and hits there are no errors of a layout.
    let layout = Layout::<f64, crate::capacity::Rig>::default();
    let noise = |draw: Option<u32>, place: usize| {
        draw.map_or(0.0, |draw| f64::from(random_signs(draw, place)[0]))
    };
    let answers_with = |draw: Option<u32>| -> [Option<SVector<f64, 10>>; M] {
        core::array::from_fn(|m| {
            let Answerer { bias, shared, own } = methods[m];
            // Every property has noise of its own, and the same bias.
            Some(SVector::<f64, 10>::from_fn(|k, _| {
                5.0 + bias + shared * noise(draw, k) + own * noise(draw, 10 * (m + 1) + k)
            }))
        })
    };
    let answers =
        (0..changes(&layout)).map(|change| ask(&layout, change, |of_it| answers_with(of_it.draw)));
    let propagation = Propagation::of(answers);
    let agreement = Agreement::of(&answers_with(None), &propagation);
    (methods.map(|method| 5.0 + method.bias), agreement)
}

#[test]
fn methods_that_differ_by_chance_are_weighted_by_their_noise() {
    // Independent noise of 1, 1 and 2 gives weights of 4/9, 4/9 and 1/9.
    let three = [answerer(0.9, 0.0, 1.0), answerer(0.0, 0.0, 1.0), answerer(-0.9, 0.0, 2.0)];
    let agreement = compared(three).1.unwrap();
    assert_eq!(agreement.outcome(), Outcome::Agree);
    assert_eq!(agreement.between.amax(), 0.0);
    // The covariance of 200 draws has correlations of 1/sqrt(200) = 7 % by chance, on biases of 0.9.
    assert!((agreement.theta[3] - 5.3).abs() < 0.15, "{}", agreement.theta);
    assert!((agreement.covariance[(3, 3)].sqrt() - 2.0 / 3.0).abs() < 0.1);
}

#[test]
fn one_method_of_three_that_is_off_is_left_out() {
    let three = [answerer(0.0, 0.2, 0.1), answerer(0.0, 0.2, 0.1), answerer(4.0, 0.2, 0.1)];
    let agreement = compared(three).1.unwrap();
    assert_eq!(agreement.outcome(), Outcome::SomeOff);
    assert!(agreement.largest().is_some_and(|largest| largest.significant));
    assert_eq!(agreement.outliers[..], [2]);
    assert!((agreement.theta[0] - 5.0).abs() < 1e-12 && agreement.between.amax() == 0.0);
}

#[test]
fn two_methods_of_five_with_one_cause_are_named_together() {
    let good = answerer(0.0, 0.2, 0.1);
    let five = [good, answerer(3.0, 0.2, 0.1), good, answerer(3.05, 0.2, 0.1), good];
    let agreement = compared(five).1.unwrap();
    assert_eq!(agreement.outliers[..], [1, 3]);
    assert!((agreement.theta[0] - 5.0).abs() < 1e-12);
    // Two against two say nothing of who is off.
    let four = [good, answerer(3.0, 0.2, 0.1), good, answerer(3.0, 0.2, 0.1)];
    let agreement = compared(four).1.unwrap();
    assert_eq!(agreement.outcome(), Outcome::Differ);
}

#[test]
fn where_methods_disagree_the_combined_answer_lies_among_them_and_its_interval_contains_them() {
    // Noise that both share makes the best weights without a difference 2 and -1.
    for methods in [
        [answerer(0.0, 1.0, 0.01), answerer(6.0, 2.0, 0.01)],
        [answerer(0.0, 2.0, 0.01), answerer(-6.0, 1.0, 0.01)],
    ] {
        let (values, agreement) = compared(methods);
        let agreement = agreement.unwrap();
        assert_eq!(agreement.outcome(), Outcome::Differ);
        for k in 0..10 {
            let theta = agreement.theta[k];
            assert!(values[0].min(values[1]) <= theta && theta <= values[0].max(values[1]));
            let sigma = agreement.covariance[(k, k)].sqrt();
            for value in values {
                assert!((value - theta).abs() < 2.0 * sigma, "{value} {theta} {sigma}");
            }
            // The squares of the difference and of its noise, 6² and 1, leave 35 for twice the variance between them.
            assert!(
                (agreement.between[k] - 17.5_f64.sqrt()).abs() < 0.05,
                "{}",
                agreement.between[k]
            );
        }
    }
}

#[test]
fn three_that_all_differ_have_a_common_spread() {
    let three = [answerer(-2.0, 0.3, 0.1), answerer(0.0, 0.3, 0.1), answerer(2.0, 0.3, 0.1)];
    let agreement = compared(three).1.unwrap();
    assert!(agreement.outliers.is_empty());
    // The variance of -2, 0 and 2 is 4, less that of the noise of 0.1.
    assert!((agreement.theta[0] - 5.0).abs() < 0.01, "{}", agreement.theta);
    assert!((agreement.between[0] - 2.0).abs() < 0.01, "{}", agreement.between);
}

#[test]
fn one_answer_alone_is_not_compared() {
    assert!(compared([answerer(0.0, 0.1, 0.1)]).1.is_none());
}
