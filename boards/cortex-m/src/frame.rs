//! The framebuffer of a screen of 128 × 64 pixels, organised in pages.
//!
//! *Page*: a stripe of eight rows; each byte is a column of it, with the topmost pixel in the lowest bit.

use core::convert::Infallible;

use embedded_graphics::Pixel;
use embedded_graphics::draw_target::DrawTarget;
use embedded_graphics::geometry::{OriginDimensions, Size};
use embedded_graphics::pixelcolor::BinaryColor;
use massline_protocol::crc32;

/// Columns.
pub const WIDTH: usize = 128;
/// Stripes of eight rows.
pub const PAGES: usize = 8;

/// The pixels of one page.
pub type Page = [u8; WIDTH];

/// The picture, and which of its pages differ from what was sent. A picture may be redrawn as a whole:
/// pages that end up unchanged are not sent again.
#[derive(Clone, Debug)]
pub struct Frame {
    pages: [Page; PAGES],
    /// Bit mask of the pages drawn on since they were sent.
    touched: u8,
    /// Checksums of the pages as they were sent; `None` for a page that was never sent.
    sent: [Option<u32>; PAGES],
}

impl Default for Frame {
    fn default() -> Self {
        Self::new()
    }
}

impl Frame {
    /// A black picture. Every page is to be sent, because a screen shows noise when it is switched on.
    pub const fn new() -> Self {
        Self { pages: [[0; WIDTH]; PAGES], touched: u8::MAX, sent: [None; PAGES] }
    }

    /// Marks every page to be sent again.
    pub fn change_all(&mut self) {
        self.touched = u8::MAX;
        self.sent = [None; PAGES];
    }

    /// Number and content of a page that differs from what was sent.
    pub fn changed(&mut self) -> Option<(u8, &Page)> {
        while let Some(page) = self.pages.get(self.touched.trailing_zeros() as usize) {
            let number = self.touched.trailing_zeros() as usize;
            if self.sent[number] != Some(crc32(page)) {
                return Some((number as u8, &self.pages[number]));
            }
            self.touched &= !(1 << number);
        }
        None
    }

    /// Marks a page as sent.
    pub fn sent(&mut self, number: u8) {
        let number = usize::from(number);
        let Some(page) = self.pages.get(number) else { return };
        self.sent[number] = Some(crc32(page));
        self.touched &= !(1 << number);
    }
}

impl OriginDimensions for Frame {
    fn size(&self) -> Size {
        Size::new(WIDTH as u32, 8 * PAGES as u32)
    }
}

impl DrawTarget for Frame {
    type Color = BinaryColor;
    type Error = Infallible;

    fn draw_iter<I: IntoIterator<Item = Pixel<BinaryColor>>>(
        &mut self,
        pixels: I,
    ) -> Result<(), Infallible> {
        for Pixel(at, color) in pixels {
            let (Ok(x), Ok(y)) = (usize::try_from(at.x), usize::try_from(at.y)) else { continue };
            let Some(byte) = self.pages.get_mut(y / 8).and_then(|page| page.get_mut(x)) else {
                continue;
            };
            let bit = 1 << (y % 8);
            let drawn = if color.is_on() { *byte | bit } else { *byte & !bit };
            if drawn != *byte {
                *byte = drawn;
                self.touched |= 1 << (y / 8);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use embedded_graphics::geometry::Point;

    fn sent() -> Frame {
        let mut frame = Frame::new();
        while let Some((number, _)) = frame.changed() {
            frame.sent(number);
        }
        frame
    }

    fn set(frame: &mut Frame, x: i32, y: i32, on: bool) {
        let Ok(()) = frame.draw_iter([Pixel(Point::new(x, y), on.into())]);
    }

    #[test]
    fn a_pixel_is_a_bit_of_its_page() {
        let mut frame = sent();
        set(&mut frame, 127, 63, true);
        let mut page = [0; WIDTH];
        page[127] = 0x80;
        assert_eq!(frame.changed(), Some((7, &page)));
        set(&mut frame, 0, 9, true);
        assert_eq!(frame.changed().map(|(number, page)| (number, page[0])), Some((1, 2)));
    }

    #[test]
    fn a_new_screen_gets_every_page_once() {
        let mut frame = sent();
        frame.change_all();
        let mut numbers = Vec::new();
        while let Some((number, _)) = frame.changed() {
            numbers.push(number);
            frame.sent(number);
        }
        assert_eq!(numbers, [0, 1, 2, 3, 4, 5, 6, 7]);
    }

    #[test]
    fn a_page_is_sent_once_for_a_change() {
        let mut frame = sent();
        assert_eq!(frame.changed(), None);
        set(&mut frame, 3, 0, true);
        frame.sent(0);
        assert_eq!(frame.changed(), None);
        set(&mut frame, 3, 0, true);
        assert_eq!(frame.changed(), None, "nothing has changed");
        set(&mut frame, 3, 0, false);
        assert!(frame.changed().is_some());
    }

    #[test]
    fn a_picture_drawn_anew_is_sent_where_it_differs() {
        let mut frame = sent();
        let draw = |frame: &mut Frame, x| {
            let Ok(()) = frame.clear(BinaryColor::Off);
            set(frame, 10, 20, true);
            set(frame, x, 60, true);
        };
        draw(&mut frame, 1);
        while let Some((number, _)) = frame.changed() {
            frame.sent(number);
        }
        draw(&mut frame, 1);
        assert_eq!(frame.changed(), None, "the same picture");
        draw(&mut frame, 2);
        assert_eq!(frame.changed().map(|(number, _)| number), Some(7));
        frame.sent(7);
        assert_eq!(frame.changed(), None);
    }

    #[test]
    fn what_lies_outside_is_not_drawn() {
        let mut frame = sent();
        for (x, y) in [(-1, 0), (0, -1), (128, 0), (0, 64), (i32::MAX, i32::MIN)] {
            set(&mut frame, x, y, true);
        }
        assert_eq!(frame.changed(), None);
    }
}
