//! Grades a hit: decides whether it is good enough to be averaged.
//!
//! Each grading is a function below that adds its findings; [`HitGrader::grade`] runs them all. The
//! [policy](crate::layout::HitPolicy) of the test decides the consequence of a finding.
//!
//! Only a few numbers of a record are stored; the record is read two to three times instead.

mod channel;
mod force;
mod long;
mod plateau;
#[cfg(test)]
mod tests;

pub use channel::ChannelRange;
pub use long::grade_long;

use channel::{Extreme, Survey};
use plateau::{Push, flat_top};

use super::chain::HAMMER;
use super::record::rest_scans;
use super::{AdcProperties, CHANNELS, Calibration, PRE_TRIGGER_SCANS, Record, Samples};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Subject};
use crate::layout::{HitPolicy, TestSettings};
use crate::real::Real;
use crate::units::{MetersPerSecondSquared, Newtons};

/// What a hit in the suspension profile is judged by: how hard it was, how still the object hung, and whether the
/// record is long enough.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Swing {
    /// Impulse of the force, N s.
    pub impulse: f32,
    /// Standard deviation of the response that moved most before the hit, relative to the largest peak; 0 where none
    /// moved by more than its noise.
    pub rest: f32,
    /// The largest response at the end of the record, under the window, relative to the largest peak.
    pub remainder: f32,
}

/// Result of grading one hit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct HitReport {
    /// Largest force above the rest value.
    pub peak_force: Newtons,
    /// Largest magnitude of any response relative to its rest value.
    pub peak_acceleration: MetersPerSecondSquared,
    /// What a hit with a long record is judged by.
    pub swing: Option<Swing>,
    /// The findings with their deciding numbers, about channels or about the force as a whole.
    pub findings: Diagnostics,
    /// Fingerprint that distinguishes this record from others.
    pub fingerprint: u32,
}

impl HitReport {
    /// True when the hit may be averaged.
    pub fn good(&self) -> bool {
        !self.findings.iter().any(Diagnostic::is_error)
    }
}

/// Grades the complete record of a hit on the rig; `last` is the fingerprint of the previous hit.
///
/// The rest value of a sensor may include gravity, so an overload is assumed from the range minus 1 g, less 2
/// %, relative to the rest value: 14.7 g of 16 g.
pub fn grade(
    record: &Record,
    adc: &AdcProperties,
    calibration: &Calibration,
    test: &TestSettings<f32>,
    last: Option<u32>,
) -> HitReport {
    let mut ranges = [ChannelRange::<f32>::EMPTY; CHANNELS];
    for (channel, range) in ranges.iter_mut().enumerate() {
        *range = ChannelRange::of_rig(adc, calibration, channel);
    }
    let in_use = ranges.get(..=adc.responses()).unwrap_or(&ranges);
    let rate = adc.rate.0;
    HitGrader { ranges: in_use, rate, pre_trigger: PRE_TRIGGER_SCANS, test, last }.grade(record)
}

/// A clipped signal stays within 2 % of the clipping level, despite noise and the filter after the sensor.
const RANGE_MARGIN: f32 = 0.02;
/// Largest noise of an ADXL326 with 10 nF, four standard deviations by specification, m/s²: 0.04 g.
const SENSOR_NOISE: f32 = 0.04 * crate::units::STANDARD_GRAVITY as f32;

impl ChannelRange<f32> {
    const EMPTY: Self =
        Self { scale: 0.0, rails: [0.0; 2], range: 0.0, resolution: 0.0, noise: 0.0 };

    /// Range of a channel of the rig.
    fn of_rig(adc: &AdcProperties, calibration: &Calibration, channel: usize) -> Self {
        let scale = calibration.per_code(adc, channel);
        let sensor = calibration.sensor_range - crate::units::STANDARD_GRAVITY as f32;
        let (range, noise) = match channel {
            HAMMER => (f32::INFINITY, 0.0),
            _ => (sensor * (1.0 - RANGE_MARGIN), SENSOR_NOISE),
        };
        let rails = [0.0, f32::from(adc.full_scale())];
        Self { scale, rails, range, resolution: scale.abs(), noise }
    }
}

