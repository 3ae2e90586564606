//! Names and units of columns, from the lines of text before the numbers.

use super::dialect::{Row, Separator};
use super::number::looks_numeric;
use super::scale::is_unit;
use super::time::is_time;
use super::{Channel, RecordingError, beginnings, factors, is_named_force};
use crate::encoding::{Text, unit_of};
use crate::units::is_unstated;

/// Words in a row of units that stand beside the units.
const UNIT_WORDS: [&str; 6] = ["unit", "units", "einheit", "einheiten", "unité", "unités"];

/// The channels from the lines of text before the data: names, then perhaps units; other lines are comments.
///
/// # Errors
/// When there are more names than columns.
pub(super) fn channels(
    header: Vec<Row>,
    columns: usize,
    separator: Separator,
    text: &Text<'_>,
) -> Result<Vec<Channel>, RecordingError> {
    let mut last = None;
    let mut rows: Vec<Vec<Channel>> = Vec::new();
    let mut others: Vec<Vec<Channel>> = Vec::new();
    let mut factors = vec![None; columns];
    let mut faults = vec![None; columns];
    for row in header {
        if factors::take_row(&row, &mut factors) {
            continue;
        }
        beginnings::take_row(&row, &mut faults);
        let Row { line, mut fields } = row;
        if let Some(first) = fields.first_mut() {
            *first = first.trim_start_matches(['#', '%']).trim().to_owned();
        }
        let labels = |fields: &[String]| fields.iter().map(|field| channel(field, text)).collect();
        let line_text = separator.line(&fields);
        let fits = |fields: &Vec<String>| fields.len() == columns && columns > 1;
        let marks = Separator::ALL.into_iter().filter(|mark| *mark != Separator::Blanks);
        let mut otherwise = marks.map(|mark| mark.fields(&line_text)).filter(fits);
        if separator == Separator::Blanks {
            // Names with blanks in them may be separated by commas.
            fields = otherwise.next().unwrap_or_else(|| separator.fields(&line_text));
        }
        let is_label = |first: &String| first.ends_with(':') || is_unit_word(first);
        if fields.len() == columns + 1 && fields.first().is_some_and(is_label) {
            fields.remove(0);
        }
        if fields.len() == columns {
            if may_be_names(&fields) {
                rows.push(labels(&fields));
            }
        } else if let Some(fields) = otherwise.next() {
            others.push(labels(&fields));
        } else if separator != Separator::Blanks {
            last = Some((line, fields));
        }
    }
    if rows.is_empty() {
        rows = others;
    }
    let has_names = rows.len() > 1;
    let units = rows.iter().rposition(|row| is_units(row, has_names)).map(|at| rows.remove(at));
    let is_name = |channel: &Channel| is_time(channel) || is_named_force(&channel.name);
    let names_at = rows.iter().rposition(|row| row.iter().any(is_name));
    let names = match (
        names_at.or(rows.len().checked_sub(1)).and_then(|at| rows.into_iter().nth(at)),
        last,
    ) {
        (Some(names), _) => names,
        // The header may omit names, but must not have more names than there are columns.
        (None, Some((line, fields))) if fields.len() > columns && columns > 1 => {
            return Err(RecordingError::Ragged { line, found: fields.len(), wanted: columns });
        }
        // A title is no row of names.
        (None, Some((_, fields))) if fields.len() > 1 || columns == 1 => {
            fields.iter().map(|field| channel(field, text)).collect()
        }
        _ => Vec::new(),
    };
    Ok((0..columns)
        .map(|k| {
            let named = names.get(k).cloned().unwrap_or_default();
            match units.as_ref().and_then(|units| units.get(k)) {
                Some(label) => with_unit(named, &whole(label), text),
                None => named,
            }
        })
        .zip(factors.into_iter().zip(faults))
        .map(|(channel, (multiplier, fault))| Channel { multiplier, fault, ..channel })
        .collect())
}

/// True for a word that says that units stand beside it.
pub(super) fn is_unit_word(label: &str) -> bool {
    let label = label.trim_end_matches(':').to_lowercase();
    label.split_whitespace().next_back().is_some_and(|last| UNIT_WORDS.contains(&last))
}

