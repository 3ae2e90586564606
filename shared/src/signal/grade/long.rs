//! Grades a hit with a long record: a push of the suspension modes.

use super::channel::Survey;
use super::{
    ChannelRange, Findings, HitReport, LargestValues, Swing, fingerprint, force, overload,
    rest_scans, too_hard,
};
use crate::diagnosis::{Code, Diagnostics, Subject};
use crate::layout::TestSettings;
use crate::signal::chain::HAMMER;
use crate::signal::{
    AdcProperties, Calibration, FullRateExtremes, LongRecordAnalysis, PRE_TRIGGER_SCANS, Record,
};
use crate::units::{MetersPerSecondSquared, Newtons, ScanIndex};

/// Largest standard deviation of the rows of an ADXL326 at rest, m/s²: 4 mg, twice what its noise of 300 µg/√Hz and its
/// 1/f noise make in 25 Hz.
const ROW_NOISE: f32 = 0.004 * crate::units::STANDARD_GRAVITY as f32;
/// Ratio of the standard deviation before the hit to the peak from which the object swings too much: as large an error
/// of a shape as 3 mm at the mark.
const SWINGS: f32 = 0.01;
/// Ratio of the windowed response at the end of the record to its peak above which the response is cut off: the modal
/// methods have no answer then.
const LEFT: f32 = 0.01;
/// Ratio of the force after the first half second to the peak that is a second push.
const LATE_PUSH: f32 = 0.1;

/// Grades the complete long record of the hit that triggered at this scan; `last` is the fingerprint of the previous
/// hit.
///
/// It is judged by its impulse, by rest before it, and by what is left at the end; a response is clipped when its code
/// was at the end of the range at the full rate, the force also when it is flat at its peak: an amplifier ends before the
/// converter does.
pub fn grade_long(
    record: &Record,
    (trigger, extremes): (ScanIndex, &FullRateExtremes),
    adc: &AdcProperties,
    calibration: &Calibration,
    test: &TestSettings<f32>,
    last: Option<u32>,
) -> HitReport {
    let mut findings = Findings { policy: test.policy, list: Diagnostics::new() };
    let rows = adc.of_rows();
    let survey = |channel: usize| {
        let scale = calibration.per_code(&rows, channel);
        Survey::of(record, channel, scale, rest_scans(PRE_TRIGGER_SCANS))
    };
    let mut largest = LargestValues::<f32>::default();
    for channel in HAMMER + 1..=adc.responses() {
        let response = survey(channel);
        let rest = response.rest / f32::from(adc.to_row_code());
        let share = share_of_range(adc, calibration, channel, rest, extremes.0[channel]);
        if share >= 1.0 {
            findings.about_channel(Code::Overload, channel, response.peak());
        } else {
            largest.share.offer(channel, share);
        }
        largest.peak.offer(channel, response.peak());
        largest.end.offer(channel, response.end_spread);
        if response.spread > ROW_NOISE {
            largest.spread.offer(channel, response.spread);
        }
    }
    let push = survey(HAMMER);
    overload(&mut findings, record, HAMMER, &range_of_force(adc, calibration), &push, None);
    too_hard(&mut findings, largest.share);
    let analysis = LongRecordAnalysis::<f32>::new(adc, calibration, test, trigger);
    let impulse = analysis.impulse(record);
    judge_impulse(&mut findings, impulse, test.impulse_ns);
    let late = late_push(adc, calibration, &push, extremes.0[HAMMER]);
    let scale = calibration.per_code(&rows, HAMMER);
    let second = force::second_peak(record, scale, &push).max(late);
    if second > 0.0 {
        findings.add(Code::DoubleHit, Subject::Whole, second);
    }
    // Where nothing has moved, nothing is left either.
    let share =
        |value: f32| if largest.peak.value > 0.0 { value / largest.peak.value } else { 0.0 };
    let rest = share(largest.spread.value);
    if rest > SWINGS {
        findings.about_channel(Code::PreTriggerNotQuiet, largest.spread.channel, rest);
    }
    let seconds = record.len().saturating_sub(PRE_TRIGGER_SCANS) as f32 / rows.rate.0;
    let window = libm::expf(-test.exponential_decay * seconds);
    let remainder = share(largest.end.value * window);
    if remainder > LEFT {
        findings.about_channel(Code::ClippedRecord, largest.end.channel, remainder);
    }
    let fingerprint = fingerprint::<f32, _>(record);
    if last == Some(fingerprint) {
        findings.add(Code::DuplicateHit, Subject::Whole, 0.0);
    }
    HitReport {
        peak_force: Newtons(push.highest.value),
        peak_acceleration: MetersPerSecondSquared(largest.peak.value),
        swing: Some(Swing { impulse, rest, remainder }),
        findings: findings.list,
        fingerprint,
    }
}