/// Grades the hits of one test.
///
/// It can also grade the signals of another rig; use [`grade`] for a record of this one.
///
/// ```
/// # use massline_shared::diagnosis::Code;
/// # use massline_shared::layout::TestSettings;
/// # use massline_shared::signal::{ChannelRange, HitGrader};
/// // A half sine of 4 ms that does not reach the least force of a hit, and a ringing response.
/// let sine = |n: usize| (std::f64::consts::PI * (n as f64 - 80.0) / 16.0).sin();
/// let force: Vec<f64> = (0..2048).map(|n| if (80..96).contains(&n) { 5.0 * sine(n) } else { 0.0 }).collect();
/// let response: Vec<f64> =
///     (0..2048).map(|n| if n < 80 { 0.0 } else { (-0.01 * (n - 80) as f64).exp() }).collect();
/// let range =
///     ChannelRange { scale: 1.0, rails: [-1e3, 1e3], range: 150.0, resolution: 0.0, noise: 0.0 };
/// let test = TestSettings::default();
/// let grader =
///     HitGrader { ranges: &[range; 2], rate: 4000.0, pre_trigger: 80, test: &test, last: None };
/// let report = grader.grade(&[force.as_slice(), response.as_slice()]);
/// assert!(!report.good());
/// assert_eq!(report.findings[0].code, Code::TooWeak);
/// assert!((report.peak_force.0 - 5.0).abs() < 1e-3);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct HitGrader<'a, R> {
    /// Ranges of the channels in use, the hammer first.
    pub ranges: &'a [ChannelRange<R>],
    /// Scans per second.
    pub rate: R,
    /// Number of scans in a record before the hit.
    pub pre_trigger: usize,
    /// Settings of the test: band, windows, smallest peak force and policy.
    pub test: &'a TestSettings<R>,
    /// Fingerprint of the previous hit.
    pub last: Option<u32>,
}

/// Above this share of its range a channel may clip at the next hit: a person's hits vary by a tenth.
const NEAR_RANGE: f64 = 0.9;
/// Below this level at the top of the band, dB, the force hardly excites it.
const LOWEST_SPECTRUM: f64 = -20.0;
/// Above this ratio of the standard deviation before the hit to the peak, a channel is not quiet.
const NOT_QUIET: f64 = 0.02;
/// Above this ratio of the force at the end of the record to its peak, the hammer is still in contact.
const FORCE_LEFT: f64 = 0.05;
/// Above this ratio of the windowed response at the end of the record to its peak, the response is cut off.
const RESPONSE_LEFT: f64 = 0.1;
/// Smallest number of scans before the hit that determines the rest value.
const FEWEST_PRE_TRIGGER: usize = 16;

