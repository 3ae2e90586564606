//! Text, bars and lists on a screen of 128 × 64 pixels.
//!
//! The screen has a title bar of 11 rows, then five lines of ten rows. Drawing is clipped at the screen's
//! edge.

use core::convert::Infallible;
use core::fmt::{self, Write as _};

use embedded_graphics::mono_font::iso_8859_1::FONT_6X10;
use embedded_graphics::mono_font::{MonoFont, MonoTextStyleBuilder, ascii};
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::*;
use embedded_graphics::primitives::{Line, PointsIter, Rectangle};
use embedded_graphics::text::{Alignment, Baseline, Text, TextStyleBuilder};

use crate::panel::{number, words};

/// Pixels of the screen.
pub const SIZE: Size = Size::new(128, 64);
const WIDTH: i32 = SIZE.width as i32;
/// Rows of the title bar.
const TITLE: i32 = 11;
/// The first character that the font does not have.
const BEYOND_FONT: u32 = 0x100;
/// Rows of a line.
pub const LINE: i32 = 10;
/// Number of lines under the title.
pub const LINES: usize = 5;

/// A drawing target that is black and white and cannot fail.
pub trait Screen: DrawTarget<Color = BinaryColor, Error = Infallible> {}
impl<D: DrawTarget<Color = BinaryColor, Error = Infallible>> Screen for D {}

/// Draws on a screen.
pub(in crate::panel) struct Canvas<'a, D>(pub &'a mut D);

impl<D: Screen> Canvas<'_, D> {
    /// Clears the screen.
    pub fn clear(&mut self) {
        let Ok(()) = self.0.clear(BinaryColor::Off);
    }

    /// Draws the title bar: bright, with one text at the left and one at the right.
    pub fn title(&mut self, left: &str, right: &str) {
        self.fill(0, 0, WIDTH, TITLE);
        self.write(&FONT_6X10, left, 1, 1, Alignment::Left, BinaryColor::Off);
        self.write(&FONT_6X10, right, WIDTH - 2, 1, Alignment::Right, BinaryColor::Off);
    }

    /// Draws a line under the title; lines are counted from 0.
    pub fn line(&mut self, line: usize, text: &str) {
        self.text(0, top(line), text);
    }

    /// Draws a line with one text at the left and one at the right.
    pub fn pair(&mut self, line: usize, left: &str, right: &str) {
        self.line(line, left);
        self.text_right(WIDTH - 1, top(line), right);
    }

    /// Draws a formatted line.
    pub fn format(&mut self, line: usize, arguments: fmt::Arguments<'_>) {
        self.line(line, &text(arguments));
    }

    /// Draws the lines of a text, the first at this line.
    pub fn lines(&mut self, first: usize, text: &str) {
        for (line, text) in (first..).zip(text.split('\n')) {
            self.line(line, text);
        }
    }

    /// Draws a list and marks the line at the cursor, which is always visible.
    pub fn list<'t>(&mut self, texts: impl ExactSizeIterator<Item = &'t str>, cursor: usize) {
        let first = (cursor + 1).saturating_sub(LINES);
        let count = texts.len();
        for (place, text) in texts.enumerate().skip(first).take(LINES) {
            let y = top(place - first);
            let color = if place == cursor {
                self.fill(0, y, WIDTH - 4, LINE);
                BinaryColor::Off
            } else {
                BinaryColor::On
            };
            self.write(&FONT_6X10, text, 2, y, Alignment::Left, color);
        }
        self.scroll_bar(first, count);
    }

    /// Draws a scroll bar at the right edge, if the list is longer than the screen.
    fn scroll_bar(&mut self, first: usize, count: usize) {
        if count > LINES {
            let rows = |places: usize| (places * LINES * LINE as usize / count) as i32;
            self.fill(WIDTH - 2, top(0) + rows(first), 2, rows(LINES).max(3));
        }
    }

    /// Draws small text; the position is its upper left corner.
    pub fn text(&mut self, x: i32, y: i32, text: &str) {
        self.write(&FONT_6X10, text, x, y, Alignment::Left, BinaryColor::On);
    }

    /// Draws small text; the position is its upper right corner.
    pub fn text_right(&mut self, x: i32, y: i32, text: &str) {
        self.write(&FONT_6X10, text, x, y, Alignment::Right, BinaryColor::On);
    }

    /// Draws large text; the position is its upper left corner.
    pub fn big(&mut self, x: i32, y: i32, text: &str) {
        self.write(&ascii::FONT_10X20, text, x, y, Alignment::Left, BinaryColor::On);
    }

    /// Draws a bright bar with dark text, as wide as the screen.
    pub fn bar(&mut self, y: i32, text: &str) {
        self.fill(0, y, WIDTH, TITLE);
        self.write(&FONT_6X10, text, WIDTH / 2, y + 1, Alignment::Center, BinaryColor::Off);
    }

    /// Draws a filled rectangle; nothing if it is empty.
    pub fn fill(&mut self, x: i32, y: i32, width: i32, height: i32) {
        let size = Size::new(width.max(0) as u32, height.max(0) as u32);
        let Ok(()) = self.0.fill_solid(&Rectangle::new(Point::new(x, y), size), BinaryColor::On);
    }

    /// Draws a thin line.
    pub fn stroke(&mut self, from: Point, to: Point) {
        // Drawn point by point: code for styled lines, which can be thick, costs 1 KB of flash.
        let points = Line::new(from, to).points();
        let Ok(()) = self.0.draw_iter(points.map(|point| Pixel(point, BinaryColor::On)));
    }

    fn write(
        &mut self,
        font: &MonoFont<'_>,
        text: &str,
        x: i32,
        y: i32,
        alignment: Alignment,
        color: BinaryColor,
    ) {
        let style = MonoTextStyleBuilder::new().font(font).text_color(color).build();
        let layout = TextStyleBuilder::new().alignment(alignment).baseline(Baseline::Top).build();
        let Ok(_) = Text::with_text_style(text, Point::new(x, y), style, layout).draw(self.0);
    }
}

/// Upper row of a line under the title.
pub(in crate::panel) fn top(line: usize) -> i32 {
    TITLE + 2 + LINE * line as i32
}

/// A text in at most `width` characters; a longer one is cut and ends with two points. A character that the font does
/// not have is a question mark.
pub(in crate::panel) fn clipped(text: &str, width: usize) -> number::Text {
    let more = text.chars().count() > width;
    let length = if more { width.saturating_sub(2) } else { width };
    let points = if more { ".." } else { "" };
    let mut cut = number::Text::new();
    for character in text.chars().take(length).chain(points.chars()) {
        let drawn = if u32::from(character) < BEYOND_FONT { character } else { '?' };
        // Text beyond the buffer would not fit the screen either.
        let _ = cut.push(drawn);
    }
    cut
}

/// A text in two: as many characters as fit a line, and the rest.
pub(in crate::panel) fn wrapped(text: &str) -> (&str, &str) {
    let end = text.char_indices().nth(words::WIDTH).map_or(text.len(), |(at, _)| at);
    text.split_at_checked(end).unwrap_or((text, ""))
}

/// A formatted text, cut to the length of a line.
pub(in crate::panel) fn text(arguments: fmt::Arguments<'_>) -> number::Text {
    let mut text = number::Text::new();
    // Text beyond the buffer would not fit the screen either.
    let _ = text.write_fmt(arguments);
    text
}
