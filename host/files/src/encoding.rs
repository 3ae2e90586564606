//! Encodings of text files: from bytes to text.
//!
//! A file that is not UTF-8 seldom says what it is. A *reading* is one way to turn the bytes of a label into text. The
//! most likely reading may name a channel; a unit counts only if every reading that is a unit is the same one
//! ([`unit_of`]). The byte 0xB2 is `²` in Windows-1252 and `ｲ` in Shift-JIS: of both readings of `m/s\xB2` only the
//! first is a unit.

use std::borrow::Cow;

use encoding_rs::{Encoding, SHIFT_JIS, UTF_8, UTF_16BE, UTF_16LE, WINDOWS_1252};
use thiserror::Error;

/// Bytes at the beginning of a text from which UTF-16 without a byte order mark is recognised.
const UTF16_SAMPLE: usize = 512;

/// Byte order marks of UTF-32, of either order.
const UTF32_MARKS: [&[u8]; 2] = [b"\xff\xfe\0\0", b"\0\0\xfe\xff"];

/// The character that ended a text file under DOS.
const CONTROL_Z: u8 = 0x1a;

/// The text of a file.
#[derive(Clone, Debug)]
pub struct Text<'b> {
    /// The text, without a byte order mark.
    pub text: Cow<'b, str>,
    encoding: &'static Encoding,
    marked: bool,
}

/// Why bytes are not accepted as text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum NotText {
    /// Bytes that no text has.
    #[error("byte {at} is 0x{byte:02X}, which no text has: the file is binary")]
    Binary {
        /// Place of the first of them, from 0.
        at: usize,
        /// Its value.
        byte: u8,
    },
    /// The byte order mark of an encoding that is not read.
    #[error("the file is UTF-32; export it as UTF-8")]
    Utf32,
    /// A byte order mark with other bytes behind it.
    #[error(
        "the file has the byte order mark of {encoding}, but is not {encoding}; export it again"
    )]
    Malformed {
        /// Name of the encoding.
        encoding: &'static str,
    },
}

impl<'b> Text<'b> {
    /// The text of a file: UTF-8, UTF-16, or else Shift-JIS or Windows-1252, whichever is more likely. A Control-Z at
    /// the end is left out.
    ///
    /// # Errors
    /// When the bytes are no text.
    pub fn decode(bytes: &'b [u8]) -> Result<Self, NotText> {
        // The mark of UTF-32 begins like that of UTF-16.
        if UTF32_MARKS.iter().any(|mark| bytes.starts_with(mark)) {
            return Err(NotText::Utf32);
        }
        if let Some((encoding, mark)) = Encoding::for_bom(bytes) {
            let marked = bytes.get(mark..).unwrap_or_default();
            return Self::strict(marked, encoding, true)
                .ok_or(NotText::Malformed { encoding: encoding.name() });
        }
        if let Some(encoding) = utf16_without_mark(bytes)
            && let Some(text) = Self::strict(bytes, encoding, false)
        {
            return Ok(text);
        }
        let bytes = without_end_mark(bytes);
        if let Some((at, &byte)) = (0..).zip(bytes).find(|(_, byte)| is_binary(**byte)) {
            return Err(NotText::Binary { at, byte });
        }
        let encoding = likely_encoding(bytes);
        let (text, _) = encoding.decode_without_bom_handling(bytes);
        Ok(Self { text, encoding, marked: false })
    }

    /// The text of bytes that are all of one encoding; none when they are not.
    fn strict(bytes: &'b [u8], encoding: &'static Encoding, marked: bool) -> Option<Self> {
        let bytes = if encoding == UTF_8 { without_end_mark(bytes) } else { bytes };
        let mut text = encoding.decode_without_bom_handling_and_without_replacement(bytes)?;
        if text.ends_with(char::from(CONTROL_Z)) {
            text.to_mut().pop();
        }
        let binary = text.bytes().any(is_binary);
        (!binary).then_some(Self { text, encoding, marked })
    }

    /// The name of the encoding, as a person knows it.
    pub fn encoding(&self) -> &'static str {
        match self.encoding.name() {
            "windows-1252" if self.text.is_ascii() => "ASCII",
            "windows-1252" => "Windows-1252",
            "Shift_JIS" => "Shift-JIS",
            "UTF-8" if self.text.is_ascii() && !self.marked => "ASCII",
            name => name,
        }
    }

    /// The bytes of a part of this text, for [`readings`]: those of the file where its encoding is a guess.
    pub fn bytes_of<'t>(&self, part: &'t str) -> Cow<'t, [u8]> {
        if self.encoding == SHIFT_JIS || self.encoding == WINDOWS_1252 {
            self.encoding.encode(part).0
        } else {
            part.as_bytes().into()
        }
    }
}

