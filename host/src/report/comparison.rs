//! What all methods say together, as a table and as JSON.

use std::ops::Range;

use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::identify::agreement::{Difference, Outcome};
use massline_shared::identify::{Estimate, HALF_WIDTH_95, Method};
use massline_shared::layout::HostLayout;
use nalgebra::SVector;

use super::{INERTIA_CONVENTION, as_exact_as, message_in, two_digits};
use crate::document::{self, Properties};
use crate::output::{Tone, align_right, table};
use crate::suspension::{Comparison, Doubt};
use crate::verdict::Verdict;

/// All answers with their standard deviations, the combined one, and whether they agree; empty for fewer than two. `judged` is
/// the verdict on the best of them.
pub fn comparison_text(
    comparison: &Comparison,
    estimates: &[Estimate<f64>],
    layout: &HostLayout,
    judged: Option<Verdict>,
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
    let tone = tone(comparison, judged);
    let verdict = tone.mark(verdict(comparison, estimates, layout, judged));
    format!(
        "all methods on the same data, the best first\n{tables}{INERTIA_CONVENTION}\n{verdict}\n{distances}"
    )
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

/// Standard deviations of a difference from which methods hardly agree. Of a hundred differences by noise alone one in twenty sets
/// has one as large.
const HARDLY: f64 = 3.5;

/// How a verdict sounds.
fn tone(comparison: &Comparison, judged: Option<Verdict>) -> Tone {
    match (comparison.doubt, &comparison.agreement) {
        (None, Some(_)) if judged == Some(Verdict::DoNotUse) => Tone::Bad,
        (Some(Doubt::Misfit), _) => Tone::Bad,
        (None, Some(agreement)) if agreement.outcome() == Outcome::Agree => Tone::Good,
        _ => Tone::Warning,
    }
}

/// Whether the methods agree, or which ones are off.
fn verdict(
    comparison: &Comparison,
    estimates: &[Estimate<f64>],
    layout: &HostLayout,
    judged: Option<Verdict>,
) -> String {
    match comparison.doubt {
        Some(Doubt::FlexibleMode) => {
            return "a flexible mode above the band moves the apparent mass, which only the global fit takes into account: \
                    rely on it; the others are off by about their distance from it"
                .into();
        }
        Some(Doubt::Misfit) => {
            return "no body on a suspension fits these responses as well as their own modes do: rely on none of the \
                    answers before the cause is found"
                .into();
        }
        None => {}
    }
    let Some(agreement) = &comparison.agreement else {
        return "the methods cannot be compared: the uncertainty of their differences is not known"
            .into();
    };
    let name = |place: usize| method_at(comparison, place).map_or("a method", Method::name);
    let Some(largest) = agreement.largest() else { return String::new() };
    let difference = difference_text(largest, largest.methods.map(name));
    let outcome = agreement.outcome();
    if outcome == Outcome::Agree && judged == Some(Verdict::DoNotUse) {
        return format!(
            "none of these answers is to be used: that the methods agree with each other ({difference} at most) does not \
             make the data right"
        );
    }
    if outcome == Outcome::Agree {
        let hardly = largest.difference.abs() > HARDLY * largest.sigma;
        return match hardly {
            true => format!(
                "the methods hardly agree: {difference}; noise alone rarely makes so much, so check the layout and \
                 repeat the hits"
            ),
            false => format!("the methods agree: at most, {difference}"),
        };
    }
    let off: Vec<Method> =
        agreement.outliers.iter().filter_map(|place| method_at(comparison, *place)).collect();
    if outcome == Outcome::Differ {
        return format!(
            "the methods disagree: {difference}; the combined standard deviations include the differences between the \
             methods"
        );
    }
    let reasons = reasons(&off, estimates, layout);
    let (are, left_out) = if off.len() == 1 { ("is", "It is") } else { ("are", "They are") };
    let names = listed(&off);
    format!(
        "{names} {are} off: {difference}; {reasons}. {left_out} left out of the combined answer"
    )
}

/// A difference of two methods with these names, as a clause.
pub(super) fn difference_text(of: &Difference<f64>, [first, second]: [&str; 2]) -> String {
    let parameter = &INERTIAL_PARAMETERS[of.property];
    format!(
        "{} of {first} and {second} differ by {} {}, {:.1} standard deviations of the difference",
        parameter.symbol,
        two_digits(of.difference.abs() * parameter.table_factor),
        parameter.table_unit,
        of.difference.abs() / of.sigma,
    )
}

/// A difference of two methods with these names as JSON.
pub(super) fn difference_json(
    of: &Difference<f64>,
    methods: [Option<&'static str>; 2],
) -> document::Pair {
    document::Pair {
        methods,
        property: INERTIAL_PARAMETERS[of.property].name,
        difference: of.difference,
        sigma: of.sigma,
        significant: of.significant,
    }
}

/// `a`, `a and b`, `a, b and c`.
pub(super) fn listed(methods: &[Method]) -> String {
    let names: Vec<&str> = methods.iter().map(|method| method.name()).collect();
    match names.split_last() {
        Some((last, first)) if !first.is_empty() => format!("{} and {last}", first.join(", ")),
        _ => names.concat(),
    }
}

fn method_at(comparison: &Comparison, place: usize) -> Option<Method> {
    comparison.methods.get(place).copied().flatten()
}

/// What puts methods off while the others agree: what was found about the modes, or else what is known of the methods.
fn reasons(off: &[Method], estimates: &[Estimate<f64>], layout: &HostLayout) -> String {
    let of_off = estimates.iter().filter(|estimate| off.contains(&estimate.method));
    let mut found: Vec<String> = of_off
        .flat_map(|of| of.diagnostics.iter().map(move |d| (of.method.entry().doubted_by, d)))
        .filter(|(doubts, d)| doubts.contains(&d.code))
        .map(|(_, d)| message_in(d, layout))
        .collect();
    if found.is_empty() {
        found = off.iter().map(|method| reason(*method, layout)).collect();
    }
    let mut distinct = Vec::new();
    for reason in found {
        if !distinct.contains(&reason) {
            distinct.push(reason);
        }
    }
    distinct.join("; ")
}

/// What is known to put a method off.
fn reason(method: Method, layout: &HostLayout) -> String {
    let entry = method.entry();
    let name = method.name();
    if entry.uses_priors && !layout.priors.is_empty() {
        return format!("{name} uses [prior], which not all others do: check the values there");
    }
    format!("{name} is off when {}", entry.off_when)
}

/// The comparison as JSON; `None` for fewer than two answers.
pub fn comparison_json(
    comparison: &Comparison,
    estimates: &[Estimate<f64>],
    layout: &HostLayout,
    judged: Option<Verdict>,
) -> Option<document::Agreement> {
    if comparison.methods.iter().flatten().count() < 2 {
        return None;
    }
    let name = |place: usize| method_at(comparison, place).map(Method::name);
    let of_ten = |values: &SVector<f64, 10>| Properties::of((*values).into());
    let of_method = |(method, sigma): (&Option<Method>, &Option<SVector<f64, 10>>)| {
        let sigma = sigma.as_ref().map(of_ten);
        method.map(|method| document::OfMethod { method: method.name(), sigma })
    };
    let agreement = comparison.agreement.as_ref();
    let combined = agreement.map(|agreement| {
        let sigma = agreement.covariance.diagonal().map(|v| v.max(0.0).sqrt());
        document::Combined {
            value: of_ten(&agreement.theta),
            sigma: of_ten(&sigma),
            half_width95: of_ten(&(sigma * HALF_WIDTH_95)),
            between_methods: of_ten(&agreement.between),
        }
    });
    let pair = |pair: &Difference<f64>| difference_json(pair, pair.methods.map(name));
    let outliers = agreement.iter().flat_map(|agreement| &agreement.outliers);
    Some(document::Agreement {
        outcome: agreement.map(|agreement| agreement.outcome().name()),
        doubt: comparison.doubt.filter(|_| agreement.is_none()).map(Doubt::name),
        off: outliers.filter_map(|place| name(*place)).collect(),
        verdict: verdict(comparison, estimates, layout, judged),
        methods: comparison.methods.iter().zip(&comparison.sigmas).filter_map(of_method).collect(),
        combined,
        pairs: agreement.iter().flat_map(|agreement| agreement.pairs.iter().map(pair)).collect(),
    })
}
