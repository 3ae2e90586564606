//! The fit of the wheel reaches the bound, and its intervals hold.

use super::wheel::*;
use super::*;
use crate::body::scale;
use crate::identify::HALF_WIDTH_95;

/// Errors over the standard deviations, total error, and number of extra terms of a few tests.
struct Study {
    /// Errors over standard deviations.
    z: Vec<f64>,
    /// Root mean square error relative to mass, L and m L².
    total: f64,
    extra_terms: Vec<usize>,
    noise: f64,
}

/// Tests of the wheel, fitted from a body that is 5 % off.
fn study(layout: &Wheel, object: &Object, settings: GlobalFitSettings, runs: usize) -> Study {
    let truth = RigidBody::from_theta(&SVector::from(THETA));
    let start = RigidBody {
        mass: truth.mass * 1.05,
        center_of_mass: truth.center_of_mass + Vector3::new(0.01, -0.01, 0.01),
        inertia: truth.inertia * 0.95,
    };
    let (f, unit) = (bins(), scale(truth.mass, layout.characteristic_length()));
    let mut memory = vec![0.0; workspace(3, 5)];
    let mut random = Random(88_172_645_463_325_252);
    let mut study = Study { z: Vec::new(), total: 0.0, extra_terms: Vec::new(), noise: 0.0 };
    for _ in 0..runs {
        let data = measure(layout, object, &f, NOISE, &mut random);
        let responses = FrequencyResponses::new(&f, &data, 9, 5).unwrap();
        let solution = solve(layout, &responses, &start, &settings, &mut memory).unwrap();
        let error = solution.estimate.theta() - truth.theta();
        study.z.extend(&error.component_div(&solution.estimate.sigma().unwrap()));
        study.total += error.component_div(&unit).norm_squared() / 10.0 / runs as f64;
        study.noise += solution.noise / runs as f64;
        study.extra_terms.push(solution.extra_terms);
    }
    study.total = study.total.sqrt();
    study
}

impl Study {
    /// Share of the 95 % intervals that hold the truth.
    fn coverage(&self) -> f64 {
        let held = self.z.iter().filter(|z| z.abs() <= HALF_WIDTH_95).count();
        held as f64 / self.z.len() as f64
    }
}

/// Room for chance: the errors of one test are correlated, so n tests are about 4 n independent numbers, whose
/// coverage scatters by `√(0.95 · 0.05/(4 n))`; three times that.
fn least_coverage(runs: usize) -> f64 {
    0.95 - 3.0 * (0.95 * 0.05 / (4.0 * runs as f64)).sqrt()
}

#[test]
fn with_noise_alone_the_fit_reaches_the_bound() {
    let runs = 20;
    let study = study(&without_errors(layout()), &Object::new(0.0), Default::default(), runs);
    // The root mean square of 80 normal numbers scatters by 8 %: three times that. Over 2000 tests it is 1.01.
    assert!((study.total / BOUND - 1.0).abs() < 0.24, "{}", study.total / BOUND);
    assert!(study.coverage() > least_coverage(runs), "{}", study.coverage());
    assert!(study.extra_terms.iter().all(|n| *n == 0), "{:?}", study.extra_terms);
    // A run has 8730 numbers, so the mean of the runs scatters by 0.2 %.
    assert!((study.noise / NOISE * 2_f64.sqrt() - 1.0).abs() < 0.01, "{}", study.noise);
}

#[test]
fn with_the_default_budget_the_intervals_hold() {
    let runs = 20;
    let study = study(&layout(), &Object::new(0.0), Default::default(), runs);
    assert!(study.coverage() > least_coverage(runs), "{}", study.coverage());
    assert!(study.extra_terms.iter().all(|n| *n == 0), "{:?}", study.extra_terms);
}

#[test]
fn a_tyre_asks_for_an_extra_term() {
    let runs = 10;
    let layout = without_errors(layout());
    let with_extra_term = study(&layout, &Object::new(9.0), Default::default(), runs);
    assert!(with_extra_term.coverage() > least_coverage(runs), "{}", with_extra_term.coverage());
    assert!(
        with_extra_term.extra_terms.iter().all(|n| *n > 0),
        "{:?}",
        with_extra_term.extra_terms
    );
    // Without the term the fit takes the tyre for mass.
    let without = GlobalFitSettings { most_extra_terms: 0, ..Default::default() };
    let biased = study(&layout, &Object::new(9.0), without, 1);
    assert!(
        biased.total > 5.0 * with_extra_term.total,
        "{} {}",
        biased.total,
        with_extra_term.total
    );
}
