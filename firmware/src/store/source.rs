//! Sources of the bytes that are to be stored.

use massline_protocol::{crc32, crc32_of_chunks};
use massline_shared::Real;
use massline_shared::nalgebra::Complex;
use massline_shared::signal::CompactLines;

/// Bytes that are checksummed at a time.
const PIECE: usize = 64;

/// Bytes that are to be stored. They are read piece by piece, so that a long object need not be encoded as
/// a whole, and must be the same each time they are read.
pub trait Source {
    /// Number of bytes.
    fn length(&self) -> usize;

    /// CRC-32 of all bytes.
    fn checksum(&self) -> u32 {
        let (mut crc, mut piece) = (crc32_of_chunks(), [0; PIECE]);
        for offset in (0..self.length()).step_by(PIECE) {
            let piece = piece.get_mut(..PIECE.min(self.length() - offset)).unwrap_or_default();
            self.read(offset, piece);
            crc.update(piece);
        }
        crc.finalize()
    }

    /// Fills `out` with the bytes from `offset` on.
    fn read(&self, offset: usize, out: &mut [u8]);
}

impl Source for [u8] {
    fn length(&self) -> usize {
        self.len()
    }

    fn checksum(&self) -> u32 {
        crc32(self)
    }

    fn read(&self, offset: usize, out: &mut [u8]) {
        let bytes = self.get(offset..).unwrap_or_default();
        for (to, byte) in out.iter_mut().zip(bytes) {
            *to = *byte;
        }
    }
}

impl<S: Source + ?Sized> Source for &S {
    fn length(&self) -> usize {
        (**self).length()
    }

    fn checksum(&self) -> u32 {
        (**self).checksum()
    }

    fn read(&self, offset: usize, out: &mut [u8]) {
        (**self).read(offset, out);
    }
}

/// A finished DOF with its lines: the head, which says the rest of the DOF in at most [`MAX_DOF`](super::MAX_DOF)
/// bytes of postcard, and the lines after it.
#[derive(Debug)]
pub struct DofWithLines<'a, F> {
    /// What the DOF says besides its lines.
    pub head: &'a [u8],
    /// The lines.
    pub lines: &'a CompactLines<F>,
}

impl<R: Real, F: Fn(usize, usize) -> Complex<R>> Source for DofWithLines<'_, F> {
    fn length(&self) -> usize {
        self.head.len() + self.lines.length()
    }

    fn read(&self, offset: usize, out: &mut [u8]) {
        let in_head = self.head.len().saturating_sub(offset).min(out.len());
        let (of_head, of_lines) = out.split_at_mut(in_head);
        self.head.read(offset, of_head);
        self.lines.read((offset + in_head).saturating_sub(self.head.len()), of_lines);
    }
}
