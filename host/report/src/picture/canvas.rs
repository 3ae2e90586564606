//! What pictures are drawn on: the same drawing becomes an SVG or a PNG file.

use std::sync::OnceLock;

use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use super::bitmap::Bitmap;
use super::theme::{FAINT, INK, LABEL, PAPER, SIZE, SMALL, TITLE};
use super::vector::Vector;
use crate::typography::with_minus_signs;
use massline_result::{Error, Result};

/// Fonts by which a viewer of an SVG file looks for ours.
pub(super) const FONT: &str = "DejaVu Sans, Verdana, sans-serif";
/// DejaVu Sans with the letters of Latin, Greek and Cyrillic and the signs of mathematics.
const FONT_FILE: &[u8] = include_bytes!("font/DejaVuSans.ttf");

/// The licence of the font, which goes with every copy of it.
pub const FONT_LICENCE: &str = include_str!("font/LICENSE");

/// The format of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum ImageFormat {
    /// Scalable vector graphics.
    Svg,
    /// A bitmap.
    Png,
}

/// Where something is drawn.
pub(super) type Area<B> = DrawingArea<B, Shift>;
/// The outcome of drawing.
pub(super) type DrawingOutcome<B> =
    std::result::Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// What stands above a picture.
pub struct Heading<'a> {
    /// What was measured; it is shortened where there is no room for all of it.
    pub subject: &'a str,
    /// What the picture shows of it.
    pub shows: String,
}

/// A picture that can be drawn.
pub trait Drawing {
    /// What stands above it.
    fn heading(&self) -> Heading<'_>;

    /// Draws all but the heading.
    ///
    /// # Errors
    /// Those of the backend.
    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> DrawingOutcome<B>;
}

/// The bytes of a picture's file.
///
/// # Errors
/// Exit 1 when it cannot be drawn.
pub fn render(drawing: &impl Drawing, format: ImageFormat) -> Result<Vec<u8>> {
    register()?;
    match format {
        ImageFormat::Svg => {
            let mut text = String::new();
            draw(drawing, Vector::on(&mut text, SIZE, FONT))?;
            Ok(text.into_bytes())
        }
        ImageFormat::Png => {
            let (width, height) = SIZE;
            let mut pixels = vec![0; 3 * width as usize * height as usize];
            draw(drawing, Bitmap::on(&mut pixels, SIZE))?;
            let mut bytes = Vec::new();
            let mut encoder = png::Encoder::new(&mut bytes, width, height);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            let mut writer = encoder.write_header().map_err(failed)?;
            writer.write_image_data(&pixels).map_err(failed)?;
            writer.finish().map_err(failed)?;
            Ok(bytes)
        }
    }
}

fn draw<B: DrawingBackend>(drawing: &impl Drawing, backend: B) -> Result<()> {
    let area = backend.into_drawing_area();
    let drawn = || {
        area.fill(&PAPER)?;
        let (head, rest) = area.split_vertically(TITLE * 2.0);
        let (width, height) = head.dim_in_pixel();
        let middle = (width as i32 / 2, height as i32 / 2 + 4);
        let title = title(&head, &drawing.heading())?;
        write(&head, &title, middle, (HPos::Center, VPos::Center), TITLE)?;
        drawing.draw(&rest.margin(0, 20, 30, 40))?;
        area.present()
    };
    drawn().map_err(failed)
}

/// The heading in the width of an area, with some room at both sides.
fn title<B: DrawingBackend>(
    area: &Area<B>,
    Heading { subject, shows }: &Heading<'_>,
) -> std::result::Result<String, DrawingAreaErrorKind<B::ErrorType>> {
    /// Room at both sides together, pixels: as the margins of the picture.
    const SIDES: i32 = 60;
    let room = area.dim_in_pixel().0 as i32 - SIDES;
    let rest = format!(": {shows}");
    let taken = area.estimate_text_size(&rest, &text(TITLE))?.0 as i32;
    let subject = fitted(area, subject, TITLE, room - taken)?;
    fitted(area, &(subject + &rest), TITLE, room)
}

/// A text in letters of a size, shortened to this width, pixels; one that is cut ends with an ellipsis.
pub(super) fn fitted<B: DrawingBackend>(
    area: &Area<B>,
    words: &str,
    size: f64,
    width: i32,
) -> std::result::Result<String, DrawingAreaErrorKind<B::ErrorType>> {
    let style = text(size);
    let fits = |words: &str| Ok(area.estimate_text_size(words, &style)?.0 as i32 <= width);
    // One that is far too long is not measured to its end.
    let mut letters: Vec<char> = words.chars().take(width.max(0) as usize + 1).collect();
    if fits(words)? {
        return Ok(words.to_owned());
    }
    loop {
        let kept: String = letters.iter().collect();
        let shortened = format!("{}…", kept.trim_end());
        if letters.pop().is_none() || fits(&shortened)? {
            return Ok(shortened);
        }
    }
}

