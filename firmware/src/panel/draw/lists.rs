//! Lists, messages, and the pages about the rig.

use massline_protocol::Clock;
use massline_protocol::message::Battery;
use massline_shared::diagnosis::{Diagnostic, Severity};
use massline_shared::layout::{RigLayout, TestProfile};

use super::canvas::{Canvas, Screen, clipped, text, wrapped};
use super::{LayoutLine, View};
use crate::panel::menu::{ABOUT_PAGES, Question, SCREEN_PAGE};
use crate::panel::number::{Text, fixed};
use crate::panel::refused::RefusalReason;
use crate::panel::words;
use crate::store::RESULTS;

/// The main list.
pub(super) fn home<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    list(canvas, view, "massline", &charge(view.model.battery));
}

/// The charge of the battery, or that it is low; empty without a battery.
fn charge(battery: Option<Battery>) -> Text {
    match battery {
        None => Text::new(),
        Some(battery) if battery.is_low() => text(format_args!("charge!")),
        Some(battery) => text(format_args!("{} %", battery.percent)),
    }
}

/// The list of the current screen.
pub(super) fn entries<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>, title: &str) {
    list(canvas, view, title, "");
}

fn list<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>, title: &str, right: &str) {
    canvas.title(title, right);
    let entries = view.menu.entries(view.model);
    let labels = entries.iter().map(|entry| entry.label(view.model));
    canvas.list(labels, usize::from(view.menu.cursor()));
}

/// The diagnostics of the campaign or of a refused layout.
pub(super) fn findings<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    let page = usize::from(view.menu.cursor());
    let pages = text(format_args!("{}/{}", page + 1, view.findings.len()));
    if let Some(diagnostic) = view.findings.get(page) {
        finding(canvas, diagnostic, view.layout, &pages);
    }
}

/// One diagnostic: its severity, its subject, and what to do.
pub(super) fn finding<D: Screen>(
    canvas: &mut Canvas<'_, D>,
    diagnostic: &Diagnostic,
    layout: Option<&RigLayout>,
    pages: &str,
) {
    let title = match diagnostic.severity {
        Severity::Note => "Note",
        Severity::Warning => "Warning",
        Severity::Error => "Error",
    };
    canvas.title(title, pages);
    canvas.line(0, &words::subject(diagnostic, layout));
    canvas.lines(1, diagnostic.code.words());
}

/// The stored layouts; the one in use is marked.
pub(super) fn layouts<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    canvas.title("Layouts", &text(format_args!("{}", view.layouts.len())));
    if view.layouts.is_empty() {
        canvas.lines(1, words::of_reason(RefusalReason::NoLayout));
        return;
    }
    let line = |layout: &LayoutLine| {
        let mark = if layout.in_use { '*' } else { ' ' };
        let modes = if layout.profile == TestProfile::Suspension { "~" } else { "" };
        let room = words::WIDTH - 2 - modes.len();
        text(format_args!("{mark}{modes}{}", clipped(&layout.title, room)))
    };
    let lines: heapless::Vec<_, 8> = view.layouts.iter().take(8).map(line).collect();
    canvas.list(lines.iter().map(|line| line.as_str()), usize::from(view.menu.cursor()));
}

/// How full the flash is, and its wear.
pub(super) fn storage<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    canvas.title("Storage", "");
    let results = view.results.len();
    canvas.pair(0, "results", &text(format_args!("{results}")));
    canvas.pair(1, "layouts", &text(format_args!("{}", view.layouts.len())));
    canvas.pair(2, "failed writes", &text(format_args!("{}", view.stats.store_failures)));
    if results >= RESULTS {
        canvas.lines(3, "Full: delete one\nunder Results.");
    }
}

