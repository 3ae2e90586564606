//! Which column of a recording is its time, and in which unit it is.

use std::ops::Range;

use super::steps::{Steps, Times};
use super::{Channel, RecordingError, factors};
use crate::units::{is_unstated, time_unit};

/// Words of a name that say that a column is a time.
const TIME: [&str; 21] = [
    "time",
    "times",
    "millis",
    "micros",
    "ticks",
    "clock",
    "zeitpunkt",
    "sekunden",
    "seconds",
    "timestamp",
    "timestamps",
    "datetime",
    "elapsed",
    "epoch",
    "zeit",
    "uhrzeit",
    "zeitstempel",
    "temps",
    "tiempo",
    "tempo",
    "時間",
];
/// Names of a column that counts the samples.
const INDEX: [&str; 18] = [
    "counter", "cnt", "frame", "zähler", "index", "idx", "sample", "samples", "no", "nr", "n", "i",
    "k", "point", "row", "scan", "number", "count",
];

/// The fewest rows between two points at which the time begins again.
const SHORTEST_RUN: usize = 3;

/// Relative difference up to which the steps of two segments are the same.
const EQUAL_STEPS: f64 = 1e-3;

/// The column of a recording that has its time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeColumn {
    /// Its name in the file.
    pub name: String,
    /// Its unit.
    pub unit: TimeUnit,
    /// Its steps, whose rows are places in the file.
    pub steps: Steps,
    /// What the numbers of these places are.
    pub places: Places,
    /// Its first value.
    pub first: f64,
    /// Whether it counts the samples.
    pub is_index: bool,
}

/// What the number of a place in a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Places {
    /// A line of the file.
    Lines,
    /// A value of the record that begins in this line of the file.
    ValuesOfRecord(usize),
}

impl Places {
    /// The place as text.
    pub(super) fn name(self, number: usize) -> String {
        match self {
            Self::Lines => format!("line {number}"),
            Self::ValuesOfRecord(line) => format!("value {number} of the record in line {line}"),
        }
    }
}

/// The unit of a time column.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeUnit {
    /// A unit of time.
    Known {
        /// Its label in the file.
        label: String,
        /// Its size, s.
        seconds: f64,
    },
    /// The times of a clock.
    Clock,
    /// A label that is no unit of time.
    Unknown(String),
    /// Two labels that contradict each other.
    Contradictory(String, String),
    /// No label.
    Unstated,
}

impl TimeUnit {
    /// The unit by the name and the label of a column: the last word of the name may be a unit, as in `time_us`.
    pub(super) fn of(channel: &Channel) -> Self {
        let words = words(&channel.name);
        let word = words.last().filter(|_| words.len() > 1 || is_unstated(&channel.unit));
        let known = |label: &str| {
            // The names of the clocks of an Arduino.
            let label = match label {
                "millis" => "ms",
                "micros" => "us",
                label => label,
            };
            time_unit(label).map(|seconds| (label.to_owned(), seconds))
        };
        let of_name = word.and_then(|word| known(word)).filter(|(word, _)| word != "t");
        let label = channel.unit.trim();
        match (of_name, known(label)) {
            (Some((a, first)), Some((b, second))) if first != second => Self::Contradictory(a, b),
            (_, Some((label, seconds))) => Self::Known { label, seconds },
            _ if !is_unstated(label) => Self::Unknown(label.to_owned()),
            (Some((label, seconds)), _) => Self::Known { label, seconds },
            _ => Self::Unstated,
        }
    }
}

/// The columns that have no reading of a sensor.
#[derive(Debug, Default, PartialEq)]
pub(super) struct TimeColumns {
    /// The time.
    pub time: Option<usize>,
    /// Columns that count the samples, further times, and other columns with the name of a time or a count.
    pub others: Vec<usize>,
}

/// True for a column that may be a time or an index, by its place, name and unit.
pub(super) fn may_be_time(place: usize, channel: &Channel) -> bool {
    is_time(channel) || is_index(&channel.name) || (channel.name.is_empty() && place < 2)
}

