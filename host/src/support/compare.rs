//! Compares results with the truth of a bench.

use massline_result::{Estimate, TestResult};
use massline_shared::body::{INERTIAL_PARAMETERS, RigidBody, scale};

use crate::output::{align_right, table};
use crate::{Error, Result};
use massline_report::document::ComparedTest;
use massline_report::words::{as_exact_as, in_interval};

/// A test whose true answer is known.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Name of the test.
    pub name: String,
    /// The result.
    pub result: TestResult,
    truth: [f64; 10],
    length: f64,
}

impl Comparison {
    /// A result beside the true ten properties.
    pub fn new(name: &str, seed: u64, truth: [f64; 10], length: f64, result: TestResult) -> Self {
        let characteristic_length_m = Some(length);
        let result =
            TestResult { seed: Some(seed), truth: Some(truth), characteristic_length_m, ..result };
        Self { name: name.into(), result, truth, length }
    }

    /// Measured minus true, in % of [m, L, L, L, m L² × 6].
    ///
    /// # Errors
    /// When the result has no answer.
    pub fn errors_percent(&self) -> Result<[f64; 10]> {
        Ok(self.errors_of(&self.answer()?.theta()))
    }

    /// The same of any ten properties.
    fn errors_of(&self, theta: &[f64; 10]) -> [f64; 10] {
        let scale = scale(self.truth[0], self.length);
        std::array::from_fn(|k| 100.0 * (theta[k] - self.truth[k]) / scale[k])
    }

    /// The answers of all methods beside the truth: for each the largest error and the root mean square. Empty without
    /// answers.
    pub fn of_methods(&self) -> String {
        if self.result.results.is_empty() {
            return String::new();
        }
        let combined =
            self.result.agreement.as_ref().and_then(|agreement| agreement.combined.as_ref());
        let each =
            self.result.results.iter().map(|estimate| (estimate.method.name(), estimate.theta()));
        let mut table = table();
        table.set_header(["method", "worst, % of scale", "at", "rms, % of scale"]);
        for (name, theta) in
            each.chain(combined.map(|answer| ("combined", answer.value.in_order())))
        {
            table.add_row(row(name, &self.errors_of(&theta)));
        }
        format!("{table}\n")
    }

    /// The largest of [`Comparison::errors_percent`] by absolute value, and the symbol of its property.
    ///
    /// # Errors
    /// When the result has no answer.
    pub fn worst(&self) -> Result<(&'static str, f64)> {
        Ok(worst_of(&self.errors_percent()?))
    }

    /// The result with name, seed and errors.
    ///
    /// # Errors
    /// When it has no answer.
    pub fn document(&self) -> Result<ComparedTest> {
        Ok(ComparedTest {
            result: self.result.clone(),
            name: self.name.clone(),
            error_percent_of_scale: self.errors_percent()?,
        })
    }

    fn answer(&self) -> Result<&Estimate> {
        self.result.answer().ok_or_else(|| {
            Error::undetermined("no_answer", format!("{}: the result has no answer", self.name))
        })
    }
}

/// The ten properties of all tests side by side, each ± half the width of its 95 % interval; below them the largest
/// error and the root mean square of the errors, % of scale.
///
/// # Errors
/// When a result has no answer.
pub fn side_by_side(comparisons: &[Comparison]) -> Result<String> {
    let Some(first) = comparisons.first() else { return Ok(String::new()) };
    let mut table = table();
    let names = comparisons.iter().enumerate().map(|(k, _)| format!("test {}", k + 1));
    table.set_header(["", "unit", "expected"].map(str::to_owned).into_iter().chain(names));
    align_right(&mut table, 2..3 + comparisons.len());
    for (k, parameter) in INERTIAL_PARAMETERS.iter().enumerate() {
        let factor = parameter.table_factor;
        let mut cells = vec![parameter.symbol.to_owned(), parameter.table_unit.to_owned()];
        cells.push(exact(first.truth[k] * factor));
        for comparison in comparisons {
            let answer = comparison.answer()?;
            let half = answer.half_widths().map(|half| half[k] * factor);
            cells.push(measured(answer.theta()[k] * factor, half));
        }
        table.add_row(cells);
    }
    let true_moments =
        RigidBody::from_theta(&first.truth.into()).principal().map(|principal| principal.moments);
    for k in 0..3 {
        let mut cells = vec![format!("J_{}", k + 1), "g m²".into()];
        cells.push(true_moments.map_or_else(String::new, |moments| exact(moments[k] * 1e3)));
        for comparison in comparisons {
            let answer = comparison.answer()?;
            let moments = answer.principal_moments_kg_m2.value;
            let half = answer.principal_half_widths().map(|half| half[k] * 1e3);
            cells.push(moments.map_or_else(String::new, |value| measured(value[k] * 1e3, half)));
        }
        table.add_row(cells);
    }
    let errors = comparisons.iter().map(Comparison::errors_percent).collect::<Result<Vec<_>>>()?;
    let line = |name: &str, cell: &dyn Fn(&[f64; 10]) -> String| {
        let head = [name, "%", ""].map(str::to_owned);
        head.into_iter().chain(errors.iter().map(cell)).collect::<Vec<_>>()
    };
    table.add_row(line("worst", &|errors| {
        let (symbol, worst) = worst_of(errors);
        format!("{worst:+.2} {symbol}")
    }));
    table.add_row(line("rms", &|errors| format!("{:.2}", rms_of(errors))));
    Ok(table.to_string())
}

