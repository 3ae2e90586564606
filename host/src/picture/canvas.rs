//! What pictures are drawn on: the same drawing becomes an SVG or a PNG file.

use std::sync::OnceLock;

use plotters::chart::MeshStyle;
use plotters::coord::Shift;
use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{FontStyle, register_font};

use super::theme::{FAINT, INK, LABEL, PAPER, SIZE, SMALL, TITLE};
use crate::error::{Error, Result};

/// Fonts by which a viewer of an SVG file looks for ours.
const FONT: &str = "DejaVu Sans, Verdana, sans-serif";
/// DejaVu Sans with the letters of Latin, Greek and Cyrillic and the signs of mathematics.
const FONT_FILE: &[u8] = include_bytes!("font/DejaVuSans.ttf");

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
pub(super) type Drawn<B> =
    std::result::Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// A picture that can be drawn.
pub trait Drawing {
    /// Its title.
    fn title(&self) -> String;

    /// Draws all but the title.
    ///
    /// # Errors
    /// Those of the backend.
    fn draw<B: DrawingBackend>(&self, area: &Area<B>) -> Drawn<B>;
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
            draw(drawing, SVGBackend::with_string(&mut text, SIZE))?;
            Ok(text.into_bytes())
        }
        ImageFormat::Png => {
            let (width, height) = SIZE;
            let mut pixels = vec![0; 3 * width as usize * height as usize];
            draw(drawing, BitMapBackend::with_buffer(&mut pixels, SIZE))?;
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
        write(&head, &drawing.title(), middle, (HPos::Center, VPos::Center), TITLE)?;
        drawing.draw(&rest.margin(0, 20, 30, 40))?;
        area.present()
    };
    drawn().map_err(failed)
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
) -> Drawn<B> {
    area.draw_text(words, &text(size).pos(Pos::new(horizontal, vertical)), at)
}

/// A number with this many decimals, short also when it is no number of a test.
pub(super) fn number(value: f64, decimals: usize) -> String {
    if value.abs() < 1e6 { format!("{value:.decimals$}") } else { format!("{value:.1e}") }
}

/// Names beside their colours, in lines from the top of an area; returns the height that they take.
pub(super) fn legend<B: DrawingBackend>(
    area: &Area<B>,
    names: &[(String, RGBColor)],
) -> std::result::Result<i32, DrawingAreaErrorKind<B::ErrorType>> {
    const LINE: i32 = 34;
    let width = area.dim_in_pixel().0 as i32;
    let (mut x, mut y) = (0, LINE / 2);
    for (name, color) in names {
        let needs = 70 + area.estimate_text_size(name, &text(LABEL))?.0 as i32;
        if x > 0 && x + needs > width {
            (x, y) = (0, y + LINE);
        }
        area.draw(&Rectangle::new([(x, y - 9), (x + 18, y + 9)], color.filled()))?;
        write(area, name, (x + 28, y), (HPos::Left, VPos::Center), LABEL)?;
        x += needs;
    }
    Ok(y + LINE)
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
