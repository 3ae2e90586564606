//! Draws circuit symbols as SVG. The position of a symbol is the point where it meets its wire.

use std::fmt::Write;

/// Alignment of a text relative to its point.
#[derive(Clone, Copy)]
pub enum Align {
    Left,
    Middle,
    Right,
}

/// A drawing in progress. Lengths are in pixels; y increases downward.
pub struct Pen {
    svg: String,
}

impl Pen {
    pub fn new(width: i32, height: i32) -> Self {
        let style =
            "fill:none;stroke:#1a1a1a;stroke-width:1.6;stroke-linecap:round;stroke-linejoin:round";
        let svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
             viewBox=\"0 0 {width} {height}\" font-family=\"DejaVu Sans, Verdana, Arial, sans-serif\">\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n<g style=\"{style}\">\n"
        );
        Self { svg }
    }

    pub fn finish(mut self) -> String {
        self.svg += "</g>\n</svg>\n";
        self.svg
    }

    fn add(&mut self, element: std::fmt::Arguments<'_>) {
        // Writing to a String cannot fail.
        let _ = writeln!(self.svg, "{element}");
    }

    /// Shifts everything drawn from now on to the right by `x`, until [`Pen::unshift`].
    pub fn shift(&mut self, x: i32) {
        self.add(format_args!("<g transform=\"translate({x},0)\">"));
    }

    pub fn unshift(&mut self) {
        self.add(format_args!("</g>"));
    }

    /// A line through points.
    pub fn wire(&mut self, points: &[(i32, i32)]) {
        let points: Vec<_> = points.iter().map(|(x, y)| format!("{x},{y}")).collect();
        self.add(format_args!("<polyline points=\"{}\"/>", points.join(" ")));
    }

    /// A dot where wires are connected.
    pub fn joint(&mut self, (x, y): (i32, i32)) {
        self.add(format_args!("<circle cx=\"{x}\" cy=\"{y}\" r=\"3\" fill=\"#1a1a1a\"/>"));
    }

    pub fn text(&mut self, (x, y): (i32, i32), size: i32, align: Align, text: &str) {
        let anchor = match align {
            Align::Left => "start",
            Align::Middle => "middle",
            Align::Right => "end",
        };
        let text = text.replace('&', "&amp;").replace('<', "&lt;");
        self.add(format_args!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"#1a1a1a\" \
             stroke=\"none\">{text}</text>"
        ));
    }

    /// Lines of text below each other, beside a part.
    pub fn label(&mut self, (x, y): (i32, i32), lines: &[&str]) {
        for (line, text) in (0..).zip(lines) {
            self.text((x, y + 13 * line), 11, Align::Left, text);
        }
    }

    /// A part with a name in it.
    pub fn part(&mut self, (x, y): (i32, i32), (width, height): (i32, i32)) {
        self.add(format_args!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" rx=\"3\" fill=\"#f4f1e8\"/>"
        ));
    }

    /// A ground symbol at the end of a wire.
    pub fn ground(&mut self, (x, y): (i32, i32)) {
        for (down, half) in [(0, 9), (4, 6), (8, 3)] {
            self.wire(&[(x - half, y + down), (x + half, y + down)]);
        }
    }

    /// A supply symbol at the end of a wire.
    pub fn supply(&mut self, (x, y): (i32, i32), name: &str) {
        self.wire(&[(x - 9, y), (x + 9, y)]);
        self.text((x, y - 4), 11, Align::Middle, name);
    }

    /// A capacitor from a wire down to ground.
    pub fn capacitor(&mut self, (x, y): (i32, i32), lines: &[&str]) {
        self.joint((x, y));
        self.wire(&[(x, y), (x, y + 12)]);
        self.wire(&[(x - 9, y + 12), (x + 9, y + 12)]);
        self.wire(&[(x - 9, y + 17), (x + 9, y + 17)]);
        self.wire(&[(x, y + 17), (x, y + 28)]);
        self.ground((x, y + 28));
        self.label((x + 13, y + 13), lines);
    }

    /// A resistor in a wire that goes right; its length is 50.
    pub fn resistor(&mut self, (x, y): (i32, i32), name: &str, value: &str) {
        self.wire(&[(x, y), (x + 8, y)]);
        self.part((x + 8, y - 6), (34, 12));
        self.wire(&[(x + 42, y), (x + 50, y)]);
        self.text((x + 25, y - 10), 11, Align::Middle, name);
        self.text((x + 25, y + 18), 11, Align::Middle, value);
    }

    /// A resistor from a wire up to the supply (-1) or down to ground (1); its length is 56.
    pub fn resistor_to_rail(&mut self, (x, y): (i32, i32), way: i32, rail: &str, lines: &[&str]) {
        self.joint((x, y));
        self.wire(&[(x, y), (x, y + 12 * way)]);
        self.part((x - 6, (y + 12 * way).min(y + 46 * way)), (12, 34));
        self.wire(&[(x, y + 46 * way), (x, y + 56 * way)]);
        if way < 0 {
            self.supply((x, y - 56), rail);
        } else {
            self.ground((x, y + 56));
        }
        self.label((x + 12, y + 29 * way), lines);
    }

    /// Two diodes that clamp a wire between ground and the supply.
    pub fn clamp(&mut self, (x, y): (i32, i32), rail: &str, lines: &[&str]) {
        self.joint((x, y));
        for top in [y - 38, y + 22] {
            // The cathodes are on top: current flows from ground to the wire, and from the wire to the
            // supply.
            self.wire(&[(x - 9, top), (x + 9, top)]);
            self.wire(&[(x, top), (x - 9, top + 15), (x + 9, top + 15), (x, top)]);
        }
        self.wire(&[(x, y - 56), (x, y - 38)]);
        self.wire(&[(x, y - 23), (x, y + 22)]);
        self.wire(&[(x, y + 37), (x, y + 56)]);
        self.supply((x, y - 56), rail);
        self.ground((x, y + 56));
        self.label((x + 14, y - 36), lines);
    }

    /// An operational amplifier as a voltage follower of the input at `(x, y)`; returns the point of its
    /// output. `pins` are the pin numbers of plus, minus and output.
    pub fn follower(&mut self, (x, y): (i32, i32), name: &str, pins: [u8; 3]) -> (i32, i32) {
        let (left, tip, out) = (x + 26, x + 88, y + 13);
        self.wire(&[(x, y), (left, y)]);
        self.wire(&[(left, y - 14), (tip, out), (left, y + 40), (left, y - 14)]);
        self.wire(&[(tip, out), (tip + 14, out)]);
        self.joint((tip + 10, out));
        let below = y + 48;
        self.wire(&[
            (tip + 10, out),
            (tip + 10, below),
            (x + 8, below),
            (x + 8, y + 26),
            (left, y + 26),
        ]);
        self.text((left + 5, y + 4), 11, Align::Left, "+");
        self.text((left + 5, y + 30), 11, Align::Left, "−");
        self.text((left + 16, y + 17), 11, Align::Left, name);
        let number = |pin: u8| pin.to_string();
        self.text((left - 3, y - 3), 9, Align::Right, &number(pins[0]));
        self.text((left - 3, y + 23), 9, Align::Right, &number(pins[1]));
        self.text((tip + 4, out - 7), 9, Align::Right, &number(pins[2]));
        (tip + 14, out)
    }

    /// A push-button from a wire to ground.
    pub fn button(&mut self, (x, y): (i32, i32), name: &str) {
        self.wire(&[(x - 3, y), (x + 4, y)]);
        self.wire(&[(x + 4, y - 9), (x + 40, y - 9)]);
        self.wire(&[(x + 22, y - 9), (x + 22, y - 17)]);
        self.wire(&[(x + 40, y), (x + 70, y), (x + 70, y + 8)]);
        for end in [x + 4, x + 40] {
            self.add(format_args!("<circle cx=\"{end}\" cy=\"{y}\" r=\"3\" fill=\"#ffffff\"/>"));
        }
        self.ground((x + 70, y + 8));
        self.text((x + 90, y + 4), 12, Align::Left, name);
    }

    /// A buzzer from a wire to ground.
    pub fn buzzer(&mut self, (x, y): (i32, i32), name: &str) {
        self.add(format_args!(
            "<path d=\"M{x},{0} a14,14 0 0 1 0,28 z\" fill=\"#f4f1e8\"/>",
            y - 6
        ));
        self.wire(&[(x - 10, y), (x, y)]);
        self.wire(&[(x, y + 16), (x - 10, y + 16), (x - 10, y + 26)]);
        self.ground((x - 10, y + 26));
        self.text((x + 24, y + 12), 12, Align::Left, name);
    }
}
