//! Statistics of simulated tests, pooled over the four tests of the three-bar frame.

use massline_analysis::monte_carlo::Run;
use massline_analysis::monte_carlo::measurement::TestLayout;
use massline_analysis::monte_carlo::statistics::MethodStatistics;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::Estimate;
use massline_shared::identify::maximum_likelihood::{ErrorBudget, RIG_WORKSPACE, Start, solve};

/// Pooled over tests and properties.
#[derive(Clone, Copy, Debug)]
pub struct PooledStatistics {
    /// Share of the 95 % intervals that hold the truth.
    pub coverage: f64,
    /// Geometric mean of the root mean square error over the bound.
    pub error: f64,
    /// Geometric mean of the mean width of the intervals over that which the bound permits.
    pub width: f64,
}

/// The statistics of a method in several tests, together.
#[must_use]
#[track_caller]
pub fn pooled(of_tests: &[MethodStatistics]) -> PooledStatistics {
    let count = of_tests.len() as f64;
    let mean = |quantity: fn(&MethodStatistics) -> Option<f64>| {
        of_tests.iter().map(|test| quantity(test).expect("has answers")).sum::<f64>() / count
    };
    PooledStatistics {
        coverage: mean(MethodStatistics::pooled_coverage95),
        error: mean(|test| test.geometric_mean_ratio().map(f64::ln)).exp(),
        width: mean(|test| test.geometric_mean_width().map(f64::ln)).exp(),
    }
}

/// The answers of maximum likelihood to the mass lines of the runs under another layout, with its budget as
/// stated.
#[must_use]
#[track_caller]
pub fn solved_again(
    runs: &[Run],
    layout: &TestLayout,
) -> Vec<Result<Estimate<f64>, Option<Diagnostics>>> {
    let mut memory = [0.0; RIG_WORKSPACE];
    let measured = runs.iter().map(|run| run.as_ref().expect("has mass lines"));
    measured
        .map(|run| {
            let start = Start::InertiaRestraint;
            let solution = solve(layout, &run.dofs, start, ErrorBudget::Stated, &mut memory);
            solution.map(|solution| solution.estimate).map_err(Some)
        })
        .collect()
}
