//! The list of stored results, and the pages of one result.

use massline_protocol::message::ResultEntry;
use massline_shared::identify::{Estimate, Verdict};
use massline_shared::layout::{HitUncertainty, RigLayout};

use super::View;
use super::canvas::{Canvas, Screen, text};
use super::figures::{quantity, symbol};
use super::lists;
use crate::panel::number::{Text, decimals_for, fitting, percent};
use crate::panel::summary::{Page, Summary};

/// Millimeters of a meter, gram square meters of a kilogram square meter.
const MILLI: f32 = 1000.0;

/// The list of results.
pub(super) fn list<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    canvas.title("Results", &text(format_args!("{}", view.results.len())));
    if view.results.is_empty() {
        canvas.lines(1, "None yet.");
        return;
    }
    let lines: heapless::Vec<Text, { crate::store::RESULTS }> =
        view.results.iter().take(crate::store::RESULTS).map(of_entry).collect();
    canvas.list(lines.iter().map(|line| line.as_str()), usize::from(view.menu.cursor()));
}

fn of_entry(entry: &ResultEntry) -> Text {
    match entry.mass {
        Some(mass) => {
            let decimals = mass.sigma.map_or(3, |sigma| decimals_for(sigma, 2));
            text(format_args!("{:>4}  {} kg", entry.number, fitting(mass.value, decimals, 8)))
        }
        None => text(format_args!("{:>4}  not solved", entry.number)),
    }
}

/// A page of the open result.
pub(super) fn page<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    let Some(summary) = view.summary else { return };
    let place = view.menu.cursor();
    let page = summary.page(place);
    let pages = text(format_args!("{}/{}", place + 1, summary.pages()));
    canvas.title(&title(page, summary), &pages);
    match (page, &summary.answer) {
        (Page::Finding(finding), _) => finding_page(canvas, view, summary, finding, &pages),
        (Page::NoAnswer, _) => canvas.lines(0, "No answer: the next\npages say why."),
        (Page::Mass, Some(answer)) => {
            canvas.line(0, summary.verdict.map_or("", of_verdict));
            property(canvas, answer, 1, 0, 1.0, "kg");
            (1..4).for_each(|k| property(canvas, answer, 1 + k, k, MILLI, "mm"));
        }
        (Page::Moments, Some(answer)) => inertia(canvas, answer, 4),
        (Page::Products, Some(answer)) => inertia(canvas, answer, 7),
        (Page::Principal, Some(answer)) => principal(canvas, answer),
        (Page::Limits, Some(answer)) => limits(canvas, answer),
        (Page::Budget, Some(answer)) => budget(canvas, answer, own_layout(view, summary)),
        (Page::Lines, _) => lines(canvas, summary),
        _ => {}
    }
}

fn title(page: Page, summary: &Summary) -> Text {
    match page {
        Page::NoAnswer | Page::Lines | Page::Mass => {
            text(format_args!("Result {}", summary.number))
        }
        Page::Moments | Page::Products => text(format_args!("Inertia g m\u{b2}")),
        Page::Principal => text(format_args!("Principal g m\u{b2}")),
        Page::Limits => text(format_args!("What limits it")),
        Page::Budget => text(format_args!("Error budget")),
        Page::Finding(_) => Text::new(),
    }
}

/// Whether an answer can be used.
fn of_verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::Good => "Verdict: good",
        Verdict::UseWithCare => "Use with care",
        Verdict::DoNotUse => "Do not use",
    }
}

/// Lines that are stored: the program solves them.
fn lines<D: Screen>(canvas: &mut Canvas<'_, D>, summary: &Summary) {
    canvas.format(0, format_args!("{} places stored.", summary.places_with_lines));
    canvas.lines(1, "The program solves it:\nmassline");
    canvas.format(3, format_args!("results get {}", summary.number));
}

fn inertia<D: Screen>(canvas: &mut Canvas<'_, D>, answer: &Estimate<f32>, first: usize) {
    (0..3).for_each(|k| property(canvas, answer, k, first + k, MILLI, ""));
    canvas.line(4, "about the centre");
}

fn finding_page<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    view: &View<'_>,
    summary: &Summary,
    finding: u8,
    pages: &str,
) {
    let Some(diagnostic) = summary.findings.get(usize::from(finding)) else { return };
    lists::finding(canvas, diagnostic, own_layout(view, summary), pages);
}

