//! What all methods say together, as a table and as JSON.

use std::ops::Range;

use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::identify::{Estimate, HALF_WIDTH_95, Method};
use massline_shared::layout::HostLayout;
use nalgebra::SVector;
use serde_json::{Value, json};

use super::{as_exact_as, two_digits};
use crate::output::{align_right, table};
use crate::suspension::Comparison;

/// All answers with their standard deviations, the combined one, and whether they agree; empty for fewer than two.
pub fn comparison_text(
    comparison: &Comparison,
    estimates: &[Estimate<f64>],
    layout: &HostLayout,
) -> String {
    if estimates.len() < 2 {
        return String::new();
    }
    let mut rows: Vec<Row> = estimates
        .iter()
        .map(|estimate| {
            let method = estimate.method;
            let place = comparison.methods.iter().position(|of| *of == Some(method));
            let propagated = place.and_then(|place| comparison.sigmas[place]);
            (method.name(), estimate.theta(), estimate.sigma().or(propagated))
        })
        .collect();
    if let Some(agreement) = &comparison.agreement {
        let sigma = agreement.covariance.diagonal().map(|v| v.max(0.0).sqrt());
        rows.push(("combined", agreement.theta, Some(sigma)));
    }
    let tables: String = [0..4, 4..7, 7..10].map(|columns| table_of(&rows, columns)).concat();
    let distances = distances_from_global_fit(estimates);
    format!("all methods on the same data\n{tables}{}\n{distances}", verdict(comparison, layout))
}

/// How far the other methods are from the global fit where they have been warned of it; empty otherwise.
fn distances_from_global_fit(estimates: &[Estimate<f64>]) -> String {
    let distance = |estimate: &Estimate<f64>| {
        let warned = |d: &&Diagnostic| d.code == Code::FlexibleModeAboveBand;
        let share = estimate.diagnostics.iter().find(warned)?.value;
        Some(format!("{} {:.1}", estimate.method.name(), 100.0 * share))
    };
    let all: Vec<String> = estimates.iter().filter_map(distance).collect();
    if all.is_empty() {
        return String::new();
    }
    format!("largest distance from the global fit, % of scale: {}\n", all.join(", "))
}

/// Name, values and standard deviations.
type Row = (&'static str, SVector<f64, 10>, Option<SVector<f64, 10>>);

/// Some of the ten properties of every row, each with its standard deviation below.
fn table_of(rows: &[Row], columns: Range<usize>) -> String {
    let mut all = table();
    let parameters = &INERTIAL_PARAMETERS[columns.clone()];
    let header = parameters.iter().map(|p| format!("{}, {}", p.symbol, p.table_unit));
    all.set_header(std::iter::once(String::new()).chain(header));
    align_right(&mut all, 1..=parameters.len());
    for (name, theta, sigma) in rows {
        let cells = columns.clone().zip(parameters).map(|(k, parameter)| {
            let factor = parameter.table_factor;
            let exact = sigma.map(|sigma| sigma[k] * factor);
            let spread = exact.map_or("-".into(), |sigma| as_exact_as(sigma, exact));
            format!("{}\n± {spread}", as_exact_as(theta[k] * factor, exact))
        });
        all.add_row(std::iter::once((*name).to_owned()).chain(cells));
    }
    format!("{all}\n")
}

/// Whether the methods agree, or which one is off.
fn verdict(comparison: &Comparison, layout: &HostLayout) -> String {
    if comparison.flexible {
        return "a flexible mode above the band moves the apparent mass, which only the global fit takes into account: \
                rely on it; the others are off by about their distance from it"
            .into();
    }
    let Some(agreement) = &comparison.agreement else {
        return "the methods cannot be compared: the uncertainty of their differences is not known"
            .into();
    };
    let name = |place: usize| method_at(comparison, place).map_or("a method", Method::name);
    let largest = agreement.pairs.iter().max_by(|a, b| {
        let size = |d: &massline_shared::identify::agreement::Difference<f64>| {
            (d.significant, d.difference.abs() / (d.sigma + f64::MIN_POSITIVE))
        };
        size(a).partial_cmp(&size(b)).unwrap_or(std::cmp::Ordering::Equal)
    });
    let Some(largest) = largest else { return String::new() };
    let parameter = &INERTIAL_PARAMETERS[largest.property];
    let [first, second] = largest.methods.map(name);
    let difference = format!(
        "{} of {first} and {second} differ by {} {}, {:.1} standard deviations of the difference",
        parameter.symbol,
        two_digits(largest.difference.abs() * parameter.table_factor),
        parameter.table_unit,
        largest.difference.abs() / largest.sigma,
    );
    match (agreement.agrees(), agreement.outlier) {
        (true, _) => format!("the methods agree: at most, {difference}"),
        (false, Some(outlier)) => format!(
            "{} is off: {difference}; {}. It is left out of the combined answer",
            name(outlier),
            method_at(comparison, outlier)
                .map_or_else(String::new, |method| reason(method, layout)),
        ),
        (false, None) => format!(
            "the methods disagree: {difference}; the combined standard deviations include the differences between the \
             methods"
        ),
    }
}

fn method_at(comparison: &Comparison, place: usize) -> Option<Method> {
    comparison.methods.get(place).copied().flatten()
}

/// What puts a method off while the others agree.
fn reason(method: Method, layout: &HostLayout) -> String {
    let entry = method.entry();
    if entry.uses_priors && !layout.priors.is_empty() {
        return "it uses [prior], which not all others do: check the values there".into();
    }
    format!("it is off when {}", entry.off_when)
}

/// The comparison as JSON; `null` for fewer than two answers.
pub fn comparison_json(comparison: &Comparison, layout: &HostLayout) -> Value {
    if comparison.methods.iter().flatten().count() < 2 {
        return Value::Null;
    }
    let name = |place: usize| method_at(comparison, place).map(Method::name);
    let Some(agreement) = &comparison.agreement else {
        let verdict = verdict(comparison, layout);
        let none = Value::Null;
        return json!({
            "agree": false, "off": none, "verdict": verdict, "combined": none, "pairs": [],
        });
    };
    let sigma = agreement.covariance.diagonal().map(|v| v.max(0.0).sqrt());
    let of_ten = |values: &SVector<f64, 10>| {
        let names = INERTIAL_PARAMETERS.iter().map(|parameter| parameter.name.to_owned());
        names.zip(values.iter().map(|v| json!(v))).collect::<serde_json::Map<_, _>>()
    };
    json!({
        "agree": agreement.agrees(),
        "off": agreement.outlier.and_then(name),
        "verdict": verdict(comparison, layout),
        "combined": {
            "value": of_ten(&agreement.theta),
            "sigma": of_ten(&sigma),
            "half_width95": of_ten(&(sigma * HALF_WIDTH_95)),
            "between_methods": of_ten(&agreement.between),
        },
        "pairs": agreement.pairs.iter().map(|pair| json!({
            "methods": pair.methods.map(name),
            "property": INERTIAL_PARAMETERS[pair.property].name,
            "difference": pair.difference,
            "sigma": pair.sigma,
            "significant": pair.significant,
        })).collect::<Vec<_>>(),
    })
}
