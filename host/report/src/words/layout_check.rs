//! Predictions of layouts as JSON and as text.

use std::ops::Range;

use massline_protocol::LayoutHash;
use massline_result::{ErrorSource, Mode, Properties};
use massline_shared::body::{INERTIAL_PARAMETERS, InertialParameter};
use massline_shared::design::{Part, Predict};
use massline_shared::diagnosis::Code;
use massline_shared::identify::Method;
use massline_shared::layout::{Dof, HostLayout, RIG_SENSORS, RigLayout};

use massline_analysis::design::{
    Advice, DesignReport, Forecast, LayoutCriterion, LayoutFindings, Options, PredictedUncertainty,
    Suggestion,
};

use super::{
    INERTIA_CONVENTION, better_hits_text, hash_text, indicators_text, message_in, refusals,
    refusals_text, source_words, suspension_mode, two_digits,
};
use crate::document::{
    self, AssumedBody, CandidateCounts, ForecastAnswer, HitTotal, JudgedLayout, JudgedMethod,
    LayoutCheck, LayoutSuggestion, Prediction, SensorTotal,
};
use crate::table::align_right;
use crate::table::table;
use massline_files::layout_file::LayoutFile;

/// Error sources with a smaller share than this are not listed.
const MIN_SHARE: f64 = 0.005;

/// The prediction for a layout as JSON; `noise` is relative to 1/mass.
pub fn design_report_json(
    design_report: &DesignReport,
    file: &LayoutFile,
    noise: f64,
    forecast: Option<&Forecast>,
    notes: Vec<String>,
) -> LayoutCheck {
    let judged = LayoutJudgement {
        layout: &file.layout,
        predicted: design_report.predicted.as_ref(),
        findings: &design_report.findings,
        criterion: &design_report.criterion,
        whose: &design_report.whose,
        noise,
        forecast,
    };
    LayoutCheck {
        judged: judged.to_json(notes),
        error_sources: design_report.parts.iter().map(error_source).collect(),
        advice: design_report.advice.as_ref().map(|advice| advice_json(advice, file)),
    }
}

/// A suggestion as JSON, not yet written to a file.
pub fn suggestion_json(
    suggestion: &Suggestion,
    options: &Options,
    forecast: Option<&Forecast>,
    notes: Vec<String>,
) -> LayoutSuggestion {
    let judged = LayoutJudgement {
        layout: &suggestion.layout,
        predicted: Some(&suggestion.predicted),
        findings: &suggestion.findings,
        criterion: &suggestion.criterion,
        whose: &suggestion.whose,
        noise: options.noise,
        forecast,
    };
    LayoutSuggestion {
        judged: judged.to_json(notes),
        candidates: CandidateCounts {
            sensors: suggestion.candidates.sensors.len(),
            hits: suggestion.candidates.hits.len(),
        },
        before: prediction_json(suggestion.before.as_ref()),
        seed: options.seed,
        starts: options.starts,
        written: None,
    }
}

/// A layout and what is predicted for it.
struct LayoutJudgement<'a> {
    layout: &'a HostLayout,
    predicted: Option<&'a PredictedUncertainty>,
    findings: &'a LayoutFindings,
    criterion: &'a LayoutCriterion,
    whose: &'a str,
    noise: f64,
    forecast: Option<&'a Forecast>,
}