/// Every way to read the bytes of a label, the most likely one first.
pub fn readings(label: &[u8]) -> impl Iterator<Item = Cow<'_, str>> {
    let [first, second] = match likely_encoding(label) {
        encoding if encoding == SHIFT_JIS => [SHIFT_JIS, WINDOWS_1252],
        _ => [WINDOWS_1252, SHIFT_JIS],
    };
    let encodings = if label.is_ascii() { &[UTF_8][..] } else { &[UTF_8, first, second] };
    let encodings = encodings.to_vec();
    encodings.into_iter().filter_map(move |encoding| {
        encoding.decode_without_bom_handling_and_without_replacement(label)
    })
}

/// The most likely text of the bytes of a label.
pub fn label(bytes: &[u8]) -> Cow<'_, str> {
    // Windows-1252 has a character for every byte.
    readings(bytes).next().unwrap_or_default()
}

/// The reading of a label that is a unit, and what the unit means: `meaning` gives what a text means as a unit. There
/// is none when no reading is a unit, or when two readings are units that differ.
pub fn unit_of<'b, T: PartialEq>(
    bytes: &'b [u8],
    meaning: impl Fn(&str) -> Option<T>,
) -> Option<(Cow<'b, str>, T)> {
    let mut units = readings(bytes).filter_map(|text| {
        let unit = meaning(&text)?;
        Some((text, unit))
    });
    let first = units.next()?;
    units.all(|(_, unit)| unit == first.1).then_some(first)
}

/// UTF-8 if the bytes are that; else Shift-JIS if they are that and have characters of two bytes that begin below 0xA0,
/// where Windows-1252 has hardly a letter; else Windows-1252.
fn likely_encoding(bytes: &[u8]) -> &'static Encoding {
    if std::str::from_utf8(bytes).is_ok() {
        return UTF_8;
    }
    let is_japanese = |text: Cow<'_, str>| {
        let is_kana_or_kanji =
            |c: char| matches!(c, '\u{3040}'..='\u{30ff}' | '\u{4e00}'..='\u{9fff}');
        text.chars().any(is_kana_or_kanji)
            && !text.chars().any(|c| ('\u{e000}'..='\u{f8ff}').contains(&c))
    };
    let has_low_lead = bytes.iter().any(|byte| matches!(byte, 0x81..=0x84 | 0x88..=0x9f));
    let text = SHIFT_JIS.decode_without_bom_handling_and_without_replacement(bytes);
    if has_low_lead && text.is_some_and(is_japanese) { SHIFT_JIS } else { WINDOWS_1252 }
}

/// UTF-16 by the zeros that it has in every other byte of a text of mostly ASCII.
fn utf16_without_mark(bytes: &[u8]) -> Option<&'static Encoding> {
    let sample = bytes.get(..UTF16_SAMPLE).unwrap_or(bytes);
    let zeros = |parity: usize| sample.iter().skip(parity).step_by(2).filter(|&&b| b == 0).count();
    let most = sample.len() / 4;
    match [zeros(0), zeros(1)] {
        [0, low] if low > most => Some(UTF_16LE),
        [high, 0] if high > most => Some(UTF_16BE),
        _ => None,
    }
}

fn without_end_mark(bytes: &[u8]) -> &[u8] {
    let end = bytes.trim_ascii_end();
    if end.last() == Some(&CONTROL_Z) {
        end.strip_suffix(&[CONTROL_Z]).unwrap_or(end)
    } else {
        bytes
    }
}

