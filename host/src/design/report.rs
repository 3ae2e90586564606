//! Predictions of layouts as JSON and as text.

use massline_protocol::LayoutHash;
use massline_shared::body::{INERTIAL_PARAMETERS, InertialParameter};
use massline_shared::design::{Criterion, Part};
use massline_shared::identify::{Applicability, Method};
use massline_shared::layout::{HostLayout, RIG_SENSORS, RigLayout};
use serde_json::{Map, Value, json};

use super::{Advice, DesignReport, Predicted, Suggestion};
use crate::layout_file::LayoutFile;
use crate::output::{align_right, table};
use crate::report::{hash_text, two_digits};

/// Error sources with a smaller share than this are not listed.
const MIN_SHARE: f64 = 0.005;

/// The prediction for a layout as JSON, without its diagnostics.
pub fn design_report_json(design_report: &DesignReport, file: &LayoutFile) -> Value {
    let mut value = of_both(&Judged {
        layout: &file.layout,
        predicted: design_report.predicted.as_ref(),
        applicability: &design_report.applicability,
        criterion: &design_report.criterion,
        whose: &design_report.whose,
    });
    value["error_sources"] = design_report.parts.iter().map(part_json).collect();
    value["advice"] = design_report.advice.as_ref().map_or(Value::Null, |a| advice_json(a, file));
    value
}

/// A layout and what is predicted for it.
struct Judged<'a> {
    layout: &'a HostLayout,
    predicted: Option<&'a Predicted>,
    applicability: &'a Applicability<f64>,
    criterion: &'a Criterion<f64>,
    whose: &'a str,
}

/// The keys that `layout check` and `layout suggest` have in common; they are equal for the same layout.
fn of_both(judged: &Judged<'_>) -> Value {
    let Judged { layout, predicted, applicability, criterion, whose } = judged;
    let mut value = predicted_json(*predicted);
    value["identifiable"] = json!(predicted.is_some());
    value["rank"] = json!(applicability.rank);
    value["condition"] = json!(applicability.condition);
    value["methods"] = methods_json(applicability);
    value["noise_m_per_s2_per_n"] = json!(criterion.noise);
    value["characteristic_length_m"] = json!(layout.characteristic_length());
    value["scale"] = ten(|k| json!(criterion.scale[k]));
    value["body"] = json!({ "source": whose, "properties": criterion.body.theta().as_slice() });
    value["sensors"] = layout.sensors.iter().map(|s| json!(s.node)).collect();
    value["hits"] = layout.hits.iter().map(|h| json!(h.dof.to_string())).collect();
    value["hits_per_dof"] = json!(layout.test.hits_per_dof);
    value["layout_hash"] = json!(layout.cast().and_then(|rig: RigLayout| hash_text(rig.hash())));
    value
}

/// A suggestion as JSON, without its diagnostics.
pub fn suggestion_json(suggestion: &Suggestion) -> Value {
    let mut value = of_both(&Judged {
        layout: &suggestion.layout,
        predicted: Some(&suggestion.predicted),
        applicability: &suggestion.applicability,
        criterion: &suggestion.criterion,
        whose: &suggestion.whose,
    });
    value["candidates"] = json!({
        "sensors": suggestion.candidates.sensors.len(),
        "hits": suggestion.candidates.hits.len(),
    });
    value["before"] = predicted_json(suggestion.before.as_ref());
    value
}

fn predicted_json(predicted: Option<&Predicted>) -> Value {
    json!({
        "sigma": ten(|k| json!(predicted.map(|p| p.sigma[k]))),
        "percent_of_scale": ten(|k| json!(predicted.map(|p| p.percent_of_scale[k]))),
        "total_percent_of_scale": predicted.map(|p| p.total_percent_of_scale),
    })
}

fn ten(of: impl Fn(usize) -> Value) -> Value {
    let members: Map<String, Value> =
        INERTIAL_PARAMETERS.iter().enumerate().map(|(k, p)| (p.name.to_owned(), of(k))).collect();
    Value::Object(members)
}

fn methods_json(applicability: &Applicability<f64>) -> Value {
    let methods = Method::of_mass_lines().map(|method| {
        let obstacles: Vec<_> = applicability.obstacles(method).map(|code| code.name()).collect();
        json!({
            "method": method.name(),
            "applicable": obstacles.is_empty(),
            "blocked_by": obstacles,
        })
    });
    methods.collect()
}

