//! Finds the force channel, the sampling rate and the hits of a recording.

use massline_shared::layout::HOST_SENSORS;
use massline_shared::signal::EdgeTrigger;

use super::{CutHit, MOST_HITS, Options};
use crate::{Error, Result};
use massline_files::recording::{
    EVERY_RESPONSE, LeftOutColumn, Rate, Recording, Segment, column, is_named_force, six_digits,
};
use massline_files::units::{Quantity, force_unit, motion_unit};

/// Most channels that are graded together: the hammer and the sensors of the largest layout.
const MOST_CHANNELS: usize = 1 + 3 * HOST_SENSORS;
/// A segment with fewer samples than this is rejected.
const SHORTEST: usize = 32;
/// Number of samples at the start of a segment whose mean is the zero level of its force.
const FIRST: usize = 8;

/// The channels in the order of grading: the force, then the responses. Channels that are neither are left out.
pub(super) fn channel_order(recording: &mut Recording, options: &Options) -> Result<Vec<usize>> {
    let left_out = left_out(recording, options)?;
    let candidates: Vec<usize> =
        (0..recording.channels.len()).filter(|k| !left_out.contains(k)).collect();
    let stated = options.force.as_deref().map(|wanted| recording.named(wanted)).transpose()?;
    let force = match stated {
        Some(force) => force,
        None => the_force(recording, &candidates, options)?,
    };
    if !candidates.contains(&force) {
        let message = "the column of the force is left out; leave out another one";
        return Err(Error::input("force_left_out", message));
    }
    let before = recording.left_out.len();
    let useful = recording.leave_out_other_units(Some(force), &options.statements, &candidates)?;
    let used: Vec<usize> = candidates.into_iter().filter(|k| useful.contains(k)).collect();
    no_other_force(recording, &used, force, options)?;
    let count = used.len();
    if count < 2 {
        return Err(no_response(recording.left_out.get(before..).unwrap_or_default()));
    }
    if count > MOST_CHANNELS {
        let message = format!(
            "there are {count} channels; at most {MOST_CHANNELS} are graded together: leave some out with \
             --leave-out COLUMN, or export fewer"
        );
        return Err(Error::input("too_many_channels", message));
    }
    Ok([force].into_iter().chain(used.into_iter().filter(|&k| k != force)).collect())
}

/// The channels that the user leaves out; a column that the reader has left out already may be among them.
fn left_out(recording: &mut Recording, options: &Options) -> Result<Vec<usize>> {
    let mut places = Vec::new();
    for wanted in &options.leave_out {
        let is_gone =
            recording.left_out.iter().any(|left_out| left_out.name.eq_ignore_ascii_case(wanted));
        match recording.named(wanted) {
            Ok(place) => places.push(place),
            Err(_) if is_gone || recording.is_time_column(wanted) => {}
            Err(error) => return Err(error),
        }
    }
    for &place in &places {
        let Some(channel) = recording.channels.get(place) else { continue };
        let name = column(place, channel);
        recording.left_out.push(LeftOutColumn { name, reason: "--leave-out".into() });
    }
    Ok(places)
}

/// The error of a recording without a response; `others` are the channels that have units of something else.
fn no_response(others: &[LeftOutColumn]) -> Error {
    if others.is_empty() {
        let message = "there is one channel; force and at least one response are needed";
        return Error::input("no_response", message);
    }
    let names: Vec<String> = others
        .iter()
        .map(|LeftOutColumn { name, reason }| format!("\"{name}\": {reason}"))
        .collect();
    let message = format!(
        "no channel is an acceleration ({}); state the unit of one with --unit COLUMN=UNIT, or export accelerations",
        names.join(", ")
    );
    Error::input("recording_unknown_unit", message)
}

/// Whether a channel is a force: by what the user states, else by its unit, else by its name.
fn is_force(recording: &Recording, k: usize, options: &Options) -> bool {
    let Some(channel) = recording.channels.get(k) else { return false };
    let is_meant =
        |column: &String| column != EVERY_RESPONSE && recording.named(column).ok() == Some(k);
    let statements = &options.statements;
    if let Some(stated) = statements.sensitivities.iter().rfind(|stated| is_meant(&stated.column)) {
        return stated.sensitivity.is_of_force();
    }
    let stated = statements
        .units
        .iter()
        .rfind(|stated| is_meant(&stated.column))
        .map(|stated| stated.unit.as_str());
    let unit = stated.unwrap_or(&channel.unit);
    let is_acceleration = motion_unit(unit, Quantity::Acceleration).is_some();
    force_unit(unit).is_some() || is_named_force(&channel.name) && !is_acceleration
}

/// Refuses a second channel that is a force: by its unit or, where none is stated, by its name.
fn no_other_force(
    recording: &Recording,
    used: &[usize],
    force: usize,
    options: &Options,
) -> Result<()> {
    let is_other = |&k: &usize| k != force && is_force(recording, k, options);
    let Some(other) = used.iter().copied().find(is_other) else { return Ok(()) };
    let column =
        recording.channels.get(other).map_or_else(String::new, |channel| column(other, channel));
    let message = format!(
        "channel {} is a force as well by its name or unit, and the responses are accelerations: leave it out with \
         --leave-out \"{column}\", or, if it is an acceleration, state its unit with --unit \"{column}=UNIT\"",
        other + 1
    );
    Err(Error::input("several_forces", message))
}

/// The channel among those used that is the force; the first one when no channel has a name.
fn the_force(recording: &Recording, used: &[usize], options: &Options) -> Result<usize> {
    let forces = used.iter().copied().filter(|&k| is_force(recording, k, options));
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
        && recording.channels.iter().all(|channel| channel.name.is_empty())
    {
        return Ok(first);
    }
    let message = format!(
        "no channel is a force by its name or unit; the recording has {}: say which with --force",
        recording.list()
    );
    Err(Error::input("no_force", message))
}

/// Refuses a rate that does not reach the end of the band.
pub(super) fn check_rate(rate: &Rate, options: &Options) -> Result<()> {
    let [_, high] = options.test.expected_band();
    if rate.hz.is_finite() && rate.hz > 2.0 * high {
        return Ok(());
    }
    let notes: String = rate.notes.iter().map(|note| format!("; {note}")).collect();
    let message = format!(
        "the rate of {} Hz ({}) reaches {} Hz, and the band ends at {high} Hz: check the unit of the time (state it \
         with --unit) or the rate (--rate-hz), or lower the HIGH of --band-hz{notes}",
        six_digits(rate.hz),
        rate.origin(),
        six_digits(0.5 * rate.hz)
    );
    Err(Error::input("rate_too_low", message))
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
        let force = order.first().copied().unwrap_or_default();
        let samples =
            recording.segments.iter().filter_map(|segment| segment.0.get(force)).flatten();
        let largest = samples.fold(0.0_f64, |most, sample| most.max(*sample));
        let message = format!(
            "no hit of {} N or more after {} s of quiet was found, and the largest force is {} N; check the unit of \
             the force, lower --trigger-n or --pre-trigger-s, or say with --force which channel is the force",
            options.test.trigger_n,
            options.pre_trigger_s,
            six_digits(largest)
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
