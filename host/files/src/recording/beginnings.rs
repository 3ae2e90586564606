//! A row of a header that states when each column begins: `t0;10:00:00,000;10:00:00,010`.

use super::dialect::Row;
use super::number::Decimal;
use super::stamp::Stamp;
use super::{RecordingError, six_digits};

/// Words that begin such a row.
const WORDS: [&str; 8] =
    ["t0", "x0", "start", "start time", "starttime", "startzeit", "begin", "trigger time"];

/// Marks the channels that begin at another time than the first one of the row.
pub(super) fn take_row(row: &Row, faults: &mut [Option<RecordingError>]) {
    let Some((label, fields)) = row.fields.split_first() else { return };
    let label = label.trim_start_matches(['#', '%']).trim().trim_end_matches(':');
    let begins: Vec<Option<f64>> = fields.iter().map(|field| seconds(field)).collect();
    let Some(first) = begins.iter().flatten().next().copied() else { return };
    if !WORDS.contains(&label.to_lowercase().as_str()) {
        return;
    }
    // The label stands in the place of the first column, or before all of them.
    let place = faults.len().saturating_sub(begins.len());
    for (fault, begins) in faults.iter_mut().skip(place).zip(begins) {
        let Some(later) = begins.map(|begins| begins - first).filter(|later| *later != 0.0) else {
            continue;
        };
        let text = format!(
            "by the row \"{label}\" this column begins {} s {} the first one; export \
             channels that were sampled together",
            six_digits(later.abs()),
            if later > 0.0 { "after" } else { "before" }
        );
        *fault = Some(RecordingError::Header { line: row.line, fault: text });
    }
}

fn seconds(field: &str) -> Option<f64> {
    let number = || Decimal::Point.number(field).or_else(|| Decimal::Comma.number(field));
    Stamp::parse(field).map(|stamp| stamp.seconds - stamp.zone).or_else(number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_that_begin_at_different_times_are_marked() {
        let marked = |fields: &[&str], columns: usize| {
            let fields = fields.iter().map(|field| (*field).to_owned()).collect();
            let mut faults = vec![None; columns];
            take_row(&Row { line: 3, fields }, &mut faults);
            faults.iter().map(Option::is_some).collect::<Vec<_>>()
        };
        assert_eq!(marked(&["t0", "10:00:00,000", "10:00:00,010"], 2), [false, true]);
        assert_eq!(marked(&["t0", "10:00:00", "10:00:00"], 2), [false, false]);
        assert_eq!(marked(&["X0", "0.0", "0.5"], 3), [false, false, true]);
        assert_eq!(marked(&["Range", "0.0", "0.5"], 3), [false; 3]);
        assert_eq!(marked(&["Start", "now"], 2), [false; 2]);
    }
}
