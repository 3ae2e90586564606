//! Finds a hammer whose signal has the wrong sign: compression is negative in many front ends.

use massline_shared::signal::EdgeTrigger;

use super::Options;
use super::repeats::median;
use crate::{Error, Result};
use massline_files::recording::Segment;

/// How many times larger the negative pulses of a reversed hammer are than its positive ones.
const LARGER: f64 = 2.0;

/// Refuses a force whose pulses are negative. `force` is its place, `column` its name on the command line.
pub(super) fn check(
    segments: &[Segment],
    force: usize,
    column: &str,
    rate: f64,
    options: &Options,
) -> Result<()> {
    let samples = |segment: &Segment| segment.0.get(force).cloned().unwrap_or_default();
    let pulses = |sign: f64| -> Vec<f64> {
        match segments {
            [whole] => continuous(&samples(whole), sign, rate, options),
            segments => segments
                .iter()
                .filter_map(|segment| extreme(&samples(segment), sign, options.test.trigger_n))
                .collect(),
        }
    };
    let [positive, negative] = [1.0, -1.0].map(pulses);
    let peak = median(negative.clone());
    let is_reversed = negative.len() >= positive.len().max(1) && peak > LARGER * median(positive);
    if !is_reversed {
        return Ok(());
    }
    let is_turned =
        options.statements.reversed.iter().any(|name| name.eq_ignore_ascii_case(column));
    let message = if is_turned {
        format!(
            "turned by --reverse \"{column}\", the force has pulses of {:.0} N; leave this option out",
            -peak
        )
    } else {
        format!(
            "the force has pulses of {:.0} N: its polarity is reversed; turn it with --reverse \"{column}\"",
            -peak
        )
    };
    Err(Error::input("force_reversed", message))
}

/// The peaks of the pulses with this sign that the trigger finds.
fn continuous(force: &[f64], sign: f64, rate: f64, options: &Options) -> Vec<f64> {
    let scans = |seconds: f64| (seconds * rate).round().max(1.0) as usize;
    let mut trigger = EdgeTrigger::new(options.test.trigger_n, scans(options.pre_trigger_s));
    let mut end = 0;
    let mut peaks = Vec::new();
    for (n, sample) in force.iter().enumerate() {
        if n == end {
            trigger.arm();
        }
        if trigger.feed(sign * sample) {
            end = n.saturating_add(scans(options.record_s)).min(force.len());
            let pulse = force.get(n..end).unwrap_or_default();
            peaks.push(pulse.iter().fold(0.0, |peak: f64, sample| peak.max(sign * sample)));
        }
    }
    peaks
}

/// The largest deviation of a segment from its first sample to this side, if it reaches the trigger.
fn extreme(force: &[f64], sign: f64, trigger_n: f64) -> Option<f64> {
    let rest = force.first()?;
    let peak = force.iter().fold(0.0, |peak: f64, sample| peak.max(sign * (sample - rest)));
    (peak >= trigger_n).then_some(peak)
}
