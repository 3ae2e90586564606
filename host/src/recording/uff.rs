//! Time records of a universal file: dataset 58 with function type 1. A DOF that occurs again begins the next
//! segment, whose channels have the quantities and units of those of the first.

use super::lvm::EQUAL_RATES;
use super::{Channel, DeclaredRate, Recording, RecordingError, Segment, Source};
use crate::uff::{Function, UffFile};

/// Reads the bytes of a file.
pub(super) fn read(bytes: &[u8]) -> Result<Recording, RecordingError> {
    let file = UffFile::parse(bytes)?;
    let records: Vec<&Function> = file.functions.iter().filter(|f| f.is_time_response()).collect();
    let Some(first) = records.first() else {
        let text = "the file holds no time records (dataset 58, function type 1); export these, or \
                    give frequency responses to `massline solve`";
        return Err(RecordingError::Array(text.into()));
    };
    let per_segment = records
        .iter()
        .skip(1)
        .position(|f| {
            f.response == first.response && f.numerator_axis.measures_as(&first.numerator_axis)
        })
        .map_or(records.len(), |at| at + 1);
    let channels: Vec<Channel> =
        records.iter().take(per_segment).map(|f| f.time_channel()).collect();
    Recording::plausible(records.len().div_ceil(per_segment) as u64, per_segment as u64)?;
    let mut segments = Vec::new();
    for group in records.chunks(per_segment) {
        if group.len() < per_segment {
            let wanted = format!("{per_segment} records of the last segment");
            return Err(RecordingError::Truncated { wanted });
        }
        let length = group.first().map_or(0, |f| f.ordinate.len());
        if let Some(other) = group.iter().find(|f| f.ordinate.len() != length) {
            let found = other.ordinate.len();
            return Err(RecordingError::Ragged { line: other.line, found, wanted: length });
        }
        if let Some((other, wanted)) =
            group.iter().zip(&channels).find(|(f, channel)| f.time_channel() != **channel)
        {
            let fault = format!(
                "this record of channel \"{}\" has another quantity, DOF or unit than that of the first segment; \
                 export all segments alike",
                wanted.name
            );
            return Err(RecordingError::Header { line: other.line, fault });
        }
        if let (Some(wanted), Some((other, found))) = (
            rate(first),
            group
                .iter()
                .filter_map(|f| Some((f, rate(f)?)))
                .find(|(_, r)| differs(*r, rate(first))),
        ) {
            let fault = format!(
                "this record was sampled at {found} Hz and the first one at {wanted} Hz; export all records at one rate"
            );
            return Err(RecordingError::Header { line: other.line, fault });
        }
        segments.push(Segment(group.iter().map(|f| f.time_samples()).collect()));
    }
    let declared =
        rate(first).map(|hz| DeclaredRate { hz, uncertainty: 0.0, entry: "the abscissa" });
    let source = Source { format: "universal file", ..Source::default() };
    Ok(Recording { source, declared, channels, segments, ..Recording::default() })
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
        Channel { name: name.trim().to_owned(), unit: unit.to_owned(), factor, fault: None }
    }
}

/// Whether two rates are different.
fn differs(rate: f64, first: Option<f64>) -> bool {
    first.is_some_and(|first| (rate / first - 1.0).abs() > EQUAL_RATES)
}

/// The sampling rate of an even abscissa, Hz.
fn rate(function: &Function) -> Option<f64> {
    let (first, last) = (function.abscissa.first()?, function.abscissa.last()?);
    let steps = function.abscissa.len().checked_sub(1)?;
    let rate = steps as f64 / (last - first);
    (rate.is_finite() && rate > 0.0).then_some(rate)
}
