//! What all methods say together, as part of a result and as tables.

use std::ops::Range;

use massline_result::{Doubt, NamedValue, Properties, TestResult, Verdict};
use massline_shared::body::INERTIAL_PARAMETERS;
use massline_shared::identify::agreement::{Difference, Outcome};
use massline_shared::identify::{Estimate, HALF_WIDTH_95, Method};
use massline_shared::layout::HostLayout;
use nalgebra::SVector;

use super::{INERTIA_CONVENTION, in_interval, message_in, two_digits};
use crate::table::align_right;
use crate::table::table;
use crate::tone::Tone;
use massline_analysis::suspension::Comparison;

/// All answers of a result with their standard deviations, the combined one, and whether they agree; empty for fewer
/// than two.
pub fn agreement_text(result: &TestResult) -> String {
    let (Some(agreement), [_, _, ..]) = (&result.agreement, result.results.as_slice()) else {
        return String::new();
    };
    let of_method = |estimate: &massline_result::Estimate| {
        (estimate.method.name(), estimate.theta(), estimate.half_widths())
    };
    let mut rows: Vec<Row> = result.results.iter().map(of_method).collect();
    if let Some(combined) = &agreement.combined {
        let half_widths = combined.half_width95.in_order();
        rows.push(("combined", combined.value.in_order(), Some(half_widths)));
    }
    let tables: String = [0..4, 4..7, 7..10].map(|columns| table_of(&rows, columns)).concat();
    let tone = match (agreement.doubt, agreement.outcome.map(|outcome| outcome.0)) {
        (Some(Doubt::Misfit), _) => Tone::Bad,
        (_, Some(Outcome::Agree)) if result.verdict != Some(Verdict::DoNotUse) => Tone::Good,
        _ => Tone::Warning,
    };
    format!(
        "all methods on the same data, the best first (± 95 %)\n{tables}{INERTIA_CONVENTION}\n{}\n",
        tone.mark(agreement.sentence.clone())
    )
}

/// Name, values, and half the widths of the 95 % intervals.
type Row = (&'static str, [f64; 10], Option<[f64; 10]>);

/// Some of the ten properties of every row, each with half the width of its 95 % interval below.
fn table_of(rows: &[Row], columns: Range<usize>) -> String {
    let mut table = table();
    let parameters = &INERTIAL_PARAMETERS[columns.clone()];
    let header = parameters.iter().map(|p| format!("{}, {}", p.symbol, p.table_unit));
    table.set_header(std::iter::once(String::new()).chain(header));
    align_right(&mut table, 1..=parameters.len());
    for (name, theta, half_widths) in rows {
        let cells = columns.clone().zip(parameters).map(|(k, parameter)| {
            let factor = parameter.table_factor;
            let half = half_widths.map(|half| half[k] * factor);
            let value = in_interval(theta[k] * factor, half);
            match half {
                Some(half_width) => format!("{value}\n± {}", in_interval(half_width, half)),
                None => value,
            }
        });
        table.add_row(std::iter::once((*name).to_owned()).chain(cells));
    }
    format!("{table}\n")
}

/// Standard deviations of a difference from which methods hardly agree. Of a hundred differences by noise alone one in
/// twenty sets has one as large.
const HARDLY: f64 = 3.5;

/// Whether the methods agree, or which ones are off.
fn sentence(
    comparison: &Comparison,
    estimates: &[Estimate<f64>],
    layout: &HostLayout,
    judged: Option<Verdict>,
) -> String {
    match comparison.doubt {
        Some(Doubt::FlexibleMode) => {
            return "a flexible mode above the band moves the apparent mass, which only the global fit takes into \
                    account: rely on it; the others are off by about their distance from it"
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
            "none of these answers is to be used: that the methods agree with each other ({difference} at most) does \
             not make the data right"
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
pub(super) fn difference_text(difference: &Difference<f64>, [first, second]: [&str; 2]) -> String {
    let parameter = &INERTIAL_PARAMETERS[difference.property];
    format!(
        "{} of {first} and {second} differ by {} {}, {:.1} standard deviations of the difference",
        parameter.symbol,
        two_digits(difference.difference.abs() * parameter.table_factor),
        parameter.table_unit,
        difference.difference.abs() / difference.sigma,
    )
}

/// A difference of two methods as part of a result.
pub(super) fn pair(
    difference: &Difference<f64>,
    methods: [Option<NamedValue<Method>>; 2],
) -> massline_result::Pair {
    massline_result::Pair {
        methods,
        property: INERTIAL_PARAMETERS[difference.property].symbol.into(),
        difference: difference.difference,
        sigma: difference.sigma,
        significant: difference.significant,
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
    let mut reasons: Vec<String> = of_off
        .flat_map(|estimate| {
            estimate.diagnostics.iter().map(move |d| (estimate.method.entry().doubted_by, d))
        })
        .filter(|(doubts, d)| doubts.contains(&d.code))
        .map(|(_, d)| message_in(d, layout))
        .collect();
    if reasons.is_empty() {
        reasons = off.iter().map(|method| reason(*method, layout)).collect();
    }
    let mut distinct = Vec::new();
    for reason in reasons {
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

/// What all methods say together, as part of a result; `None` for fewer than two. `judged` is the verdict on the best
/// of them.
pub fn agreement(
    comparison: &Comparison,
    estimates: &[Estimate<f64>],
    layout: &HostLayout,
    judged: Option<Verdict>,
) -> Option<massline_result::Agreement> {
    if comparison.methods.iter().flatten().count() < 2 {
        return None;
    }
    let named = |place: usize| method_at(comparison, place).map(NamedValue);
    let of_ten = |values: &SVector<f64, 10>| Properties::of((*values).into());
    let of_method = |(method, sigma): (&Option<Method>, &Option<SVector<f64, 10>>)| {
        let sigma = sigma.as_ref().map(of_ten);
        method.map(|method| massline_result::MethodSigma { method: method.into(), sigma })
    };
    let agreement = comparison.agreement.as_ref();
    let combined = agreement.map(|agreement| {
        let sigma = agreement.covariance.diagonal().map(|v| v.max(0.0).sqrt());
        massline_result::CombinedAnswer {
            value: of_ten(&agreement.theta),
            sigma: of_ten(&sigma),
            half_width95: of_ten(&(sigma * HALF_WIDTH_95)),
            between_methods: of_ten(&agreement.between),
        }
    });
    let of_two = |difference: &Difference<f64>| pair(difference, difference.methods.map(named));
    let outliers = agreement.iter().flat_map(|agreement| &agreement.outliers);
    Some(massline_result::Agreement {
        outcome: agreement.map(|agreement| agreement.outcome().into()),
        doubt: comparison.doubt.filter(|_| agreement.is_none()),
        off: outliers.filter_map(|place| named(*place)).collect(),
        sentence: sentence(comparison, estimates, layout, judged),
        methods: comparison.methods.iter().zip(&comparison.sigmas).filter_map(of_method).collect(),
        combined,
        pairs: agreement.iter().flat_map(|agreement| agreement.pairs.iter().map(of_two)).collect(),
    })
}