/// True for fields that may be names: no readings, and no statement such as `Range: 5`.
fn may_be_names(fields: &[String]) -> bool {
    let is_reading =
        |field: &String| looks_numeric(field) && !field.chars().all(|c| c.is_ascii_digit());
    let is_statement = match fields {
        [first, rest @ ..] => {
            first.ends_with(':') && !rest.iter().any(|field| field.ends_with(':'))
        }
        [] => false,
    };
    let is_statement = is_statement && fields.first().is_some_and(|first| !is_unit_word(first));
    !is_statement && !fields.iter().any(is_reading)
}

/// A channel with the unit that a row of units states for it, if it states one. Where its name states another one, both
/// are kept.
pub(super) fn with_unit(named: Channel, label: &str, text: &Text<'_>) -> Channel {
    if is_unit_word(label) || is_unstated(label) {
        return named;
    }
    let unit = decided(&unwrapped(label), text);
    let name = match is_unstated(&named.unit) || named.unit == unit {
        true => named.name.clone(),
        false => whole(&named),
    };
    Channel { name, unit, ..named }
}

/// True for a row of units: at least half of what it states is known. Alone it must be known wholly.
fn is_units(row: &[Channel], has_names: bool) -> bool {
    let labels: Vec<String> = row.iter().map(whole).filter(|label| !is_unstated(label)).collect();
    let is_known = |label: &String| is_unit(&unwrapped(label)) || is_unit_word(label);
    let known = labels.iter().filter(|label| is_known(label)).count();
    known > 0 && if has_names { 2 * known >= labels.len() } else { known == labels.len() }
}

/// The text of which a channel was made.
fn whole(channel: &Channel) -> String {
    match (channel.name.as_str(), channel.unit.as_str()) {
        (name, "") => name.to_owned(),
        ("", unit) => unit.to_owned(),
        (name, unit) => format!("{name} ({unit})"),
    }
}

/// Splits `Force [N]`, `Force (N)`, `Force / N` or `Force in N` into a name and a unit. A unit in round brackets, or
/// without any, is one that is known: `Force (top)` is a name.
pub(super) fn channel(label: &str, text: &Text<'_>) -> Channel {
    let named = |name: &str, unit: String| Channel {
        name: name.trim().to_owned(),
        unit,
        ..Channel::default()
    };
    let known = |unit: &str| {
        let unit = decided(&unwrapped(unit), text);
        is_unit(&unit).then_some(unit)
    };
    let mut rest = label;
    while let Some(open) = rest.rfind(['[', '(']) {
        let (front, group) = rest.split_at_checked(open).unwrap_or((rest, ""));
        let close = if group.starts_with('[') { ']' } else { ')' };
        // Brackets within a unit: (m/(N s^2)).
        let end = label.get(open..).and_then(|group| group.rfind(close)).map(|at| open + at);
        let unit = end.and_then(|end| label.get(open + 1..end)).unwrap_or_default();
        let after = end.and_then(|end| label.get(end + 1..)).unwrap_or_default();
        if let Some(unit) = known(unit) {
            let front = front.trim().trim_end_matches('/');
            return named(&format!("{front} {}", after.trim()), unit);
        }
        // A time has a unit in any brackets: an unknown one is refused.
        let is_stated = close == ']' || is_time(&named(front, String::new()));
        if is_stated && end.is_some() && after.trim().is_empty() {
            return named(front, unwrapped(unit));
        }
        rest = front;
    }
    for sign in [" / ", " in ", ", ", "/"] {
        if let Some((name, unit)) =
            label.split_once(sign).filter(|(name, _)| !name.trim().is_empty())
            && !is_unit(label)
            && let Some(unit) = known(unit)
        {
            return named(name, unit);
        }
    }
    named(label, String::new())
}

/// A unit without its brackets.
fn unwrapped(unit: &str) -> String {
    let unit = unit.trim();
    let pairs = [('[', ']'), ('(', ')')];
    let inner =
        pairs.iter().find_map(|&(open, close)| unit.strip_prefix(open)?.strip_suffix(close));
    inner.unwrap_or(unit).trim().to_owned()
}

