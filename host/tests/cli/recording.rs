//! A recording of a terminal as an animated SVG: the screens one above the other, of which a window shows one at a
//! time.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::time::Duration;

use vt100::{Cell, Color, Screen};

use crate::on_terminal::Size;

/// A screen that is followed by another within this time was not whole yet.
const WHOLE: Duration = Duration::from_millis(30);
/// Every screen is shown for at least this time; changes that are faster are left out.
const SHORTEST: Duration = Duration::from_millis(350);
/// Nothing is shown for longer, except the last screen of a program.
const LONGEST: Duration = Duration::from_millis(1500);
const LAST: Duration = Duration::from_millis(3500);
/// Width and height of a character and size of its font, pixels.
const CELL: [f64; 2] = [8.4, 17.0];
const FONT: u8 = 14;
/// Distance of the text from the edge, pixels.
const EDGE: f64 = 10.0;
/// Colours of the terminal: ground, text, and the first sixteen of its palette.
const GROUND: &str = "#16181d";
const TEXT: &str = "#d7dae0";
const PALETTE: [&str; 16] = [
    "#16181d", "#ff6b68", "#8fd46a", "#f0c75e", "#6cb6ff", "#e08bea", "#56d4dd", "#d7dae0",
    "#878d9a", "#ff8a87", "#a9e68a", "#ffdc85", "#94caff", "#eeadf5", "#82e6ed", "#ffffff",
];

/// The animation of these screens, each with its time since the start of its program; programs follow one another.
pub fn svg(programs: &[Vec<(Duration, Screen)>], size: Size) -> String {
    let mut shown = Vec::new();
    programs.iter().for_each(|seen| shown.extend(chosen(seen, size)));
    let mut rows = BTreeMap::new();
    let screens: Vec<Vec<usize>> =
        shown.iter().map(|(screen, _)| rows_of(screen, size, &mut rows)).collect();
    let [width, height] = [0, 1].map(|k| f64::from(size[k]) * CELL[k] + 2.0 * EDGE);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.0} {height:.0}\" width=\"{width:.0}\" \
         height=\"{height:.0}\" role=\"img\" aria-label=\"a measurement in a terminal\">\n<style>\n{}</style>\n\
         <rect width=\"100%\" height=\"100%\" rx=\"6\" fill=\"{GROUND}\"/>\n<defs>\n",
        style(&shown, height)
    );
    for (row, number) in &rows {
        let _ = writeln!(svg, "<g id=\"r{number}\">{row}</g>");
    }
    svg += "</defs>\n<g id=\"screens\">\n";
    for (place, screen) in screens.iter().enumerate() {
        let _ =
            write!(svg, "<g transform=\"translate({EDGE} {:.0})\">", place as f64 * height + EDGE);
        for (line, number) in screen.iter().enumerate().filter(|(_, number)| **number > 0) {
            let _ = write!(svg, "<use href=\"#r{number}\" y=\"{:.0}\"/>", line as f64 * CELL[1]);
        }
        svg += "</g>\n";
    }
    svg + "</g>\n</svg>\n"
}

/// The screens that can be seen, and how long each of them is shown.
fn chosen(seen: &[(Duration, Screen)], [columns, rows]: Size) -> Vec<(Screen, Duration)> {
    let mut chosen: Vec<(Screen, Duration)> = Vec::new();
    let of_size: Vec<_> =
        seen.iter().filter(|(_, screen)| of_screen(screen) == [columns, rows]).collect();
    for (place, (at, screen)) in of_size.iter().enumerate() {
        let is_last = place + 1 == of_size.len();
        let until = of_size.get(place + 1).map_or(*at + LAST, |(next, _)| *next);
        let time = (until - *at).min(if is_last { LAST } else { LONGEST });
        match chosen.last_mut() {
            Some((last, shown)) if last.contents() == screen.contents() => *shown += time,
            Some((_, shown)) if !is_last && (time < WHOLE || *shown < SHORTEST) => *shown += time,
            _ => chosen.push((screen.clone(), time)),
        }
    }
    chosen.iter_mut().for_each(|(_, time)| *time = (*time).min(LAST));
    chosen
}

/// Columns and rows of a screen.
fn of_screen(screen: &Screen) -> Size {
    let (rows, columns) = screen.size();
    [columns.get(), rows.get()]
}