impl<R: Real> HitGrader<'_, R> {
    /// Grades a complete record.
    pub fn grade<D: Samples<R> + ?Sized>(&self, record: &D) -> HitReport {
        let mut findings = Findings { policy: self.test.policy, list: Diagnostics::new() };
        let (mut force, mut push) = (None, None);
        let mut whole = true;
        let mut largest = LargestValues::default();
        for (channel, range) in self.ranges.iter().enumerate() {
            let survey = Survey::of(record, channel, range.scale, rest_scans(self.pre_trigger));
            let overloaded =
                overload(&mut findings, record, channel, range, &survey, push.as_ref());
            if !overloaded {
                largest.share.offer(channel, share_of_range(channel, range, &survey));
            }
            if channel == HAMMER {
                push = Some(Push::of(record, range.scale, &survey));
                force = Some(survey);
                whole = !overloaded;
                continue;
            }
            largest.peak.offer(channel, survey.peak());
            largest.end.offer(channel, survey.end_spread);
            if survey.spread > range.noise {
                largest.spread.offer(channel, survey.spread);
            }
        }
        too_hard(&mut findings, largest.share);
        if let Some(force) = &force {
            self.force(&mut findings, record, force, whole);
            not_quiet(&mut findings, force, &largest);
            self.clipped(&mut findings, record.scans(), force, &largest);
        }
        if self.pre_trigger < FEWEST_PRE_TRIGGER {
            findings.add(Code::TriggerTooEarly, Subject::Whole, self.pre_trigger as f32);
        }
        let fingerprint = fingerprint(record);
        if self.last == Some(fingerprint) {
            findings.add(Code::DuplicateHit, Subject::Whole, 0.0);
        }
        HitReport {
            peak_force: Newtons(force.map_or(0.0, |force| force.highest.value.to_f32())),
            peak_acceleration: MetersPerSecondSquared(largest.peak.value.to_f32()),
            swing: None,
            findings: findings.list,
            fingerprint,
        }
    }

    /// Checks for a force that is too weak, lacks the top of the band, or has two peaks. Peaks are compared
    /// only when the force is `whole`, that is, not clipped.
    fn force<D: Samples<R> + ?Sized>(
        &self,
        findings: &mut Findings,
        record: &D,
        force: &Survey<R>,
        whole: bool,
    ) {
        let peak = force.highest.value;
        if peak < self.test.min_peak_force_n {
            findings.add(Code::TooWeak, Subject::Whole, peak.to_f32());
        }
        let scale = self.ranges.first().map_or_else(R::one, |range| range.scale);
        let second = force::second_peak(record, scale, force);
        if whole && second > R::zero() {
            findings.add(Code::DoubleHit, Subject::Whole, second.to_f32());
        }
        let half_width = (self.test.force_window_s * self.rate).to_f64() as usize;
        let top = self.test.expected_band()[1];
        let drop = force::spectrum_drop(record, force, half_width, top, self.rate);
        if let Some(drop) = drop.filter(|&drop| drop < R::of(LOWEST_SPECTRUM)) {
            findings.add(Code::ForceSpectrumLow, Subject::Whole, drop.to_f32());
        }
    }

    /// Checks whether the record ends before the contact is over or before the windowed response has decayed.
    fn clipped(
        &self,
        findings: &mut Findings,
        scans: usize,
        force: &Survey<R>,
        largest: &LargestValues<R>,
    ) {
        let peak = force.highest.value;
        if peak > R::zero() && force.end_mean > peak * R::of(FORCE_LEFT) {
            findings.about_channel(Code::ClippedRecord, HAMMER, (force.end_mean / peak).to_f32());
            return;
        }
        let duration = R::of(scans.saturating_sub(force.highest.at) as f64) / self.rate;
        let left = largest.end.value * (-self.test.exponential_decay * duration).exp();
        if left > largest.peak.value * R::of(RESPONSE_LEFT) {
            let left = left / largest.peak.value;
            findings.about_channel(Code::ClippedRecord, largest.end.channel, left.to_f32());
        }
    }
}

/// Findings with the severity given by the policy.
struct Findings {
    policy: HitPolicy,
    list: Diagnostics,
}

impl Findings {
    fn about_channel(&mut self, code: Code, channel: usize, value: f32) {
        self.add(code, Subject::channel(channel), value);
    }

    fn add(&mut self, code: Code, subject: Subject, value: f32) {
        let severity = self.policy.treatment(code).severity();
        // There is room for ten overloaded channels and one finding of every other code, which never all
        // occur together. More overloaded channels of other recorders are not named.
        let overloads = self.list.iter().filter(|other| other.code == Code::Overload).count();
        if code == Code::Overload && overloads >= CHANNELS {
            return;
        }
        let _ = self.list.push(Diagnostic::about(code, severity, subject, value));
    }
}

/// A value with the channel that has it.
#[derive(Clone, Copy)]
struct WorstChannel<R> {
    channel: usize,
    value: R,
}

impl<R: Real> WorstChannel<R> {
    fn none() -> Self {
        Self { channel: HAMMER, value: R::zero() }
    }

    fn offer(&mut self, channel: usize, value: R) {
        if value > self.value {
            *self = Self { channel, value };
        }
    }
}

