//! The fixed columns of a record.
//!
//! The format counts bytes, and so do most writers; some pad by characters, which differ where a name is not ASCII.
//! Both layouts are tried, and a unit counts only if no other layout and no other encoding of the record has another
//! unit.

use std::borrow::Cow;

use crate::encoding::{label, unit_of};
use crate::units::{is_unstated, label_meaning};

/// A record in one layout.
pub(super) struct Columns<'a> {
    record: &'a [u8],
    /// The byte at which each column begins.
    starts: Vec<usize>,
}

impl<'a> Columns<'a> {
    /// The columns of a record by bytes.
    pub(super) fn by_bytes(record: &'a [u8]) -> Self {
        Self { record, starts: (0..record.len()).collect() }
    }

    /// The columns of a record by characters, where they differ from those by bytes.
    pub(super) fn by_characters(record: &'a [u8]) -> Option<Self> {
        let text = std::str::from_utf8(record).ok().filter(|text| !text.is_ascii())?;
        Some(Self { record, starts: text.char_indices().map(|(at, _)| at).collect() })
    }

    /// Columns `from..from + width`, fewer where the record is shorter.
    pub(super) fn bytes(&self, from: usize, width: usize) -> &'a [u8] {
        let start = |column: usize| self.starts.get(column).copied().unwrap_or(self.record.len());
        self.record.get(start(from)..start(from.saturating_add(width))).unwrap_or_default()
    }

    /// The text of these columns without blanks around it.
    pub(super) fn text(&self, from: usize, width: usize) -> Cow<'a, str> {
        label(self.bytes(from, width).trim_ascii())
    }

    /// The integer in these columns.
    pub(super) fn integer(&self, from: usize, width: usize) -> Option<i64> {
        self.text(from, width).parse().ok()
    }

    /// Whether these columns, which separate fields, are blank.
    pub(super) fn are_blank<const N: usize>(&self, columns: [usize; N]) -> bool {
        columns.iter().all(|&column| self.bytes(column, 1).trim_ascii().is_empty())
    }
}

/// Columns of the name of an axis and of its unit in records 8 to 11, `I10,3I5,2(1X,20A1)`.
const NAME: usize = 26;
const UNIT: usize = 47;
const WIDTH: usize = 20;

/// The label of the unit in one of the records 8 to 11; empty where none is stated. Where the columns leave in doubt
/// what it is, the text is one that is no unit.
pub(super) fn unit_label(record: &[u8]) -> String {
    let layouts = [Some(Columns::by_bytes(record)), Columns::by_characters(record)];
    let fields: Vec<&[u8]> = layouts.iter().flatten().filter_map(unit_field).collect();
    let mut known = Vec::new();
    for (text, meaning) in fields.iter().filter_map(|field| unit_of(field, label_meaning)) {
        if known.iter().all(|(_, other)| *other != meaning) {
            known.push((text, meaning));
        }
    }
    match &known[..] {
        [(text, _)] => text.clone().into_owned(),
        [] => {
            let in_doubt = || label(record.get(NAME..).unwrap_or_default().trim_ascii());
            let text = fields.first().map_or_else(in_doubt, |field| label(field));
            if is_unstated(&text) {
                unit_in_name(record).unwrap_or_default()
            } else {
                text.into_owned()
            }
        }
        several => {
            let texts: Vec<&str> = several.iter().map(|(text, _)| text.as_ref()).collect();
            texts.join(" or ")
        }
    }
}

/// The unit in the name of an axis whose field of the unit states none: in brackets, or the last word of a line that
/// ends before that field.
fn unit_in_name(record: &[u8]) -> Option<String> {
    let name = label(record.get(NAME..)?.get(..WIDTH.min(record.len() - NAME))?.trim_ascii());
    let inner = ["()", "[]"].iter().find_map(|pair| {
        let (open, close) = pair.split_at(1);
        Some(name.strip_suffix(close)?.rsplit_once(open)?.1.to_owned())
    });
    let is_short = record.trim_ascii_end().len() < UNIT;
    let last = || name.rsplit_once(' ').filter(|_| is_short).map(|(_, last)| last.to_owned());
    inner.or_else(last).filter(|unit| label_meaning(unit).is_some())
}

