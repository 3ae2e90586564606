//! The screens of a campaign.

use core::fmt::Write as _;
use massline_shared::measurement::campaign::Phase;

use embedded_graphics::prelude::*;
use massline_shared::diagnosis::{Code, Diagnostic};
use massline_shared::layout::TestProfile;
use massline_shared::signal::{CHANNELS, ELSEWHERE, Swing};

use super::View;
use super::canvas::{Canvas, SIZE, Screen, clipped, text, top};
use super::{lists, precision, sketch};
use crate::panel::number::{Text, decimals_for, fitting, percent};
use crate::panel::{PanelModel, words};

/// Position and size of the sketch.
const SKETCH: (Point, Size) = (Point::new(80, 12), Size::new(48, 40));
/// Height of the tallest level bar.
const TALLEST: i32 = 9;

/// Draws the screen of the current phase.
pub(super) fn draw<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    let model = view.model;
    match model.phase {
        Phase::Idle => prepared(canvas, view),
        Phase::Armed | Phase::Busy => {
            match model.verdict.and_then(|verdict| verdict.reason) {
                Some(reason) if reason.is_error() => rejected(canvas, view, &reason),
                Some(doubt) => doubtful(canvas, view, &doubt),
                None => guided(canvas, view),
            }
            match precision::after_a_dof(model) {
                Some(line) => canvas.bar(53, &line),
                None if model.is_swing_shown() && model.phase == Phase::Armed => {}
                None => levels(canvas, model),
            }
        }
        Phase::Confirming => {
            lists::entries(canvas, view, &text(format_args!("Good hit {}", strength(model))));
        }
        Phase::Paused => {
            let mut title = Text::new();
            // There is room: the name of a DOF has eight characters at most.
            let _ = write!(title, "Paused {} {}/{}", place(model), model.accepted, model.wanted);
            lists::entries(canvas, view, &title);
        }
        Phase::Solving => {
            let (title, words) = match model.profile {
                TestProfile::MassLine => ("Computing", "The ten properties\nare being computed."),
                TestProfile::Suspension => ("Storing", "The last place is\nbeing stored."),
            };
            canvas.title(title, "");
            canvas.lines(1, words);
        }
        Phase::TargetReached => precision::target_reached(canvas, model),
        Phase::Done => done(canvas, model),
    }
}

fn prepared<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    let Some(layout) = view.layout else {
        canvas.title("No layout", "");
        canvas.lines(0, "Send one from a PC:\nmassline measure\n  LAYOUT.toml");
        return;
    };
    canvas.title(&clipped(&layout.title, words::WIDTH), "");
    canvas.format(0, format_args!("{} sensors", layout.sensors.len()));
    canvas.format(1, format_args!("{} places", layout.hits.len()));
    canvas.format(2, format_args!("{} hits each", layout.test.hits_per_dof));
    canvas.line(
        3,
        match layout.test.profile {
            TestProfile::MassLine => "mass lines",
            TestProfile::Suspension => "modes",
        },
    );
    canvas.line(4, "OK: start  Next: what");
    sketch::draw(canvas, layout, None, SKETCH.0, SKETCH.1);
}

/// Shows where to hit next.
fn guided<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    let model = view.model;
    let title = match model.verdict {
        Some(_) => text(format_args!("Good {}", strength(model))),
        None if model.profile == TestProfile::Suspension => text(format_args!("Hit when still")),
        None => text(format_args!("Hit now")),
    };
    let count = text(format_args!("{}/{}", next_hit(model), model.wanted));
    let swing = model.verdict.and_then(|verdict| verdict.swing);
    let beside = if swing.is_some() { count.clone() } else { time_left(model) };
    let fits = title.len() + beside.len() < words::WIDTH;
    canvas.title(&title, if fits { &beside } else { "" });
    progress(canvas, model);
    canvas.big(0, 14, &place(model));
    match swing {
        Some(Swing { rest, remainder, .. }) => {
            canvas.text(0, 33, &text(format_args!("rest {}%", in_percent(rest))));
            canvas.text(0, 42, &text(format_args!("left {}%", in_percent(remainder))));
        }
        None => {
            let number = model.dof.map_or(0, |(index, _)| index + 1);
            canvas.text(0, 33, &text(format_args!("place {number}/{}", model.dofs)));
            let hit = || text(format_args!("hit {count}"));
            canvas.text(0, 42, &precision::place_that_helps(model).unwrap_or_else(hit));
        }
    }
    let current = model.dof.map(|(index, _)| usize::from(index));
    if let Some(layout) = view.layout {
        sketch::draw(canvas, layout, current, SKETCH.0, SKETCH.1);
    }
}

/// Shows why the last hit was rejected, and where to hit again.
fn rejected<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>, reason: &Diagnostic) {
    let again = text(format_args!("AGAIN {}", place(view.model)));
    said_of_hit(canvas, view, &again, reason);
}

/// Shows what makes an accepted hit doubtful, and where to hit next.
fn doubtful<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>, doubt: &Diagnostic) {
    let next = text(format_args!("KEPT, now {}", place(view.model)));
    said_of_hit(canvas, view, &next, doubt);
}