impl LayoutJudgement<'_> {
    /// The keys that `layout check` and `layout suggest` have in common; they are equal for the same layout.
    fn to_json(&self, notes: Vec<String>) -> JudgedLayout {
        let Self { layout, predicted, findings, criterion, whose, noise, forecast } = *self;
        let diagnostics = &findings.diagnostics;
        JudgedLayout {
            prediction: prediction_json(predicted),
            identifiable: predicted.is_some() && forecast.is_none_or(Forecast::has_answer),
            rank: findings.equations.map(|(rank, _)| rank),
            condition: findings
                .equations
                .map(|equations| equations.1)
                .filter(|condition| condition.is_finite()),
            methods: findings.methods.iter().map(method_json).collect(),
            noise_m_per_s2_per_n: criterion.noise(),
            noise,
            forecast: forecast.map(|forecast| forecast_json(forecast, layout)),
            characteristic_length_m: layout.characteristic_length(),
            scale: Properties::of((*criterion.scale()).into()),
            body: AssumedBody {
                source: whose.to_owned(),
                properties: criterion.body().theta().into(),
            },
            sensors: layout.sensors.iter().map(|sensor| sensor.node).collect(),
            hits: layout.hits.iter().map(|hit| hit.dof.to_string()).collect(),
            hits_per_dof: layout.test.hits_per_dof,
            layout_hash: layout.cast().and_then(|rig: RigLayout| hash_text(rig.hash())),
            codes: diagnostics.iter().map(|d| d.code.name().to_owned()).collect(),
            diagnostics: super::findings(diagnostics, |d| message_in(d, layout)),
            notes,
        }
    }
}

fn forecast_json(forecast: &Forecast, layout: &HostLayout) -> document::Forecast {
    let answer = |(method, predicted): &(Method, PredictedUncertainty)| ForecastAnswer {
        method: method.name().into(),
        prediction: prediction_json(Some(predicted)),
    };
    document::Forecast {
        answers: forecast.answers.iter().map(answer).collect(),
        not_applicable: refusals(&forecast.refusals, |d| message_in(d, layout)),
        combined: prediction_json(forecast.combined.as_ref()),
        modes: modes_of(forecast, layout),
    }
}

fn prediction_json(predicted: Option<&PredictedUncertainty>) -> Prediction {
    let ten = |quantity: fn(&PredictedUncertainty) -> [f64; 10]| match predicted {
        Some(predicted) => Properties::of(quantity(predicted).map(Some)),
        None => Properties::of([None; 10]),
    };
    Prediction {
        sigma: ten(|p| p.sigma),
        percent_of_scale: ten(|p| p.percent_of_scale),
        total_percent_of_scale: predicted.map(|p| p.total_percent_of_scale),
    }
}

fn method_json((method, obstacles): &(Method, Vec<Code>)) -> JudgedMethod {
    JudgedMethod {
        method: method.name().into(),
        applicable: obstacles.is_empty(),
        blocked_by: obstacles.iter().map(|code| code.name().to_owned()).collect(),
    }
}

/// What a source of error contributes, as part of a document.
pub fn error_source(part: &Part<f64>) -> ErrorSource {
    ErrorSource {
        source: part.source.name().into(),
        share: part.share,
        shares: Properties::of(part.shares.into()),
    }
}

fn advice_json(advice: &Advice, file: &LayoutFile) -> document::Advice {
    let layout = &file.layout;
    let hit = |dof: Dof, total| HitTotal { dof: dof.to_string(), total_percent_of_scale: total };
    let sensor = |node, total| SensorTotal { node, total_percent_of_scale: total };
    let hits = layout.hits.iter().zip(&advice.without_hits);
    let sensors = layout.sensors.iter().zip(&advice.without_sensors);
    document::Advice {
        further_hit: advice.further_hit.map(|(dof, total)| hit(dof, Some(total))),
        further_sensor: advice.further_sensor.map(|(node, total)| sensor(node, Some(total))),
        without_hits: hits.map(|(layout_hit, total)| hit(layout_hit.dof, *total)).collect(),
        without_sensors: sensors
            .map(|(layout_sensor, total)| sensor(layout_sensor.node, *total))
            .collect(),
    }
}