/// Largest ratio of an extreme at the full rate to the distance from the rest value to range or rail, at least 1 at the
/// end of it. Codes are those of the converter.
fn share_of_range(
    adc: &AdcProperties,
    calibration: &Calibration,
    channel: usize,
    rest: f32,
    [low, high]: [u16; 2],
) -> f32 {
    let range = ChannelRange::of_rig(adc, calibration, channel);
    let share = |code: f32, rail: f32| {
        let room = ((rail - rest) * range.scale).abs().min(range.range);
        if code == rail { 1.0 } else { ((code - rest) * range.scale).abs() / room }
    };
    share(low.into(), range.rails[0]).max(share(high.into(), range.rails[1]))
}

/// The range of the hammer's codes in the record, which have the resolution of rows and the steps of the converter.
fn range_of_force(adc: &AdcProperties, calibration: &Calibration) -> ChannelRange<f32> {
    let range = ChannelRange::of_rig(adc, calibration, HAMMER);
    let factor = f32::from(adc.to_row_code());
    let rails = range.rails.map(|rail| rail * factor);
    ChannelRange { scale: calibration.per_code(&adc.of_rows(), HAMMER), rails, ..range }
}

fn judge_impulse(findings: &mut Findings, impulse: f32, [least, most]: [f32; 2]) {
    if impulse < least {
        findings.add(Code::ImpulseTooSmall, Subject::Whole, impulse);
    } else if impulse > most {
        findings.add(Code::ImpulseTooLarge, Subject::Whole, impulse);
    }
}

