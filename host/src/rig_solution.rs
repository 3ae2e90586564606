//! A rig's test, solved on the host in double precision: from the mass lines in its result, or in the suspension
//! profile from the lines that the rig has stored with it.
//!
//! The answer is the program's. The rig's own answer is compared with it; what the rig has seen while measuring stands.

use massline_protocol::object::MeasurementResult;
use massline_result::RigAnswer;
use massline_shared::body::{INERTIAL_PARAMETERS, scale};
use massline_shared::identify::{Estimate, IdentifySettings, Observations};
use massline_shared::layout::{HostLayout, TestProfile};

use crate::Error;
use crate::rig_lines::StoredTest;
use crate::solve::{band_of_modes, first_error, lacking, no_modal_answer};
use massline_analysis::identification::{
    Identification, MeasuredLines, Selection, contradicted, identify, layout_of, learned, lines_of,
    sensors_not_rigid,
};
use massline_analysis::plausibility::suspicions;
use massline_analysis::rig_findings::of_measuring;
use massline_analysis::score_tests::ScoreTests;
use massline_analysis::single_fault::NominalTest;
use massline_analysis::suspension::{
    Comparison, MassLineAnswers, compare, reciprocity_of_mass_lines, warn_of_flexible_mode,
};
use massline_report::solution::Solution;
use massline_report::words::{estimates_of, known, measured, message_in};

/// Largest difference of the rig's answer, in standard deviations of the program's, that nobody could tell from none. A
/// corrected layout makes more; single precision a thousandth of it.
const SAME_SIGMA: f64 = 0.1;
/// The same where standard deviations are not known, % of scale.
const SAME_PERCENT: f64 = 0.1;

/// Solves a rig's test with the layout of its measurement, or a corrected one. Mass lines are searched for the single
/// mistake that explains them.
pub fn solve_test(test: StoredTest<'_>, nominal: &NominalTest, selection: Selection) -> Solution {
    let layout = layout_of(test.result, &nominal.layout);
    if test.result.dofs.is_empty() && test.result.lines.is_empty() {
        return Solution {
            no_answer: Some(nothing_measured(test.result)),
            measured: measured(test.result),
            seen_by_rig: test.result.diagnostics.to_vec(),
            layout,
            ..Solution::default()
        };
    }
    let mut solution = match test.profile() {
        TestProfile::MassLine => of_mass_lines(test.result, nominal, layout, selection),
        TestProfile::Suspension => of_lines(test, layout, selection),
    };
    let estimates = &solution.identification.estimates;
    solution.suspicions = suspicions(nominal, estimates);
    solution.seen_by_rig = match estimates.is_empty() {
        true => test.result.diagnostics.to_vec(),
        false => of_measuring(&test.result.diagnostics),
    };
    let tests = &solution.score_tests;
    tests.in_proportion(&mut solution.seen_by_rig);
    solution.identification.each_diagnostics(|diagnostics| tests.in_proportion(diagnostics));
    let estimates = &solution.identification.estimates;
    let own = measured(test.result);
    solution.measured = massline_result::TestResult {
        rig: rig_answer(estimates, test.result, solution.layout.characteristic_length()),
        ..own
    };
    if estimates.is_empty() && solution.no_answer.is_none() {
        let text = solution.missing.clone();
        let text = text.unwrap_or_else(|| "the data do not determine the ten properties".into());
        solution.no_answer = Some(Error::undetermined("no_answer", text));
    }
    solution
}

fn of_mass_lines(
    result: &MeasurementResult,
    nominal: &NominalTest,
    layout: HostLayout,
    selection: Selection,
) -> Solution {
    let lines = lines_of(result, &layout);
    let observed = Observations::of_mass_lines(&layout, &lines);
    let identification = identify(&observed, selection, &IdentifySettings::default());
    let reasons = identification.not_applicable.first().map(|(_, reasons)| reasons.as_slice());
    let no_answer = reasons.filter(|_| identification.estimates.is_empty());
    Solution {
        no_answer: no_answer.and_then(|reasons| first_error(reasons, |d| message_in(d, &layout))),
        examination: Some(nominal.examine_result(result)),
        score_tests: ScoreTests::of(&layout, &lines, &identification.estimates),
        comparison: comparison(&identification, &layout, &lines),
        diagnostics: [
            reciprocity_of_mass_lines(&layout, &lines).as_slice(),
            &sensors_not_rigid(&layout, &lines),
        ]
        .concat(),
        identification,
        layout,
        ..Solution::default()
    }
}

