//! Where the bytes come from that are to be kept.

use massline_protocol::crc32;

/// Bytes that are to be kept. They are read piece by piece, so that a long thing need not be encoded as a whole;
/// they are the same however often they are read.
pub trait Source {
    /// How many there are.
    fn length(&self) -> usize;

    /// CRC-32 over all of them.
    fn checksum(&self) -> u32;

    /// Writes the bytes from `offset` on into `out`, which they fill.
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
