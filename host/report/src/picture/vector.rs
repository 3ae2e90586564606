//! SVG files: as small as they can be without a difference that is seen, because a report holds dozens of them.
//!
//! Lines of one style in a row are one element; points that lie on the line between their neighbours are left out; what
//! is the same for all letters stands once.

use std::convert::Infallible;
use std::fmt::Write;

use plotters_backend::text_anchor::{HPos, VPos};
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
    FontTransform,
};

/// How far a line may lie from a point that it leaves out, pixels.
const UNSEEN: f64 = 0.6;
/// The library's size of letters over that of an SVG file.
const LETTERS: f64 = 1.24;

/// An SVG file.
pub(super) struct Vector<'a> {
    text: &'a mut String,
    size: (u32, u32),
    /// Attributes and data of the lines that are not written yet.
    lines: Option<(String, String)>,
}

type Outcome = Result<(), DrawingErrorKind<Infallible>>;

impl<'a> Vector<'a> {
    /// An SVG file of this size, whose letters are of these families.
    pub fn on(text: &'a mut String, size: (u32, u32), families: &str) -> Self {
        let (width, height) = size;
        *text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} \
             {height}\" font-family=\"{families}\">\n"
        );
        Self { text, size, lines: None }
    }

    /// Writes the lines that are not written yet.
    fn end_lines(&mut self) {
        if let Some((attributes, data)) = self.lines.take() {
            let _ = writeln!(self.text, "<path fill=\"none\"{attributes} d=\"{data}\"/>");
        }
    }

    fn element(&mut self, color: BackendColor, words: impl FnOnce() -> String) {
        if color.alpha > 0.0 {
            self.end_lines();
            let _ = writeln!(self.text, "{}", words());
        }
    }

    fn add_line(&mut self, points: &[BackendCoord], style: &impl BackendStyle) {
        let color = style.color();
        if color.alpha == 0.0 || points.is_empty() {
            return;
        }
        let attributes =
            format!("{} stroke-width=\"{}\"", paint("stroke", color), style.stroke_width());
        if self.lines.as_ref().is_none_or(|(other, _)| *other != attributes) {
            self.end_lines();
            self.lines = Some((attributes, String::new()));
        }
        if let Some((_, data)) = &mut self.lines {
            write_steps(data, &simplified(points));
        }
    }
}

/// The attributes of a colour.
fn paint(attribute: &str, BackendColor { alpha, rgb: (red, green, blue) }: BackendColor) -> String {
    let opacity = if alpha < 1.0 { format!(" opacity=\"{alpha}\"") } else { String::new() };
    format!(" {attribute}=\"#{red:02X}{green:02X}{blue:02X}\"{opacity}")
}

/// An area or its edge.
fn filled_or_not(style: &impl BackendStyle, is_filled: bool) -> String {
    if is_filled {
        return paint("fill", style.color());
    }
    let edge = paint("stroke", style.color());
    format!(" fill=\"none\"{edge} stroke-width=\"{}\"", style.stroke_width())
}

/// Writes a line as its first point and the steps to the others.
fn write_steps(data: &mut String, points: &[BackendCoord]) {
    let Some(((x, y), others)) = points.split_first() else { return };
    let _ = write!(data, "M{x} {y}");
    let (mut x, mut y) = (*x, *y);
    for (place, to) in others.iter().enumerate() {
        let step = [to.0 - x, to.1 - y];
        for (axis, value) in step.into_iter().enumerate() {
            // A sign separates numbers as well.
            let before = match (place, axis) {
                (0, 0) => "l",
                _ if value < 0 => "",
                _ => " ",
            };
            let _ = write!(data, "{before}{value}");
        }
        (x, y) = *to;
    }
}

/// A line without the points that it passes anyway (Douglas and Peucker, 1973).
fn simplified(points: &[BackendCoord]) -> Vec<BackendCoord> {
    let last = points.len() - 1;
    let mut is_kept = vec![false; points.len()];
    (is_kept[0], is_kept[last]) = (true, true);
    let mut pieces = vec![(0, last)];
    while let Some((from, to)) = pieces.pop() {
        let distance = |place: usize| distance(points[place], [points[from], points[to]]);
        let farthest = (from + 1..to).map(|place| (distance(place), place));
        let farthest = farthest.reduce(|a, b| if b.0 > a.0 { b } else { a });
        if let Some((_, place)) = farthest.filter(|(distance, _)| *distance > UNSEEN) {
            is_kept[place] = true;
            pieces.extend([(from, place), (place, to)]);
        }
    }
    points.iter().zip(is_kept).filter_map(|(point, kept)| kept.then_some(*point)).collect()
}

/// How far a point lies from a line with ends.
fn distance(point: BackendCoord, [from, to]: [BackendCoord; 2]) -> f64 {
    let offset = |end: BackendCoord| {
        [f64::from(end.0) - f64::from(from.0), f64::from(end.1) - f64::from(from.1)]
    };
    let ([x, y], [along, up]) = (offset(point), offset(to));
    let square = along * along + up * up;
    let share = if square > 0.0 { ((x * along + y * up) / square).clamp(0.0, 1.0) } else { 0.0 };
    (x - share * along).hypot(y - share * up)
}

