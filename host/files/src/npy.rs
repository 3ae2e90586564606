//! NumPy's array file: checks of the header that npyz leaves to its caller.
//!
//! The format: `\x93NUMPY`, version, length of the header (two bytes in version 1, four in later versions), a
//! Python dictionary as text, the data. npyz reserves as much memory as the length states, recurses into
//! every bracket, and multiplies the numbers of the shape without a check for overflow. The header is
//! therefore checked here before npyz reads it.

use npyz::NpyHeader;
use thiserror::Error;

/// The first bytes of the file.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// Longest dictionary, bytes; `numpy.load` has the same limit.
const MAX_DICTIONARY: usize = 10_000;
/// Deepest nesting of brackets: the shape of a field of a record has four levels.
const MAX_DEPTH: usize = 8;
/// Largest number of digits of all numbers together: a product of numbers with 19 digits in total is less
/// than 2⁶⁴.
const MAX_DIGITS: usize = 19;

/// Why a header is rejected.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum HeaderError {
    /// The file does not begin as one.
    #[error("this is not a NumPy array file (.npy); one begins with the bytes \\x93NUMPY")]
    NoNpy,
    /// The header is cut off or has another form.
    #[error("the NumPy header cannot be read: {0}; save the array again with numpy.save")]
    Malformed(String),
}

/// Splits a file into the header and the data after it.
pub fn open(bytes: &[u8]) -> Result<(NpyHeader, &[u8]), HeaderError> {
    if !bytes.starts_with(MAGIC) {
        return Err(HeaderError::NoNpy);
    }
    check_dictionary(&String::from_utf8_lossy(dictionary(bytes)?))?;
    let mut data = bytes;
    let header = NpyHeader::from_reader(&mut data).map_err(|e| malformed(e.to_string()))?;
    Ok((header, data))
}

/// A shape in Python's notation.
pub fn shape_text(shape: &[u64]) -> String {
    let sizes: Vec<String> = shape.iter().map(u64::to_string).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    format!("({}{comma})", sizes.join(", "))
}

fn malformed(reason: impl Into<String>) -> HeaderError {
    HeaderError::Malformed(reason.into())
}

/// The text of the header: as long as the file states, but not longer than the file.
fn dictionary(bytes: &[u8]) -> Result<&[u8], HeaderError> {
    let short = || malformed("the file ends in it");
    let rest = bytes.get(MAGIC.len()..).unwrap_or_default();
    let (&[major, _], rest) = rest.split_first_chunk::<2>().ok_or_else(short)?;
    let (length, rest) = if major == 1 {
        let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(short)?;
        (usize::from(u16::from_le_bytes(*length)), rest)
    } else {
        let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(short)?;
        (usize::try_from(u32::from_le_bytes(*length)).unwrap_or(usize::MAX), rest)
    };
    if length > MAX_DICTIONARY {
        return Err(malformed(format!("it has {length} bytes, at most {MAX_DICTIONARY} are read")));
    }
    rest.get(..length).ok_or_else(short)
}

/// Checks that a dictionary is as simple as those of arrays of numbers.
fn check_dictionary(text: &str) -> Result<(), HeaderError> {
    let (mut depth, mut digits) = (0_usize, 0);
    let mut quote = None;
    let mut previous = ' ';
    for c in text.chars() {
        match (quote, c) {
            (_, '\\') => return Err(malformed("it has a backslash")),
            // Python would read an empty string followed by a quote as the start of a triple-quoted string.
            (Some(open), c) if c == open && previous == open => {
                return Err(malformed("it has an empty string"));
            }
            (Some(open), c) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(c),
            (None, '(' | '[' | '{') => depth += 1,
            (None, ')' | ']' | '}') => depth = depth.saturating_sub(1),
            (None, '0'..='9') => digits += 1,
            // The letters of True and False only, so no letters of numbers in other notations.
            (None, ' ' | '\n' | ',' | ':' | 'T' | 'r' | 'u' | 'e' | 'F' | 'a' | 'l' | 's') => {}
            (None, c) => return Err(malformed(format!("it has {c:?} outside of strings"))),
        }
        previous = c;
        if depth > MAX_DEPTH {
            return Err(malformed(format!("it has more than {MAX_DEPTH} brackets in each other")));
        }
        if digits > MAX_DIGITS {
            return Err(malformed(format!("its numbers have more than {MAX_DIGITS} digits")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u8, length: u32, dictionary: &str) -> Vec<u8> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend([version, 0]);
        match version {
            1 => bytes.extend((length as u16).to_le_bytes()),
            _ => bytes.extend(length.to_le_bytes()),
        }
        bytes.extend(dictionary.as_bytes());
        bytes
    }

    fn error(dictionary: &str) -> String {
        open(&file(1, dictionary.len() as u32, dictionary)).err().unwrap().to_string()
    }

    #[test]
    fn a_header_that_is_longer_than_its_file_reserves_no_memory() {
        for length in [u32::MAX, 10_001, 10_000] {
            assert!(open(&file(2, length, "{'descr': '<u2'}")).is_err());
        }
    }

    #[test]
    fn a_shape_whose_product_overflows_is_refused() {
        let with_shape =
            |shape: &str| format!("{{'descr': '<u2', 'fortran_order': False, 'shape': {shape}}}");
        for shape in [
            "(9223372036854775807, 10)",
            "(99999999999, 99999999999)",
            "(0xFFFFFFFFFFFFFFFF, 255)",
            "(99999999+99999999, 2)",
            "(1_0, 2)",
            "(1e9, 2)",
            "(-1, 10)",
        ] {
            let error = error(&with_shape(shape));
            assert!(error.starts_with("the NumPy header cannot be read: "), "{shape}: {error}");
        }
        let most = with_shape("(9999999999, 999999999)");
        let bytes = file(1, most.len() as u32, &most);
        assert_eq!(open(&bytes).unwrap().0.len(), 9_999_999_999 * 999_999_999);
    }

    #[test]
    fn brackets_without_end_are_refused() {
        for open in ["(", "[", "{"] {
            assert!(error(&open.repeat(5000)).contains("brackets"));
            assert!(error(&format!("'''a'b''', {}", open.repeat(5000))).contains("empty string"));
            assert!(error(&format!("'a\\', {}", open.repeat(5000))).contains("backslash"));
        }
    }

    #[test]
    fn a_shape_is_written_as_python_writes_it() {
        let shapes: [&[u64]; 3] = [&[], &[20], &[4, 5]];
        assert_eq!(shapes.map(shape_text), ["()", "(20,)", "(4, 5)"]);
    }
}
