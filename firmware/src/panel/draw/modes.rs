//! The pages of a result about the suspension modes and the methods that use them.

use massline_protocol::modes::{StoredAgreement, StoredMode, StoredRefusal};
use massline_shared::body::{INERTIAL_PARAMETERS, RigidBody};
use massline_shared::diagnosis::Diagnostic;
use massline_shared::identify::Method;
use massline_shared::identify::agreement::Outcome;
use massline_shared::layout::{AXIS_LETTERS, RigLayout, motion_at};
use massline_shared::modes::{Shown, energy_shares, norm_indicator_of_shape};
use massline_shared::nalgebra::Vector6;

use super::canvas::{Canvas, LINE, LINES, Screen, text, top};
use super::figures::{figures, symbol};
use crate::panel::number::{Text, decimals_for, fitting};
use crate::panel::summary::Spread;
use crate::panel::words;

/// Share of the kinetic energy from which a mode is mostly one motion.
const MOSTLY: f32 = 0.6;
/// Most decimals of a frequency in Hz, and of a damping ratio in percent: the cords change by more from day to day.
const HERTZ_DECIMALS: u8 = 4;
const DAMPING_DECIMALS: u8 = 3;
/// Part of the best hit's Norm Indicator below which a hit hardly moves a mode.
const HARDLY: f32 = 0.1;

/// A mode: frequency, damping, its motion about the centre of mass, and which hit shows it.
pub(super) fn mode<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    mode: &StoredMode,
    body: Option<&RigidBody<f32>>,
    layout: Option<&RigLayout>,
    dofs: u16,
) {
    let known = |sigma: f32| Some(sigma).filter(|sigma| *sigma > 0.0);
    let row = |canvas: &mut Canvas<'_, D>, line, words, value: f32, sigma: f32, most: u8| {
        let decimals = known(sigma).map_or(most, |sigma| decimals_for(sigma, 2).min(most));
        figures(canvas, line, words, value, known(sigma), decimals);
    };
    row(canvas, 0, ("freq", "Hz"), mode.frequency_hz, mode.sigma[0], HERTZ_DECIMALS);
    let (damping, sigma) = (100.0 * mode.damping_ratio, 100.0 * mode.sigma[1]);
    row(canvas, 1, ("damp", "%"), damping, sigma, DAMPING_DECIMALS);
    if let Some(body) = body {
        canvas.line(2, &motion(&energy_shares(&mode.shape(), body)));
    }
    match layout {
        Some(layout) => hits(canvas, mode, layout, dofs),
        None => canvas.lines(3, "Use its layout to see\nwhich hits show it."),
    }
}

/// The motion of a mode in words, from the shares of its kinetic energy.
fn motion(shares: &Vector6<f32>) -> Text {
    let largest = |beside: Option<usize>| {
        let others = shares.iter().copied().enumerate().filter(|(k, _)| Some(*k) != beside);
        others.fold((0, f32::NEG_INFINITY), |most, next| if next.1 > most.1 { next } else { most })
    };
    let (first, share) = largest(None);
    let axis = |k: usize| AXIS_LETTERS[k % 3];
    if !share.is_finite() {
        return Text::new();
    }
    if share >= MOSTLY {
        let verb = if first < 3 { "moves along" } else { "turns about" };
        return text(format_args!("mostly {verb} {}", axis(first)));
    }
    let (second, other) = largest(Some(first));
    let part = |k: usize, share: f32| {
        let turns = if k < 3 { "" } else { "rot " };
        text(format_args!("{turns}{} {}%", axis(k), fitting(100.0 * share, 0, 3)))
    };
    text(format_args!("{}, {}", part(first, share), part(second, other)))
}