/// The layout of a result, if it is the one in use: the names of nodes of another layout would mislead.
fn own_layout<'v>(view: &'v View<'_>, summary: &Summary) -> Option<&'v RigLayout> {
    view.layout.filter(|_| view.layout_hash == summary.layout_hash)
}

/// The stated scatter of the hits, if it is the same at every DOF.
fn common_scatter(layout: &RigLayout) -> Option<HitUncertainty<f32>> {
    let (first, others) = layout.hits.split_first()?;
    let same = others.iter().all(|hit| hit.uncertainty == first.uncertainty);
    same.then_some(first.uncertainty)
}

/// What the data have taught about the error budget: the scatter of the hits beside the stated one, and the
/// scale of the errors of sensors and marks.
fn budget<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    answer: &Estimate<f32>,
    layout: Option<&RigLayout>,
) {
    let Some(learned) = &answer.learned else { return canvas.line(0, "used as stated") };
    match layout.and_then(common_scatter) {
        _ if learned.scatter_degrees_of_freedom == 0 => canvas.line(0, "hits: as stated"),
        Some(stated) => {
            canvas.line(0, "your hits    (stated)");
            let row = |stated: f32, scale: f32, unit: &str| {
                let in_milli =
                    |value: f32| fitting(value * MILLI, decimals_for(value * MILLI, 2), 5);
                text(format_args!("{} {unit} ({})", in_milli(stated * scale), in_milli(stated)))
            };
            canvas.pair(1, "place", &row(stated.position, learned.scales.hit_position, "mm"));
            canvas.pair(2, "turn", &row(stated.direction, learned.scales.hit_direction, "mrad"));
        }
        None => {
            canvas.line(0, "your hits:");
            let row = |scale: f32| text(format_args!("{} x stated", fitting(scale, 2, 6)));
            canvas.pair(1, "place", &row(learned.scales.hit_position));
            canvas.pair(2, "turn", &row(learned.scales.hit_direction));
        }
    }
    if learned.constant_log_variance > 0.0 {
        canvas.line(3, "sensors and marks:");
        let scale = fitting(learned.scales.constant, 2, 6);
        canvas.format(4, format_args!("{scale} x as stated"));
    } else {
        canvas.line(3, "sensors: as stated");
    }
}

fn property<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    answer: &Estimate<f32>,
    line: usize,
    k: usize,
    scale: f32,
    unit: &str,
) {
    let sigma = answer.sigma().map(|sigmas| sigmas[k] * scale);
    quantity(canvas, line, &symbol(k), answer.theta()[k] * scale, sigma, unit);
}

fn principal<D: Screen>(canvas: &mut Canvas<'_, D>, answer: &Estimate<f32>) {
    let Some(principal) = answer.body.principal() else { return canvas.line(0, "not finite") };
    let sigmas = answer.covariance.as_ref().map(|c| principal.moment_sigmas(c));
    for (k, moment) in principal.moments.iter().enumerate() {
        let sigma = sigmas.map(|sigmas| sigmas[k] * MILLI);
        quantity(canvas, k, ["J1", "J2", "J3"][k], moment * MILLI, sigma, "");
    }
}

/// What limits the accuracy: the method, whether the data agree with the stated uncertainties, the
/// condition number of the equations, and the least known parameter.
fn limits<D: Screen>(canvas: &mut Canvas<'_, D>, answer: &Estimate<f32>) {
    canvas.line(0, answer.method.entry().title);
    match answer.consistency {
        Some(consistency) => {
            let rejected = consistency.rejects_budget();
            let verdict = if rejected { "residuals too large" } else { "residuals as expected" };
            canvas.line(1, verdict);
            let chi = fitting(consistency.chi_squared, 1, 6);
            canvas.format(2, format_args!("chi\u{b2} {chi} of {}", consistency.degrees_of_freedom));
        }
        None => canvas.line(1, "scatter of hits only"),
    }
    canvas.pair(3, "condition", &fitting(answer.condition, 1, 8));
    if let Some((k, share)) = answer.least_known() {
        canvas.pair(4, "least known", &text(format_args!("{} {}", symbol(k), percent(share))));
    }
}