/// The largest values over all responses; `share` includes the hammer.
struct LargestValues<R> {
    peak: WorstChannel<R>,
    /// Standard deviation before the hit, for channels where it exceeds the noise.
    spread: WorstChannel<R>,
    /// Standard deviation at the end of the record.
    end: WorstChannel<R>,
    /// Ratio of the extreme to the range.
    share: WorstChannel<R>,
}

impl<R: Real> Default for LargestValues<R> {
    fn default() -> Self {
        let none = WorstChannel::none();
        Self { peak: none, spread: none, end: none, share: none }
    }
}

/// Checks, for a response with the force, whether the converter is at a rail, the sensor
/// at the end of its range, or the signal on a plateau because an earlier stage clipped it.
///
/// A sensor clips at the end of its range. Relative to the rest value, that level depends on the gravity in
/// the rest value and on the true gain. So an overload is assumed from the distance that is certain for any
/// direction of gravity, or below it from a flat top.
fn overload<R: Real, D: Samples<R> + ?Sized>(
    findings: &mut Findings,
    record: &D,
    channel: usize,
    range: &ChannelRange<R>,
    survey: &Survey<R>,
    push: Option<&Push<R>>,
) -> bool {
    let clipped = |extreme: &Extreme<R>| {
        let [low, high] = range.rails;
        extreme.reading <= low
            || extreme.reading >= high
            || extreme.value.abs() >= range.range
            || flat_top(record, channel, range, survey, extreme, push)
    };
    let mut worst: Option<R> = None;
    for extreme in [survey.highest, survey.lowest] {
        if clipped(&extreme) && worst.is_none_or(|worst| extreme.value.abs() > worst.abs()) {
            worst = Some(extreme.value);
        }
    }
    if let Some(value) = worst {
        findings.about_channel(Code::Overload, channel, value.to_f32());
    }
    worst.is_some()
}

/// Largest ratio of an extreme to the distance from the rest value to range or rail; 0 when neither is known.
/// For the hammer, only the push counts.
fn share_of_range<R: Real>(channel: usize, range: &ChannelRange<R>, survey: &Survey<R>) -> R {
    let share = |extreme: &Extreme<R>| {
        let rail = if extreme.reading > survey.rest { range.rails[1] } else { range.rails[0] };
        let room = ((rail - survey.rest) * range.scale).abs().min(range.range);
        if room > R::zero() { extreme.value.abs() / room } else { R::zero() }
    };
    let push = share(&survey.highest);
    if channel == HAMMER { push } else { push.max(share(&survey.lowest)) }
}

fn too_hard<R: Real>(findings: &mut Findings, share: WorstChannel<R>) {
    if share.value >= R::of(NEAR_RANGE) {
        findings.about_channel(Code::TooHard, share.channel, share.value.to_f32());
    }
}

/// Checks for motion before the hit: force and responses each against their own peak, the responses against
/// the largest of all.
fn not_quiet<R: Real>(findings: &mut Findings, force: &Survey<R>, largest: &LargestValues<R>) {
    let hammer = WorstChannel { channel: HAMMER, value: force.spread };
    for (unrest, peak) in [(hammer, force.highest.value), (largest.spread, largest.peak.value)] {
        if peak > R::zero() && unrest.value > peak * R::of(NOT_QUIET) {
            let share = unrest.value / peak;
            findings.about_channel(Code::PreTriggerNotQuiet, unrest.channel, share.to_f32());
            return;
        }
    }
}

/// FNV-1a (Fowler, Noll, Vo) over the readings of the hammer and the first response in single precision.
/// Noise makes two hits differ.
fn fingerprint<R: Real, D: Samples<R> + ?Sized>(record: &D) -> u32 {
    const OFFSET: u32 = 0x811c_9dc5;
    const PRIME: u32 = 0x0100_0193;
    let bits = record.readings(HAMMER, 0).chain(record.readings(HAMMER + 1, 0));
    bits.fold(OFFSET, |hash, reading| {
        let bits = reading.to_f32().to_bits();
        // Exponent and leading digits of a code are in the upper half.
        (hash ^ bits ^ (bits >> 16)).wrapping_mul(PRIME)
    })
}
