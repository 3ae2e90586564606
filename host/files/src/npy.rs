//! NumPy's array file: the header of an array, read and written.
//!
//! The format: `\x93NUMPY`, version, length of the header (two bytes in version 1, four in later versions), a
//! Python dictionary as text, the data. The dictionary of an array of numbers has three keys with a text, a truth and a
//! list of whole numbers; nothing else is read.

use thiserror::Error;

/// The first bytes of the file.
pub const MAGIC: &[u8] = b"\x93NUMPY";

/// Longest dictionary, bytes; `numpy.load` has the same limit.
const MAX_DICTIONARY: usize = 10_000;
/// What the length of a header is a multiple of, bytes.
const ALIGNMENT: usize = 64;

/// The array that follows a header.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Header {
    /// The type of its elements in NumPy's notation, such as `<f8`; that of a record as it is written.
    pub descr: String,
    /// Whether its first index runs fastest.
    pub fortran_order: bool,
    /// Its sizes.
    pub shape: Vec<u64>,
}

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
///
/// # Errors
/// When it is no array file, or its header is not that of an array.
pub fn open(bytes: &[u8]) -> Result<(Header, &[u8]), HeaderError> {
    let rest = bytes.strip_prefix(MAGIC).ok_or(HeaderError::NoNpy)?;
    let (dictionary, data) = split(rest)?;
    // Latin-1 up to version 2 of the format, UTF-8 since.
    let text = str::from_utf8(dictionary)
        .map_or_else(|_| dictionary.iter().copied().map(char::from).collect(), str::to_owned);
    Ok((Header::parse(&text)?, data))
}

impl Header {
    /// The number of elements.
    pub fn len(&self) -> u64 {
        self.shape.iter().product()
    }

    /// Whether the array has no element.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The type of its elements as Python writes it.
    pub fn type_text(&self) -> String {
        if self.descr.starts_with('[') { self.descr.clone() } else { format!("'{}'", self.descr) }
    }

    /// The file up to the data.
    pub fn to_bytes(&self) -> Vec<u8> {
        let order = if self.fortran_order { "True" } else { "False" };
        let mut dictionary = format!(
            "{{'descr': {}, 'fortran_order': {order}, 'shape': {}, }}",
            self.type_text(),
            shape_text(&self.shape)
        );
        let before = MAGIC.len() + 4;
        let length = (before + dictionary.len() + 1).next_multiple_of(ALIGNMENT) - before;
        let padding = length - dictionary.len() - 1;
        dictionary.extend(std::iter::repeat_n(' ', padding).chain(['\n']));
        [MAGIC, &[1, 0], &(length as u16).to_le_bytes(), dictionary.as_bytes()].concat()
    }

