//! A panel without hardware: the machine has neither screen nor buttons that a test could access.

use core::convert::Infallible;
use core::future::pending;

use embedded_graphics::Pixel;
use embedded_graphics::pixelcolor::BinaryColor;
use embedded_graphics::prelude::{DrawTarget, OriginDimensions, Size};
use massline_firmware::board::Panel;
use massline_firmware::panel::{Button, Cue};

/// A panel that shows nothing and never reports a press.
#[derive(Debug, Default)]
pub struct NoPanel(NoScreen);

/// A target of the size of a screen that discards what is drawn.
#[derive(Debug, Default)]
pub struct NoScreen;

impl OriginDimensions for NoScreen {
    fn size(&self) -> Size {
        Size::new(128, 64)
    }
}

impl DrawTarget for NoScreen {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Infallible> {
        // Each pixel is evaluated, so that the drawing code is the same as on a board with a screen.
        for Pixel(at, color) in pixels {
            core::hint::black_box((at, color));
        }
        Ok(())
    }
}

impl Panel for NoPanel {
    type Screen = NoScreen;

    fn screen(&mut self) -> &mut NoScreen {
        &mut self.0
    }

    async fn flush(&mut self) {}

    async fn button(&mut self) -> Button {
        // Opaque to the compiler, so that the code that handles a press is linked, as on a board with
        // buttons.
        if core::hint::black_box(false) {
            return Button::Ok;
        }
        pending().await
    }

    fn cue(&mut self, _cue: Cue) {}
}