/// Identity of the rig.
pub(super) fn about<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    let page = view.menu.cursor();
    let pages = text(format_args!("{}/{ABOUT_PAGES}", page + 1));
    let (info, stats) = (view.info, view.stats);
    canvas.title("About", &pages);
    match page {
        0 => {
            canvas.pair(0, "massline", info.firmware);
            let dirty = if info.git_dirty { "+" } else { "" };
            let hash = info.git_hash.get(..12).unwrap_or(info.git_hash);
            canvas.pair(1, "git", &text(format_args!("{hash}{dirty}")));
            canvas.pair(2, "board", info.name);
            canvas.pair(3, "started by", info.boot_reason.name());
            let seconds = stats.uptime_ms / 1000;
            let (hours, minutes) = (seconds / 3600, seconds / 60 % 60);
            canvas.pair(4, "up", &text(format_args!("{hours}:{minutes:02}:{:02}", seconds % 60)));
        }
        1 => {
            let (used, size) = (stats.stack_high_water, stats.stack_size);
            canvas.pair(0, "stack", &text(format_args!("{used}/{size}")));
            canvas.pair(1, "triggers", &text(format_args!("{}", stats.triggers)));
            canvas.pair(2, "scans lost", &text(format_args!("{}", stats.scans_lost)));
            canvas.pair(3, "too late", &text(format_args!("{}", stats.deadlines_missed)));
            canvas.pair(4, "broken frames", &text(format_args!("{}", stats.frames_broken)));
        }
        2 => hardware(canvas, view),
        SCREEN_PAGE => {
            canvas.pair(0, "screen", view.screen.name());
            canvas.lines(2, "Shifted by 2 columns?\nOK: another type");
        }
        _ if info.last_panic.is_empty() => canvas.line(0, "No panic before this."),
        _ => {
            canvas.line(0, "Last panic:");
            paragraph(canvas, 1, info.last_panic);
        }
    }
}

/// Clock and supply, and what is wrong with them.
fn hardware<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>) {
    let info = view.info;
    let hardware = info.hardware();
    canvas.pair(0, "clock", info.clock.name());
    if let Some(millivolts) = hardware.brown_out_mv {
        let (volts, tenths) = (millivolts / 1000, millivolts / 100 % 10);
        canvas.pair(1, "brown-out", &text(format_args!("{volts}.{tenths} V")));
    }
    if let Some(battery) = view.model.battery {
        let volts = fixed(f32::from(battery.millivolts) / 1000.0, 2);
        canvas.pair(2, "battery", &text(format_args!("{volts} V")));
    }
    if hardware.supply_is_low {
        canvas.lines(3, "Supply too low to\nwrite flash.");
    } else if info.clock == Clock::Internal {
        canvas.lines(3, "The crystal is dead:\ntime is a few % off.");
    }
}

/// A long text, wrapped over the remaining lines and cut at the end of the screen.
fn paragraph<D: Screen>(canvas: &mut Canvas<'_, D>, first: usize, text: &str) {
    let mut rest = text;
    for line in first..super::canvas::LINES {
        let (now, later) = wrapped(rest);
        canvas.line(line, now);
        rest = later;
    }
}

/// A question before something is deleted.
pub(super) fn sure<D: Screen>(canvas: &mut Canvas<'_, D>, view: &View<'_>, question: Question) {
    canvas.title("Sure?", "");
    match question {
        Question::End => canvas.lines(0, "End the campaign?\nIts hits are lost."),
        Question::Redo => canvas.lines(0, "Forget the hits of\nthis place?"),
        Question::Delete => {
            canvas.line(0, "Delete for good?");
            if let Some(summary) = view.summary {
                canvas.format(1, format_args!("Result {}", summary.number));
            }
        }
    }
    canvas.line(3, "OK: yes");
    canvas.line(4, "Back: no");
}

/// Why the rig has refused an action.
pub(super) fn refused<D: Screen>(canvas: &mut Canvas<'_, D>, reason: RefusalReason) {
    canvas.title("Not possible", "");
    canvas.lines(0, words::of_reason(reason));
    if let RefusalReason::TooLittleRoom(results @ 1..) = reason {
        let more = if results == 1 { "" } else { "s" };
        canvas.format(3, format_args!("{results} result{more}, old first"));
    }
    canvas.line(4, "OK");
}