fn of_lines(test: StoredTest<'_>, layout: HostLayout, selection: Selection) -> Solution {
    let wanted = selection.modal_methods();
    let missing = missing_lines(test);
    let Some((lines, record_s)) = test.measured_lines(&layout) else {
        let no_answer = missing.clone().unwrap_or_else(|| "there are no lines".into());
        return Solution {
            no_answer: Some(Error::undetermined("lines_missing", no_answer)),
            layout,
            ..Solution::default()
        };
    };
    let layout = lines.layout().clone();
    let mut solution = match lines.solve(record_s, &wanted, |_, _| ()) {
        Ok(solved) => {
            let mut identification = Identification {
                estimates: solved.estimates,
                not_applicable: solved.not_applicable,
                ..Identification::default()
            };
            identification.sort();
            if let Some(global) = &solved.global {
                warn_of_flexible_mode(&mut identification.estimates, global, &layout);
            }
            let without_priors =
                identification.estimates.iter().find(|e| !e.method.entry().uses_priors);
            let mut diagnostics = solved.modes.diagnostics.clone();
            diagnostics.extend(without_priors.iter().flat_map(|e| contradicted(&layout.priors, e)));
            let band = band_of_modes(&layout.test);
            Solution {
                identification,
                diagnostics,
                modes: Some((solved.modes, band)),
                global_fit: solved.global,
                score_tests: solved.score_tests,
                comparison: solved.comparison,
                ..Solution::default()
            }
        }
        Err(reasons) => {
            let refused = wanted.iter().map(|method| (*method, reasons.clone()));
            let identification =
                Identification { not_applicable: refused.collect(), ..Default::default() };
            Solution { identification, ..Solution::default() }
        }
    };
    if let (Some((_, reasons)), true) =
        (solution.identification.not_applicable.first(), solution.answer().is_none())
    {
        let readings = lines.responses().ok();
        let lacking = readings.and_then(|readings| lacking(lines.layout(), &readings, reasons));
        solution.no_answer = Some(no_modal_answer(&layout, reasons, lacking.as_deref()));
    }
    solution.missing = missing;
    solution.record_s = Some(record_s);
    solution.layout = layout;
    solution
}

/// The error of a result without hits.
pub fn nothing_measured(result: &MeasurementResult) -> Error {
    let text = format!("result {} has no hits: every DOF was skipped", result.head.number);
    Error::undetermined("nothing_measured", text)
}

/// The rig's own answer beside that of the program, by the best method that both answer by.
fn rig_answer(
    estimates: &[Estimate<f64>],
    result: &MeasurementResult,
    length: f64,
) -> Option<RigAnswer> {
    let of_rig = estimates_of(result);
    let pair = |host: &Estimate<f64>| {
        let same = of_rig.iter().find(|rig| rig.method == host.method)?;
        Some((host.clone(), same.theta() - host.theta()))
    };
    let (host, difference) = estimates.iter().find_map(pair)?;
    let percent = 100.0 * difference.component_div(&scale(host.body.mass, length));
    let in_sigma = host.sigma().map(|sigma| difference.component_div(&sigma));
    let worst = in_sigma.as_ref().unwrap_or(&percent).iamax();
    let agrees = match &in_sigma {
        Some(in_sigma) => in_sigma[worst].abs() <= SAME_SIGMA,
        None => percent[worst].abs() <= SAME_PERCENT,
    };
    Some(RigAnswer {
        method: host.method.into(),
        property: INERTIAL_PARAMETERS[worst].symbol.into(),
        difference: difference[worst],
        difference_sigma: in_sigma.map(|sigmas| sigmas[worst]).filter(|sigmas| sigmas.is_finite()),
        difference_percent_of_scale: known(percent[worst]),
        agrees,
    })
}

/// What is said of DOFs whose lines the rig does not have any more.
fn missing_lines(test: StoredTest<'_>) -> Option<String> {
    let missing = test.missing();
    (!missing.is_empty()).then(|| {
        format!(
            "the lines of {} are missing: they are deleted with their result, or were lost on the rig; measure these \
             DOFs again",
            missing.join(", ")
        )
    })
}

/// How the methods agree that have answered these mass lines.
fn comparison(
    identification: &Identification,
    layout: &HostLayout,
    lines: &MeasuredLines,
) -> Comparison {
    let estimates = &identification.estimates;
    let settings = IdentifySettings::default().inertia_restraint;
    let budget = estimates.first().map_or_else(|| layout.clone(), |best| learned(layout, best));
    compare(&MassLineAnswers::new(estimates, lines, budget, settings), |_, _| ())
}