    /// Reads a dictionary.
    fn parse(text: &str) -> Result<Self, HeaderError> {
        let inner = text.trim().strip_prefix('{');
        let mut rest = inner.ok_or_else(|| malformed("it does not begin with \"{\""))?;
        let (mut descr, mut fortran_order, mut shape) = (None, None, None);
        loop {
            rest = rest.trim_start();
            if let Some(after) = rest.strip_prefix('}') {
                if !after.is_empty() {
                    return Err(malformed("something follows its \"}\""));
                }
                break;
            }
            let (key, after) = quoted(rest).ok_or_else(|| malformed("a key is missing in it"))?;
            let value = after.trim_start().strip_prefix(':').map(str::trim_start);
            let value = value.ok_or_else(|| malformed(format!("{key:?} has no value")))?;
            let wrong = |needed: &str| malformed(format!("the value of {key:?} is not {needed}"));
            let is_new;
            (is_new, rest) = match key {
                "descr" => {
                    let (value, after) =
                        element_type(value).ok_or_else(|| wrong("the type of an array"))?;
                    (descr.replace(value.to_owned()).is_none(), after)
                }
                "fortran_order" => {
                    let (value, after) = truth(value).ok_or_else(|| wrong("True or False"))?;
                    (fortran_order.replace(value).is_none(), after)
                }
                "shape" => {
                    let (value, after) =
                        sizes(value).ok_or_else(|| wrong("the shape of an array"))?;
                    (shape.replace(value).is_none(), after)
                }
                _ => return Err(malformed(format!("it has the key {key:?}"))),
            };
            if !is_new {
                return Err(malformed(format!("it has {key:?} twice")));
            }
            rest = rest.trim_start();
            rest = match rest.strip_prefix(',') {
                Some(after) => after,
                None if rest.starts_with('}') => rest,
                None => return Err(malformed(format!("no comma follows the value of {key:?}"))),
            };
        }
        let missing = |key: &str| malformed(format!("it has no {key:?}"));
        Ok(Self {
            descr: descr.ok_or_else(|| missing("descr"))?,
            fortran_order: fortran_order.ok_or_else(|| missing("fortran_order"))?,
            shape: shape.ok_or_else(|| missing("shape"))?,
        })
    }
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

/// The text of the header, as long as the file states, but not longer than the file; and the data after it.
fn split(bytes: &[u8]) -> Result<(&[u8], &[u8]), HeaderError> {
    let short = || malformed("the file ends in it");
    let (&[major, _], rest) = bytes.split_first_chunk::<2>().ok_or_else(short)?;
    let (length, rest) = match major {
        1 => {
            let (length, rest) = rest.split_first_chunk::<2>().ok_or_else(short)?;
            (usize::from(u16::from_le_bytes(*length)), rest)
        }
        2 | 3 => {
            let (length, rest) = rest.split_first_chunk::<4>().ok_or_else(short)?;
            (usize::try_from(u32::from_le_bytes(*length)).unwrap_or(usize::MAX), rest)
        }
        _ => return Err(malformed(format!("version {major} of the format is not known"))),
    };
    if length > MAX_DICTIONARY {
        return Err(malformed(format!("it has {length} bytes, at most {MAX_DICTIONARY} are read")));
    }
    rest.split_at_checked(length).ok_or_else(short)
}

/// A text in quotes, and what follows it.
fn quoted(text: &str) -> Option<(&str, &str)> {
    let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
    let (inner, rest) = text[1..].split_once(quote)?;
    (!inner.contains('\\')).then_some((inner, rest))
}

/// The type of the elements, and what follows it.
fn element_type(text: &str) -> Option<(&str, &str)> {
    if !text.starts_with('[') {
        return quoted(text);
    }
    let mut depth = 0_usize;
    let mut quote = None;
    for (place, c) in text.char_indices() {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(c),
            (None, '[') => depth += 1,
            (None, ']') => depth -= 1,
            (None, _) => {}
        }
        if depth == 0 {
            return Some(text.split_at(place + 1));
        }
    }
    None
}

/// Python's truth, and what follows it.
fn truth(text: &str) -> Option<(bool, &str)> {
    let is_true = text.strip_prefix("True").map(|rest| (true, rest));
    is_true.or_else(|| text.strip_prefix("False").map(|rest| (false, rest)))
}