/// The rules that move the window from screen to screen.
fn style(shown: &[(Screen, Duration)], height: f64) -> String {
    let total: f64 = shown.iter().map(|(_, time)| time.as_secs_f64()).sum();
    let mut frames = String::new();
    let mut at = 0.0;
    for (place, (_, time)) in shown.iter().enumerate() {
        let up = place as f64 * height;
        let _ = write!(frames, "{:.2}%{{transform:translateY(-{up:.0}px)}}", 100.0 * at / total);
        at += time.as_secs_f64();
    }
    let last = shown.len().saturating_sub(1) as f64 * height;
    let mut style = format!(
        "text{{font:{FONT}px ui-monospace,'DejaVu Sans Mono',Menlo,Consolas,monospace;white-space:pre}}\
         .b{{font-weight:bold}}\n@keyframes screens{{{frames}}}\n\
         #screens{{animation:screens {total:.1}s step-end infinite}}\n\
         @media(prefers-reduced-motion:reduce){{#screens{{animation:none;transform:translateY(-{last:.0}px)}}}}\n"
    );
    for (number, color) in PALETTE.iter().chain([&TEXT, &GROUND]).enumerate() {
        let _ = write!(style, ".c{number}{{fill:{color}}}");
    }
    style + "\n"
}

/// The numbers of the rows of a screen; an empty one is 0. Equal rows are drawn once.
fn rows_of(
    screen: &Screen,
    [columns, rows]: Size,
    drawn: &mut BTreeMap<String, usize>,
) -> Vec<usize> {
    let numbers = (0..rows).map(|row| {
        let svg = row_of(screen, row, columns);
        if svg.is_empty() {
            return 0;
        }
        let next = drawn.len() + 1;
        *drawn.entry(svg).or_insert(next)
    });
    numbers.collect()
}

/// How a character looks.
#[derive(Clone, Copy, PartialEq)]
struct Look {
    text: usize,
    ground: usize,
    bold: bool,
}

/// Numbers of the colours of text and ground in the style.
const OF_TEXT: usize = PALETTE.len();
const OF_GROUND: usize = PALETTE.len() + 1;

impl Look {
    fn of(cell: &Cell) -> Self {
        let number = |color: Color, default: usize| match color {
            Color::Idx(number) if usize::from(number) < PALETTE.len() => number.into(),
            _ => default,
        };
        let [text, ground] = [number(cell.fgcolor(), OF_TEXT), number(cell.bgcolor(), OF_GROUND)];
        let [text, ground] = if cell.inverse() { [ground, text] } else { [text, ground] };
        Self { text, ground, bold: cell.bold() }
    }
}

/// A row as elements, each a run of characters that look the same; empty for one without any.
fn row_of(screen: &Screen, row: u16, columns: u16) -> String {
    let mut runs: Vec<(u16, Look, String)> = Vec::new();
    for column in 0..columns {
        let Some(cell) = screen.cell(row, column) else { continue };
        let look = Look::of(cell);
        let text = if cell.has_contents() { cell.contents() } else { " " };
        match runs.last_mut() {
            Some((_, last, run)) if *last == look => run.push_str(text),
            _ => runs.push((column, look, text.to_owned())),
        }
    }
    runs.iter().map(|(column, look, text)| run_of(*column, *look, text)).collect()
}

fn run_of(column: u16, look: Look, text: &str) -> String {
    let x = |column: usize| column as f64 * CELL[0];
    let mut svg = String::new();
    let width = text.chars().count();
    if look.ground != OF_GROUND {
        let _ = write!(
            svg,
            "<rect x=\"{:.1}\" width=\"{:.1}\" height=\"{}\" class=\"c{}\"/>",
            x(column.into()),
            x(width),
            CELL[1],
            look.ground
        );
    }
    let inner = text.trim();
    if inner.is_empty() {
        return svg;
    }
    let before = text.chars().take_while(|c| c.is_whitespace()).count();
    let bold = if look.bold { " b" } else { "" };
    let escaped = inner.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let _ = write!(
        svg,
        "<text x=\"{:.1}\" y=\"13\" textLength=\"{:.1}\" lengthAdjust=\"spacingAndGlyphs\" \
         class=\"c{}{bold}\">{escaped}</text>",
        x(usize::from(column) + before),
        x(inner.chars().count()),
        look.text
    );
    svg
}