/// Text as the contents of an element.
fn escaped(words: &str) -> String {
    words
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
        .replace('\'', "&apos;")
}

impl DrawingBackend for Vector<'_> {
    type ErrorType = Infallible;

    fn get_size(&self) -> (u32, u32) {
        self.size
    }

    fn ensure_prepared(&mut self) -> Outcome {
        Ok(())
    }

    fn present(&mut self) -> Outcome {
        self.end_lines();
        if !self.text.ends_with("</svg>\n") {
            self.text.push_str("</svg>\n");
        }
        Ok(())
    }

    fn draw_pixel(&mut self, (x, y): BackendCoord, color: BackendColor) -> Outcome {
        let fill = paint("fill", color);
        self.element(color, || {
            format!("<rect x=\"{x}\" y=\"{y}\" width=\"1\" height=\"1\"{fill}/>")
        });
        Ok(())
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Outcome {
        self.add_line(&[from, to], style);
        Ok(())
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Outcome {
        self.add_line(&path.into_iter().collect::<Vec<_>>(), style);
        Ok(())
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        (left, top): BackendCoord,
        (right, bottom): BackendCoord,
        style: &S,
        fill: bool,
    ) -> Outcome {
        self.element(style.color(), || {
            let (width, height) = (right - left, bottom - top);
            let paint = filled_or_not(style, fill);
            format!("<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\"{paint}/>")
        });
        Ok(())
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        (x, y): BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Outcome {
        self.element(style.color(), || {
            let paint = filled_or_not(style, fill);
            format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\"{paint}/>")
        });
        Ok(())
    }

    fn fill_polygon<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Outcome {
        let points: Vec<BackendCoord> = path.into_iter().collect();
        self.element(style.color(), || {
            let mut data = String::new();
            write_steps(&mut data, &points);
            format!("<path{} d=\"{data}z\"/>", paint("fill", style.color()))
        });
        Ok(())
    }

    fn draw_text<S: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &S,
        (x, y): BackendCoord,
    ) -> Outcome {
        self.element(style.color(), || {
            let anchor = match style.anchor().h_pos {
                HPos::Left => "",
                HPos::Right => " text-anchor=\"end\"",
                HPos::Center => " text-anchor=\"middle\"",
            };
            let down = match style.anchor().v_pos {
                VPos::Top => "0.76em",
                VPos::Center => "0.5ex",
                VPos::Bottom => "-0.5ex",
            };
            let turned = match style.transform() {
                FontTransform::None => String::new(),
                FontTransform::Rotate90 => format!(" transform=\"rotate(90 {x} {y})\""),
                FontTransform::Rotate180 => format!(" transform=\"rotate(180 {x} {y})\""),
                FontTransform::Rotate270 => format!(" transform=\"rotate(270 {x} {y})\""),
            };
            format!(
                "<text x=\"{x}\" y=\"{y}\" dy=\"{down}\"{anchor} font-size=\"{:.1}\"{}{turned}>{}</text>",
                style.size() / LETTERS,
                paint("fill", style.color()),
                escaped(text)
            )
        });
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use plotters::prelude::*;

    use super::*;

    /// What is drawn in a picture of 100 by 80 pixels.
    fn drawn(draw: impl Fn(&DrawingArea<Vector<'_>, plotters::coord::Shift>)) -> String {
        let mut text = String::new();
        let area = Vector::on(&mut text, (100, 80), "A, B").into_drawing_area();
        draw(&area);
        area.present().unwrap();
        drop(area);
        text
    }

    #[test]
    fn lines_of_one_style_are_one_element() {
        let text = drawn(|area| {
            for x in [10, 30] {
                area.draw(&PathElement::new([(x, 5), (x + 9, 1)], Color::stroke_width(&RED, 2)))
                    .unwrap();
            }
            area.draw(&PathElement::new([(1, 2), (3, 4)], Color::stroke_width(&BLUE, 2))).unwrap();
        });
        assert_eq!(text.matches("<path").count(), 2, "{text}");
        assert!(
            text.contains("stroke=\"#FF0000\" stroke-width=\"2\" d=\"M10 5l9-4M30 5l9-4\""),
            "{text}"
        );
        assert!(text.ends_with("d=\"M1 2l2 2\"/>\n</svg>\n"), "{text}");
    }

    #[test]
    fn points_that_a_line_passes_anyway_are_left_out() {
        let line = [(0, 0), (5, 0), (10, 0), (10, 0), (20, 1), (30, 9), (40, 0)];
        assert_eq!(simplified(&line), [(0, 0), (20, 1), (30, 9), (40, 0)]);
        assert_eq!(simplified(&[(3, 4)]), [(3, 4)]);
        // There and back again.
        assert_eq!(simplified(&[(0, 0), (9, 0), (0, 0)]), [(0, 0), (9, 0), (0, 0)]);
    }

    #[test]
    fn text_is_text() {
        let text = drawn(|area| {
            let style = ("A", 24.8).into_font().color(&BLACK);
            area.draw_text("<b> & \"c\"", &style, (3, 4)).unwrap();
        });
        assert!(
            text.contains(
                "font-size=\"20.0\" fill=\"#000000\">&lt;b&gt; &amp; &quot;c&quot;</text>"
            ),
            "{text}"
        );
    }
}
