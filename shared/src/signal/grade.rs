//! Is this hit good enough to be averaged?
//!
//! Each grading is one function below that adds its findings; [`grade`] runs them all.

use super::chain::HAMMER;
use super::{AdcProperties, Calibration, PRE_TRIGGER_SCANS, Record};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::units::{MetersPerSecondSquared, Newtons};

/// Pre-trigger readings that make the rest value of a channel.
///
/// The last eighth is left out: the hammer touches before its force reaches the trigger level.
pub(super) const fn rest_scans(pre_trigger: usize) -> usize {
    pre_trigger - pre_trigger / 8
}

/// What was found about one hit.
#[derive(Clone, Debug, PartialEq)]
pub struct HitReport {
    /// Largest force, from rest.
    pub peak_force: Newtons,
    /// Largest magnitude of any response, from rest.
    pub peak_acceleration: MetersPerSecondSquared,
    /// What is wrong: [`Code::Overload`] about a channel (0 the hammer) with the force or
    /// acceleration that it shows, N or m/s²; [`Code::TooWeak`] with the peak force, N.
    pub findings: Diagnostics,
}

impl HitReport {
    /// True when the hit can be averaged.
    pub fn good(&self) -> bool {
        !self.findings.iter().any(Diagnostic::is_error)
    }

    fn reject(&mut self, code: Code, channel: usize, value: f32) {
        let finding = Diagnostic::about(code, Severity::Error, channel as u16, value);
        // A channel has one finding and the hit a few: they fit. A lost one leaves it rejected.
        let _ = self.findings.push(finding);
    }
}

/// Grades a complete record.
///
/// A sensor may feel gravity at rest, so 2 % less than its range less 1 g is an overload from rest:
/// 14.7 g of 16 g.
pub fn grade(
    record: &Record,
    adc: &AdcProperties,
    calibration: &Calibration,
    weakest_hit: Newtons,
) -> HitReport {
    let mut report = HitReport {
        peak_force: Newtons(0.0),
        peak_acceleration: MetersPerSecondSquared(0.0),
        findings: Diagnostics::new(),
    };
    for channel in 0..=adc.responses() {
        let extremes = Extremes::of(record, channel);
        let (highest, lowest) = extremes.span(calibration.per_code(adc, channel));
        if channel == HAMMER {
            report.peak_force = Newtons(highest);
        } else {
            let peak = &mut report.peak_acceleration.0;
            *peak = peak.max(highest).max(-lowest);
        }
        overload(&mut report, record, adc, calibration, channel, &extremes);
    }
    too_weak(&mut report, weakest_hit);
    report
}

/// Lowest, highest and rest code of a channel.
struct Extremes {
    low: u16,
    high: u16,
    rest: f32,
}

impl Extremes {
    fn of(record: &Record, channel: usize) -> Self {
        let (mut low, mut high, mut sum) = (u16::MAX, 0, 0_u32);
        for code in record.channel(channel).take(rest_scans(PRE_TRIGGER_SCANS)) {
            sum += u32::from(code);
        }
        record.channel(channel).for_each(|code| {
            low = low.min(code);
            high = high.max(code);
        });
        let rest = sum as f32 / rest_scans(PRE_TRIGGER_SCANS).min(record.len()).max(1) as f32;
        Self { low: low.min(high), high, rest }
    }

    /// Highest and lowest value from rest, in units.
    fn span(&self, per_code: f32) -> (f32, f32) {
        let a = (f32::from(self.high) - self.rest) * per_code;
        let b = (f32::from(self.low) - self.rest) * per_code;
        (a.max(b), a.min(b))
    }
}

/// The ADC stands at a rail, or the sensor at the end of its range.
///
/// A sensor that clips does not pass its range. Where that shows from rest depends on the gravity
/// that it feels at rest, and on its true gain. So it is overloaded when it comes as far from rest as
/// gravity leaves it for certain, or not quite so far with a flat top there.
fn overload(
    report: &mut HitReport,
    record: &Record,
    adc: &AdcProperties,
    calibration: &Calibration,
    channel: usize,
    extremes: &Extremes,
) {
    let per_code = calibration.per_code(adc, channel);
    let certain =
        (calibration.sensor_range - crate::STANDARD_GRAVITY as f32) * (1.0 - RANGE_MARGIN);
    let mut worst: Option<f32> = None;
    for code in [extremes.high, extremes.low] {
        let value = (f32::from(code) - extremes.rest) * per_code;
        let share = value.abs() / certain;
        let railed = code == 0 || code >= adc.full_scale();
        let clipped = channel != HAMMER
            && (share >= 1.0
                || (share >= FLAT_TOP_SHARE && flat_top(record, channel, code, per_code)));
        if (railed || clipped) && worst.is_none_or(|worst| value.abs() > worst.abs()) {
            worst = Some(value);
        }
    }
    if let Some(value) = worst {
        report.reject(Code::Overload, channel, value);
    }
}

/// Noise, and the filter after the sensor, keep a clipped signal within 2 % of where it clips.
const RANGE_MARGIN: f32 = 0.02;
/// From this share on a flat top is a clipped sensor: the gain of an uncalibrated ADXL326 is up to
/// 10 % less than nominal.
const FLAT_TOP_SHARE: f32 = 0.85;
/// Scans within [`FLAT_TOP_NOISE`] of the extreme that make a flat top. A half sine of 5 ms and
/// 12 g stays there for 0.3 ms, one or two scans at 4 kS/s.
const FLAT_TOP_SCANS: usize = 4;
/// Noise of a clipped signal about its end, m/s²: 0.04 g, four standard deviations of an ADXL326
/// with 10 nF; three codes at 12 bit.
const FLAT_TOP_NOISE: f32 = 0.04 * crate::STANDARD_GRAVITY as f32;

