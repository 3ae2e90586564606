//! A study as JSON and as tables.

use massline_shared::identify::Method;
use massline_shared::layout::PROPERTIES;
use serde_json::{Value, json};

use super::Study;
use super::statistics::{MethodStatistics, PropertyStatistics};
use crate::output;

/// Units of the tables and factors to them, in the order of the ten.
fn unit(property: usize) -> (&'static str, f64) {
    match property {
        0 => ("kg", 1.0),
        1..=3 => ("mm", 1e3),
        _ => ("g m²", 1e3),
    }
}

/// One object: `runs`, `methods` with the ten of each, SI units; coverages are shares from 0 to 1.
pub fn to_json(study: &Study) -> Value {
    json!({
        "runs": study.runs,
        "runs_wanted": study.wanted,
        "runs_without_mass_lines": study.unmeasured.map_or(0, |(count, _)| count),
        "rejected_hits": study.rejected_hits,
        "methods": study.methods.iter().map(method_json).collect::<Vec<_>>(),
    })
}

fn method_json(method: &MethodStatistics) -> Value {
    let properties = method.properties.iter().zip(PROPERTIES);
    json!({
        "method": method.method.name(),
        "answers": method.answers,
        "unanswered": method.unanswered,
        "geometric_mean_ratio": method.geometric_mean_ratio(),
        "worst_ratio": method.worst_ratio(),
        "pooled_coverage95": method.pooled_coverage95(),
        "properties": properties.map(|(p, name)| property_json(name, p)).collect::<Vec<_>>(),
    })
}

fn property_json(name: &str, p: &PropertyStatistics) -> Value {
    json!({
        "name": name,
        "truth": p.truth,
        "bias": p.bias,
        "rms": p.rms,
        "bound": p.bound,
        "ratio": p.ratio(),
        "coverage95": p.coverage95,
    })
}

/// For people: one table with the methods side by side, then what they come to.
pub fn to_text(study: &Study) -> String {
    let answered: Vec<&MethodStatistics> = study.methods.iter().filter(|m| m.answers > 0).collect();
    let mut text = String::new();
    if let Some(first) = answered.first() {
        let mut table = output::table();
        let mut header = vec![String::new(), "truth".into(), "unit".into(), "bound".into()];
        for method in &answered {
            let short = short_name(method.method);
            header.extend(["bias", "rms", "ratio", "cover"].map(|what| format!("{short} {what}")));
        }
        table.set_header(header);
        for (k, name) in PROPERTIES.into_iter().enumerate() {
            table.add_row(row(&answered, &first.properties[k], k, name));
        }
        output::align_right(&mut table, (1..4 + 4 * answered.len()).filter(|&k| k != 2));
        text += &format!("{table}\n");
    }
    for method in &study.methods {
        text += &summary(method);
    }
    text += &format!("{} runs", study.runs);
    if study.runs < study.wanted {
        text += &format!(" of {}", study.wanted);
    }
    text += &format!(", {} hits rejected and repeated\n", study.rejected_hits);
    if let Some((count, first)) = study.unmeasured {
        text += &format!("{count} runs have no mass lines, the first because: {first}\n");
    }
    text + "ratio: rms error over the Cramér-Rao bound at the truth; cover: share of the 95 % \
            intervals that hold the truth"
}

fn row(
    answered: &[&MethodStatistics],
    first: &PropertyStatistics,
    k: usize,
    name: &str,
) -> Vec<String> {
    let (unit, factor) = unit(k);
    let number = |v: f64| format!("{:.4}", v * factor);
    let mut row =
        vec![name.to_owned(), number(first.truth), unit.into(), or_dash(first.bound.map(number))];
    for method in answered {
        let p = &method.properties[k];
        row.extend([
            format!("{:+.4}", p.bias * factor),
            number(p.rms),
            or_dash(p.ratio().map(|r| format!("{r:.2}"))),
            or_dash(p.coverage95.map(percent)),
        ]);
    }
    row
}

fn summary(method: &MethodStatistics) -> String {
    let name = method.method.name();
    if method.answers == 0 {
        return format!("{name}: no answer in any run\n");
    }
    let number = |v: Option<f64>| or_dash(v.map(|v| format!("{v:.3}")));
    let mut text = format!(
        "{name}: rms/bound {} (geometric mean), {} (worst); coverage {}",
        number(method.geometric_mean_ratio()),
        number(method.worst_ratio()),
        or_dash(method.pooled_coverage95().map(percent)),
    );
    if method.unanswered > 0 {
        text += &format!("; {} runs without an answer", method.unanswered);
    }
    text + "\n"
}

fn short_name(method: Method) -> &'static str {
    match method {
        Method::InertiaRestraint => "IRM",
        Method::MaximumLikelihood => "ML",
        Method::GlobalFit => "global",
    }
}

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

fn or_dash(text: Option<String>) -> String {
    text.unwrap_or_else(|| "-".into())
}