/// A true value.
fn exact(value: f64) -> String {
    as_exact_as(value, Some(0.01 * value.abs()))
}

/// A value and half the width of its interval, where that is known.
fn measured(value: f64, half_width: Option<f64>) -> String {
    let text = in_interval(value, half_width);
    match half_width {
        // Without blanks four tests fit beside each other.
        Some(half) => format!("{text}±{}", in_interval(half, half_width)),
        None => text,
    }
}

/// The largest error by absolute value, and the symbol of its property.
fn worst_of(errors: &[f64; 10]) -> (&'static str, f64) {
    let named = INERTIAL_PARAMETERS.iter().map(|parameter| parameter.symbol).zip(*errors);
    let larger = |worst: (&'static str, f64), next: (&'static str, f64)| {
        if next.1.abs() > worst.1.abs() { next } else { worst }
    };
    named.reduce(larger).unwrap_or_default()
}

fn rms_of(errors: &[f64; 10]) -> f64 {
    (errors.iter().map(|error| error * error).sum::<f64>() / 10.0).sqrt()
}

/// The name of what has these errors, % of scale, the largest of them, and the root mean square.
fn row(name: &str, errors: &[f64; 10]) -> [String; 4] {
    let (symbol, worst) = worst_of(errors);
    [name.into(), format!("{worst:+.3}"), symbol.into(), format!("{:.3}", rms_of(errors))]
}

#[cfg(test)]
mod tests {
    use massline_shared::diagnosis::Diagnostics;
    use massline_shared::identify::{self, Method};
    use nalgebra::SVector;

    use super::*;
    use massline_report::words::{estimate_of, message};

    const TRUTH: [f64; 10] = [2.0, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03, 0.001, 0.002, 0.003];

    fn comparison(change: impl FnOnce(&mut [f64; 10])) -> Comparison {
        let mut theta = TRUTH;
        change(&mut theta);
        let estimate = identify::Estimate {
            method: Method::MaximumLikelihood,
            body: RigidBody::from_theta(&SVector::from(theta)),
            covariance: None,
            condition: 10.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        };
        let results = vec![estimate_of(&estimate, message)];
        let result = TestResult { results, ..TestResult::default() };
        Comparison::new("t", 1, TRUTH, 0.5, result)
    }

    #[test]
    fn errors_are_relative_to_mass_length_and_mass_times_length_squared() {
        // 1 % of 2 kg, of 0.5 m, of 2 kg (0.5 m)².
        let c = comparison(|theta| {
            theta[0] += 0.02;
            theta[2] -= 0.005;
            theta[9] += 0.005;
        });
        let errors = c.errors_percent().unwrap();
        for (k, expected) in [(0, 1.0), (1, 0.0), (2, -1.0), (9, 1.0)] {
            // Rounding.
            assert!((errors[k] - expected).abs() < 1e-9, "{k}: {}", errors[k]);
        }
    }

    #[test]
    fn the_worst_is_the_largest_by_amount() {
        let c = comparison(|theta| {
            theta[1] += 0.001;
            theta[5] -= 0.01;
        });
        let (symbol, error) = c.worst().unwrap();
        assert_eq!(symbol, "J_yy");
        assert!(error < -1.9);
    }

    #[test]
    fn a_result_without_an_answer_is_no_comparison() {
        let mut c = comparison(|_| ());
        c.result.results.clear();
        assert_eq!(c.worst().unwrap_err().exit_code(), 3);
    }
}
