//! Time records of a universal file: dataset 58 with function type 1. Records that repeat the DOFs, quantities and
//! units of those before them in the same order are further segments; other records of a DOF that occurs again are
//! channels of their own.

use std::collections::HashSet;

use super::lvm::EQUAL_RATES;
use super::steps::{Steps, Times};
use super::time::{Places, TimeColumn, TimeUnit};
use super::{
    Channel, DeclaredRate, MOST_CHANNELS, Recording, RecordingError, Segment, Source, six_digits,
};
use crate::uff::{Function, UffFile};
use crate::units::{Measure, is_unstated, unit_size};

/// Reads the bytes of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Recording, RecordingError> {
    let file = UffFile::parse(bytes)?;
    let records: Vec<&Function> = file.functions.iter().filter(|f| f.is_time_response()).collect();
    let Some(first) = records.first() else {
        let text = "the file holds no time records (dataset 58, function type 1); export these, or \
                    give frequency responses to `massline solve`";
        return Err(RecordingError::Array(text.into()));
    };
    let per_segment = channels_of_segment(&records)?;
    let mut channels: Vec<Channel> =
        records.iter().take(per_segment).map(|f| f.time_channel()).collect();
    Recording::plausible(records.len().div_ceil(per_segment) as u64, per_segment as u64)?;
    for record in &records {
        record.check_increment()?;
    }
    let rate_of_first = rate(first)?;
    let mut segments = Vec::new();
    for group in records.chunks(per_segment) {
        let length = group.first().map_or(0, |f| f.ordinate.len());
        if let Some(other) = group.iter().find(|f| f.ordinate.len() != length) {
            let samples = other.ordinate.len();
            return Err(RecordingError::Ragged {
                line: other.line,
                found: samples,
                wanted: length,
            });
        }
        for record in group {
            if let Some((wanted, hz)) = rate_of_first.zip(rate(record)?)
                && differs(hz, rate_of_first)
            {
                let fault = format!(
                    "this record was sampled at {hz} Hz and the first one at {wanted} Hz; export all records at one \
                     rate"
                );
                return Err(RecordingError::Header { line: record.line, fault });
            }
        }
        segments.push(Segment(group.iter().map(|f| f.time_samples()).collect()));
    }
    name_apart(&mut channels);
    let declared = rate_of_first.map(|hz| DeclaredRate {
        hz,
        uncertainty: 0.0,
        entry: "the abscissa".to_owned(),
        states_unit: true,
    });
    let mut notes = file.notes.clone();
    for (record, channel) in records.iter().zip(&channels) {
        notes.extend(contradiction(record, channel));
    }
    let source = Source { format: "universal file", ..Source::default() };
    let time = records.iter().find_map(|record| uneven(record));
    Ok(Recording { source, declared, time, channels, segments, notes, ..Recording::default() })
}

/// What contradicts the unit of a record.
fn contradiction(record: &Function, channel: &Channel) -> Option<String> {
    let name = match record.numerator_axis.data_type {
        9 | 13 => "N",
        _ => "m/s^2",
    };
    let unit = match (channel.unit.as_str(), channel.factor) {
        ("", None | Some(1.0)) => name.to_owned(),
        ("", Some(factor)) => format!("{} {name}", six_digits(factor)),
        (unit, _) => unit.to_owned(),
    };
    let contradiction = record.time_contradiction()?;
    Some(contradiction.sentence(&unit, &format!("values of {}", channel.name), six_digits))
}

/// The abscissa of a record that states each time and is not even, from which no rate is taken.
fn uneven(record: &Function) -> Option<TimeColumn> {
    let [first, _, _, ..] = record.abscissa[..] else { return None };
    let mut times = Times::default();
    record.abscissa.iter().for_each(|&time| times.push(time, digit(time)));
    let steps = match times.steps() {
        Steps::Even { .. } => return None,
        Steps::Lost { gaps, samples, row, after } => {
            Steps::Lost { gaps, samples, row: row + 1, after }
        }
        Steps::Uneven(unevenness) => Steps::Uneven(unevenness.at(|row| row + 1)),
    };
    let name = format!("abscissa of {}", record.time_channel().name);
    let unit = TimeUnit::Known { label: "s".into(), seconds: 1.0 };
    let places = Places::ValuesOfRecord(record.line);
    Some(TimeColumn { name, unit, steps, places, first, is_index: false })
}

