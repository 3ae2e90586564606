//! Bitmaps: lines with soft edges and round corners, and a sign for letters that the font lacks.
//!
//! The backend of the library joins the pieces of a wide line with spikes where it turns sharply, and leaves letters
//! out that the font lacks. A viewer of an SVG file does both better.

use plotters::prelude::BitMapBackend;
use plotters_backend::{
    BackendColor, BackendCoord, BackendStyle, BackendTextStyle, DrawingBackend, DrawingErrorKind,
};

/// Stands for a letter that the font lacks.
const REPLACEMENT: char = '□';
/// How far the library draws letters above the place where an SVG file has them, share of their size: there half the
/// height of small letters is below the middle.
const TOO_HIGH: f64 = 0.12;
/// What is at most drawn at a place to count as nothing, share of a pixel.
const NOTHING: f32 = 0.02;

/// A bitmap of red, green and blue.
pub(super) struct Bitmap<'a>(BitMapBackend<'a>);

/// The outcome of drawing on a bitmap.
type Outcome<'a> = Result<(), DrawingErrorKind<<BitMapBackend<'a> as DrawingBackend>::ErrorType>>;

impl<'a> Bitmap<'a> {
    /// A bitmap of this size in three bytes for each pixel.
    pub fn on(pixels: &'a mut [u8], size: (u32, u32)) -> Self {
        Self(BitMapBackend::with_buffer(pixels, size))
    }

    /// Mixes a colour into each pixel of a box, in the share that `cover` has for it.
    fn cover<S: BackendStyle>(&mut self, cover: &Cover, style: &S) -> Outcome<'a> {
        let BackendColor { alpha, rgb } = style.color();
        let wide = (cover.right - cover.left + 1).max(1) as usize;
        for (place, share) in cover.shares.iter().enumerate().filter(|(_, share)| **share > 0.0) {
            let at = (cover.left + (place % wide) as i32, cover.top + (place / wide) as i32);
            let alpha = alpha * f64::from(*share);
            self.0.draw_pixel(at, BackendColor { alpha, rgb })?;
        }
        Ok(())
    }
}

/// The shares of pixels that a figure covers, row by row; the ends of the box are in it.
struct Cover {
    left: i32,
    top: i32,
    right: i32,
    bottom: i32,
    shares: Vec<f32>,
}

impl Cover {
    /// An empty box about these points with a border, as far as it is on the bitmap.
    fn about(points: &[BackendCoord], border: f32, (width, height): (u32, u32)) -> Self {
        let border = border.ceil() as i32 + 1;
        let ends = |coordinate: fn(&BackendCoord) -> i32, size: u32| {
            let low =
                points.iter().map(coordinate).min().unwrap_or(0).saturating_sub(border).max(0);
            let high = points.iter().map(coordinate).max().unwrap_or(-1).saturating_add(border);
            [low, high.min(size as i32 - 1)]
        };
        let [[left, right], [top, bottom]] =
            [ends(|point| point.0, width), ends(|point| point.1, height)];
        let count = (right - left + 1).max(0) as usize * (bottom - top + 1).max(0) as usize;
        Self { left, top, right, bottom, shares: vec![0.0; count] }
    }

    /// Raises the shares to those of a figure whose edge is `outside` pixels away from a place, less inside; only
    /// between these corners.
    fn add(&mut self, corners: [BackendCoord; 2], border: f32, outside: impl Fn(f32, f32) -> f32) {
        let border = border.ceil() as i32 + 1;
        let [from, to] = corners;
        let wide = (self.right - self.left + 1).max(0) as usize;
        let rows = (from.1.min(to.1) - border).max(self.top)
            ..=(from.1.max(to.1) + border).min(self.bottom);
        for y in rows {
            let columns = (from.0.min(to.0) - border).max(self.left)
                ..=(from.0.max(to.0) + border).min(self.right);
            for x in columns {
                let share = (0.5 - outside(x as f32, y as f32)).clamp(0.0, 1.0);
                let place = (y - self.top) as usize * wide + (x - self.left) as usize;
                self.shares[place] = self.shares[place].max(share);
            }
        }
    }

    /// Adds a piece of a line, with round ends but for those where the line ends.
    fn add_piece(&mut self, [from, to]: [BackendCoord; 2], width: f32, is_end: [bool; 2]) {
        let start = [from.0 as f32, from.1 as f32];
        let step = [to.0 as f32 - start[0], to.1 as f32 - start[1]];
        let length = step[0].hypot(step[1]);
        if length == 0.0 {
            return;
        }
        self.add([from, to], width / 2.0, |x, y| {
            let (x, y) = (x - start[0], y - start[1]);
            let along = (x * step[0] + y * step[1]) / length;
            let across = (x * step[1] - y * step[0]).abs() / length;
            // Beyond an end: how far.
            let beyond = (-along).max(along - length);
            let is_cut = if along < 0.0 { is_end[0] } else { is_end[1] };
            match beyond > 0.0 {
                true if is_cut => beyond.max(across - width / 2.0),
                true => beyond.hypot(across) - width / 2.0,
                false => across - width / 2.0,
            }
        });
    }
}

impl<'a> DrawingBackend for Bitmap<'a> {
    type ErrorType = <BitMapBackend<'a> as DrawingBackend>::ErrorType;

    fn get_size(&self) -> (u32, u32) {
        self.0.get_size()
    }

