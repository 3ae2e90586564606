//! Layouts for which only maximum likelihood has an answer: what the check of a layout predicts before
//! the test agrees with what the fit returns after it.

use massline::support::bench_test::nominal_calibration;
use massline_analysis::monte_carlo::measurement::measure;
use massline_files::layout_file::LayoutFile;
use massline_physics::Bench;
use massline_shared::Real;
use massline_shared::capacity::Rig;
use massline_shared::identify::maximum_likelihood::{ErrorBudget, RIG_WORKSPACE, Start, solve};
use massline_shared::identify::{Applicability, DofMassLines, Estimate, Method};
use massline_shared::layout::{Layout, assumed_body};
use massline_tests::campaign::{THREE_BAR_TESTS, scans};

type RigLayoutIn<R> = Layout<R, Rig>;
type Dofs<R> = Vec<DofMassLines<R, Rig>>;

/// Two sensors on every pair of nodes.
const SENSORS: [&str; 6] = ["[1, 2]", "[1, 3]", "[1, 4]", "[2, 3]", "[2, 4]", "[3, 4]"];

/// The test with other sensors.
fn with_sensors(test: &str, sensors: &str) -> LayoutFile {
    let line = test.lines().find(|line| line.starts_with("sensors")).expect("sensors");
    let text = test.replace(line, &format!("sensors = {sensors}"));
    LayoutFile::parse(&text, "test.toml").expect("a good layout")
}

/// Fits from a crude start, as when the inertia restraint method has no answer.
fn fit<R: Real>(layout: &RigLayoutIn<R>, dofs: &Dofs<R>) -> Option<Estimate<R>> {
    let solution =
        solve(layout, dofs, Start::Crude, ErrorBudget::FirstOrder, &mut [R::zero(); RIG_WORKSPACE]);
    solution.ok().map(|solution| solution.estimate)
}

fn single(dofs: &Dofs<f64>) -> Dofs<f32> {
    dofs.iter().map(|(dof, lines)| (*dof, lines.cast())).collect()
}

#[test]
fn the_fit_agrees_with_the_check_of_a_layout_without_inertia_restraint() {
    let bench = Bench::named("default").expect("bundled");
    let truth = bench.truth().theta();
    let mut predicted = 0;
    for test in THREE_BAR_TESTS {
        for sensors in SENSORS {
            let file = with_sensors(test, sensors);
            let layout: RigLayoutIn<f64> = file.layout.cast().expect("fits the rig");
            let glued = layout.sensors.iter().map(|sensor| sensor.position);
            let places = glued.chain(layout.hits.iter().map(|hit| hit.position));
            let body = assumed_body(None, places);
            let methods = [Method::MaximumLikelihood];
            if Applicability::new(&layout, &body, &methods).diagnostics.iter().any(|d| d.is_error())
            {
                continue;
            }
            predicted += 1;
            let mut source = *scans(&bench, &file, 1);
            let dofs = measure(&mut source, &layout, &nominal_calibration(&bench)).expect("lines");
            let wide = fit(&layout, &dofs.dofs)
                .unwrap_or_else(|| panic!("{} {sensors}", file.layout.title));
            let narrow = fit::<f32>(&layout.cast().expect("fits"), &single(&dofs.dofs));
            let narrow = narrow.unwrap_or_else(|| panic!("{} {sensors}", file.layout.title));
            let sigma = wide.sigma().expect("a covariance");
            for k in 0..10 {
                let error = (wide.theta()[k] - truth[k]).abs() / sigma[k];
                // 240 numbers, with standard deviations that are too wide rather than too narrow.
                assert!(error < 4.0, "{} {sensors} {k}: {error}", file.layout.title);
                // The project's limit for single precision.
                let difference = (f64::from(narrow.theta()[k]) - wide.theta()[k]).abs() / sigma[k];
                assert!(difference < 0.01, "{} {sensors} {k}: {difference}", file.layout.title);
            }
        }
    }
    assert_eq!(predicted, THREE_BAR_TESTS.len() * SENSORS.len());
}
