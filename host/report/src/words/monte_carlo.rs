//! A study as JSON and as tables.

use std::fmt::Display;

use crate::table::{Table, align_right, table};
use massline_shared::Real;
use massline_shared::body::{INERTIAL_PARAMETERS, InertialParameter};
use massline_shared::capacity::Capacity;
use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::Method;
use massline_shared::layout::{Layout, TestProfile};

use crate::document::{MethodOverRuns, PropertyOverRuns, RunsToTarget, SimulatedRuns};
use crate::words::counted;
use crate::words::{INERTIA_CONVENTION, as_exact_as, message, message_in, refusals, refusals_text};
use massline_analysis::monte_carlo::Study;
use massline_analysis::monte_carlo::measurement::{MOST_REJECTED, MeasureError};
use massline_analysis::monte_carlo::statistics::{
    MethodStatistics, PropertyStatistics, StoppingStatistics,
};

/// The note on a study of a single run.
const ONE_RUN: &str = "one run has an error and no rms error, ratio or coverage; repeat the test, for \
                       example --runs 100";

/// How a study was made.
#[derive(Clone, Copy, Debug)]
pub struct StudySettings<'s> {
    /// Seed of the bench.
    pub seed: u64,
    /// Title of the bench.
    pub bench: &'s str,
    /// The error budget that the methods assume: `layout` or `bench`.
    pub budget: &'static str,
    /// What says how large the errors of the bench are: `layout` or `bench`.
    pub errors: &'static str,
    /// Whether the hammer was taken as calibrated.
    pub calibrated_hammer: bool,
}

/// A study as JSON, with how it was made.
pub fn to_json(study: &Study, settings: StudySettings<'_>) -> SimulatedRuns {
    let StudySettings { seed, bench, budget, errors, calibrated_hammer } = settings;
    SimulatedRuns {
        runs: study.runs,
        runs_wanted: study.wanted,
        runs_without_mass_lines: study.unmeasured.as_ref().map_or(0, |(count, _)| *count),
        rejected_hits: study.rejected_hits,
        runs_with_warnings: study.warned,
        runs_silently_wrong: study.silent,
        target: study.stopping.as_ref().map(stopping_json),
        methods: study.methods.iter().map(method_json).collect(),
        not_applicable: refusals(&never_answered(study), message),
        notes: study.is_single().then(|| ONE_RUN.to_owned()).into_iter().collect(),
        seed,
        bench: bench.to_owned(),
        budget: budget.into(),
        errors: errors.into(),
        calibrated_hammer,
    }
}

/// The methods without an answer in any run, and the reasons.
fn never_answered(study: &Study) -> Vec<(Method, Diagnostics)> {
    let silent = study.methods.iter().filter(|method| method.answers == 0);
    silent.filter_map(|method| Some((method.method?, method.refusal.clone()?))).collect()
}

fn stopping_json(stopping: &StoppingStatistics) -> RunsToTarget {
    RunsToTarget {
        runs_at_target: stopping.reached,
        hits_of_a_campaign: stopping.hits,
        mean_hits_saved: stopping.mean_hits_saved(),
        coverage95: stopping.coverage95(),
        coverage95_at_target: stopping.coverage95_at_target(),
    }
}

/// How the runs came to the target, as text.
fn stopping_text(stopping: &StoppingStatistics) -> String {
    let StoppingStatistics { hits, runs, reached, .. } = *stopping;
    format!(
        "target: {reached} of {runs} runs reached it; {:.1} of {hits} hits saved on average; \
         coverage at the stop {}, of the runs at the target {}\n",
        stopping.mean_hits_saved(),
        or_dash(stopping.coverage95().map(percent)),
        or_dash(stopping.coverage95_at_target().map(percent)),
    )
}

fn method_json(method: &MethodStatistics) -> MethodOverRuns {
    let properties = method.properties.iter().zip(&INERTIAL_PARAMETERS);
    MethodOverRuns {
        method: method.name().into(),
        answers: method.answers,
        unanswered: method.unanswered,
        reasons: method
            .reasons
            .iter()
            .map(|(code, runs)| (code.name().to_owned(), *runs))
            .collect(),
        geometric_mean_ratio: method.geometric_mean_ratio(),
        worst_ratio: method.worst_ratio(),
        geometric_mean_width: method.geometric_mean_width(),
        pooled_coverage95: method.pooled_coverage95(),
        properties: properties.map(|(p, parameter)| property_json(parameter.symbol, p)).collect(),
    }
}

fn property_json(name: &'static str, p: &PropertyStatistics) -> PropertyOverRuns {
    PropertyOverRuns {
        name: name.into(),
        truth: p.truth,
        bias: p.bias,
        rms: p.rms,
        bound: p.bound,
        ratio: p.ratio(),
        coverage95: p.coverage95,
        half_width95: p.half_width95,
        width_ratio: p.width_ratio(),
    }
}