/// The field of the unit; none where the record cannot have these columns.
fn unit_field<'a>(columns: &Columns<'a>) -> Option<&'a [u8]> {
    let rest = columns.bytes(UNIT, usize::MAX).trim_ascii();
    let field = columns.bytes(UNIT, WIDTH).trim_ascii();
    let name = columns.bytes(NAME, WIDTH);
    // A unit after blanks in the field of the name has been shifted to the left, whole or in part.
    let is_blank = |b: &u8| *b == b' ';
    let last = name.trim_ascii().rsplit(is_blank).next().unwrap_or_default();
    let before = name.trim_ascii().strip_suffix(last).unwrap_or_default();
    let touches = name.len() >= WIDTH && !name.last().is_none_or(is_blank);
    let is_shifted = (field.is_empty() || touches)
        && before.ends_with(b"  ")
        && unit_of(last, label_meaning).is_some();
    (columns.are_blank([UNIT - 1]) && !is_shifted).then_some(if rest.len() > field.len() {
        rest
    } else {
        field
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(name: &str, unit: &str) -> Vec<u8> {
        format!("        12    0    0    0 {name} {unit}").into_bytes()
    }

    /// A field of 20 bytes, as `printf("%-20s")` writes it.
    fn by_bytes(text: &str) -> String {
        format!("{text}{}", " ".repeat(20_usize.saturating_sub(text.len())))
    }

    #[test]
    fn units_are_read_from_columns_by_bytes_and_by_characters() {
        let names =
            ["Force", "Kraft Stößel", "加速度", "Accélération mesurée", "Сила удара", "", "力"];
        for unit in ["kN", "mm/s^2", "g", "m/s²", "µm/N", "G's", "NONE", "m s-2", "(m/s²)/N"] {
            let expected = if unit == "NONE" { "" } else { unit };
            for name in names {
                // A name of more bytes than its field has is cut by no writer that counts characters.
                if name.len() <= 20 {
                    let line = record(&by_bytes(name), &by_bytes(unit));
                    assert_eq!(unit_label(&line), expected, "{name} by bytes");
                }
                let line = record(&format!("{name:20}"), &format!("{unit:20}"));
                assert_eq!(unit_label(&line), expected, "{name} by characters");
            }
        }
    }

    #[test]
    fn a_unit_in_the_name_counts_where_its_own_field_states_none() {
        let full = |name: &str, unit: &str| unit_label(&record(&by_bytes(name), &by_bytes(unit)));
        assert_eq!(full("Accel. (g)", "NONE"), "g");
        assert_eq!(full("Accel. [mm/s^2]", ""), "mm/s^2");
        assert_eq!(full("Accel. (g)", "m/s^2"), "m/s^2");
        assert_eq!(full("Force (top)", "NONE"), "");
        assert_eq!(full("Position g", "NONE"), "");
        assert_eq!(unit_label(b"        12    0    0    0 Acceleration mm/s^2"), "mm/s^2");
        assert_eq!(unit_label(b"        12    0    0    0 Acceleration"), "");
    }

    #[test]
    fn units_in_other_encodings_are_read() {
        let windows = |unit: &[u8]| [record(&by_bytes("Beschl."), "").as_slice(), unit].concat();
        assert_eq!(unit_label(&windows(b"m/s\xb2")), "m/s²");
        assert_eq!(unit_label(&windows(b"(1/N)*(m/s\xb2)")), "(1/N)*(m/s²)");
        assert_eq!(unit_label(&windows(b"\xb5m/N   ")), "µm/N");
        // Half-width katakana of Shift-JIS, and a name in it.
        let name = b"        12    0    0    0 \x89\xc1\x91\xac\x93x               ";
        assert_eq!(unit_label(&[&name[..], b"mm/s2"].concat()), "mm/s2");
        assert_eq!(unit_label(&windows("ｍ／ｓ２".as_bytes())), "ｍ／ｓ２");
    }

    #[test]
    fn a_unit_outside_its_columns_is_not_cut() {
        // One letter too many in the name: by columns this would be N.
        let long = unit_label(&record("Force of the hammer 1", "kN"));
        assert!(label_meaning(&long).is_none(), "{long}");
        let short = unit_label(&record("Acceleration      ", "g"));
        assert!(label_meaning(&short).is_none(), "{short}");
        let wide = "m/s^2/N (by the calibration of May)";
        assert_eq!(unit_label(&record(&by_bytes("Acceleration"), wide)), wide);
        assert_eq!(unit_label(b"        12"), "");
        assert_eq!(unit_label(&record(&by_bytes("Acceleration"), "")), "");
    }
}
