//! The hash that identifies a layout on the wire, in the store and in files.

use massline_shared::layout::RigLayout;

use crate::checksum::crc32;

/// Largest encoded layout, bytes.
pub const MAX_LAYOUT: usize = 1152;

/// Hash of a layout.
pub trait LayoutHash {
    /// CRC-32 over the encoded bytes of the layout.
    fn hash(&self) -> u32;
}

impl LayoutHash for RigLayout {
    fn hash(&self) -> u32 {
        let mut bytes = [0; MAX_LAYOUT];
        match postcard::to_slice(self, &mut bytes) {
            Ok(encoded) => crc32(encoded),
            // Cannot happen: MAX_LAYOUT covers full capacity, which a test proves.
            Err(_) => 0,
        }
    }
}
