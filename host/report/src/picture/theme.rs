//! Colours, sizes and fonts of all pictures.

use plotters::style::RGBColor;

/// Size of a picture, pixels.
pub(super) const SIZE: (u32, u32) = (1600, 1000);
/// Font sizes, pixels.
pub(super) const TITLE: f64 = 34.0;
pub(super) const LABEL: f64 = 24.0;
pub(super) const SMALL: f64 = 20.0;

/// Text, axes and frames.
pub(super) const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
/// What stands behind the data and must be seen: an outline.
pub(super) const GREY: RGBColor = RGBColor(0x99, 0x99, 0x99);
/// Grid lines.
pub(super) const FAINT: RGBColor = RGBColor(0xDD, 0xDD, 0xDD);
pub(super) const PAPER: RGBColor = RGBColor(0xFF, 0xFF, 0xFF);

/// Colours that people with any kind of colour vision tell apart (Okabe and Ito, Color Universal Design, 2008), without
/// yellow, which white paper swallows.
pub(super) const COLORS: [RGBColor; 7] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0x00, 0x00, 0x00),
];

/// The colour of the series with this place.
pub(super) fn color(place: usize) -> RGBColor {
    COLORS[place % COLORS.len()]
}

/// How often the colours have been used up before the series with this place.
pub(super) fn cycle(place: usize) -> usize {
    place / COLORS.len()
}

/// The lengths of dashes and of the gaps between them, pixels; none for a line without gaps.
pub(super) type Dashes = Option<[i32; 2]>;

/// Dashes that are told apart at the width of a curve.
const DASHES: [Dashes; 5] = [None, Some([12, 6]), Some([3, 4]), Some([24, 5]), Some([6, 12])];

/// The dashes of the series with this place: others each time that the colours begin anew.
pub(super) fn dashes(place: usize) -> Dashes {
    DASHES[cycle(place) % DASHES.len()]
}

/// Between paper and the first colour, for a share from 0 to 1.
pub(super) fn shade(share: f64) -> RGBColor {
    let share = share.clamp(0.0, 1.0);
    let between = |from: u8, to: u8| {
        let (from, to) = (f64::from(from), f64::from(to));
        (from + share * (to - from)).round() as u8
    };
    let to = COLORS[0];
    RGBColor(between(PAPER.0, to.0), between(PAPER.1, to.1), between(PAPER.2, to.2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_thirty_five_series_differ() {
        for place in 0..35 {
            for other in 0..place {
                let differ = color(place) != color(other) || dashes(place) != dashes(other);
                assert!(differ, "{place} and {other}");
            }
        }
    }
}
