//! Draws lines, boxes and texts as SVG, and records what is connected and where texts are.

use std::fmt::Write;

use crate::trace::{Point, Trace};

const INK: &str = "#1a1a1a";

/// Alignment of a text relative to its point.
#[derive(Clone, Copy)]
pub enum Align {
    Left,
    Middle,
    Right,
}

/// A finished sheet.
pub struct Sheet {
    pub svg: String,
    pub trace: Trace,
    pub texts: Vec<Text>,
    pub size: (i32, i32),
    /// Texts that a box was drawn over.
    pub covered: Vec<String>,
    /// Every line that is drawn: wires, symbols, edges of boxes.
    pub lines: Vec<[Point; 2]>,
}

/// A text and the corners of its box.
#[derive(Clone, Debug)]
pub struct Text {
    pub text: String,
    pub from: Point,
    pub to: Point,
}

/// A drawing in progress. Lengths are in pixels; y increases downward.
pub struct Pen {
    svg: String,
    trace: Trace,
    texts: Vec<Text>,
    covered: Vec<String>,
    lines: Vec<[Point; 2]>,
    shift: i32,
    size: (i32, i32),
    /// The net of the ground symbols that are drawn now: that of a small board is connected by its cable only.
    pub ground_net: String,
}

impl Pen {
    pub fn new(width: i32, height: i32) -> Self {
        let style = format!(
            "fill:none;stroke:{INK};stroke-width:1.6;stroke-linecap:round;stroke-linejoin:round"
        );
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n<g style=\"{style}\">\n"
        );
        let (trace, texts, covered, lines) = Default::default();
        Self {
            svg,
            trace,
            texts,
            covered,
            lines,
            shift: 0,
            size: (width, height),
            ground_net: "GND".into(),
        }
    }

    pub fn finish(mut self) -> Sheet {
        self.svg += "</g>\n</svg>\n";
        let Self { svg, trace, texts, covered, lines, size, .. } = self;
        Sheet { svg, trace, texts, size, covered, lines }
    }

    pub fn add(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.svg, "{element}");
    }

    /// Shifts everything drawn from now on to the right by `x`, until [`Pen::unshift`].
    pub fn shift(&mut self, x: i32) {
        self.shift = x;
        self.add(format_args!("<g transform=\"translate({x},0)\">"));
    }

    pub fn unshift(&mut self) {
        self.shift = 0;
        self.add(format_args!("</g>"));
    }

    fn at(&self, (x, y): Point) -> Point {
        (x + self.shift, y)
    }

    /// A line of a symbol, which connects nothing.
    pub fn line(&mut self, points: &[Point]) {
        let moved: Vec<_> = points.iter().map(|point| self.at(*point)).collect();
        self.lines.extend(moved.windows(2).map(|ends| [ends[0], ends[1]]));
        let points: Vec<_> = points.iter().map(|(x, y)| format!("{x},{y}")).collect();
        self.add(format_args!("<polyline points=\"{}\"/>", points.join(" ")));
    }

    /// A wire through points.
    pub fn wire(&mut self, points: &[Point]) {
        let moved: Vec<_> = points.iter().map(|point| self.at(*point)).collect();
        self.trace.wire(&moved);
        self.line(points);
    }

    /// A dot where wires are connected.
    pub fn joint(&mut self, (x, y): Point) {
        let at = self.at((x, y));
        self.trace.joint(at);
        self.add(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"3\" fill=\"{INK}\"/>"));
    }

    /// States that the pin of a part is here.
    pub fn pin(&mut self, at: Point, part: &str, pin: &str) {
        let at = self.at(at);
        self.trace.pin(at, format!("{part}.{pin}"));
    }

    /// States that this place belongs to a net that is also elsewhere.
    pub fn net(&mut self, at: Point, name: &str) {
        let at = self.at(at);
        self.trace.name(at, name);
    }

    pub fn text(&mut self, (x, y): Point, size: i32, align: Align, text: &str) {
        // On average, a letter of DejaVu Sans is this wide.
        let width = text.chars().count() as i32 * size * 29 / 50;
        let (anchor, left) = match align {
            Align::Left => ("start", x),
            Align::Middle => ("middle", x - width / 2),
            Align::Right => ("end", x - width),
        };
        let (from, to) = (self.at((left, y - size * 3 / 4)), self.at((left + width, y + size / 5)));
        self.texts.push(Text { text: text.to_owned(), from, to });
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        self.add(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{INK}\" \
             stroke=\"none\">{text}</text>"
        ));
    }

    /// Lines of text below each other, beside a part.
    pub fn label(&mut self, (x, y): Point, lines: &[&str]) {
        for (line, text) in (0..).zip(lines) {
            self.text((x, y + 13 * line), 11, Align::Left, text);
        }
    }

    /// Notes the edges of a box.
    fn edges(&mut self, (x, y): Point, (width, height): (i32, i32)) {
        let corners = [(x, y), (x + width, y), (x + width, y + height), (x, y + height), (x, y)];
        let corners = corners.map(|corner| self.at(corner));
        self.lines.extend(corners.windows(2).map(|ends| [ends[0], ends[1]]));
    }

    /// A part with a name in it.
    pub fn part(&mut self, (x, y): Point, (width, height): (i32, i32)) {
        let (from, to) = (self.at((x, y)), self.at((x + width, y + height)));
        let under = |text: &&Text| {
            text.from.0 < to.0 && text.to.0 > from.0 && text.from.1 < to.1 && text.to.1 > from.1
        };
        self.covered.extend(self.texts.iter().filter(under).map(|text| text.text.clone()));
        self.edges((x, y), (width, height));
        self.add(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"3\" fill=\"#f4f1e8\"/>"
        ));
    }

    /// The outline of a board of its own.
    pub fn frame(&mut self, (x, y): Point, (width, height): (i32, i32), name: &str) {
        self.edges((x, y), (width, height));
        self.add(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"6\" stroke=\"#8a8a8a\" \
             stroke-dasharray=\"6 5\"/>"
        ));
        self.text((x + 8, y - 5), 11, Align::Left, name);
    }

    /// A small circle, filled with a colour.
    pub fn circle(&mut self, (x, y): Point, radius: i32, fill: &str) {
        self.add(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{fill}\"/>"));
    }
}
