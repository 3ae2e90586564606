//! Finds the force channel, the sampling rate and the hits of a recording.

use massline_shared::signal::{CHANNELS, EdgeTrigger};

use super::{CutHit, MOST_HITS, Options};
use crate::error::{Error, Result};
use crate::recording::{Channel, Recording, Segment};
use crate::units::force_unit;

/// A segment with fewer samples than this is rejected.
const SHORTEST: usize = 32;
/// Number of samples at the start of a segment whose mean is the zero level of its force.
const FIRST: usize = 8;

/// The channels in the order of grading: the force, then the responses.
pub(super) fn channel_order(recording: &Recording, options: &Options) -> Result<Vec<usize>> {
    let left_out = options.leave_out.iter().map(|column| recording.named(column));
    let left_out = left_out.collect::<Result<Vec<_>>>()?;
    let used: Vec<usize> =
        (0..recording.channels.len()).filter(|k| !left_out.contains(k)).collect();
    let force = match &options.force {
        Some(wanted) => {
            let force = recording.named(wanted)?;
            no_other_force(recording, &used, force, options)?;
            force
        }
        None => found(recording, &used)?,
    };
    if !used.contains(&force) {
        let message = "the column of the force is left out; leave out another one";
        return Err(Error::input("force_left_out", message));
    }
    let count = used.len();
    if count < 2 {
        return Err(Error::input(
            "no_response",
            "there is one channel; force and at least one response are needed",
        ));
    }
    if count > CHANNELS {
        let message = format!(
            "there are {count} channels; at most {CHANNELS} are graded together: leave some out with \
             --leave-out COLUMN, or export fewer"
        );
        return Err(Error::input("too_many_channels", message));
    }
    Ok([force].into_iter().chain(used.into_iter().filter(|&k| k != force)).collect())
}

/// Refuses a second channel that is a force: by its unit or, where none is stated, by its name.
fn no_other_force(
    recording: &Recording,
    used: &[usize],
    force: usize,
    options: &Options,
) -> Result<()> {
    let stated = options.units.iter().filter_map(|of| recording.named(&of.column).ok());
    let stated: Vec<usize> = stated.collect();
    let is_other = |&k: &usize| {
        let of_force = |channel: &Channel| match channel.unit.as_str() {
            "" => channel.factor.is_none() && is_named_force(channel),
            unit => force_unit(unit).is_some(),
        };
        k != force && !stated.contains(&k) && recording.channels.get(k).is_some_and(of_force)
    };
    let Some(other) = used.iter().copied().find(is_other) else { return Ok(()) };
    let column = match recording.channels.get(other).map(|channel| channel.name.as_str()) {
        Some(name) if !name.is_empty() => name.to_owned(),
        _ => (other + 1).to_string(),
    };
    let message = format!(
        "channel {} is a force as well by its name or unit, and the responses are accelerations: leave it out with \
         --leave-out \"{column}\", or state its unit with --unit \"{column}=g\"",
        other + 1
    );
    Err(Error::input("several_forces", message))
}

/// True for a channel with the name of a force.
fn is_named_force(channel: &Channel) -> bool {
    let name = channel.name.to_lowercase();
    ["force", "hammer", "kraft"].iter().any(|word| name.contains(word))
}

/// The channel among those used whose name or unit is that of a force; the first one when no channel has a name.
fn found(recording: &Recording, used: &[usize]) -> Result<usize> {
    let channels = &recording.channels;
    let is_force =
        |channel: &Channel| is_named_force(channel) || force_unit(&channel.unit).is_some();
    let forces = used.iter().copied().filter(|&k| channels.get(k).is_some_and(is_force));
    match forces.collect::<Vec<_>>()[..] {
        [force] => return Ok(force),
        [] => {}
        _ => {
            let message = format!(
                "several channels are forces by their names or units; the recording has {}: say which is the \
                 hammer with --force, and leave the others out with --leave-out",
                recording.list()
            );
            return Err(Error::input("several_forces", message));
        }
    }
    if let Some(&first) = used.first()
        && channels.iter().all(|channel| channel.name.is_empty())
    {
        return Ok(first);
    }
    let message = format!(
        "no channel is a force by its name or unit; the recording has {}: say which with --force",
        recording.list()
    );
    Err(Error::input("no_force", message))
}

/// Sampling rate, Hz.
pub(super) fn rate(recording: &Recording, options: &Options) -> Result<f64> {
    let rate = options.rate_hz.or(recording.rate_hz).filter(|rate| rate.is_finite() && *rate > 0.0);
    rate.ok_or_else(|| {
        Error::input(
            "no_rate",
            "the recording does not state its sampling rate; give it with --rate-hz",
        )
    })
}