/// The predicted uncertainty of a layout as text.
pub fn design_report_text(design_report: &DesignReport, file: &LayoutFile) -> String {
    let DesignReport { findings, predicted: Some(predicted), .. } = design_report else {
        return String::new();
    };
    let mut rows = table();
    rows.set_header(["", "± sd", "unit", "% of scale", "mostly from"]);
    for (k, parameter) in INERTIAL_PARAMETERS.iter().enumerate() {
        let &InertialParameter { symbol, table_unit: unit, table_factor: factor, .. } = parameter;
        rows.add_row([
            symbol.to_owned(),
            two_digits(predicted.sigma[k] * factor),
            unit.to_owned(),
            format!("{:.3}", predicted.percent_of_scale[k]),
            most(&design_report.parts, |part| part.shares[k], 2),
        ]);
    }
    align_right(&mut rows, [1, 3]);
    let mut text = format!(
        "{rows}\n{INERTIA_CONVENTION}\nall ten: {:.3} % of scale (root mean square); {}\n",
        predicted.total_percent_of_scale,
        most(&design_report.parts, |part| part.share, usize::MAX),
    );
    text += &format!(
        "L = {:.1} mm{}\n",
        file.layout.characteristic_length() * 1e3,
        equations_text(findings),
    );
    if let Some(advice) = &design_report.advice {
        text += &advice_text(advice, &file.layout, true);
    }
    text
}

/// What each method would answer as text: how uncertain, and why some have no answer; then the modes.
pub fn forecast_text(forecast: &Forecast, layout: &HostLayout) -> String {
    let mut rows: Vec<(&str, &PredictedUncertainty)> =
        forecast.answers.iter().map(|(method, predicted)| (method.name(), predicted)).collect();
    rows.extend(forecast.combined.iter().map(|predicted| ("combined", predicted)));
    let mut text = String::new();
    if !rows.is_empty() {
        text += "each method, ± sd, in a test that was computed with this noise and solved\n";
        text += &deviations(&rows, 0..4, true);
        text += &deviations(&rows, 4..10, false);
    }
    text += &refusals_text(&refusals(&forecast.refusals, |d| message_in(d, layout)));
    let modes = modes_of(forecast, layout);
    let hz: Vec<_> = modes.iter().map(|mode| format!("{:.1}", mode.frequency_hz.value)).collect();
    text += &format!("modes at {} Hz\n", hz.join(", "));
    text + &indicators_text(&modes) + &better_hits_text(&modes).concat()
}

/// The modes that the hits hardly move, and which hit would: a line each.
pub fn unmoved(forecast: &Forecast, layout: &HostLayout) -> String {
    better_hits_text(&modes_of(forecast, layout)).concat()
}

fn modes_of(forecast: &Forecast, layout: &HostLayout) -> Vec<Mode> {
    forecast.modes.iter().map(|mode| suspension_mode(mode, layout)).collect()
}

/// Standard deviations of some properties, and if wanted of all in % of scale: a row for each method.
fn deviations(
    rows: &[(&str, &PredictedUncertainty)],
    columns: Range<usize>,
    with_total: bool,
) -> String {
    let mut table = table();
    let parameters = &INERTIAL_PARAMETERS[columns.clone()];
    let header = parameters.iter().map(|p| format!("{}, {}", p.symbol, p.table_unit));
    let total = with_total.then(|| "all ten, % of scale".to_owned());
    table.set_header(std::iter::once(String::new()).chain(header).chain(total));
    align_right(&mut table, 1..=parameters.len() + usize::from(with_total));
    for (name, predicted) in rows {
        let cells = columns.clone().zip(parameters);
        let cells =
            cells.map(|(k, parameter)| two_digits(predicted.sigma[k] * parameter.table_factor));
        let total = with_total.then(|| format!("{:.2}", predicted.total_percent_of_scale));
        table.add_row(std::iter::once((*name).to_owned()).chain(cells).chain(total));
    }
    format!("{table}\n")
}

/// The error sources with the largest shares.
pub fn most(parts: &[Part<f64>], share: impl Fn(&Part<f64>) -> f64, count: usize) -> String {
    let mut parts: Vec<_> = parts.iter().filter(|part| share(part) > MIN_SHARE).collect();
    parts.sort_by(|a, b| share(b).total_cmp(&share(a)));
    let words = parts
        .iter()
        .take(count)
        .map(|part| format!("{} {:.0} %", source_words(part.source.name()), 100.0 * share(part)));
    words.collect::<Vec<_>>().join(", ")
}

