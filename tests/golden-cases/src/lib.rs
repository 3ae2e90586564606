//! The golden cases of `tests/golden` as constants, and the checks that run them.
//!
//! The schema, the tolerance rules and the meaning of every number are in `tests/golden/SCHEMA.md`.
//! The crate needs neither an allocator nor an operating system, so that the same checks run on the
//! host and on an emulated microcontroller:
//!
//! ```
//! massline_golden_cases::run_all::<f32>(&mut |case, path, pass, worst| {
//!     assert!(pass, "{case} {path}: {worst} of the tolerance");
//! });
//! ```
#![no_std]
#![forbid(unsafe_code)]

mod case;
mod chain;
mod design;
mod dppim;
mod global_fit;
mod gravity;
mod inertia_restraint;
mod layout;
mod learned_budget;
mod mass_line;
mod maximum_likelihood;
mod modes;
mod params;

pub use case::{Array, CASES, Case, Check, Report, Rule, Values};
pub use layout::GoldenLayout;

use massline_shared::signal::RealFft;

/// Runs every case whose method this crate knows, in the precision `R`.
///
/// `report` is called once for every number or array that has a rule: case, path, whether it passes, and
/// the largest error as a fraction of the tolerance. A rule under which nothing was compared, and a case
/// of an unknown method, are reported as failed.
pub fn run_all<R: RealFft + Default>(report: &mut Report<'_>) {
    for case in CASES {
        run::<R>(case, report);
    }
}

/// Runs one case, see [`run_all`].
pub fn run<R: RealFft + Default>(case: &'static Case, report: &mut Report<'_>) {
    let mut check = Check::<R>::new(case, report);
    let done = match case.method {
        "params" => params::run(&mut check),
        "irm" => inertia_restraint::run(&mut check),
        "ml" => maximum_likelihood::run(&mut check),
        "ml_learned" => learned_budget::run(&mut check),
        "ml_full" => maximum_likelihood::run_full(&mut check),
        "massline" => mass_line::run(&mut check),
        "global_fit" => global_fit::run(&mut check),
        "gravity" => gravity::run(&mut check),
        "modal_methods" => modes::run(&mut check),
        "modal_identification" => modes::run_identification(&mut check),
        "select_modes" => modes::run_select(&mut check),
        "dppim" => dppim::run(&mut check),
        "layout" => layout::run(&mut check),
        "d_optimal" => design::run(&mut check),
        "chain" => chain::run(&mut check),
        _ => None,
    };
    check.finish(done.is_some());
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::string::{String, ToString};
    use std::vec::Vec;

    fn failures<R: RealFft + Default>() -> (usize, Vec<String>) {
        let (mut count, mut failed) = (0, Vec::new());
        run_all::<R>(&mut |case, path, pass, worst| {
            count += 1;
            if !pass {
                failed.push(std::format!("{case} {path}: {worst} of the tolerance"));
            }
        });
        (count, failed)
    }

    #[test]
    fn every_case_passes_in_double_precision() {
        let (count, failed) = failures::<f64>();
        assert!(failed.is_empty(), "{failed:#?}");
        assert!(count > 100, "{count} checks");
    }

    #[test]
    fn every_case_passes_in_single_precision() {
        let (count, failed) = failures::<f32>();
        assert!(failed.is_empty(), "{failed:#?}");
        assert!(count > 100, "{count} checks");
    }

    #[test]
    fn a_wrong_missing_or_undefined_number_fails_its_check() {
        let case = Case::find("a_irm_01_exact_bar").unwrap();
        let mut verdicts = Vec::new();
        let mut report = |_: &str, path: &str, pass: bool, _: f64| {
            verdicts.push((path.to_string(), pass));
        };
        let mut check = Check::<f64>::new(case, &mut report);
        let mut theta: Vec<f64> = case.real("expected.theta").unwrap().iter().collect();
        check.numbers("theta", &theta);
        theta[9] += 2e-3;
        check.numbers("theta", &theta);
        check.numbers("theta", &theta[..9]);
        theta[9] = f64::NAN;
        check.numbers("theta", &theta);
        assert_eq!(verdicts.iter().map(|v| v.1).collect::<Vec<_>>(), [true, false, false, false]);
    }

    #[test]
    fn a_rule_that_nothing_answers_to_fails() {
        let case = Case::find("a_irm_01_exact_bar").unwrap();
        let mut failed = Vec::new();
        let mut report = |_: &str, path: &str, pass: bool, _: f64| {
            assert!(!pass);
            failed.push(path.to_string());
        };
        Check::<f64>::new(case, &mut report).finish(true);
        assert_eq!(failed.len(), case.rules.len());
    }
}
