//! How precise the answer would be with the places hit so far, and which further place helps most.

use massline_shared::design::Widths;

use super::canvas::{Canvas, Screen, text};
use super::figures::symbol;
use crate::panel::number::{Text, decimals_for, fitting};
use crate::panel::{FurtherPlace, PanelModel, PrecisionModel, words};

/// The page with everything that is known.
pub(super) fn page<D: Screen>(canvas: &mut Canvas<'_, D>, model: &PanelModel) {
    let Some(precision) = &model.precision else { return };
    canvas.title("95 % within", &places(model, precision));
    widths(canvas, precision);
    if let Some(FurtherPlace { dof, property, half_widths: [now, then] }) = precision.further {
        let (factor, unit) = in_units(property);
        let (now, then) = (digits(now * factor, 4), digits(then * factor, 4));
        let symbol = symbol(usize::from(property).min(9));
        canvas.format(3, format_args!("{symbol} {now} to {then} {unit}"));
        canvas.format(4, format_args!("with {}", words::place(dof)));
    }
}

/// The question whether to finish.
pub(super) fn target_reached<D: Screen>(canvas: &mut Canvas<'_, D>, model: &PanelModel) {
    let Some(precision) = &model.precision else { return };
    canvas.title("Target reached", &places(model, precision));
    widths(canvas, precision);
    canvas.line(3, "OK: finish");
    canvas.line(4, "Next: hit the others");
}

/// The widths in one line, between a DOF and the first hit at the next; `None` at any other time.
pub(super) fn after_a_dof(model: &PanelModel) -> Option<Text> {
    let precision = between_dofs(model)?;
    Some(match &precision.widths {
        Some(Widths { mass, center, inertia }) => {
            let [mass, center, inertia] = [(0, mass), (1, center), (4, inertia)]
                .map(|(k, half)| digits(half * in_units(k).0, 3));
            text(format_args!("m {mass}% c {center}mm J {inertia}%"))
        }
        None => text(format_args!("more places needed")),
    })
}

/// The place that helps most, at the same time: a later one than the place to hit now.
pub(super) fn place_that_helps(model: &PanelModel) -> Option<Text> {
    let further = between_dofs(model)?.further?;
    let (_, now) = model.dof?;
    (further.dof != now).then(|| text(format_args!("later {}", words::place(further.dof))))
}

fn between_dofs(model: &PanelModel) -> Option<&PrecisionModel> {
    model.precision.as_ref().filter(|_| model.accepted == 0 && model.averaged > 0)
}

/// The number of places hit so far.
fn places(model: &PanelModel, precision: &PrecisionModel) -> Text {
    text(format_args!("{}/{}", precision.dofs, model.dofs))
}

fn widths<D: Screen>(canvas: &mut Canvas<'_, D>, precision: &PrecisionModel) {
    let Some(Widths { mass, center, inertia }) = precision.widths else {
        return canvas.lines(0, "More places are\nneeded.");
    };
    for (line, (name, property, half)) in
        [("mass", 0, mass), ("centre", 1, center), ("inertia", 4, inertia)].into_iter().enumerate()
    {
        let (factor, unit) = in_units(property);
        canvas.format(line, format_args!("{name:7} \u{b1}{} {unit}", digits(half * factor, 4)));
    }
}

/// How the half widths of a property are shown: a factor on the units of a target, and the unit.
fn in_units(property: u8) -> (f32, &'static str) {
    match property {
        0 => (100.0, "%"),
        1..=3 => (1000.0, "mm"),
        _ => (100.0, "% mL\u{b2}"),
    }
}

/// A number with two significant digits in this width.
fn digits(value: f32, width: usize) -> Text {
    fitting(value, decimals_for(value, 2), width)
}