/// Rank and condition of the equations of mass lines, and which methods apply.
fn equations_text(findings: &LayoutFindings) -> String {
    let Some((rank, condition)) = findings.equations else { return String::new() };
    format!("; rank {rank} of 10, condition {condition:.3}{}", methods_text(findings))
}

/// Which methods of mass lines apply; of those that use suspension modes there is a forecast.
fn methods_text(findings: &LayoutFindings) -> String {
    if findings.equations.is_none() {
        return String::new();
    }
    let message_of = |(method, obstacles): &(Method, Vec<Code>)| match obstacles.first() {
        None => format!("{} applies", method.name()),
        Some(code) => format!("{} does not apply ({})", method.name(), code.name()),
    };
    let each: Vec<_> = findings.methods.iter().map(message_of).collect();
    format!("; {}", each.join(", "))
}

/// What one sensor or hit more or less would change, a line each; `of_rig` for a layout that a rig is to measure.
pub fn advice_text(advice: &Advice, layout: &HostLayout, of_rig: bool) -> String {
    let mut text = String::new();
    if let Some((dof, total)) = advice.further_hit {
        text += &format!(
            "a further hit helps most at {dof}: it would bring the total to {total:.3} %\n"
        );
    }
    if let Some((node, total)) = advice.further_sensor {
        let beyond = if !of_rig || layout.sensors.len() < RIG_SENSORS {
            String::new()
        } else {
            format!(" (a rig has inputs for {RIG_SENSORS})")
        };
        text += &format!(
            "a further sensor helps most on node {node}: it would bring the total to {total:.3} %{beyond}\n"
        );
    }
    if let Some((hit, total)) = least(&layout.hits, &advice.without_hits) {
        text += &format!("least useful hit: {}; {total:.3} % without it\n", hit.dof);
    }
    if let Some((sensor, total)) = least(&layout.sensors, &advice.without_sensors) {
        let node = sensor.node;
        text += &format!("least useful sensor: on node {node}; {total:.3} % without it\n");
    }
    text
}

/// The entry whose removal costs least; `None` when none can be removed.
fn least<'a, T>(items: &'a [T], totals: &[Option<f64>]) -> Option<(&'a T, f64)> {
    let known = items.iter().zip(totals).filter_map(|(one, total)| Some((one, (*total)?)));
    known.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The prediction for a suggestion beside that for the file's own layout, as text.
pub fn suggestion_text(suggestion: &Suggestion) -> String {
    let Suggestion { predicted, before, .. } = suggestion;
    let mut rows = table();
    rows.set_header(["", "± sd now", "± sd suggested", "unit", "% of scale now", "suggested"]);
    for (k, parameter) in INERTIAL_PARAMETERS.iter().enumerate() {
        let &InertialParameter { symbol, table_unit: unit, table_factor: factor, .. } = parameter;
        let now = before.as_ref().map_or("-".into(), |p| format!("{:.3}", p.percent_of_scale[k]));
        rows.add_row([
            symbol.to_owned(),
            before.as_ref().map_or("-".into(), |p| two_digits(p.sigma[k] * factor)),
            two_digits(predicted.sigma[k] * factor),
            unit.to_owned(),
            now,
            format!("{:.3}", predicted.percent_of_scale[k]),
        ]);
    }
    align_right(&mut rows, [1, 2, 4, 5]);
    let now = match before {
        Some(before) => format!("{:.3} %", before.total_percent_of_scale),
        None => "not determined".to_owned(),
    };
    format!(
        "{rows}\nall ten: {:.3} % of scale (root mean square; L = {:.1} mm, of the suggested sensors), now {now}{}\n",
        predicted.total_percent_of_scale,
        suggestion.length * 1e3,
        methods_text(&suggestion.findings),
    )
}

/// The lines of a layout file, ready to be pasted.
pub fn lines(layout: &HostLayout) -> String {
    let sensors: Vec<_> = layout.sensors.iter().map(|s| s.node.to_string()).collect();
    let hits: Vec<_> = layout.hits.iter().map(|h| format!("\"{}\"", h.dof)).collect();
    format!("sensors = [{}]\nhits = [{}]", sensors.join(", "), hits.join(", "))
}
