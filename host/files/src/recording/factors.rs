//! Factors of columns that a text states beside their units: in a row under the names, or in a name such as
//! `Force (x0.001) [N]`. Whether the numbers are multiplied already is not stated, so that none of them is in force.

use super::Channel;
use super::dialect::Row;
use super::number::Decimal;

/// Words that begin a row of factors.
const WORDS: [&str; 20] = [
    "factor",
    "factors",
    "faktor",
    "faktoren",
    "facteur",
    "facteurs",
    "fattore",
    "scale",
    "scales",
    "scaling",
    "scale factor",
    "scale factors",
    "scaling factor",
    "skalierung",
    "skalierungsfaktor",
    "multiplier",
    "gain",
    "gains",
    "verstärkung",
    "倍率",
];

/// Marks the channels for which a row of the header states a factor other than 1; true for a row of factors.
pub(super) fn take_row(row: &Row, channels: &mut [Option<String>]) -> bool {
    let numeric = |field: &String| number(field);
    let is_label = |field: &&String| number(field).is_none() && !field.is_empty();
    let label: Vec<&str> = row.fields.iter().take_while(is_label).map(String::as_str).collect();
    let label = label.join(" ");
    let label = label.trim_start_matches(['#', '%']).trim().trim_end_matches(':').trim();
    let rest = row.fields.iter().skip_while(is_label);
    let factors: Vec<Option<f64>> = rest.map(numeric).collect();
    let is_row = WORDS.contains(&label.to_lowercase().as_str())
        && factors.iter().flatten().count() > 0
        && (factors.iter().flatten().count() > 1 || row.fields.len() == channels.len());
    if !is_row {
        return false;
    }
    // The label stands in the place of the first column, or before all of them.
    let first = channels.len().saturating_sub(factors.len());
    for (channel, factor) in channels.iter_mut().skip(first).zip(factors) {
        if let Some(factor) = factor.filter(|factor| *factor != 1.0) {
            *channel = Some(format!(
                "the row \"{label}\" in line {} states the factor {factor}",
                row.line
            ));
        }
    }
    true
}

/// The factor that is stated for a channel, as part of a sentence.
pub(super) fn of(channel: &Channel) -> Option<String> {
    let in_name =
        || in_name(&channel.name).map(|factor| format!("its name states the factor {factor}"));
    channel.multiplier.clone().or_else(in_name)
}

/// The factor in a name: a decimal number, a power of ten or a number with an exponent behind a sign of multiplication
/// or division. `Acc x 2` is a direction and a number.
fn in_name(name: &str) -> Option<&str> {
    let signs = name.char_indices().filter(|(_, c)| "xX×*÷/".contains(*c));
    signs.into_iter().find_map(|(at, sign)| {
        let before = name.get(..at)?.chars().next_back();
        let after = name.get(at + sign.len_utf8()..)?;
        let begins = !before.is_some_and(char::is_alphanumeric) || "×*÷/".contains(sign);
        let after = after.trim_start();
        let is_part = |c: char| c.is_ascii_digit() || ".,^eE+-−⁻⁰¹²³⁴⁵⁶⁷⁸⁹".contains(c);
        let end = after.find(|c| !is_part(c)).unwrap_or(after.len());
        let text = after.get(..end)?.trim_end_matches(['.', ',', '-']);
        let ends = !after.get(end..)?.starts_with(char::is_alphanumeric);
        let is_letter = sign.eq_ignore_ascii_case(&'x');
        let in_brackets = before.is_some_and(|c| "([".contains(c));
        (begins && ends && is_factor(text, is_letter && !in_brackets)).then_some(text)
    })
}

/// True for the text of a factor; after a letter, which may be a direction, ten is a number.
fn is_factor(text: &str, after_letter: bool) -> bool {
    if text.starts_with("10^")
        || text.strip_prefix("10").is_some_and(|power| {
            !power.is_empty() && power.chars().all(|c| "⁻⁰¹²³⁴⁵⁶⁷⁸⁹".contains(c))
        })
    {
        return true;
    }
    let is_fraction = text.contains(['.', ',', 'e', 'E']);
    let zeros = text.strip_prefix('1').filter(|zeros| zeros.chars().all(|c| c == '0'));
    let is_power = zeros.is_some_and(|zeros| zeros.len() > usize::from(after_letter));
    number(text).is_some_and(|value| value != 1.0) && (is_fraction || is_power)
}

/// A number with either decimal sign.
fn number(field: &str) -> Option<f64> {
    Decimal::Point.number(field).or_else(|| Decimal::Comma.number(field))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_factor_in_a_name_is_told_from_a_direction() {
        for (name, factor) in [
            ("Force (x0.001)", Some("0.001")),
            ("Force x 10^-3", Some("10^-3")),
            ("Force ×10⁻³", Some("10⁻³")),
            ("Force * 1e-3", Some("1e-3")),
            ("Force (x10)", Some("10")),
            ("Force x100", Some("100")),
            ("Force (x0,5)", Some("0,5")),
            ("Force/1000", Some("1000")),
            ("Acc x 2", None),
            ("Acc x10", None),
            ("Acc (x2)", None),
            ("x1.0", None),
            ("Max 0.5", None),
            ("Index 100", None),
            ("in/out", None),
            ("Node 3/x", None),
            ("", None),
            ("×", None),
        ] {
            assert_eq!(in_name(name), factor, "{name}");
        }
    }

    #[test]
    fn a_row_of_factors_marks_the_columns_whose_factor_is_not_one() {
        let marked = |fields: &[&str]| {
            let fields = fields.iter().map(|field| (*field).to_owned()).collect();
            let mut channels = vec![None; 3];
            let is_row = take_row(&Row { line: 2, fields }, &mut channels);
            (is_row, channels.iter().map(Option::is_some).collect::<Vec<_>>())
        };
        assert_eq!(marked(&["Factor", "0.001", "1"]), (true, vec![false, true, false]));
        assert_eq!(marked(&["Faktor:", "0,001", "2"]), (true, vec![false, true, true]));
        let words = ["#", "scale", "factors:", "1", "0.001", "1"];
        assert_eq!(marked(&words), (true, vec![false, true, false]));
        assert_eq!(marked(&["Gain", "1", "1"]), (true, vec![false; 3]));
        for fields in
            [&["Range", "100", "50"][..], &["Scale", "linear"], &["Gain", "10"], &["1", "2", "3"]]
        {
            assert_eq!(marked(fields), (false, vec![false; 3]), "{fields:?}");
        }
    }
}
