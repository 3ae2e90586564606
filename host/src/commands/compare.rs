//! Compares a result with the truth of a bench.

use massline_protocol::object::MeasurementResult;
use massline_shared::body::{INERTIAL_PARAMETERS, scale};
use massline_shared::identify::Estimate;
use nalgebra::SVector;

use crate::document::{ComparedTest, Measurement};
use crate::error::{Error, Result};
use crate::output;
use crate::report::{self, Truth};

/// What the standard deviations of a rig's answers cover.
pub const SIGMA_NOTE: &str = "sd of maximum likelihood covers the whole error budget of the layout, \
                              that of inertia restraint the scatter between hits only";

/// A test whose true answer is known.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Name of the test.
    pub name: String,
    /// Seed of the bench.
    pub seed: u64,
    /// The true ten properties.
    pub truth: [f64; 10],
    /// Characteristic length L of the layout, m.
    pub length: f64,
    /// The rig's result.
    pub result: MeasurementResult,
    /// The answer that is compared with the truth: that of the program or, where it has none, the rig's.
    pub answer: Option<Estimate<f64>>,
}

impl Comparison {
    /// Measured minus true, in % of [m, L, L, L, m L² × 6].
    ///
    /// # Errors
    /// When the result has no answer.
    pub fn errors_percent(&self) -> Result<[f64; 10]> {
        Ok(self.errors_of(&self.estimate()?.theta()))
    }

    /// The same of any ten properties.
    fn errors_of(&self, theta: &SVector<f64, 10>) -> [f64; 10] {
        let errors = theta - SVector::from(self.truth);
        (100.0 * errors.component_div(&scale(self.truth[0], self.length))).into()
    }

    /// The answers of several methods beside the truth: for each the largest error and the root mean square.
    /// Empty without answers.
    pub fn of_methods(&self, answers: &[(&str, SVector<f64, 10>)]) -> String {
        if answers.is_empty() {
            return String::new();
        }
        let mut table = output::table();
        table.set_header(["method", "worst, % of scale", "at", "rms, % of scale"]);
        for (name, theta) in answers {
            table.add_row(row(name, &self.errors_of(theta)));
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

    /// The result in its usual form, with name, seed, truth and errors; `further` adds to it.
    ///
    /// # Errors
    /// When the result has no answer.
    pub fn to_json(&self, further: impl FnOnce(&mut Measurement)) -> Result<ComparedTest> {
        let mut measurement = report::measurement_json(&self.result);
        further(&mut measurement);
        // The answers beside the truth are those that the verdict is about.
        if let Some(host) = measurement.host.as_ref().filter(|host| !host.results.is_empty()) {
            measurement.results = host.results.clone();
        }
        Ok(ComparedTest {
            measurement,
            name: self.name.clone(),
            seed: self.seed,
            truth: self.truth,
            characteristic_length_m: self.length,
            error_percent_of_scale: self.errors_percent()?,
        })
    }

    /// The ten properties as a table with standard deviation, truth and error.
    ///
    /// # Errors
    /// When the result has no answer.
    pub fn table(&self) -> Result<String> {
        let truth = Truth { properties: self.truth.map(Some), length: self.length };
        Ok(report::table(self.estimate()?, Some(&truth)))
    }

    fn estimate(&self) -> Result<&Estimate<f64>> {
        self.answer.as_ref().ok_or_else(|| {
            Error::undetermined("no_answer", format!("{}: the result has no answer", self.name))
        })
    }
}

/// One line per test: the largest error of the ten properties and the root mean square.
///
/// # Errors
/// When a result has no answer.
pub fn summary(comparisons: &[Comparison]) -> Result<String> {
    let mut table = output::table();
    table.set_header(["test", "worst, % of scale", "at", "rms, % of scale"]);
    for comparison in comparisons {
        table.add_row(row(&comparison.name, &comparison.errors_percent()?));
    }
    Ok(table.to_string())
}

/// The largest error by absolute value, and the symbol of its property.
fn worst_of(errors: &[f64; 10]) -> (&'static str, f64) {
    let named = INERTIAL_PARAMETERS.iter().map(|parameter| parameter.symbol).zip(*errors);
    let larger = |worst: (&'static str, f64), next: (&'static str, f64)| {
        if next.1.abs() > worst.1.abs() { next } else { worst }
    };
    named.reduce(larger).unwrap_or_default()
}

/// The name of what has these errors, % of scale, the largest of them, and the root mean square.
fn row(name: &str, errors: &[f64; 10]) -> [String; 4] {
    let (symbol, worst) = worst_of(errors);
    let rms = (errors.iter().map(|e| e * e).sum::<f64>() / 10.0).sqrt();
    [name.into(), format!("{worst:+.3}"), symbol.into(), format!("{rms:.3}")]
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_protocol::object::{ResultHead, StoredEstimate};
    use massline_shared::layout::FrfEstimator;
    use massline_shared::mass_line::Terms;

    const TRUTH: [f64; 10] = [2.0, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03, 0.001, 0.002, 0.003];

    fn comparison(change: impl FnOnce(&mut [f32; 10])) -> Comparison {
        let mut properties = TRUTH.map(|v| v as f32);
        change(&mut properties);
        let estimate = StoredEstimate {
            method: 1,
            properties,
            covariance: heapless::Vec::new(),
            condition: 10.0,
            consistency: None,
            learned: None,
            diagnostics: heapless::Vec::new(),
        };
        let result = MeasurementResult {
            head: ResultHead {
                title: heapless::String::new(),
                started_unix_s: 0,
                number: 1,
                layout_hash: 1,
                calibration: 1,
                gains: None,
                firmware: heapless::String::new(),
                frf_estimator: FrfEstimator::H1,
                terms: Terms::Abc,
                band_automatic: false,
            },
            dofs: heapless::Vec::new(),
            lines: Default::default(),
            estimates: [estimate].into_iter().collect(),
            diagnostics: heapless::Vec::new(),
        };
        let answer = report::estimates_of(&result).into_iter().next();
        Comparison { name: "t".into(), seed: 1, truth: TRUTH, length: 0.5, result, answer }
    }

    #[test]
    fn errors_are_relative_to_mass_length_and_mass_times_length_squared() {
        // 1 % of 2 kg, of 0.5 m, of 2 kg (0.5 m)²; the stored values are in single precision.
        let c = comparison(|p| {
            p[0] += 0.02;
            p[2] -= 0.005;
            p[9] += 0.005;
        });
        let errors = c.errors_percent().unwrap();
        for (k, expected) in [(0, 1.0), (1, 0.0), (2, -1.0), (9, 1.0)] {
            assert!((errors[k] - expected).abs() < 1e-4, "{k}: {}", errors[k]);
        }
    }

    #[test]
    fn the_worst_is_the_largest_by_amount() {
        let c = comparison(|p| {
            p[1] += 0.001;
            p[5] -= 0.01;
        });
        let (symbol, error) = c.worst().unwrap();
        assert_eq!(symbol, "J_yy");
        assert!(error < -1.9);
    }

    #[test]
    fn a_result_without_an_answer_is_no_comparison() {
        let mut c = comparison(|_| ());
        c.answer = None;
        assert_eq!(c.worst().unwrap_err().exit_code(), 3);
    }
}