/// Finds the time among the columns for which [`may_be_time`] holds.
pub(super) fn find(channels: &[Channel], columns: &[(usize, Times)]) -> TimeColumns {
    let channel = |place: usize| channels.get(place).cloned().unwrap_or_default();
    let by_name: Vec<&(usize, Times)> =
        columns.iter().filter(|(place, _)| is_time(&channel(*place))).collect();
    let indices = columns.iter().filter(|(place, times)| {
        let name = channel(*place).name;
        is_index(&name) && times.count() || name.is_empty() && *place == 0 && times.count()
    });
    let indices: Vec<usize> = indices.map(|(place, _)| *place).collect();
    let named_index = columns.iter().filter(|(place, _)| is_index(&channel(*place).name));
    // A count with a gap shows the loss.
    let counted = || named_index.clone().find(|(_, times)| times.rise()).map(|(place, _)| *place);
    // A clock may have fewer digits than a time beside it.
    let rising = by_name.iter().filter(|(_, times)| times.rise());
    let rising = rising.min_by(|(_, a), (_, b)| a.coarseness().total_cmp(&b.coarseness()));
    // The temperature is a T as well.
    let named = rising.or(by_name.iter().find(|(place, _)| channel(*place).name.len() > 1));
    let nameless = || {
        let is_nameless =
            |(place, times): &&(usize, Times)| channel(*place).name.is_empty() && times.rise();
        let first = columns.iter().find(|column| column.0 == 0).filter(is_nameless)?;
        let second = columns.iter().find(|column| column.0 == 1).filter(is_nameless);
        Some(second.filter(|_| first.1.count()).unwrap_or(first).0)
    };
    // What rises in every row, whatever its name.
    let is_other = |(place, times): &&(usize, Times)| {
        let channel = channel(*place);
        !channel.name.is_empty() && !is_time(&channel) && !is_index(&channel.name) && times.rise()
    };
    let rising: Vec<&(usize, Times)> = columns.iter().filter(is_other).collect();
    let rising_time = || rising.iter().find(|(_, times)| !times.count()).map(|(place, _)| *place);
    let time = named.map(|(place, _)| *place).or_else(nameless).or_else(rising_time);
    let time = time.or_else(|| indices.first().copied()).or_else(counted);
    let time = time.or_else(|| rising.first().map(|(place, _)| *place));
    // One letter may be anything.
    let is_meant =
        |(place, times): &&(usize, Times)| times.rise() || channel(*place).name.chars().count() > 1;
    let named = by_name.iter().copied().chain(named_index.clone()).filter(is_meant);
    let named = named.chain(rising).map(|(place, _)| *place);
    let mut others: Vec<usize> =
        indices.into_iter().chain(named).filter(|&place| Some(place) != time).collect();
    others.sort_unstable();
    others.dedup();
    TimeColumns { time, others }
}

/// The segments of a recording with this time column, and what the column says.
///
/// # Errors
/// When two segments have different steps, or the time never rises. `line` gives the line of a row.
pub(super) fn time_column(
    channel: &Channel,
    times: &Times,
    line: impl Fn(usize) -> usize,
) -> Result<(TimeColumn, Vec<Range<usize>>), RecordingError> {
    if let [first, .., last] = times.values[..]
        && !times.values.windows(2).any(|pair| pair[0] < pair[1])
    {
        let fault = format!(
            "the time column \"{}\" goes from {first} to {last} and never rises; export the samples in the order of \
             their time",
            channel.name
        );
        return Err(RecordingError::Header { line: line(0), fault });
    }
    if let Some(factor) = factors::of(channel) {
        let fault = format!(
            "the time column \"{}\": {factor}, and not whether its numbers are multiplied already; export the time \
             without a factor",
            channel.name
        );
        return Err(RecordingError::Header { line: line(0), fault });
    }
    let mut runs = times.runs();
    if runs.len() == 1 {
        let blocks = times.blocks();
        if !blocks.is_empty() {
            runs = blocks;
        }
    }
    if let [_, _, ..] = runs[..]
        && let Some(run) = runs.iter().find(|run| run.len() < SHORTEST_RUN)
    {
        let at = |row: usize| times.values.get(row).copied().unwrap_or_default();
        let last = run.end.saturating_sub(1);
        let (before, after) = if run.end < times.values.len() {
            (last, run.end)
        } else {
            (run.start.saturating_sub(1), run.start)
        };
        let fault = format!(
            "the time column \"{}\" goes from {} to {} in the next row; export the samples in the order of their time, \
             and no row of factors or ranges among them",
            channel.name,
            at(before),
            at(after)
        );
        return Err(RecordingError::Header { line: line(before), fault });
    }
    let mut steps: Option<Steps> = None;
    for run in &runs {
        let next = times.part(run.clone()).steps();
        let start = run.start;
        match (steps, next) {
            (_, Steps::Lost { row, gaps, samples, after }) => {
                steps = Some(Steps::Lost { row: line(start + row), gaps, samples, after });
                break;
            }
            (_, Steps::Uneven(unevenness)) => {
                steps = Some(Steps::Uneven(unevenness.at(|row| line(start + row))));
                break;
            }
            (
                Some(Steps::Even { step, uncertainty: known, .. }),
                Steps::Even { step: other, uncertainty, .. },
            ) => {
                if (other / step - 1.0).abs() > EQUAL_STEPS + known + uncertainty {
                    let fault = format!(
                        "the time begins again with a step of {other} instead of {step}; export segments of one rate"
                    );
                    return Err(RecordingError::Header { line: line(start), fault });
                }
                if uncertainty < known {
                    steps = Some(next);
                }
            }
            _ => steps = Some(next),
        }
    }
    let column = TimeColumn {
        name: channel.name.clone(),
        unit: TimeUnit::of(channel),
        steps: steps.unwrap_or_else(|| times.steps()),
        places: Places::Lines,
        first: times.values.first().copied().unwrap_or_default(),
        is_index: times.count(),
    };
    Ok((column, runs))
}

