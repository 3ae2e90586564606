//! Lines of text that say that samples were lost: `# buffer overflow, 40 samples lost`.

use super::RecordingError;
use super::dialect::Row;

/// Words that say so of what is in a buffer.
const OVERFLOWS: [&str; 3] = ["overflow", "overrun", "discontinuity"];
/// Words that say so beside one of [`SAMPLES`]: a title may tell of a loss of another kind.
const LOSSES: [&str; 11] = [
    "lost", "loss", "losses", "missing", "missed", "dropped", "verlust", "verloren", "fehlend",
    "perdu", "perdus",
];
/// What is lost then.
const SAMPLES: [&str; 15] = [
    "sample",
    "samples",
    "scan",
    "scans",
    "point",
    "points",
    "frame",
    "frames",
    "packet",
    "packets",
    "data",
    "daten",
    "abtastwerte",
    "werte",
    "échantillons",
];

/// Refuses a line that says that samples were lost, unless it counts none.
pub(super) fn refuse(row: &Row) -> Result<(), RecordingError> {
    let text: String = row.fields.join(" ").chars().take(60).collect();
    let lower = text.to_lowercase();
    let words = || lower.split(|c: char| !c.is_alphanumeric()).filter(|word| !word.is_empty());
    let has = |list: &[&str]| words().any(|word| list.contains(&word));
    let says = has(&OVERFLOWS) || (has(&LOSSES) && has(&SAMPLES));
    let is_none = words().any(|word| ["0", "no", "none", "kein", "keine", "aucun"].contains(&word));
    if says && !is_none {
        let fault = format!(
            "\"{text}\": samples are missing; record again without losses, or cut the file there"
        );
        return Err(RecordingError::Header { line: row.line, fault });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_that_says_that_samples_were_lost_is_told_from_others() {
        let is_refused = |text: &str| refuse(&Row { line: 1, fields: vec![text.into()] }).is_err();
        for text in ["# buffer overflow, 40 samples lost", "Dropped samples: 12", "OVERRUN"] {
            assert!(is_refused(text), "{text}");
        }
        for text in [
            "lost samples: 0",
            "no samples lost",
            "# air gap 3 mm",
            "Glossy paint",
            "Transmission loss of a panel",
            "Part: bracket, one bolt missing",
            "",
        ] {
            assert!(!is_refused(text), "{text}");
        }
    }
}
