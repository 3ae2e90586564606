//! Source of the bytes that are to be stored.

use massline_protocol::crc32;

/// Bytes that are to be stored. They are read piece by piece, so that a long object need not be encoded as
/// a whole, and must be the same each time they are read.
pub trait Source {
    /// Number of bytes.
    fn length(&self) -> usize;

    /// CRC-32 of all bytes.
    fn checksum(&self) -> u32;

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