/// The largest force after the record of the force has ended, relative to the peak; 0 when it is no push.
fn late_push(
    adc: &AdcProperties,
    calibration: &Calibration,
    push: &Survey<f32>,
    extremes: [u16; 2],
) -> f32 {
    let scale = calibration.per_code(adc, HAMMER);
    let rest = push.rest / f32::from(adc.to_row_code());
    let force = extremes.map(|code| (f32::from(code) - rest) * scale);
    let share = force[0].max(force[1]) / push.highest.value;
    if share > LATE_PUSH { share } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::tests::{ADC, hammer_code};
    use crate::signal::{CHANNELS, DECIMATION, RECORD_SCANS, Scan};
    use std::boxed::Box;
    use std::vec::Vec;

    /// A push and what follows.
    #[derive(Clone, Copy)]
    struct Push {
        peak: f32,
        scans: usize,
        /// Where an amplifier ends, N.
        end: f32,
        /// Acceleration of the ringing after it and before it, m/s², and its decay, 1/s.
        ringing: f32,
        before: f32,
        decay: f32,
        extremes: FullRateExtremes,
    }

    impl Push {
        fn good() -> Self {
            let mut extremes = [[1900, 2200]; CHANNELS];
            extremes[HAMMER] = [hammer_code(0.0), hammer_code(0.2)];
            let extremes = FullRateExtremes(extremes);
            let (peak, end) = (80.0, f32::INFINITY);
            Self { peak, scans: 80, end, ringing: 3.0, before: 0.0, decay: 0.2, extremes }
        }

        fn record(&self) -> Box<Record> {
            let calibration = Calibration::default();
            let mut record = Box::new(Record::new());
            for place in 0..RECORD_SCANS {
                let since = place as f32 - PRE_TRIGGER_SCANS as f32;
                let inside = (0.0..self.scans as f32).contains(&since);
                let phase = core::f32::consts::PI * since / self.scans as f32;
                let force = if inside { self.peak * phase.sin() } else { 0.0 }.min(self.end);
                let mut scan: Scan = [0; CHANNELS];
                scan[HAMMER] = hammer_code(force) << 4;
                let time = since / 50.0;
                let amplitude = if since < 0.0 {
                    self.before
                } else {
                    self.ringing * (-self.decay * time).exp()
                };
                for channel in 1..CHANNELS {
                    let per_code = calibration.per_code(&ADC.of_rows(), channel);
                    let value = amplitude * (19.0 * time + channel as f32).sin();
                    scan[channel] = (32_768.0 + value / per_code).round() as u16;
                }
                record.push(&scan);
            }
            record
        }

        fn report(&self) -> HitReport {
            let hit = (ScanIndex(10_000 * DECIMATION as u64), &self.extremes);
            let test = TestSettings::of_profile(crate::layout::TestProfile::Suspension);
            grade_long(&self.record(), hit, &ADC, &Calibration::default(), &test, None)
        }

        fn codes(&self) -> Vec<Code> {
            self.report().findings.iter().map(|finding| finding.code).collect()
        }
    }

    #[test]
    fn a_push_of_one_newton_second_is_good() {
        let report = Push::good().report();
        assert_eq!(report.findings, []);
        // A half sine: 2/π of the peak for 20 ms. The force is known to 0.03 N in each of 80 scans.
        let impulse = report.swing.unwrap().impulse;
        assert!((impulse - 80.0 * 0.02 * 2.0 / core::f32::consts::PI).abs() < 1e-3, "{impulse}");
        assert!((report.peak_acceleration.0 - 3.0).abs() < 0.1);
    }

    #[test]
    fn the_impulse_counts_and_not_the_peak() {
        assert_eq!(Push { peak: 20.0, scans: 20, ..Push::good() }.codes(), [Code::ImpulseTooSmall]);
        // As high as the good push, but a quarter as long.
        assert_eq!(Push { scans: 20, ..Push::good() }.codes(), [Code::ImpulseTooSmall]);
        assert_eq!(Push { scans: 120, ..Push::good() }.codes(), [Code::ImpulseTooLarge]);
        assert!(!Push { scans: 20, ..Push::good() }.report().good());
        assert!(Push { scans: 120, ..Push::good() }.report().good());
    }

    #[test]
    fn a_force_that_is_flat_at_its_peak_was_clipped() {
        // A half sine is above 90 % of its peak for 29 % of its time, and above half of it for 67 %.
        let report = Push { end: 72.0, ..Push::good() }.report();
        assert_eq!(report.findings[0].code, Code::Overload);
        assert_eq!(report.findings[0].subject, Subject::channel(HAMMER));
        assert!(!report.good());
        let beyond_the_converter = Push { peak: 200.0, scans: 60, ..Push::good() };
        assert!(beyond_the_converter.codes().contains(&Code::Overload));
    }

    #[test]
    fn swinging_before_and_after_is_named() {
        assert_eq!(Push { before: 0.1, ..Push::good() }.codes(), [Code::PreTriggerNotQuiet]);
        // Within the noise of a sensor.
        assert_eq!(Push { before: 0.03, ..Push::good() }.codes(), []);
        assert_eq!(Push { decay: 0.0, ..Push::good() }.codes(), [Code::ClippedRecord]);
    }

    #[test]
    fn what_only_the_full_rate_shows_is_named() {
        let with = |channel: usize, codes: [u16; 2]| {
            let mut push = Push::good();
            push.extremes.0[channel] = codes;
            push.codes()
        };
        assert_eq!(with(5, [0, 2200]), [Code::Overload]);
        assert_eq!(with(5, [1900, 4095]), [Code::Overload]);
        // 13.8 of 14.7 g.
        assert_eq!(with(5, [1900, 2048 + 1074]), [Code::TooHard]);
        assert_eq!(with(HAMMER, [hammer_code(0.0), hammer_code(30.0)]), [Code::DoubleHit]);
    }
}