/// Why a test yields no mass lines, with the names of its layout.
pub fn measure_error_text<R: Real, C: Capacity>(
    error: &MeasureError,
    layout: &Layout<R, C>,
) -> String {
    match error {
        MeasureError::NeverTriggered(dof) => {
            format!("no hit at DOF {} reaches test.trigger_n; lower it or hit harder", dof + 1)
        }
        MeasureError::AlwaysRejected { dof, .. } => format!(
            "{MOST_REJECTED} hits at DOF {} were rejected; look at test.min_peak_force_n or test.impulse_ns, and at \
             the force of the bench's taps",
            dof + 1
        ),
        MeasureError::Refused(error, diagnostics) if diagnostics.is_empty() => error.to_string(),
        MeasureError::Refused(_, diagnostics) => {
            let sentences: Vec<_> = diagnostics.iter().map(|d| message_in(d, layout)).collect();
            sentences.join("; ")
        }
        MeasureError::MassLine(diagnostic) => {
            let why = message_in(diagnostic, layout);
            format!("no mass line can be fitted: {why}; look at test.band_hz")
        }
    }
}

/// A study of tests with this layout as text: a table for each method, then a summary.
pub fn to_text<R: Real, C: Capacity>(study: &Study, layout: &Layout<R, C>) -> String {
    let mut text = String::new();
    for method in study.methods.iter().filter(|m| m.answers > 0) {
        text += &format!("{}\n{}\n", method.name(), table_of(method));
    }
    if !text.is_empty() {
        text += &format!("{INERTIA_CONVENTION}\n");
    }
    for method in study.methods.iter().filter(|m| m.answers > 0) {
        text += &summary(method);
    }
    text += &study.stopping.as_ref().map_or_else(String::new, stopping_text);
    text += &refusals_text(&refusals(&never_answered(study), message));
    text += &match study.runs < study.wanted {
        true => format!("{} of {}", study.runs, runs(study.wanted)),
        false => runs(study.runs),
    };
    text += &format!(
        ", {} rejected and repeated; {} with a warning or a rejected hit, {} silently wrong\n",
        counted(study.rejected_hits, "hit"),
        runs(study.warned),
        study.silent
    );
    if let Some((count, first)) = &study.unmeasured {
        let why = measure_error_text(first, layout);
        text += &format!("{} without an answer, the first because: {why}\n", runs(count));
    }
    if study.is_single() {
        return text + "note: " + ONE_RUN;
    }
    if study.stopping.is_some() {
        text += "with a target, the bound is still that of all DOFs, which the runs do not all measure\n";
    }
    let bound = match study.profile {
        TestProfile::MassLine => "the Cramér-Rao bound at the truth, with the errors of the bench",
        TestProfile::Suspension => "the bound: what the global fit expects of its own errors",
    };
    text + &format!("ratio: rms error over {bound}\n")
        + "\
            width: mean width of the 95 % intervals over that which the bound permits\n\
            cover: share of the 95 % intervals that hold the truth\n\
            silently wrong: without a warning, a property off by more than three standard deviations"
}

/// A number of runs.
fn runs(count: impl Display) -> String {
    counted(count, "run")
}

fn table_of(method: &MethodStatistics) -> Table {
    let mut table = table();
    let error = if method.is_single() { "error" } else { "bias" };
    table.set_header(["", "truth", "unit", "bound", error, "rms", "ratio", "width", "cover"]);
    for (parameter, p) in INERTIAL_PARAMETERS.iter().zip(&method.properties) {
        let &InertialParameter { symbol, table_unit: unit, table_factor: factor, .. } = parameter;
        let exact = p.bound.or(p.rms).map(|sigma| sigma * factor);
        let number = |v: f64| as_exact_as(v * factor, exact);
        table.add_row([
            symbol.to_owned(),
            number(p.truth),
            unit.into(),
            or_dash(p.bound.map(number)),
            number(p.bias),
            or_dash(p.rms.map(number)),
            or_dash(p.ratio().map(|r| format!("{r:.2}"))),
            or_dash(p.width_ratio().map(|r| format!("{r:.2}"))),
            or_dash(p.coverage95.map(percent)),
        ]);
    }
    align_right(&mut table, [1, 3, 4, 5, 6, 7, 8]);
    table
}

fn summary(method: &MethodStatistics) -> String {
    let name = method.name();
    let number = |v: Option<f64>| or_dash(v.map(|v| format!("{v:.3}")));
    let mut text = if method.is_single() {
        format!("{name}: one answer")
    } else {
        format!(
            "{name}: rms/bound {} (geometric mean), {} (worst); width/bound {}; coverage {}",
            number(method.geometric_mean_ratio()),
            number(method.worst_ratio()),
            number(method.geometric_mean_width()),
            or_dash(method.pooled_coverage95().map(percent)),
        )
    };
    if method.unanswered > 0 {
        text += &format!("; {} without an answer", runs(method.unanswered));
        let reasons = method.reasons.iter().map(|(code, runs)| format!("{} {runs}", code.name()));
        let reasons: Vec<_> = reasons.collect();
        if !reasons.is_empty() {
            text += &format!(" ({})", reasons.join(", "));
        }
    }
    text + "\n"
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".into())
}