/// A warning when the rate in use is not that of the file.
pub(super) fn other_rate(recording: &Recording, used: f64) -> Option<String> {
    let said = recording.rate_hz?;
    // A rate in a text file has at least six digits.
    let same = (said - used).abs() <= 1e-5 * used;
    (!same).then(|| format!("the file states {said} Hz, using {used} Hz from --rate-hz"))
}

/// One hit per segment, or the hits that the trigger finds in a single segment.
pub(super) fn hits(
    recording: &Recording,
    order: &[usize],
    rate: f64,
    options: &Options,
) -> Result<Vec<CutHit>> {
    let hits = match recording.segments.as_slice() {
        [whole] if begins_with_a_hit(whole, order, rate, options) => {
            vec![segmented(0, whole, order, rate, options)?]
        }
        [whole] => continuous(whole, order, rate, options),
        segments => {
            let mut hits = Vec::new();
            for (k, segment) in segments.iter().enumerate() {
                hits.push(segmented(k, segment, order, rate, options)?);
            }
            hits
        }
    };
    if hits.is_empty() {
        let message = format!(
            "no hit of {} N or more after {} s of quiet was found; lower --trigger-n or \
             --pre-trigger-s, or say with --force which channel is the force",
            options.test.trigger_n, options.pre_trigger_s
        );
        return Err(Error::input("no_hit", message));
    }
    if hits.len() > MOST_HITS {
        let message = format!(
            "the recording has {} hits of {} N or more; at most {MOST_HITS} are compared with each \
             other: raise --trigger-n, or grade it in parts",
            hits.len(),
            options.test.trigger_n
        );
        return Err(Error::input("too_many_hits", message));
    }
    Ok(hits)
}

fn segmented(
    k: usize,
    segment: &Segment,
    order: &[usize],
    rate: f64,
    options: &Options,
) -> Result<CutHit> {
    let samples = segment.samples();
    if samples < SHORTEST {
        let message = format!("segment {k} has {samples} samples; a hit needs at least {SHORTEST}");
        return Err(Error::input("recording_too_short", message));
    }
    let channels = channels_of(segment, order, 0..samples);
    let force = channels.first().map_or(&[][..], Vec::as_slice);
    // If the force never reaches the level, the grading rejects the hit as too weak.
    let touch = touch(force, options.test.trigger_n).unwrap_or(samples / 2);
    Ok(CutHit { segment: k, start_s: touch as f64 / rate, pre_trigger: touch, channels })
}

/// The first sample at which a force is this much above its rest: the mean of its first samples, half of those
/// before the contact at most.
fn touch(force: &[f64], trigger_n: f64) -> Option<usize> {
    let above = |rest: f64| force.iter().position(|&f| f >= rest + trigger_n);
    let first = above(*force.first()?)?;
    let quiet = force.get(..(first / 2).clamp(1, FIRST)).unwrap_or_default();
    above(quiet.iter().sum::<f64>() / quiet.len().max(1) as f64)
}

/// True for the record of one triggered hit: it is not longer than two records, and its force rises before a
/// continuous recording would have been quiet for long enough.
fn begins_with_a_hit(whole: &Segment, order: &[usize], rate: f64, options: &Options) -> bool {
    let force = order.first().and_then(|&k| whole.0.get(k)).map_or(&[][..], Vec::as_slice);
    let early = |touch: usize| (touch as f64) < options.pre_trigger_s * rate;
    let short = whole.samples() as f64 <= 2.0 * (options.pre_trigger_s + options.record_s) * rate;
    short && touch(force, options.test.trigger_n).is_some_and(early)
}

fn continuous(whole: &Segment, order: &[usize], rate: f64, options: &Options) -> Vec<CutHit> {
    let scans = |seconds: f64| (seconds * rate).round().max(0.0) as usize;
    let before = scans(options.pre_trigger_s).max(1);
    let length = scans(options.record_s).max(before.saturating_add(SHORTEST));
    let force = order.first().and_then(|&k| whole.0.get(k)).map_or(&[][..], Vec::as_slice);
    let mut hits: Vec<CutHit> = Vec::new();
    let mut trigger = EdgeTrigger::new(options.test.trigger_n, before);
    let mut end = 0;
    for (n, &sample) in force.iter().enumerate() {
        if n == end {
            trigger.arm();
        }
        if !trigger.feed(sample) {
            continue;
        }
        let start = n.saturating_sub(before);
        end = start.saturating_add(length).min(force.len());
        hits.push(CutHit {
            segment: hits.len(),
            start_s: n as f64 / rate,
            pre_trigger: n - start,
            channels: channels_of(whole, order, start..end),
        });
    }
    hits
}

fn channels_of(segment: &Segment, order: &[usize], range: std::ops::Range<usize>) -> Vec<Vec<f64>> {
    let samples = |&k: &usize| {
        segment.0.get(k).and_then(|c| c.get(range.clone())).unwrap_or_default().to_vec()
    };
    order.iter().map(samples).collect()
}
