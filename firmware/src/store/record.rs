//! Records, of which a page of the log consists.
//!
//! A record is a header of [`HEADER`] bytes and its payload, both padded to whole words of the flash. The
//! header has its own check, so that the next record can be found after a torn payload. The check includes
//! the page's number, so that remains of an earlier use of the page are never mistaken for a record.

use massline_protocol::crc32_of_chunks;
use num_enum::{IntoPrimitive, TryFromPrimitive};

/// Bytes of a header.
pub(super) const HEADER: usize = 16;

/// Kind of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq, IntoPrimitive, TryFromPrimitive)]
#[repr(u8)]
pub(super) enum Kind {
    /// First record of a page; its serial is the page's number.
    Page = 1,
    /// The page holds all records moved into it, and is a part of the log from here on.
    Opened = 2,
    /// A piece of an object.
    Data = 3,
    /// An object is complete, or something else has changed.
    Change = 4,
}

/// The header of a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub kind: Kind,
    /// Bytes of the payload.
    pub length: u16,
    /// Serial of the object or change. Serials are never reused.
    pub serial: u32,
    /// Offset of the payload in its object.
    pub offset: u16,
    /// CRC-32 of the payload.
    pub crc: u32,
}

impl Header {
    /// Encodes the header for the page with this number.
    pub fn encode(&self, page: u32) -> [u8; HEADER] {
        let mut bytes = [0; HEADER];
        let (kind, length) = (self.kind.into(), self.length.to_le_bytes());
        let (serial, offset) = (self.serial.to_le_bytes(), self.offset.to_le_bytes());
        bytes[0] = kind;
        bytes[2..4].copy_from_slice(&length);
        bytes[4..8].copy_from_slice(&serial);
        bytes[8..10].copy_from_slice(&offset);
        bytes[12..].copy_from_slice(&self.crc.to_le_bytes());
        let check = check(&bytes, page).to_le_bytes();
        bytes[10..12].copy_from_slice(&check);
        bytes
    }

    /// Decodes a header from the page with this number; `None` when the bytes are not a header.
    pub fn decode(bytes: &[u8; HEADER], page: u32) -> Option<Self> {
        let &[kind, zero, l0, l1, s0, s1, s2, s3, o0, o1, k0, k1, c0, c1, c2, c3] = bytes;
        let kind = Kind::try_from(kind).ok().filter(|_| zero == 0)?;
        let header = Self {
            kind,
            length: u16::from_le_bytes([l0, l1]),
            serial: u32::from_le_bytes([s0, s1, s2, s3]),
            offset: u16::from_le_bytes([o0, o1]),
            crc: u32::from_le_bytes([c0, c1, c2, c3]),
        };
        (check(bytes, page) == u16::from_le_bytes([k0, k1])).then_some(header)
    }

    /// The number of the page that starts with these bytes.
    pub fn page_number(bytes: &[u8; HEADER]) -> Option<u32> {
        let &[_, _, _, _, s0, s1, s2, s3, ..] = bytes;
        let number = u32::from_le_bytes([s0, s1, s2, s3]);
        Self::decode(bytes, number).filter(|header| header.kind == Kind::Page).map(|_| number)
    }
}

/// Check of a header (without the check itself) and its page's number.
fn check(bytes: &[u8; HEADER], page: u32) -> u16 {
    let mut crc = crc32_of_chunks();
    crc.update(&bytes[..10]);
    crc.update(&bytes[12..]);
    crc.update(&page.to_le_bytes());
    crc.finalize() as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    const ANY: Header = Header {
        kind: Kind::Data,
        length: 700,
        serial: 0x0102_0304,
        offset: 4000,
        crc: 0xDEAD_BEEF,
    };

    #[test]
    fn a_header_is_read_as_it_was_written_in_its_page_alone() {
        let bytes = ANY.encode(7);
        assert_eq!(Header::decode(&bytes, 7), Some(ANY));
        assert_eq!(Header::decode(&bytes, 8), None);
        assert_eq!(Header::page_number(&bytes), None, "no page begins with it");
    }

    #[test]
    fn the_first_record_of_a_page_says_its_number() {
        let first = Header { kind: Kind::Page, serial: 41, ..ANY };
        assert_eq!(Header::page_number(&first.encode(41)), Some(41));
        assert_eq!(Header::page_number(&first.encode(40)), None);
    }

    #[test]
    fn a_header_with_one_wrong_bit_is_none() {
        let bytes = ANY.encode(7);
        for bit in 0..8 * HEADER {
            let mut wrong = bytes;
            wrong[bit / 8] ^= 1 << (bit % 8);
            assert_eq!(Header::decode(&wrong, 7), None, "bit {bit}");
        }
        assert_eq!(Header::decode(&[0xFF; HEADER], 7), None);
        assert_eq!(Header::decode(&[0; HEADER], 0), None);
    }
}