/// The sizes of an array whose elements can be counted, and what follows them.
fn sizes(text: &str) -> Option<(Vec<u64>, &str)> {
    let (inner, rest) = text.strip_prefix('(')?.split_once(')')?;
    let inner = inner.trim();
    // One size alone needs the comma, or it is a number in brackets.
    let inner = match inner.strip_suffix(',') {
        Some(inner) => inner,
        None if inner.is_empty() || inner.contains(',') => inner,
        None => return None,
    };
    let size = |text: &str| {
        // Python 2 wrote long integers with a letter.
        let text = text.trim();
        let digits = text.strip_suffix('L').unwrap_or(text);
        digits.bytes().all(|byte| byte.is_ascii_digit()).then(|| digits.parse().ok()).flatten()
    };
    let sizes: Vec<u64> = match text.strip_prefix("()") {
        Some(_) => Vec::new(),
        None => inner.split(',').map(size).collect::<Option<_>>()?,
    };
    // Zeros are left out: beside one, other sizes could still be multiplied beyond all numbers.
    sizes.iter().filter(|size| **size > 0).try_fold(1_u64, |all, size| all.checked_mul(*size))?;
    Some((sizes, rest))
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
    fn a_shape_that_cannot_be_counted_is_refused() {
        let with_shape =
            |shape: &str| format!("{{'descr': '<u2', 'fortran_order': False, 'shape': {shape}}}");
        for shape in [
            "(9223372036854775807, 10)",
            "(99999999999, 99999999999)",
            "(0, 9223372036854775807, 10)",
            "(0xFFFFFFFFFFFFFFFF, 255)",
            "(99999999+99999999, 2)",
            "(1_0, 2)",
            "(1e9, 2)",
            "(-1, 10)",
            "(+1, 10)",
            "(1,, 10)",
            "(1, 10",
            "1, 10)",
            "None",
        ] {
            let error = error(&with_shape(shape));
            assert!(error.starts_with("the NumPy header cannot be read: "), "{shape}: {error}");
        }
        let most = with_shape("(9999999999, 999999999)");
        let bytes = file(1, most.len() as u32, &most);
        assert_eq!(open(&bytes).unwrap().0.len(), 9_999_999_999 * 999_999_999);
    }

    #[test]
    fn other_dictionaries_are_refused() {
        for (dictionary, what) in [
            ("", "begin with \"{\""),
            ("[1]", "begin with \"{\""),
            ("{}", "no \"descr\""),
            ("{'descr': '<u2', 'fortran_order': False}", "no \"shape\""),
            ("{'descr'", "\"descr\" has no value"),
            ("{'descr': '<u2}", "\"descr\" is not the type of an array"),
            ("{'descr': '<\\u2'}", "\"descr\" is not the type of an array"),
            ("{,'descr': '<u2'}", "a key is missing"),
            ("{'descr': '<u2' 'shape': (1,)}", "no comma"),
            ("{'shape': (5)}", "\"shape\" is not the shape"),
            ("{'shape': (,)}", "\"shape\" is not the shape"),
            ("{'descr': '<u2', 'descr': '<f8'}", "\"descr\" twice"),
            ("{'order': 'C'}", "the key \"order\""),
            ("{'fortran_order': 1}", "\"fortran_order\" is not True or False"),
            ("{'shape': (1,)} + {}", "follows its"),
            ("{1: 2}", "a key is missing"),
        ] {
            let message = error(dictionary);
            assert!(message.contains(what), "{dictionary}: {message}");
        }
        assert_eq!(open(b"PK").unwrap_err(), HeaderError::NoNpy);
        assert!(open(&file(4, 2, "{}")).unwrap_err().to_string().contains("version 4"));
    }

    #[test]
    fn brackets_without_end_are_refused() {
        for open in ["(", "[", "{"] {
            error(&open.repeat(5000));
            error(&format!("{{'descr': {}", open.repeat(5000)));
            error(&format!("{{'shape': {}", open.repeat(5000)));
        }
    }

    /// As numpy.save writes them, of two versions of Python, and by hand.
    #[test]
    fn headers_of_other_programs_are_read() {
        let record = "[('time]', '<f8'), ('F [\u{b5}N', '<f4', (3,))]";
        let read =
            |dictionary: &str| open(&file(1, dictionary.len() as u32, dictionary)).unwrap().0;
        let header = Header { descr: "<f8".into(), fortran_order: false, shape: vec![5, 4608, 2] };
        for dictionary in [
            "{'descr': '<f8', 'fortran_order': False, 'shape': (5, 4608, 2), }     \n",
            "{'descr': '<f8', 'fortran_order': False, 'shape': (5L, 4608L, 2L)}\n",
            "{\"shape\":(5,4608,2,),\"fortran_order\":False,\"descr\":\"<f8\"}",
            " {'descr': '<f8'\n,\n'fortran_order':\tFalse, 'shape': ( 5, 4608, 2 ) } ",
        ] {
            assert_eq!(read(dictionary), header, "{dictionary}");
        }
        let dictionary =
            format!("{{'descr': {record}, 'fortran_order': True, 'shape': (20,), }}\n");
        let header = Header { descr: record.into(), fortran_order: true, shape: vec![20] };
        assert_eq!(read(&dictionary), header);
        let version_3 = file(3, dictionary.len() as u32, &dictionary);
        assert_eq!(open(&version_3).unwrap().0, header);
        let latin_1: Vec<u8> = dictionary.chars().map(|c| c as u8).collect();
        let version_1 = [MAGIC, &[1, 0, latin_1.len() as u8, 0], &latin_1].concat();
        assert_eq!(open(&version_1).unwrap().0, header);
    }

    #[test]
    fn what_is_written_is_aligned_and_reads_back() {
        for shape in [vec![], vec![20], vec![u64::MAX, 1], vec![0, 9]] {
            let header = Header { descr: "<u2".into(), fortran_order: false, shape };
            let mut bytes = header.to_bytes();
            assert_eq!((bytes.len() % ALIGNMENT, bytes.last()), (0, Some(&b'\n')));
            bytes.extend(b"data");
            assert_eq!(open(&bytes).unwrap(), (header, &b"data"[..]));
        }
    }

    #[test]
    fn a_shape_is_written_as_python_writes_it() {
        let shapes: [&[u64]; 3] = [&[], &[20], &[4, 5]];
        assert_eq!(shapes.map(shape_text), ["()", "(20,)", "(4, 5)"]);
    }
}