/// Why a further column with the name or the values of a time or a count is left out; `time` is the time of the
/// recording, where it has one.
///
/// # Errors
/// When it is a time that does not run as the time of the recording does, row by row.
pub(super) fn beside_the_time(
    time: Option<(&Channel, &Times)>,
    (other, own): (&Channel, &Times),
    line: impl Fn(usize) -> usize,
) -> Result<&'static str, RecordingError> {
    const BY_NAME: &str = "its name or its values are those of a time or a count";
    if own.count() {
        return Ok("it counts the samples");
    }
    let Some((channel, times)) = time.filter(|_| is_time(other)) else { return Ok(BY_NAME) };
    if !own.rise() || !times.rise() {
        return Ok(BY_NAME);
    }
    let contradiction = |fault: String, row: usize| {
        let fault = format!("{fault}; export channels that were sampled together, with one time");
        Err(RecordingError::Header { line: line(row), fault })
    };
    if let ([first, _, ..], [_]) = (&times.runs()[..], &own.runs()[..]) {
        let (name, other) = (&channel.name, &other.name);
        let fault =
            format!("the time \"{name}\" begins again after this row, and \"{other}\" goes on");
        return contradiction(fault, first.end.saturating_sub(1));
    }
    let known = |channel: &Channel| match TimeUnit::of(channel) {
        TimeUnit::Known { seconds, .. } => Some(seconds),
        _ => None,
    };
    // Without two units, only that both run alike can be told.
    let ratio = match (known(channel), known(other)) {
        (Some(of_time), Some(of_other)) => Some(of_time / of_other),
        (None, None) => Some(1.0),
        _ => None,
    };
    match times.departs(own, ratio) {
        None => Ok("it repeats the time"),
        Some(row) => {
            let (name, other) = (&channel.name, &other.name);
            contradiction(
                format!("the columns \"{name}\" and \"{other}\" state different times"),
                row,
            )
        }
    }
}

/// True for a column with the name or the unit of a time.
pub(super) fn is_time(channel: &Channel) -> bool {
    if super::is_named_force(&channel.name) {
        return false;
    }
    if !is_unstated(&channel.unit) && time_unit(&channel.unit).is_some() {
        return true;
    }
    let words = words(&channel.name);
    let has_word = words.iter().any(|word| TIME.contains(&word.as_str()));
    let is_known_otherwise = super::scale::is_unit(&channel.unit);
    match words.first().map(String::as_str) {
        Some("t") if words.len() <= 2 => !is_known_otherwise,
        Some("x")
            if words.len() == 2
                && words.last().is_some_and(|word| word == "value" || word == "axis") =>
        {
            !is_known_otherwise
        }
        Some(word) if words.len() == 1 && time_unit(word).is_some() => is_unstated(&channel.unit),
        _ => has_word && !is_known_otherwise,
    }
}

/// True for the name of a column that counts the samples.
fn is_index(name: &str) -> bool {
    let words = words(name);
    name.trim() == "#"
        || (1..=2).contains(&words.len()) && words.iter().all(|word| INDEX.contains(&word.as_str()))
}