/// True when the channel stays at `extreme` for several scans.
fn flat_top(record: &Record, channel: usize, extreme: u16, per_code: f32) -> bool {
    let noise = (FLAT_TOP_NOISE / per_code.abs()) as u16;
    let mut run = 0;
    record.channel(channel).any(|code| {
        run = if code.abs_diff(extreme) <= noise { run + 1 } else { 0 };
        run >= FLAT_TOP_SCANS
    })
}

/// The force is too small for a response above the noise.
fn too_weak(report: &mut HitReport, weakest_hit: Newtons) {
    let peak = report.peak_force;
    if peak < weakest_hit {
        report.reject(Code::TooWeak, HAMMER, peak.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::signal::tests::{ADC, code};
    use crate::signal::{CHANNELS, RECORD_SCANS};
    use std::boxed::Box;
    use std::vec::Vec;

    const G: f32 = crate::STANDARD_GRAVITY as f32;

    /// A record of `value(channel, scan)` in N and m/s², as the rig's ADC would read it.
    fn record(value: impl Fn(usize, usize) -> f32) -> Box<Record> {
        let mut record = Box::new(Record::new());
        for i in 0..RECORD_SCANS {
            record.push(&core::array::from_fn(|k| code(k, value(k, i))));
        }
        record
    }

    fn graded(value: impl Fn(usize, usize) -> f32) -> HitReport {
        grade(&record(value), &ADC, &Calibration::default(), Newtons(8.0))
    }

    fn codes(report: &HitReport) -> Vec<(Code, u16)> {
        report.findings.iter().map(|f| (f.known_code().unwrap(), f.subject)).collect()
    }

    /// A half sine over scans 80 to 100.
    fn half_sine(peak: f32, i: usize) -> f32 {
        let t = i as f32 - 80.0;
        if (0.0..=20.0).contains(&t) {
            peak * (core::f32::consts::PI * t / 20.0).sin()
        } else {
            0.0
        }
    }

    /// A hit of 30 N to which channel 4 answers with `peak`, cut at `limit`.
    fn answered(peak: f32, limit: f32) -> HitReport {
        graded(|k, i| match k {
            HAMMER => half_sine(30.0, i),
            4 => half_sine(peak, i).clamp(-limit, limit),
            _ => half_sine(5.0, i),
        })
    }

    #[test]
    fn a_good_hit_has_no_findings_and_its_peaks() {
        let report = answered(-90.0, f32::MAX);
        assert!(report.good() && report.findings.is_empty());
        // Half a code: 0.016 N and 0.06 m/s².
        assert!((report.peak_force.0 - 30.0).abs() < 0.02);
        assert!((report.peak_acceleration.0 - 90.0).abs() < 0.07);
    }

    #[test]
    fn a_weak_hit_is_rejected() {
        let report = graded(|k, i| if k == HAMMER { half_sine(7.5, i) } else { 0.0 });
        assert_eq!(codes(&report), [(Code::TooWeak, 0)]);
        assert!(!report.good());
    }

    #[test]
    fn a_rail_at_either_end_of_any_channel_is_an_overload() {
        for channel in 0..CHANNELS {
            for value in [1e3, -1e3] {
                let report = graded(|k, i| match k {
                    k if k == channel && i == 90 => value,
                    HAMMER => half_sine(30.0, i),
                    _ => 0.0,
                });
                assert_eq!(codes(&report), [(Code::Overload, channel as u16)]);
                assert_eq!(report.findings[0].value > 0.0, value > 0.0);
            }
        }
    }

    #[test]
    fn a_channel_that_is_not_in_use_is_not_graded() {
        let adc = AdcProperties { channels: 7, ..ADC };
        let record =
            record(|k, i| if k == HAMMER { half_sine(30.0, i) } else { 1e3 * (k / 7) as f32 });
        let report = grade(&record, &adc, &Calibration::default(), Newtons(8.0));
        assert!(report.good(), "{report:?}");
        assert_eq!(report.peak_acceleration.0, 0.0);
    }

    #[test]
    fn a_sensor_that_clips_at_its_range_is_an_overload() {
        for sign in [1.0, -1.0] {
            assert_eq!(codes(&answered(sign * 25.0 * G, 16.0 * G)), [(Code::Overload, 4)]);
        }
    }

    #[test]
    fn a_sensor_that_feels_gravity_clips_nearer_to_rest() {
        // It stands at 1 g: 15 g more are its end, wherever its zero is.
        for sign in [1.0, -1.0] {
            assert_eq!(codes(&answered(sign * 25.0 * G, 15.0 * G)), [(Code::Overload, 4)]);
        }
    }

    #[test]
    fn a_sensor_that_clips_early_shows_by_its_flat_top() {
        // Its gain is 10 % less than its calibration says: it stops at 13.5 g from rest.
        assert_eq!(codes(&answered(16.0 * G, 13.5 * G)), [(Code::Overload, 4)]);
    }

    #[test]
    fn a_strong_hit_that_does_not_clip_is_good() {
        for peak in [14.5, 13.5, -14.5] {
            assert!(answered(peak * G, f32::MAX).good());
        }
    }
}
