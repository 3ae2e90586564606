//! What a result that was read must have beside its types: statements that do not contradict each other.

use massline_shared::body::INERTIAL_PARAMETERS;

use crate::estimate::Estimate;
use crate::test_result::TestResult;
use crate::verdict::Verdict;

/// A statement of a result that contradicts another one, or that nothing can be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{place}: {wrong}")]
pub struct Contradiction {
    /// The way to the value.
    pub place: String,
    /// What is wrong with it.
    pub wrong: String,
}

impl Contradiction {
    fn of(place: impl Into<String>, wrong: impl Into<String>) -> Self {
        Self { place: place.into(), wrong: wrong.into() }
    }

    fn within(self, place: &str) -> Self {
        Self { place: format!("{place}.{}", self.place), ..self }
    }
}

type CheckOutcome = Result<(), Contradiction>;

/// Difference of two elements that are the same by symmetry, relative to their size: the rounding of a rig's numbers.
const SYMMETRY: f64 = 1e-6;
/// Difference of two statements of one number, relative: the rounding of numbers that somebody has copied with three
/// digits.
const ROUNDING: f64 = 5e-3;

impl TestResult {
    /// Checks that verdict, reasons and answers belong together, and every answer in itself.
    ///
    /// # Errors
    /// The first contradiction.
    pub fn check(&self) -> CheckOutcome {
        let estimates = self.results.iter().enumerate();
        for (k, estimate) in estimates {
            estimate.check().map_err(|e| e.within(&format!("results[{k}]")))?;
            if self.results[..k].iter().any(|other| other.method == estimate.method) {
                let twice = format!("{} stands in the list already", estimate.method);
                return Err(Contradiction::of(format!("results[{k}].method"), twice));
            }
        }
        self.check_verdict()?;
        for (k, source) in self.error_sources.iter().enumerate() {
            if !(-ROUNDING..=1.0 + ROUNDING).contains(&source.share) {
                let wrong = format!("{} is not a share, which is from 0 to 1", source.share);
                return Err(Contradiction::of(format!("error_sources[{k}].share"), wrong));
            }
        }
        match self.characteristic_length_m {
            Some(length) if length <= 0.0 => {
                Err(Contradiction::of("characteristic_length_m", format!("{length} is no length")))
            }
            _ => Ok(()),
        }
    }

    /// The verdict is that of the gravest reason, and there is one where there is an answer.
    fn check_verdict(&self) -> CheckOutcome {
        let wrong = |wrong: String| Err(Contradiction::of("verdict", wrong));
        let (Some(answer), Some(verdict)) = (self.answer(), self.verdict) else {
            return match (self.answer(), self.verdict) {
                (Some(_), None) => wrong("it is missing, and there is an answer".into()),
                (None, Some(verdict)) => {
                    wrong(format!("\"{}\" is about an answer, and there is none", verdict.name()))
                }
                _ => Ok(()),
            };
        };
        let reasons = self.verdict_reasons.iter().map(|reason| reason.verdict);
        let gravest = reasons.max().unwrap_or(Verdict::Good);
        if verdict != gravest {
            return wrong(format!(
                "\"{}\" contradicts verdict_reasons, by which it is \"{}\"",
                verdict.name(),
                gravest.name()
            ));
        }
        if !answer.physically_consistent && verdict != Verdict::DoNotUse {
            return wrong(format!(
                "\"{}\" contradicts results[0].physically_consistent, false",
                verdict.name()
            ));
        }
        Ok(())
    }
}

impl Estimate {
    /// Checks that matrices are symmetric, that standard deviations are the roots of the variances, and that intervals
    /// contain their values.
    ///
    /// # Errors
    /// The first contradiction.
    pub fn check(&self) -> CheckOutcome {
        let inertia = &self.inertia_kg_m2.value;
        is_symmetric(inertia, "inertia_kg_m2.value")?;
        if let Some(covariance) = &self.covariance {
            if let Some(k) = (0..10).find(|&k| covariance[k][k] < 0.0) {
                let wrong =
                    format!("{} is not a variance, which is not negative", covariance[k][k]);
                return Err(Contradiction::of(format!("covariance[{k}][{k}]"), wrong));
            }
            is_symmetric(covariance, "covariance")?;
        }
        self.check_sigma()?;
        let intervals = self.interval95.iter().flat_map(|intervals| intervals.in_order());
        for (([low, high], parameter), value) in
            intervals.zip(&INERTIAL_PARAMETERS).zip(self.theta())
        {
            let place = || format!("interval95.{}", parameter.symbol);
            if low > high {
                let wrong = format!("{low} to {high} is no interval: the lower end stands first");
                return Err(Contradiction::of(place(), wrong));
            }
            let slack = ROUNDING * (high - low);
            if !(low - slack..=high + slack).contains(&value) {
                let wrong = format!("{low} to {high} does not contain the value, {value}");
                return Err(Contradiction::of(place(), wrong));
            }
        }
        Ok(())
    }

    /// The standard deviations of the ten properties are not negative, and the roots of the variances.
    fn check_sigma(&self) -> CheckOutcome {
        let Some(sigma) = self.sigma() else { return Ok(()) };
        for (k, sigma) in sigma.into_iter().enumerate() {
            let place = match k {
                0 => "mass_kg.sigma",
                1..=3 => "center_of_mass_m.sigma",
                _ => "inertia_kg_m2.sigma",
            };
            let wrong = |wrong: String| {
                let symbol = INERTIAL_PARAMETERS[k].symbol;
                Err(Contradiction::of(place, format!("of {symbol}: {wrong}")))
            };
            if sigma < 0.0 {
                return wrong(format!("{sigma} is negative; a standard deviation is not"));
            }
            let Some(covariance) = &self.covariance else { continue };
            let root = covariance[k][k].sqrt();
            if (sigma - root).abs() > ROUNDING * root {
                return wrong(format!(
                    "{sigma} is not the root of covariance[{k}][{k}], which is {root}"
                ));
            }
        }
        Ok(())
    }
}

/// Checks a matrix with this place.
fn is_symmetric<const N: usize>(rows: &[[f64; N]; N], place: &str) -> CheckOutcome {
    for i in 0..N {
        for j in 0..i {
            let scale = (rows[i][i].abs() * rows[j][j].abs()).sqrt().max(rows[i][j].abs());
            if (rows[i][j] - rows[j][i]).abs() > SYMMETRY * scale {
                let wrong = format!(
                    "{} is not equal to [{j}][{i}], {}, and the matrix is symmetric",
                    rows[i][j], rows[j][i]
                );
                return Err(Contradiction::of(format!("{place}[{i}][{j}]"), wrong));
            }
        }
    }
    Ok(())
}
