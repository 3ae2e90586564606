//! The checksum of an archive: CRC-32 of its bytes, without white space between its values and without the checksum
//! itself, which is its last key. Whoever edits an archive on purpose deletes it.

use massline_protocol::crc32_of_chunks;

/// The key, as it follows the other ones.
const KEY: &str = "\"checksum\"";
/// `<` in the JSON within a page.
const LESS: &[u8] = b"\\u003c";

/// An archive with its checksum. `bytes` are a JSON object with at least one key.
pub(super) fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let checksum = checksum(&bytes);
    bytes.pop();
    bytes.extend(format!(",{KEY}:{checksum}}}").bytes());
    bytes
}

/// Whether the bytes are those that were written, where they have a checksum.
pub(super) fn is_intact(bytes: &[u8], stated: Option<u32>) -> bool {
    let Some(stated) = stated else { return true };
    let Some(start) = bytes.windows(KEY.len()).rposition(|bytes| bytes == KEY.as_bytes()) else {
        return false;
    };
    let after = bytes[start + KEY.len()..].iter().filter(|byte| !byte.is_ascii_whitespace());
    // The checksum is the last key.
    if !after.copied().eq(format!(":{stated}}}").bytes()) {
        return false;
    }
    let before = bytes[..start].trim_ascii_end();
    let Some(before) = before.strip_suffix(b",") else { return false };
    checksum(&[before, b"}"].concat()) == stated
}

fn checksum(bytes: &[u8]) -> u32 {
    let mut digest = crc32_of_chunks();
    let (mut is_text, mut start, mut place) = (false, 0, 0);
    while let Some(&byte) = bytes.get(place) {
        // How many bytes stand here for which others; otherwise how many are taken as they are.
        let (replaced, taken) = match byte {
            b'\\' if bytes[place..].starts_with(LESS) => (Some((LESS.len(), "<")), 0),
            b'\\' => (None, 2),
            b'"' => {
                is_text = !is_text;
                (None, 1)
            }
            byte if !is_text && byte.is_ascii_whitespace() => (Some((1, "")), 0),
            _ => (None, 1),
        };
        match replaced {
            Some((length, text)) => {
                digest.update(&bytes[start..place]);
                digest.update(text.as_bytes());
                place += length;
                start = place;
            }
            None => place += taken,
        }
    }
    digest.update(&bytes[start..]);
    digest.finalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BYTES: &[u8] = br#"{"a":[1,2],"b":"x \" < y"}"#;

    fn stated(bytes: &[u8]) -> Option<u32> {
        serde_json::from_slice::<serde_json::Value>(bytes).unwrap()["checksum"]
            .as_u64()
            .map(|sum| sum as u32)
    }

    #[test]
    fn what_was_written_is_intact_also_with_other_line_breaks() {
        let sealed = sealed(BYTES.to_vec());
        let text = String::from_utf8(sealed.clone()).unwrap();
        assert!(is_intact(&sealed, stated(&sealed)));
        let spaced = text.replace(":[", ": [\n ").replace(",\"", ",\r\n\t\"") + "\n";
        assert!(is_intact(spaced.as_bytes(), stated(&sealed)), "{spaced}");
        assert!(
            is_intact(text.replace('<', "\\u003c").as_bytes(), stated(&sealed)),
            "within a page"
        );
        assert!(is_intact(BYTES, None), "edited on purpose");
    }

    #[test]
    fn every_changed_byte_is_noticed() {
        let sealed = sealed(BYTES.to_vec());
        let sum = stated(&sealed);
        for place in 0..BYTES.len() - 1 {
            let mut changed = sealed.clone();
            changed[place] ^= 1;
            assert!(!is_intact(&changed, sum), "byte {place}");
        }
        let text = String::from_utf8(sealed).unwrap();
        assert!(
            !is_intact(text.replace("x \\\"", "x\\\"").as_bytes(), sum),
            "a blank within a text"
        );
        assert!(!is_intact(text.replace('}', ",\"c\":1}").as_bytes(), sum), "another key");
    }
}
