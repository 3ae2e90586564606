//! The framebuffer of the panel: 128 × 64 pixels, bright or dark.

use std::convert::Infallible;

use embedded_graphics::Pixel;
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{DrawTarget, OriginDimensions, Size};

/// Pixels per row.
pub const WIDTH: usize = 128;
/// Number of rows.
pub const HEIGHT: usize = 64;

/// The pixels, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Framebuffer(Box<[bool; WIDTH * HEIGHT]>);

impl Default for Framebuffer {
    /// All pixels dark.
    fn default() -> Self {
        Self(Box::new([false; WIDTH * HEIGHT]))
    }
}

impl Framebuffer {
    /// Whether a pixel is bright, counted from the upper left corner; pixels outside are dark.
    pub fn is_bright(&self, x: usize, y: usize) -> bool {
        x < WIDTH && y < HEIGHT && self.0[y * WIDTH + x]
    }
}

impl OriginDimensions for Framebuffer {
    fn size(&self) -> Size {
        Size::new(WIDTH as u32, HEIGHT as u32)
    }
}

impl DrawTarget for Framebuffer {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            let (Ok(x), Ok(y)) = (usize::try_from(at.x), usize::try_from(at.y)) else { continue };
            if x < WIDTH && y < HEIGHT {
                self.0[y * WIDTH + x] = color.is_on();
            }
        }
        Ok(())
    }
}