fn part_json(part: &Part<f64>) -> Value {
    json!({
        "source": part.source.name(),
        "share": part.share,
        "shares": ten(|k| json!(part.shares[k])),
    })
}

fn advice_json(advice: &Advice, file: &LayoutFile) -> Value {
    let layout = &file.layout;
    let hits = layout.hits.iter().zip(&advice.without_hits);
    let sensors = layout.sensors.iter().zip(&advice.without_sensors);
    json!({
        "further_hit": advice.further_hit.map(|(dof, total)| json!({
            "dof": dof.to_string(), "total_percent_of_scale": total,
        })),
        "further_sensor": advice.further_sensor.map(|(node, total)| json!({
            "node": node, "total_percent_of_scale": total,
        })),
        "without_hits": hits.map(|(hit, total)| json!({
            "dof": hit.dof.to_string(), "total_percent_of_scale": total,
        })).collect::<Vec<_>>(),
        "without_sensors": sensors.map(|(sensor, total)| json!({
            "node": sensor.node, "total_percent_of_scale": total,
        })).collect::<Vec<_>>(),
    })
}

/// The predicted uncertainty of a layout as text.
pub fn design_report_text(design_report: &DesignReport, file: &LayoutFile) -> String {
    let DesignReport { applicability, predicted: Some(predicted), .. } = design_report else {
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
        "{rows}\nall ten: {:.3} % of scale (root mean square); {}\n",
        predicted.total_percent_of_scale,
        most(&design_report.parts, |part| part.share, usize::MAX),
    );
    text += &format!(
        "L = {:.1} mm; rank {} of 10, condition {:.3}; {}\n",
        file.layout.characteristic_length() * 1e3,
        applicability.rank,
        applicability.condition,
        methods_text(applicability),
    );
    if let Some(advice) = &design_report.advice {
        text += &advice_text(advice, file);
    }
    text
}

/// The error sources with the largest shares.
fn most(parts: &[Part<f64>], share: impl Fn(&Part<f64>) -> f64, count: usize) -> String {
    let mut parts: Vec<_> = parts.iter().filter(|part| share(part) > MIN_SHARE).collect();
    parts.sort_by(|a, b| share(b).total_cmp(&share(a)));
    let words = parts.iter().take(count).map(|part| {
        format!("{} {:.0} %", part.source.name().replace('_', " "), 100.0 * share(part))
    });
    words.collect::<Vec<_>>().join(", ")
}

fn methods_text(applicability: &Applicability<f64>) -> String {
    let message_of = |method: Method| {
        let mut obstacles = applicability.obstacles(method);
        match obstacles.next() {
            None => format!("{} applies", method.name()),
            Some(code) => format!("{} does not apply ({})", method.name(), code.name()),
        }
    };
    Method::of_mass_lines().map(message_of).collect::<Vec<_>>().join(", ")
}

fn advice_text(advice: &Advice, file: &LayoutFile) -> String {
    let layout = &file.layout;
    let mut text = String::new();
    if let Some((dof, total)) = advice.further_hit {
        text += &format!("a further hit helps most at {dof}: {total:.3} %\n");
    }
    if let Some((node, total)) = advice.further_sensor {
        let beyond = if layout.sensors.len() < RIG_SENSORS {
            String::new()
        } else {
            format!(" (a rig has inputs for {RIG_SENSORS})")
        };
        text += &format!("a further sensor helps most on node {node}: {total:.3} %{beyond}\n");
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
fn least<'a, T>(all: &'a [T], totals: &[Option<f64>]) -> Option<(&'a T, f64)> {
    let known = all.iter().zip(totals).filter_map(|(one, total)| Some((one, (*total)?)));
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
        "{rows}\nall ten: {:.3} % of scale (root mean square; L = {:.1} mm, of the suggested sensors), now {now}\n{}\n",
        predicted.total_percent_of_scale,
        suggestion.length * 1e3,
        methods_text(&suggestion.applicability),
    )
}

/// The lines of a layout file, ready to be pasted.
pub fn lines(layout: &HostLayout) -> String {
    let sensors: Vec<_> = layout.sensors.iter().map(|s| s.node.to_string()).collect();
    let hits: Vec<_> = layout.hits.iter().map(|h| format!("\"{}\"", h.dof)).collect();
    format!("sensors = [{}]\nhits = [{}]", sensors.join(", "), hits.join(", "))
}
