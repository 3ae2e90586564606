//! What was understood of a recording: printed before it is used.

use crate::output::counted;
use massline_files::recording::{
    Channel, LeftOut, Rate, RateSource, Recording, Scale, Source, UnitSource, column, six_digits,
};
use massline_report::document::{ColumnLeftOut, RecordedChannel, RecordingSummary};

/// What was understood of a recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Understanding {
    source: Source,
    /// Name and scale of each channel, the force first.
    channels: Vec<(String, Scale)>,
    rate: Rate,
    segments: usize,
    /// Samples of all segments.
    samples: usize,
    left_out: Vec<LeftOut>,
}

impl Understanding {
    pub(super) fn new(
        recording: &Recording,
        order: &[usize],
        scales: &[Scale],
        rate: Rate,
    ) -> Self {
        let name = |&k: &usize| {
            recording
                .channels
                .get(k)
                .map_or_else(String::new, |channel: &Channel| column(k, channel))
        };
        Self {
            source: recording.source,
            channels: order.iter().map(name).zip(scales.iter().cloned()).collect(),
            rate,
            segments: recording.segments.len(),
            samples: recording
                .segments
                .iter()
                .map(massline_files::recording::Segment::samples)
                .sum(),
            left_out: recording.left_out.clone(),
        }
    }

    /// One line for people.
    pub fn to_text(&self) -> String {
        let Source { format, encoding, separator, decimal } = self.source;
        let mut file = vec![format.to_owned()];
        file.extend(encoding.map(str::to_owned));
        file.extend(separator.map(|name| format!("separated by {name}")));
        file.extend(decimal.map(|decimal| format!("decimal {}", decimal.name())));
        let channels: Vec<String> = self
            .channels
            .iter()
            .enumerate()
            .map(|(n, (name, scale))| said(n, name, scale))
            .collect();
        let segments = if self.segments == 1 {
            String::new()
        } else {
            format!("{}, ", counted(self.segments, "segment"))
        };
        let duration = six_digits(self.samples as f64 / self.rate.hz);
        let mut text = format!(
            "{}; {}; {} Hz {}; {segments}{}, {duration} s",
            file.join(", "),
            channels.join(", "),
            six_digits(self.rate.hz),
            origin(&self.rate),
            counted(self.samples, "sample")
        );
        if !self.left_out.is_empty() {
            let left_out = self
                .left_out
                .iter()
                .map(|LeftOut { name, reason }| format!("\"{name}\" ({reason})"));
            text += &format!("; left out: {}", left_out.collect::<Vec<_>>().join(", "));
        }
        text
    }

    /// The same as JSON.
    pub fn to_json(&self) -> RecordingSummary {
        let Source { format, encoding, separator, decimal } = self.source;
        let channel = |(n, (name, scale)): (usize, &(String, Scale))| RecordedChannel {
            name: name.clone(),
            role: if n == 0 { "force" } else { "response" },
            unit: scale.unit.clone(),
            unit_source: name_of(scale.source),
            factor_to_si: scale.factor.abs(),
            reversed: scale.factor < 0.0,
        };
        let (time_column, time_unit, time_unit_assumed) = match &self.rate.source {
            RateSource::Column { name, unit, assumed } => {
                (Some(name.clone()), Some(unit.clone()), *assumed)
            }
            RateSource::Option | RateSource::Header(_) => (None, None, false),
        };
        RecordingSummary {
            format,
            encoding,
            separator,
            decimal: decimal.map(massline_files::recording::Decimal::name),
            channels: self.channels.iter().enumerate().map(channel).collect(),
            rate_hz: self.rate.hz,
            rate_source: match self.rate.source {
                RateSource::Option => "option",
                RateSource::Column { .. } => "time_column",
                RateSource::Header(_) => "header",
            },
            time_column,
            time_unit,
            time_unit_assumed,
            segments: self.segments,
            samples: self.samples,
            duration_s: self.samples as f64 / self.rate.hz,
            left_out: self
                .left_out
                .iter()
                .map(|LeftOut { name, reason }| ColumnLeftOut {
                    name: name.clone(),
                    reason: reason.clone(),
                })
                .collect(),
        }
    }
}

/// A channel as the line names it.
fn said(n: usize, name: &str, scale: &Scale) -> String {
    let role = if n == 0 { "force" } else { "response" };
    let reversed = if scale.factor < 0.0 { ", reversed" } else { "" };
    let source = match scale.source {
        UnitSource::File => "",
        UnitSource::UnitSystem => " by dataset 164",
        UnitSource::Option => " by --unit",
        UnitSource::Sensitivity => " by --sensitivity",
    };
    format!("{role} \"{name}\" in {}{source}{reversed}", scale.unit)
}

/// The name in JSON.
fn name_of(source: UnitSource) -> &'static str {
    match source {
        UnitSource::File => "file",
        UnitSource::UnitSystem => "unit_system",
        UnitSource::Option => "option",
        UnitSource::Sensitivity => "sensitivity",
    }
}

/// Where the rate comes from, in words.
pub(super) fn origin(rate: &Rate) -> String {
    match &rate.source {
        RateSource::Option => "from --rate-hz".into(),
        RateSource::Header(entry) => format!("from {entry}"),
        RateSource::Column { name, unit, assumed } => {
            let name = if name.is_empty() {
                "the first column".to_owned()
            } else {
                format!("the time column \"{name}\"")
            };
            let assumed = if *assumed { " (assumed)" } else { "" };
            format!("from {name} in {unit}{assumed}")
        }
    }
}