/// The hit that shows a mode best, and what to hit where all hits hardly show it; otherwise which hit hardly moves it.
fn hits<D: Screen>(canvas: &mut Canvas<'_, D>, mode: &StoredMode, layout: &RigLayout, dofs: u16) {
    let reference = layout.sensor_centroid();
    let shape = motion_at(&mode.shape(), &reference);
    let measured = || (0..layout.hits.len()).filter(|place| dofs >> place & 1 == 1);
    let Some(shown) = Shown::of(&shape, layout, measured()) else { return };
    let place =
        |hit: usize| layout.hits.get(hit).map_or_else(Text::new, |hit| words::place(hit.dof));
    let indicator = fitting(shown.indicator, decimals_for(shown.indicator, 2), 5);
    canvas.pair(
        3,
        &text(format_args!("best {}", place(shown.hit))),
        &text(format_args!("NI {indicator}")),
    );
    if shown.is_hardly_shown() {
        return canvas.format(4, format_args!("hardly: body {}", words::place(shown.better)));
    }
    let length = layout.characteristic_length();
    let least = measured()
        .filter_map(|hit| {
            let force = layout.hits.get(hit)?.unit_force(&reference);
            Some((norm_indicator_of_shape(&shape, &force, length), hit))
        })
        .reduce(|least, next| if next.0 < least.0 { next } else { least });
    if let Some((indicator, hit)) = least
        && indicator < HARDLY * shown.indicator
    {
        canvas.format(4, format_args!("hardly by {}", place(hit)));
    }
}

/// Title of the page of a property: its symbol and unit.
pub(super) fn property_title(k: usize) -> Text {
    let unit = match k {
        0 => "kg",
        1..4 => "mm",
        _ => "g m\u{b2}",
    };
    text(format_args!("{} {unit}", symbol(k)))
}

/// A property by every method, and combined.
pub(super) fn property<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    k: usize,
    each: &[(u8, Spread)],
    combined: Option<Spread>,
) {
    let scale = if k == 0 { 1.0 } else { 1000.0 };
    let rows = each.len() + usize::from(combined.is_some());
    let pitch = if rows > LINES { LINE - 2 } else { LINE };
    let mut row = |place: usize, name: &str, (value, sigma): Spread| {
        let y = top(0) + pitch * place as i32;
        let sigma = sigma.map(|sigma| sigma * scale);
        let decimals = sigma.map_or(3, |sigma| decimals_for(sigma, 2));
        canvas.text(0, y, name);
        canvas.text_right(84, y, &fitting(value * scale, decimals, 8));
        if let Some(sigma) = sigma {
            canvas.text(86, y, &text(format_args!("\u{b1}{}", fitting(sigma, decimals, 6))));
        }
    };
    for (place, (method, spread)) in each.iter().enumerate() {
        row(place, words::method(*method), *spread);
    }
    if let Some(combined) = combined {
        row(each.len(), "all", combined);
    }
}

/// How the methods agree, and the combined mass.
pub(super) fn agreement<D: Screen>(canvas: &mut Canvas<'_, D>, agreement: &StoredAgreement) {
    match agreement.outcome() {
        Outcome::Differ => canvas.line(0, "They do not agree."),
        Outcome::Agree => canvas.line(0, "The methods agree."),
        Outcome::SomeOff => {
            let mut off = text(format_args!("off:"));
            for method in &agreement.off {
                // Names beyond the line would not be seen either.
                let _ = core::fmt::Write::write_fmt(
                    &mut off,
                    format_args!(" {}", words::method(*method)),
                );
            }
            canvas.line(0, &off);
        }
    }
    if let Some(largest) = &agreement.largest {
        let [first, second] = largest.methods.map(words::method);
        canvas.line(1, "Largest difference:");
        canvas.format(2, format_args!("{first} to {second}"));
        let k = usize::from(largest.property).min(INERTIAL_PARAMETERS.len() - 1);
        let times = (largest.difference / largest.sigma).abs();
        canvas.format(3, format_args!("{} by {} sd", symbol(k), fitting(times, 1, 6)));
    }
    let (mass, sigma) = (agreement.properties[0], agreement.sigma[0]);
    figures(canvas, 4, ("all", "kg"), mass, Some(sigma), decimals_for(sigma, 2));
}

/// Why a method has no answer.
pub(super) fn refusal<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    refusal: &StoredRefusal,
    layout: Option<&RigLayout>,
) {
    let method = Method::from_number(refusal.method).map_or("unknown", |method| method.title());
    canvas.line(0, method);
    let reason = Diagnostic::from(refusal.reason);
    canvas.lines(1, reason.code.words());
    canvas.line(4, &words::subject(&reason, layout));
}
