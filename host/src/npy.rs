//! The header of NumPy's array file.
//!
//! The format: `\x93NUMPY`, version, length of the header (two bytes in version 1, four later), a
//! Python dictionary as text, the data.

use thiserror::Error;

/// The first bytes of the file.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";

/// Why bytes are no array file.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub(crate) enum HeaderError {
    #[error("this is no NumPy array file (.npy); one begins with the bytes \\x93NUMPY")]
    NoNpy,
    #[error("NumPy format version {0} is not known; save it with numpy.save")]
    Version(u8),
    #[error("the NumPy header cannot be read: {0}; save the array again with numpy.save")]
    Malformed(&'static str),
}

/// The dictionary of a header; each value as it is written.
pub(crate) struct Header {
    /// Type of the numbers, without quotes.
    pub descr: String,
    /// True when the first index runs fastest.
    pub fortran_order: bool,
    /// The shape as written.
    pub shape: String,
}

impl Header {
    /// The header and the data behind it.
    pub fn read(bytes: &[u8]) -> Result<(Self, &[u8]), HeaderError> {
        let rest = bytes.strip_prefix(MAGIC).ok_or(HeaderError::NoNpy)?;
        let short = HeaderError::Malformed("the file ends in it");
        let (version, rest) = rest.split_at_checked(2).ok_or(short.clone())?;
        let (length, rest) = match version {
            [1, _] => {
                let (length, rest) = rest.split_first_chunk::<2>().ok_or(short.clone())?;
                (usize::from(u16::from_le_bytes(*length)), rest)
            }
            [2 | 3, _] => {
                let (length, rest) = rest.split_first_chunk::<4>().ok_or(short.clone())?;
                let length = u32::from_le_bytes(*length);
                (usize::try_from(length).unwrap_or(usize::MAX), rest)
            }
            [other, ..] => return Err(HeaderError::Version(*other)),
            [] => return Err(short),
        };
        let (text, data) = rest.split_at_checked(length).ok_or(short)?;
        Ok((Self::parse(&String::from_utf8_lossy(text))?, data))
    }

    fn parse(text: &str) -> Result<Self, HeaderError> {
        let descr = value(text, "descr").ok_or(HeaderError::Malformed("'descr' is missing"))?;
        let order = value(text, "fortran_order")
            .ok_or(HeaderError::Malformed("'fortran_order' is missing"))?;
        let fortran_order = match order {
            "False" => false,
            "True" => true,
            _ => {
                return Err(HeaderError::Malformed("'fortran_order' is neither True nor False"));
            }
        };
        let shape = value(text, "shape").ok_or(HeaderError::Malformed("'shape' is missing"))?;
        let descr = descr.trim_matches(['\'', '"']).to_owned();
        Ok(Self { descr, fortran_order, shape: shape.to_owned() })
    }

    /// The numbers of the shape; `None` when it is none.
    pub fn sizes(&self) -> Option<Vec<u64>> {
        let inner = self.shape.strip_prefix('(')?.strip_suffix(')')?;
        inner
            .split(',')
            .map(str::trim)
            .filter(|size| !size.is_empty())
            .map(|size| size.parse().ok())
            .collect()
    }
}

/// The value of a key of the dictionary, as it is written.
fn value<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    let quoted = [format!("'{key}'"), format!("\"{key}\"")];
    let at = quoted.iter().find_map(|k| text.find(k.as_str()).map(|at| at + k.len()));
    let rest = text.get(at?..)?.trim_start().strip_prefix(':')?.trim_start();
    // To the comma or brace outside of brackets and quotes.
    let mut depth = 0_u32;
    let mut quote = None;
    for (at, c) in rest.char_indices() {
        match (quote, c) {
            (Some(open), c) if c == open => quote = None,
            (Some(_), _) => {}
            (None, '\'' | '"') => quote = Some(c),
            (None, '(' | '[') => depth += 1,
            (None, ')' | ']') => depth = depth.saturating_sub(1),
            (None, ',' | '}') if depth == 0 => return Some(rest.get(..at)?.trim()),
            _ => {}
        }
    }
    None
}