/// True for a control character that is no blank, line end or page break.
fn is_binary(byte: u8) -> bool {
    byte.is_ascii_control() && !matches!(byte, b'\t' | b'\n' | b'\r' | 0x0b | 0x0c | 0x7f)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utf16(text: &str, to_bytes: fn(u16) -> [u8; 2]) -> Vec<u8> {
        text.encode_utf16().flat_map(to_bytes).collect()
    }

    fn decode(bytes: &[u8]) -> (String, &'static str) {
        let text = Text::decode(bytes).unwrap();
        (text.text.to_string(), text.encoding())
    }

    #[test]
    fn text_is_decoded_in_the_encodings_of_spreadsheets_and_loggers() {
        let text = "Kraft [N];a [m/s²]\n1;2\n";
        let marked = |mark: &[u8], bytes: Vec<u8>| [mark, &bytes].concat();
        let (little, big) = (utf16(text, u16::to_le_bytes), utf16(text, u16::to_be_bytes));
        for (bytes, encoding) in [
            (text.as_bytes().to_vec(), "UTF-8"),
            (marked(b"\xef\xbb\xbf", text.as_bytes().to_vec()), "UTF-8"),
            (little.clone(), "UTF-16LE"),
            (big.clone(), "UTF-16BE"),
            (marked(b"\xff\xfe", little), "UTF-16LE"),
            (marked(b"\xfe\xff", big), "UTF-16BE"),
            (b"Kraft [N];a [m/s\xb2]\n1;2\n".to_vec(), "Windows-1252"),
        ] {
            assert_eq!(decode(&bytes), (text.to_owned(), encoding));
        }
        assert_eq!(decode(b"Force,a\n1,2\n\x1a"), ("Force,a\n1,2\n".to_owned(), "ASCII"));
        let japanese = "時間[s],力[N],加速度[m/s2]\n";
        assert_eq!(decode(&SHIFT_JIS.encode(japanese).0), (japanese.to_owned(), "Shift-JIS"));
        for western in
            ["Größe;Beschleunigung\n", "Température;Accélération\n", "“Force”\n", "€; µm; °C\n"]
        {
            assert_eq!(
                decode(&WINDOWS_1252.encode(western).0),
                (western.to_owned(), "Windows-1252")
            );
        }
    }

    #[test]
    fn bytes_that_are_no_text_are_named() {
        let fault = |bytes: &[u8]| Text::decode(bytes).unwrap_err();
        assert_eq!(fault(b"\x89PNG\r\n\x1a\n\0\0"), NotText::Binary { at: 6, byte: 0x1a });
        assert_eq!(fault(b"Force,a\n1\0,2\n"), NotText::Binary { at: 9, byte: 0 });
        assert_eq!(fault(b"\xff\xfe1"), NotText::Malformed { encoding: "UTF-16LE" });
        assert_eq!(fault(b"\xef\xbb\xbfm/s\xb2"), NotText::Malformed { encoding: "UTF-8" });
        assert_eq!(fault(b"\xff\xfe\0\0F\0\0\0"), NotText::Utf32);
    }

    #[test]
    fn a_guessed_encoding_never_decides_a_unit() {
        let size = |text: &str| match text {
            "m/s²" => Some(1),
            "ｲ" => Some(2),
            "²" | "µm" | "μm" => Some(3),
            _ => None,
        };
        let unit =
            |bytes: &[u8]| unit_of(bytes, size).map(|(text, size)| (text.into_owned(), size));
        for bytes in ["m/s²".as_bytes(), b"m/s\xb2"] {
            assert_eq!(unit(bytes), Some(("m/s²".to_owned(), 1)));
        }
        // A micrometre of Windows-1252 and one of Shift-JIS.
        assert_eq!(unit(b"\xb5m"), Some(("µm".to_owned(), 3)));
        assert_eq!(unit(b"\x83\xcam"), Some(("μm".to_owned(), 3)));
        // Two readings that are different units.
        assert_eq!(unit(b"\xb2"), None);
        assert_eq!(unit(b"\xff\xfe"), None);
        assert_eq!(label(b"m/s\xb2"), "m/s²");
        assert_eq!(label(b""), "");
    }

    #[test]
    fn the_bytes_of_a_label_come_back_from_the_text_of_its_file() {
        // The µ of Windows-1252 beside Japanese names.
        let mut bytes = SHIFT_JIS.encode("時間,力,変位\n").0.into_owned();
        bytes.extend(b"s,N,\xb5m\n");
        let text = Text::decode(&bytes).unwrap();
        assert_eq!(text.encoding(), "Shift-JIS");
        let last = text.text.lines().last().and_then(|line| line.split(',').next_back()).unwrap();
        assert_eq!(last, "ｵm");
        let known = |text: &str| (text == "µm").then_some(());
        assert_eq!(unit_of(&text.bytes_of(last), known), Some(("µm".into(), ())));
    }
}
