//! Scans as a rig sends them.

use massline_shared::signal::{CHANNELS, Scan};

/// Decodes scans from little-endian codes; an incomplete scan at the end is dropped.
pub fn scans_of(bytes: &[u8]) -> Vec<Scan> {
    let scan = |bytes: &[u8]| {
        let mut scan = Scan::default();
        for (code, pair) in scan.iter_mut().zip(bytes.chunks_exact(2)) {
            *code = u16::from_le_bytes([pair[0], pair[1]]);
        }
        scan
    };
    bytes.chunks_exact(2 * CHANNELS).map(scan).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_little_endian_and_scan_by_scan() {
        let mut bytes: Vec<u8> = (0..40).collect();
        bytes.push(9);
        let scans = scans_of(&bytes);
        assert_eq!(scans.len(), 2);
        assert_eq!(scans[0][0], 0x0100);
        assert_eq!(scans[1][9], 39 << 8 | 38);
    }
}