/// The words of a name in small letters: `timeUs`, `time_us` and `Time (us)` are two words each.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut last = ' ';
    for c in name.chars() {
        let begins = c.is_uppercase() && last.is_lowercase();
        if !c.is_alphanumeric() || begins {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| c.is_alphanumeric()) {
            word.extend(c.to_lowercase());
        }
        last = c;
    }
    words.retain(|word| !word.is_empty());
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    fn channel(name: &str, unit: &str) -> Channel {
        Channel { name: name.into(), unit: unit.into(), ..Channel::default() }
    }

    #[test]
    fn a_time_is_known_by_its_name_or_its_unit() {
        for (name, unit) in [
            ("t", ""),
            ("Time", ""),
            ("Time", "msec"),
            ("time_us", ""),
            ("t_ms", ""),
            ("timeMs", ""),
            ("", "ns"),
            ("X_Value", ""),
            ("Elapsed time", "s"),
            ("timestamp", ""),
            ("Zeit", "s"),
            ("X", "ms"),
            ("ms", ""),
            ("Time 1 - default rate", "s"),
            ("Time", "fortnights"),
        ] {
            assert!(is_time(&channel(name, unit)), "{name} {unit}");
        }
        for (name, unit) in [
            ("Force", ""),
            ("T", "°C"),
            ("t", "K"),
            ("Hammer time", "N"),
            ("x", ""),
            ("x", "m/s^2"),
            ("tip", ""),
            ("a", "g"),
            ("m", ""),
            ("Sometimes", ""),
            ("", ""),
            ("Lifetime", "N"),
        ] {
            assert!(!is_time(&channel(name, unit)), "{name} {unit}");
        }
    }

    #[test]
    fn the_unit_of_a_time_is_read_from_its_label_or_its_name() {
        let seconds = |name: &str, unit: &str| match TimeUnit::of(&channel(name, unit)) {
            TimeUnit::Known { seconds, .. } => Ok(seconds),
            other => Err(other),
        };
        for (name, unit, expected) in [
            ("Time", "s", 1.0),
            ("Time", "sec", 1.0),
            ("Time", "Seconds", 1.0),
            ("Time", "ms", 1e-3),
            ("Time", "msec", 1e-3),
            ("Time", "milliseconds", 1e-3),
            ("Time", "us", 1e-6),
            ("Time", "µs", 1e-6),
            ("Time", "μs", 1e-6),
            ("Time", "usec", 1e-6),
            ("Time", "ns", 1e-9),
            ("Time", "min", 60.0),
            ("time_us", "", 1e-6),
            ("t_ms", "", 1e-3),
            ("timeMs", "", 1e-3),
            ("timestamp_ns", "", 1e-9),
            ("Time", "MSEC", 1e-3),
            ("ms", "", 1e-3),
            ("time_us", "us", 1e-6),
        ] {
            assert_eq!(seconds(name, unit), Ok(expected), "{name} {unit}");
        }
        assert_eq!(seconds("Time", ""), Err(TimeUnit::Unstated));
        assert_eq!(seconds("t", ""), Err(TimeUnit::Unstated));
        assert_eq!(seconds("Time", "ticks"), Err(TimeUnit::Unknown("ticks".into())));
        assert_eq!(seconds("time_ms", "s"), Err(TimeUnit::Contradictory("ms".into(), "s".into())));
    }

    #[test]
    fn an_index_is_no_time_beside_one() {
        let rising = |step: f64| Times::exact((0..16).map(|k| step * f64::from(k)).collect());
        let noise = || Times::exact((0..16).map(|k| f64::from(k * 7 % 5)).collect());
        let find = |names: &[&str], columns: Vec<Times>| {
            let channels: Vec<Channel> = names.iter().map(|name| channel(name, "")).collect();
            find(&channels, &columns.into_iter().enumerate().collect::<Vec<_>>())
        };
        let columns = |time, others: &[usize]| TimeColumns { time, others: others.to_vec() };
        assert_eq!(find(&["", ""], vec![rising(1.0), rising(0.1)]), columns(Some(1), &[0]));
        assert_eq!(find(&["", ""], vec![rising(1.0), noise()]), columns(Some(0), &[]));
        assert_eq!(find(&["", ""], vec![noise(), noise()]), columns(None, &[]));
        assert_eq!(
            find(&["Index", "Time"], vec![rising(1.0), rising(0.1)]),
            columns(Some(1), &[0])
        );
        assert_eq!(
            find(&["Sample No", "Force"], vec![rising(1.0), noise()]),
            columns(Some(0), &[])
        );
        assert_eq!(find(&["t", "T"], vec![rising(0.1), noise()]), columns(Some(0), &[]));
    }
}