/// Shows what was found in the last hit, and under a title which hit is next.
fn said_of_hit<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    view: &View<'_>,
    title: &str,
    diagnostic: &Diagnostic,
) {
    let model = view.model;
    let hit = text(format_args!("{}/{}", next_hit(model), model.wanted));
    let fits = title.len() + hit.len() < words::WIDTH;
    canvas.title(title, if fits { &hit } else { "" });
    progress(canvas, model);
    canvas.lines(0, diagnostic.code.words());
    canvas.text(
        0,
        43,
        &difference(diagnostic).unwrap_or_else(|| words::subject(diagnostic, view.layout)),
    );
    if let Some(swing) = model.verdict.and_then(|verdict| verdict.swing) {
        canvas.bar(53, &still(swing));
    }
}

/// How still the object hung before a hit, and how much of its response the record cut off.
fn still(swing: Swing) -> Text {
    let [rest, left] = [swing.rest, swing.remainder].map(in_percent);
    text(format_args!("rest {rest}% left {left}%"))
}

/// A share in percent, to a hundredth.
fn in_percent(share: f32) -> Text {
    fitting(100.0 * share, 2, 4)
}

/// How far a hit that may have landed elsewhere is from its repeat hits, and the limit that it exceeds.
fn difference(diagnostic: &Diagnostic) -> Option<Text> {
    (diagnostic.code == Code::HitElsewhere).then(|| {
        let limit = ELSEWHERE as f32;
        text(format_args!("{} off, over {}", percent(diagnostic.value), percent(limit)))
    })
}

/// Progress bar of the campaign, under the title.
fn progress<D: Screen>(canvas: &mut Canvas<'_, D>, model: &PanelModel) {
    let share = u32::from(model.hits_done) * SIZE.width / u32::from(model.hits.max(1));
    canvas.fill(0, 12, share as i32, 1);
}

/// Level bars of all channels, the hammer first; or a text while a record is taken or analysed.
fn levels<D: Screen>(canvas: &mut Canvas<'_, D>, model: &PanelModel) {
    if model.phase == Phase::Busy {
        return match model.ringing_left {
            Some(left) => canvas.bar(53, &text(format_args!("{left} s, do not touch"))),
            None => canvas.bar(53, "measuring"),
        };
    }
    for (channel, &level) in model.levels.iter().enumerate().take(CHANNELS) {
        let x = match channel.checked_sub(1) {
            None => 0,
            Some(response) => 15 + 38 * (response / 3) as i32 + 12 * (response % 3) as i32,
        };
        let height = i32::from(level).min(TALLEST);
        canvas.fill(x, 62 - height, 9, height);
        canvas.fill(x, 63, 9, 1);
    }
}

fn done<D: Screen>(canvas: &mut Canvas<'_, D>, model: &PanelModel) {
    canvas.title(&text(format_args!("Result {}", model.result)), "");
    match model.mass {
        _ if model.block => {
            canvas.lines(0, "The block has been\nmeasured.");
            canvas.line(3, "OK: hammer's gain");
        }
        Some(mass) => {
            let sigma = mass.sigma.filter(|sigma| sigma.is_finite());
            let decimals = sigma.map_or(3, |sigma| decimals_for(sigma, 2));
            canvas.big(0, top(0), &text(format_args!("{} kg", fitting(mass.value, decimals, 9))));
            if let Some(sigma) = sigma {
                let sigma = fitting(sigma, decimals, 7);
                canvas.line(2, &text(format_args!("\u{b1} {sigma} kg (1 sd)")));
            }
            canvas.line(3, "OK: all properties");
        }
        None if model.has_lines() => {
            canvas.big(0, top(0), "Measured");
            canvas.line(2, "The program solves it.");
            canvas.line(3, "OK: how");
        }
        None => {
            canvas.big(0, top(0), "No answer");
            canvas.line(3, "OK: why");
        }
    }
    canvas.line(4, "Next: measure again");
}

/// Node and direction of the current DOF.
fn place(model: &PanelModel) -> Text {
    model.dof.map_or_else(Text::new, |(_, dof)| words::place(dof))
}

/// Number of the next hit, from 1.
fn next_hit(model: &PanelModel) -> u8 {
    model.accepted.saturating_add(1).min(model.wanted)
}

/// What a hit is judged by: its impulse in the suspension profile, else its peak force.
fn strength(model: &PanelModel) -> Text {
    let Some(verdict) = model.verdict else { return Text::new() };
    match verdict.swing {
        Some(swing) => text(format_args!("{} N s", fitting(swing.impulse, 2, 6))),
        None => text(format_args!("{} N", fitting(verdict.peak_force, 0, 6))),
    }
}

/// Remaining time of the campaign in minutes and seconds.
fn time_left(model: &PanelModel) -> Text {
    let Some(seconds) = model.seconds_left else { return Text::new() };
    text(format_args!("{}:{:02}", seconds / 60, seconds % 60))
}