/// Makes the font known to the library, once.
pub(super) fn register() -> Result<()> {
    static REGISTERED: OnceLock<bool> = OnceLock::new();
    let done = REGISTERED.get_or_init(|| register_font(FONT, FontStyle::Normal, FONT_FILE).is_ok());
    if *done { Ok(()) } else { Err(failed("the font is broken")) }
}

fn failed(why: impl std::fmt::Display) -> Error {
    Error::internal(
        "picture_not_drawn",
        format!("the picture could not be drawn: {why}; report this"),
    )
}

/// The style of text of a size in pixels.
pub(super) fn text(size: f64) -> TextStyle<'static> {
    (FONT, size).into_font().color(&INK)
}

/// Writes text at a place in pixels.
pub(super) fn write<B: DrawingBackend>(
    area: &Area<B>,
    words: &str,
    at: (i32, i32),
    (horizontal, vertical): (HPos, VPos),
    size: f64,
) -> DrawingOutcome<B> {
    area.draw_text(words, &text(size).pos(Pos::new(horizontal, vertical)), at)
}

/// A number with this many decimals, short also when it is no number of a test.
pub(super) fn number(value: f64, decimals: usize) -> String {
    let text =
        if value.abs() < 1e6 { format!("{value:.decimals$}") } else { format!("{value:.1e}") };
    with_minus_signs(&text)
}

/// A number beside an axis: without zeros at its end, and without the rounding of the arithmetic.
pub(super) fn tick(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    // Adding zero takes the sign from a negative zero.
    with_minus_signs(&format!("{}", rounded + 0.0))
}

/// Gives the frame of a chart the lines and letters of all pictures.
pub(super) fn styled<'m, 'a, 'b, X: Ranged, Y: Ranged, B: DrawingBackend>(
    mesh: &'m mut MeshStyle<'a, 'b, X, Y, B>,
) -> &'m mut MeshStyle<'a, 'b, X, Y, B> {
    mesh.light_line_style(FAINT.mix(0.0))
        .bold_line_style(FAINT)
        .axis_style(INK)
        .label_style(text(SMALL))
        .axis_desc_style(text(LABEL))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn width_of(words: &str) -> u32 {
        let mut svg = String::new();
        let area = Vector::on(&mut svg, SIZE, FONT).into_drawing_area();
        area.estimate_text_size(words, &text(TITLE)).unwrap().0
    }

    #[test]
    fn a_heading_that_is_too_wide_loses_letters_of_its_subject() {
        register().unwrap();
        let mut svg = String::new();
        let area = Vector::on(&mut svg, SIZE, FONT).into_drawing_area();
        for letters in [40, 20_000] {
            let subject = "W".repeat(letters);
            let shows = "frequency responses to 3 hits at 1:+Z".to_owned();
            let title = title(&area, &Heading { subject: &subject, shows }).unwrap();
            assert!(title.starts_with("WWW"), "{title}");
            assert!(title.ends_with("W…: frequency responses to 3 hits at 1:+Z"), "{title}");
            assert!(width_of(&title) <= SIZE.0 - 60, "{title}");
        }
        let heading = Heading { subject: "frame", shows: "the test in space".into() };
        assert_eq!(title(&area, &heading).unwrap(), "frame: the test in space");
    }

    #[test]
    fn numbers_of_an_axis_are_short() {
        for (value, text) in
            [(200.0, "200"), (0.1 + 0.2, "0.3"), (1e-7, "0.0000001"), (-0.0, "0"), (-12.5, "−12.5")]
        {
            assert_eq!(tick(value), text);
        }
    }

    /// A title of letters that the font lacks, as a picture.
    struct TitledPicture(&'static str);

    impl Drawing for TitledPicture {
        fn heading(&self) -> Heading<'_> {
            Heading { subject: self.0, shows: String::new() }
        }

        fn draw<B: DrawingBackend>(&self, _: &Area<B>) -> DrawingOutcome<B> {
            Ok(())
        }
    }

    #[test]
    fn letters_that_the_font_lacks_are_seen_in_a_bitmap() {
        let drawn = |subject| render(&TitledPicture(subject), ImageFormat::Png).unwrap();
        assert_eq!(drawn("架台"), drawn("□□"));
        assert_ne!(drawn("架台"), drawn(""));
        assert_ne!(drawn("äЖ"), drawn("□□"));
    }
}
