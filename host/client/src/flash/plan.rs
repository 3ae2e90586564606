//! Plans which sectors are erased and what is written; neither touches the store.

use std::ops::Range;

use super::board::Board;
use super::image::Image;
use massline_result::{Error, Result};

/// The effect of flashing an image on a board's flash.
#[derive(Debug, PartialEq, Eq)]
pub struct Plan {
    /// The board.
    pub board: &'static Board,
    /// The image to be written.
    pub image: Image,
    /// The sectors that the image occupies, by rising address; none belongs to the store.
    pub erase: Vec<Range<u32>>,
}

impl Plan {
    /// Plans an image for a board.
    ///
    /// # Errors
    /// `image_outside_flash`, `image_overlaps_store`.
    pub fn new(board: &'static Board, image: Image) -> Result<Self> {
        let flash = board.flash.range();
        for segment in &image.segments {
            let (start, end) = (segment.address, segment.end());
            if start < flash.start || end > u64::from(flash.end) {
                return Err(Error::input(
                    "image_outside_flash",
                    format!(
                        "the image holds 0x{start:08x} to 0x{end:08x}; flash of {} is 0x{:08x} to 0x{:08x}",
                        board.name, flash.start, flash.end
                    ),
                ));
            }
            if start < board.store.end && end > u64::from(board.store.start) {
                return Err(overlap(board, start, end));
            }
        }
        let touched = |sector: &Range<u32>| {
            let meets = |s: &super::image::Segment| {
                s.address < sector.end && s.end() > u64::from(sector.start)
            };
            image.segments.iter().any(meets)
        };
        let erase = board.flash.each_sector().filter(touched).collect();
        Ok(Self { board, image, erase })
    }

    /// Total size of the erased sectors, bytes.
    pub fn erased(&self) -> u64 {
        self.erase.iter().map(|sector| u64::from(sector.end - sector.start)).sum()
    }
}

fn overlap(board: &Board, start: u32, end: u64) -> Error {
    Error::input(
        "image_overlaps_store",
        format!(
            "the image holds 0x{start:08x} to 0x{end:08x} and would overwrite what the rig has stored at \
             0x{:08x} to 0x{:08x} (layouts, calibration, results); leave --image out, and the firmware is built with \
             the memory map of {}",
            board.store.start, board.store.end, board.name
        ),
    )
}