/// The reading of a label that is a unit, if the readings agree; else the label as it is.
pub(super) fn decided(label: &str, text: &Text<'_>) -> String {
    if label.is_ascii() {
        return label.to_owned();
    }
    let meaning = |label: &str| super::scale::size(label);
    let bytes = text.bytes_of(label);
    unit_of(&bytes, meaning).map_or_else(|| label.to_owned(), |(unit, _)| unit.into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts(label: &str) -> (String, String) {
        let text = Text::decode(label.as_bytes()).unwrap();
        let Channel { name, unit, .. } = channel(label, &text);
        (name, unit)
    }

    #[test]
    fn a_label_is_split_into_name_and_unit() {
        for (label, name, unit) in [
            ("Force [N]", "Force", "N"),
            ("Force (N)", "Force", "N"),
            ("Force", "Force", ""),
            ("[N]", "", "N"),
            ("Force (top)", "Force (top)", ""),
            ("Force (top) [lbf]", "Force (top)", "lbf"),
            ("Force [N] (filtered)", "Force (filtered)", "N"),
            ("Force / N", "Force", "N"),
            ("Force/N", "Force", "N"),
            ("Kraft in N", "Kraft", "N"),
            ("Force, lbf", "Force", "lbf"),
            ("a (m/s^2)", "a", "m/s^2"),
            ("a [furlong]", "a", "furlong"),
            ("in/out", "in/out", ""),
            ("x/y", "x/y", ""),
            ("Acc (mV)", "Acc", "mV"),
            ("Acc (m/(s*s))", "Acc", "m/(s*s)"),
            ("", "", ""),
            ("a [m/s²]", "a", "m/s²"),
            ("Room [°C]", "Room", "°C"),
            ("[", "[", ""),
            ("a) b (", "a) b (", ""),
            ("m/s²", "m/s²", ""),
        ] {
            assert_eq!(parts(label), (name.to_owned(), unit.to_owned()), "{label}");
        }
    }

    fn labels(header: &str, columns: usize, separator: Separator) -> Vec<(String, String)> {
        let text = Text::decode(header.as_bytes()).unwrap();
        let rows = super::super::dialect::rows_of(header, separator)
            .collect::<Result<Vec<_>, _>>()
            .unwrap();
        let channels = channels(rows, columns, separator, &text).unwrap();
        channels.into_iter().map(|channel| (channel.name, channel.unit)).collect()
    }

    #[test]
    fn names_and_units_are_found_among_other_lines() {
        use Separator::{Blanks, Comma, Semicolon, Tab};
        let expected = |pairs: &[(&str, &str)]| -> Vec<(String, String)> {
            pairs.iter().map(|(name, unit)| ((*name).to_owned(), (*unit).to_owned())).collect()
        };
        let three = expected(&[("Time", "s"), ("Force", "N"), ("Acc", "g")]);
        for (header, separator) in [
            ("Time,Force,Acc\ns,N,g\n", Comma),
            ("s,N,g\nTime,Force,Acc\n", Comma),
            ("Test;of;today\nTime;Force;Acc\n[s];[N];[g]\n", Semicolon),
            ("Time [s]\tForce [N]\tAcc [g]\n", Tab),
            ("Time [s];Force [N];Acc [g]\n", Tab),
            ("# Time (s) Force (N) Acc (g)\n", Blanks),
            ("# Time (s), Force (N), Acc (g)\n", Blanks),
            ("Time,Force,Acc\ns,N,g\nRange,100,50\n", Comma),
        ] {
            assert_eq!(labels(header, 3, separator), three, "{header}");
        }
        let four = expected(&[("Time", "s"), ("Force", "N"), ("Acc", "g"), ("Temp", "flames")]);
        assert_eq!(labels("Time,Force,Acc,Temp\ns,N,g,flames\n", 4, Comma), four);
        assert_eq!(labels("Time,Force,Acc\nUnit,N,g\n", 3, Comma)[1..], three[1..]);
        assert_eq!(
            labels("N,g\n", 2, Comma),
            expected(&[("N", ""), ("g", "")])
                .iter()
                .map(|(unit, _)| (String::new(), unit.clone()))
                .collect::<Vec<_>>()
        );
        assert_eq!(labels("A title\n", 2, Comma), expected(&[("", ""), ("", "")]));
    }

    #[test]
    fn a_unit_in_a_guessed_encoding_is_one_only_if_no_reading_contradicts() {
        let bytes = [&encoding_rs::SHIFT_JIS.encode("時間 [s],力 [N],変位 [").0[..], b"m/s\xb2]\n"]
            .concat();
        let text = Text::decode(&bytes).unwrap();
        let last = text.text.trim().rsplit(',').next().unwrap();
        let Channel { name, unit, .. } = channel(last, &text);
        assert_eq!((name.as_str(), unit.as_str()), ("変位", "m/s²"));
    }
}
