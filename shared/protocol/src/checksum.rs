//! CRC-32 (ISO-HDLC), the checksum of frames, objects, layouts and calibrations.

use massline_shared::signal::Calibration;

static CRC: crc::Crc<u32, crc::Table<1>> =
    crc::Crc::<u32, crc::Table<1>>::new(&crc::CRC_32_ISO_HDLC);

/// CRC-32 of one contiguous slice.
pub fn crc32(bytes: &[u8]) -> u32 {
    CRC.checksum(bytes)
}

/// CRC-32 of bytes that arrive in pieces: call `update` with each, then `finalize`.
pub fn crc32_of_chunks() -> crc::Digest<'static, u32, crc::Table<1>> {
    CRC.digest()
}

/// Checksum by which a result identifies its calibration.
pub fn calibration_checksum(calibration: &Calibration) -> u32 {
    // A calibration consists of four-byte floats, and postcard encodes each in four bytes.
    let mut bytes = [0; size_of::<Calibration>()];
    postcard::to_slice(calibration, &mut bytes).map_or(0, |bytes| crc32(bytes))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_value_of_the_catalogue_comes_out_whole_and_in_pieces() {
        // The check value of CRC-32/ISO-HDLC: the checksum of these nine digits.
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
        let mut crc = crc32_of_chunks();
        crc.update(b"1234");
        crc.update(b"56789");
        assert_eq!(crc.finalize(), 0xCBF4_3926);
    }
}
