//! Domain values as the postcard bytes that are stored. They are encoded anew for every piece that is read, so that a
//! value is never in memory twice.

use massline_protocol::crc32_of_chunks;
use postcard::ser_flavors::Flavor;
use serde::Serialize;

/// Takes encoded bytes, one at a time.
pub(crate) struct Bytes<'t>(pub &'t mut dyn FnMut(u8));

impl Bytes<'_> {
    /// Appends a value.
    pub fn put(&mut self, value: &impl Serialize) {
        // Cannot fail: the closure accepts every byte.
        let _ = postcard::serialize_with_flavor(value, Bytes(self.0));
    }
}

impl Flavor for Bytes<'_> {
    type Output = ();

    fn try_push(&mut self, byte: u8) -> postcard::Result<()> {
        (self.0)(byte);
        Ok(())
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

/// What puts its values; the same each time.
pub(crate) type Put<'p> = &'p dyn Fn(&mut Bytes<'_>);

/// Number and CRC-32 of the bytes.
pub(crate) fn measured(put: Put<'_>) -> (usize, u32) {
    let (mut length, mut checksum) = (0, crc32_of_chunks());
    put(&mut Bytes(&mut |byte| {
        length += 1;
        checksum.update(&[byte]);
    }));
    (length, checksum.finalize())
}

/// Fills `out` with the bytes from `offset` on.
pub(crate) fn read(put: Put<'_>, offset: usize, out: &mut [u8]) {
    let mut at = 0_usize;
    put(&mut Bytes(&mut |byte| {
        if let Some(to) = at.checked_sub(offset).and_then(|place| out.get_mut(place)) {
            *to = byte;
        }
        at += 1;
    }));
}