    fn ensure_prepared(&mut self) -> Outcome<'a> {
        self.0.ensure_prepared()
    }

    fn present(&mut self) -> Outcome<'a> {
        self.0.present()
    }

    fn draw_pixel(&mut self, point: BackendCoord, color: BackendColor) -> Outcome<'a> {
        self.0.draw_pixel(point, color)
    }

    fn draw_line<S: BackendStyle>(
        &mut self,
        from: BackendCoord,
        to: BackendCoord,
        style: &S,
    ) -> Outcome<'a> {
        self.0.draw_line(from, to, style)
    }

    fn draw_rect<S: BackendStyle>(
        &mut self,
        upper_left: BackendCoord,
        lower_right: BackendCoord,
        style: &S,
        fill: bool,
    ) -> Outcome<'a> {
        self.0.draw_rect(upper_left, lower_right, style, fill)
    }

    fn draw_path<S: BackendStyle, I: IntoIterator<Item = BackendCoord>>(
        &mut self,
        path: I,
        style: &S,
    ) -> Outcome<'a> {
        let mut points: Vec<BackendCoord> = path.into_iter().collect();
        points.dedup();
        let is_upright = |ends: &[BackendCoord]| ends[0].0 == ends[1].0 || ends[0].1 == ends[1].1;
        if style.stroke_width() == 1 && points.windows(2).all(is_upright) {
            return self.0.draw_path(points, style);
        }
        let width = style.stroke_width() as f32;
        let mut cover = Cover::about(&points, width / 2.0, self.get_size());
        let last = points.len().saturating_sub(2);
        let is_closed = points.first() == points.last();
        for (place, ends) in points.windows(2).enumerate() {
            let is_end = [!is_closed && place == 0, !is_closed && place == last];
            cover.add_piece([ends[0], ends[1]], width, is_end);
        }
        self.cover(&cover, style)
    }

    fn draw_circle<S: BackendStyle>(
        &mut self,
        center: BackendCoord,
        radius: u32,
        style: &S,
        fill: bool,
    ) -> Outcome<'a> {
        let half = if fill { 0.0 } else { style.stroke_width() as f32 / 2.0 };
        let (radius, middle) = (radius as f32, [center.0 as f32, center.1 as f32]);
        let mut cover = Cover::about(&[center], radius + half, self.get_size());
        cover.add([center; 2], radius + half, |x, y| {
            let outside = (x - middle[0]).hypot(y - middle[1]) - radius;
            if fill { outside } else { outside.abs() - half }
        });
        self.cover(&cover, style)
    }

    fn draw_text<T: BackendTextStyle>(
        &mut self,
        text: &str,
        style: &T,
        at: BackendCoord,
    ) -> Outcome<'a> {
        let lower = (TOO_HIGH * style.size()).round() as i32;
        let (x, y) = style.transform().transform(0, lower);
        self.0.draw_text(&drawable(text, style), style, (at.0 + x, at.1 + y))
    }
}

/// The text with a sign for each letter that the font lacks.
fn drawable<T: BackendTextStyle>(text: &str, style: &T) -> String {
    let lacks =
        |letter: char| !letter.is_ascii() && !letter.is_whitespace() && is_blank(letter, style);
    text.chars().map(|letter| if lacks(letter) { REPLACEMENT } else { letter }).collect()
}

/// Whether nothing is drawn for a letter.
fn is_blank<T: BackendTextStyle>(letter: char, style: &T) -> bool {
    let mut ink: f32 = 0.0;
    let drawn = style.draw(letter.encode_utf8(&mut [0; 4]), (0, 0), |_, _, color| {
        ink = ink.max(color.alpha as f32);
        Ok::<(), std::convert::Infallible>(())
    });
    drawn.is_ok() && ink <= NOTHING
}

#[cfg(test)]
mod tests {
    use plotters::prelude::{BLACK, ShapeStyle};

    use super::*;

    const SIZE: (u32, u32) = (100, 100);

    /// The pixels that a path of this width in black colours at least a little.
    fn inked(path: &[BackendCoord], width: u32) -> Vec<(i32, i32)> {
        let mut pixels = vec![255; 3 * 100 * 100];
        let style = ShapeStyle { color: BLACK.into(), filled: false, stroke_width: width };
        Bitmap::on(&mut pixels, SIZE).draw_path(path.iter().copied(), &style).unwrap();
        let places = pixels.chunks(3).enumerate().filter(|(_, pixel)| pixel[0] < 255);
        places.map(|(place, _)| (place as i32 % 100, place as i32 / 100)).collect()
    }

    #[test]
    fn a_wide_line_has_no_spike_where_it_turns_back() {
        let inked = inked(&[(50, 60), (51, 40), (52, 60), (52, 40)], 5);
        assert!(!inked.is_empty());
        for (x, y) in inked {
            assert!((46..=56).contains(&x) && (36..=64).contains(&y), "{x} {y}");
        }
    }

    #[test]
    fn a_line_ends_where_it_ends_so_that_dashes_stay_apart() {
        let inked = inked(&[(20, 50), (30, 50)], 5);
        let [left, right] = [inked.iter().map(|at| at.0).min(), inked.iter().map(|at| at.0).max()];
        assert_eq!([left, right], [Some(20), Some(30)]);
        assert_eq!(inked.len(), 11 * 5);
    }

    #[test]
    fn what_is_beyond_the_bitmap_is_left_out() {
        assert!(inked(&[(-900, 50), (-800, 60)], 5).is_empty());
        assert!(!inked(&[(i32::MIN / 4, 50), (i32::MAX / 4, 50)], 5).is_empty());
        assert!(inked(&[], 5).is_empty() && inked(&[(5, 5)], 5).is_empty());
    }
}