/// The last digit of a time as the format writes it, with six of them (`E13.5`).
fn digit(time: f64) -> f64 {
    const DECIMALS: i32 = 5;
    if time == 0.0 { 0.0 } else { 10_f64.powi(time.abs().log10().floor() as i32 - DECIMALS) }
}

/// The number of channels: that of the shortest beginning whose DOFs and quantities the records repeat to their end.
///
/// # Errors
/// When the last repetition is incomplete, or a repetition has other units.
fn channels_of_segment(records: &[&Function]) -> Result<usize, RecordingError> {
    let channels: Vec<Channel> = records.iter().map(|f| f.time_channel()).collect();
    let repeats = |period: &usize| {
        channels
            .iter()
            .skip(*period)
            .zip(&channels)
            .all(|(later, channel)| later.name == channel.name)
    };
    let periods = 1..channels.len().min(MOST_CHANNELS + 1);
    let Some(period) = periods.into_iter().find(repeats) else { return Ok(channels.len()) };
    let rest = channels.len() % period;
    // A beginning that occurs once and in part is no segment: two of its channels have the same DOF.
    if rest > 0 && channels.len() < 2 * period {
        return Ok(channels.len());
    }
    if rest > 0 {
        let wanted = format!("{} records of the last segment", period - rest);
        return Err(RecordingError::Truncated { wanted });
    }
    let mut later = records.iter().zip(&channels).skip(period).zip(&channels);
    if let Some(((record, channel), wanted)) =
        later.find(|((_, channel), wanted)| channel != wanted)
    {
        let fault = format!(
            "this record of channel \"{}\" has another unit than that of the first segment ({:?} and {:?}); export all \
             segments alike",
            wanted.name, channel.unit, wanted.unit
        );
        return Err(RecordingError::Header { line: record.line, fault });
    }
    Ok(period)
}

/// Adds the number of the record to each name that occurs again.
fn name_apart(channels: &mut [Channel]) {
    let mut names = HashSet::new();
    for (place, channel) in channels.iter_mut().enumerate() {
        if !names.insert(channel.name.clone()) {
            channel.name = format!("{} (record {})", channel.name, place + 1).trim().to_owned();
        }
    }
}

impl Function {
    /// The channel of a record; the unit of a velocity or displacement is always given, so that it is refused
    /// where an acceleration is needed.
    fn time_channel(&self) -> Channel {
        let (name, unit) = match self.numerator_axis.data_type {
            9 | 13 => ("force", ""),
            8 => ("displacement", "m"),
            11 => ("velocity", "m/s"),
            12 => ("acceleration", ""),
            _ => ("", ""),
        };
        let name = format!("{name} {}:{}", self.response.node, self.response.direction);
        let unit = match self.numerator_axis.unit.trim() {
            "" => unit,
            stated => stated,
        };
        let factor = if unit.is_empty() { self.time_factor() } else { None };
        Channel {
            name: name.trim().to_owned(),
            unit: unit.to_owned(),
            factor,
            ..Channel::default()
        }
    }
}

/// Whether two rates are different.
fn differs(rate: f64, first: Option<f64>) -> bool {
    first.is_some_and(|first| (rate / first - 1.0).abs() > EQUAL_RATES)
}

/// The sampling rate of an even abscissa, Hz.
fn rate(function: &Function) -> Result<Option<f64>, RecordingError> {
    let unit = &function.abscissa_axis.unit;
    let second = match is_unstated(unit) {
        true => 1.0,
        false => unit_size(unit, Measure::Time).map_err(|fault| {
            let fault = format!(
                "the abscissa is in \"{unit}\": {fault}; export the records over time in seconds"
            );
            RecordingError::Header { line: function.line, fault }
        })?,
    };
    let ends = function.abscissa.first().zip(function.abscissa.last());
    let steps = function.abscissa.len().saturating_sub(1);
    let rate = ends.map(|(first, last)| steps as f64 / ((last - first) * second));
    Ok(rate.filter(|rate| rate.is_finite() && *rate > 0.0))
}
