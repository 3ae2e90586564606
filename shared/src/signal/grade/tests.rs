//! Tests of grading with records as the rig takes them, and with other signals.

use super::*;
use crate::layout::HitTreatment;
use crate::signal::tests::{ADC, code};
use crate::signal::{CHANNELS, RECORD_SCANS};
use std::boxed::Box;
use std::vec::Vec;

const G: f32 = crate::units::STANDARD_GRAVITY as f32;

/// A record of `value(channel, scan)` in N and m/s², as digitised by the rig's ADC.
fn record(value: impl Fn(usize, usize) -> f32) -> Box<Record> {
    let mut record = Box::new(Record::new());
    for i in 0..RECORD_SCANS {
        record.push(&core::array::from_fn(|k| code(k, value(k, i))));
    }
    record
}

fn graded(value: impl Fn(usize, usize) -> f32) -> HitReport {
    graded_after(None, value)
}

fn graded_after(last: Option<u32>, value: impl Fn(usize, usize) -> f32) -> HitReport {
    let test = TestSettings::default();
    grade(&record(value), &ADC, &Calibration::default(), &test, last)
}

fn codes(report: &HitReport) -> Vec<(Code, Subject)> {
    report.findings.iter().map(|f| (f.code, f.subject)).collect()
}

/// A half sine from scan 80 to scan 100.
fn half_sine(peak: f32, i: usize) -> f32 {
    let t = i as f32 - 80.0;
    if (0.0..=20.0).contains(&t) { peak * (core::f32::consts::PI * t / 20.0).sin() } else { 0.0 }
}

/// A hit of 30 N with a response of the peak `peak` on channel 4, clipped at `limit`.
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
    // The tolerance covers half a code: 0.016 N and 0.06 m/s².
    assert!((report.peak_force.0 - 30.0).abs() < 0.02);
    assert!((report.peak_acceleration.0 - 90.0).abs() < 0.07);
}

#[test]
fn a_weak_hit_is_rejected() {
    let report = graded(|k, i| if k == HAMMER { half_sine(7.5, i) } else { 0.0 });
    assert_eq!(codes(&report), [(Code::TooWeak, Subject::Whole)]);
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
            assert_eq!(codes(&report), [(Code::Overload, Subject::channel(channel))]);
            assert_eq!(report.findings[0].value > 0.0, value > 0.0);
        }
    }
}

#[test]
fn a_channel_that_is_not_in_use_is_not_graded() {
    let adc = AdcProperties { channels: 7, ..ADC };
    let record = record(|k, i| if k == HAMMER { half_sine(30.0, i) } else { 1e3 * (k / 7) as f32 });
    let report = grade(&record, &adc, &Calibration::default(), &TestSettings::default(), None);
    assert!(report.good(), "{report:?}");
    assert_eq!(report.peak_acceleration.0, 0.0);
}

#[test]
fn a_sensor_that_clips_at_its_range_is_an_overload() {
    for sign in [1.0, -1.0] {
        assert_eq!(
            codes(&answered(sign * 25.0 * G, 16.0 * G)),
            [(Code::Overload, Subject::Channel(4))]
        );
    }
}

#[test]
fn a_sensor_that_feels_gravity_clips_nearer_to_rest() {
    // The rest value is 1 g, so the sensor is at its end 15 g from it, whatever its zero.
    for sign in [1.0, -1.0] {
        assert_eq!(
            codes(&answered(sign * 25.0 * G, 15.0 * G)),
            [(Code::Overload, Subject::Channel(4))]
        );
    }
}

#[test]
fn a_sensor_that_clips_early_shows_by_its_flat_top() {
    // The true gain is 10 % below the calibration, so the output stops at 13.5 g from the rest value.
    assert_eq!(codes(&answered(16.0 * G, 13.5 * G)), [(Code::Overload, Subject::Channel(4))]);
}

#[test]
fn a_strong_hit_that_does_not_clip_is_good() {
    for peak in [14.5, 13.5, -14.5] {
        assert!(answered(peak * G, f32::MAX).good());
    }
}

/// A hit with the force `force(scan)`, N, which every response follows with 5/30 m/s² per N.
fn tapped(force: impl Fn(usize) -> f32) -> HitReport {
    graded(|k, i| if k == HAMMER { force(i) } else { force(i) / 6.0 })
}

/// A half sine of the peak `peak` that starts at `start` and lasts `length` scans.
fn pulse(start: f32, length: f32, peak: f32, i: usize) -> f32 {
    let phase = (i as f32 - start) / length;
    if (0.0..=1.0).contains(&phase) { peak * (core::f32::consts::PI * phase).sin() } else { 0.0 }
}

#[test]
fn a_second_touch_is_a_double_hit_before_or_after_the_main_one() {
    // Pulses of 5 ms, 12 to 75 ms apart; the second is at least a seventh of the first.
    for (gap, share) in [(30.0, 0.15), (50.0, 0.5), (100.0, 0.9), (300.0, 0.2)] {
        for swapped in [false, true] {
            let (first, second) = if swapped { (share, 1.0) } else { (1.0, share) };
            let report = tapped(|i| {
                pulse(80.0, 20.0, 30.0 * first, i) + pulse(80.0 + gap, 20.0, 30.0 * second, i)
            });
            assert_eq!(
                codes(&report),
                [(Code::DoubleHit, Subject::Whole)],
                "{gap} {share} {swapped}"
            );
            // A code is 0.03 N of 30 N.
            assert!((report.findings[0].value - share).abs() < 5e-3, "{report:?}");
            assert!(!report.good());
        }
    }
}

#[test]
fn ringing_of_hammer_or_filter_is_no_double_hit() {
    // A damped oscillation of up to 30 % of the peak after the hit, at 250 Hz and at 1.2 kHz, that first goes
    // below the rest value like that of a filter.
    for per_scan in [0.39_f32, 1.9] {
        for size in [0.05, 0.15, 0.3] {
            let report = tapped(|i| {
                let t = (i as f32 - 100.0).max(0.0);
                // 12 N only: with more, the ringing would reach the lower rail, 4.4 N below the rest value.
                12.0 * (half_sine(1.0, i) - size * (per_scan * t).sin() * (-0.03 * t).exp())
            });
            assert!(
                !codes(&report).contains(&(Code::DoubleHit, Subject::Whole)),
                "{size} {report:?}"
            );
        }
    }
}

#[test]
fn a_shoulder_of_the_pulse_is_no_double_hit() {
    // Two overlapping pulses, between which the force does not fall below half.
    let report = tapped(|i| pulse(80.0, 20.0, 30.0, i) + pulse(92.0, 20.0, 20.0, i));
    assert!(report.good() && report.findings.is_empty(), "{report:?}");
}

#[test]
fn a_hit_near_the_end_of_a_range_warns() {
    // The hammer reads up to (3 V − 0.1 V) / 22.5 mV/N = 128.9 N, a sensor up to 14.7 g from its rest value.
    let report = tapped(|i| half_sine(120.0, i));
    assert_eq!(codes(&report), [(Code::TooHard, Subject::Channel(0))]);
    assert!(report.good() && (report.findings[0].value - 120.0 / 128.9).abs() < 1e-3);
    let report = answered(-13.6 * G, f32::MAX);
    assert_eq!(codes(&report), [(Code::TooHard, Subject::Channel(4))]);
    assert!(report.good() && (report.findings[0].value - 13.6 / 14.7).abs() < 1e-3);
    assert!(answered(13.0 * G, f32::MAX).findings.is_empty());
}

#[test]
fn a_flat_top_is_an_overload_wherever_it_was_clipped() {
    // Clipped at 80 and 95 % of the peak, far from any range, as by a charge amplifier or in a file.
    for limit in [0.8_f32, 0.95] {
        for channel in [HAMMER, 3] {
            let report = graded(|k, i| {
                let value = half_sine(1.0, i);
                60.0 * if k == channel { value.min(limit) } else { value }
            });
            assert_eq!(codes(&report), [(Code::Overload, Subject::channel(channel))], "{limit}");
            assert!((report.findings[0].value - 60.0 * limit).abs() < 0.1);
        }
    }
}

#[test]
fn a_small_smooth_response_has_no_flat_top() {
    // Peaks from 24 m/s² and 190 codes down to 3 codes, where each code is a plateau.
    for peak in [24.0_f32, 6.0, 2.0, 0.4] {
        for length in [20.0, 200.0, 1900.0] {
            let report = graded(|k, i| match k {
                HAMMER => half_sine(30.0, i),
                _ => pulse(80.0, length, peak, i),
            });
            assert!(report.good(), "{peak} {length} {report:?}");
        }
    }
}

#[test]
fn a_soft_tip_does_not_excite_the_band() {
    // A half sine of length T has its first zero at 1.5/T, 75 Hz for 20 ms; at 120 Hz the level is 20 lg
    // |cos(2.4 π)/(1 − 4·2.4²)| = −37 dB. The force window includes all of it.
    let report = tapped(|i| pulse(80.0, 80.0, 30.0, i));
    assert_eq!(codes(&report), [(Code::ForceSpectrumLow, Subject::Whole)]);
    assert!(report.good());
    // The tolerance covers codes of 0.03 N of 30 N, and a sum instead of an integral.
    assert!((report.findings[0].value + 37.0).abs() < 1.0, "{report:?}");
}

#[test]
fn a_body_that_moves_before_the_hit_is_not_quiet() {
    let swing = |i: usize| if i < 80 { (0.2 * i as f32).sin() } else { 0.0 };
    let report = graded(|k, i| match k {
        HAMMER => half_sine(30.0, i),
        5 => 5.0 * swing(i) + half_sine(20.0, i),
        _ => half_sine(40.0, i),
    });
    assert_eq!(codes(&report), [(Code::PreTriggerNotQuiet, Subject::Channel(5))]);
    // The value is 5/√2 of 40, over eleven periods, with quantisation.
    assert!((report.findings[0].value - 0.088).abs() < 3e-3, "{report:?}");
    let report = tapped(|i| half_sine(30.0, i) + 2.0 * swing(i));
    assert_eq!(codes(&report), [(Code::PreTriggerNotQuiet, Subject::Channel(0))]);
    assert!(report.good());
}

#[test]
fn a_hammer_that_stays_clips_the_record() {
    let report = tapped(|i| half_sine(30.0, i).max(if i > 90 { 3.0 } else { 0.0 }));
    assert_eq!(codes(&report), [(Code::ClippedRecord, Subject::Channel(0))]);
    assert!((report.findings[0].value - 0.1).abs() < 2e-3 && !report.good());
}

#[test]
fn a_response_that_is_not_over_clips_the_record_unless_a_window_ends_it() {
    let ringing = record(|k, i| match k {
        HAMMER => half_sine(30.0, i),
        _ => {
            if i > 100 {
                40.0 * (0.05 * i as f32).sin()
            } else {
                half_sine(10.0, i)
            }
        }
    });
    let graded = |exponential_decay| {
        let test = TestSettings { exponential_decay, ..TestSettings::default() };
        grade(&ringing, &ADC, &Calibration::default(), &test, None)
    };
    let report = graded(1.0);
    assert_eq!(codes(&report), [(Code::ClippedRecord, Subject::Channel(1))]);
    // The value is 1/√2 e^{−0.49}, over three periods.
    assert!((report.findings[0].value - 0.433).abs() < 0.02, "{report:?}");
    assert!(graded(10.0).findings.is_empty());
}

#[test]
fn the_record_of_the_hit_before_is_a_duplicate() {
    let hit = |k: usize, i: usize| half_sine(if k == HAMMER { 30.0 } else { 8.0 }, i);
    let first = graded(hit);
    let again = graded_after(Some(first.fingerprint), hit);
    assert_eq!(codes(&again), [(Code::DuplicateHit, Subject::Whole)]);
    assert!(!again.good());
    // A difference of one code in one scan makes another record.
    let other = graded_after(Some(first.fingerprint), |k, i| {
        hit(k, i) + if (k, i) == (1, 2000) { 0.2 } else { 0.0 }
    });
    assert!(other.findings.is_empty());
}

#[test]
fn the_policy_decides_what_a_finding_means() {
    let weak = record(|k, i| if k == HAMMER { half_sine(7.5, i) } else { 0.0 });
    for treatment in HitTreatment::ALL {
        let policy = HitPolicy::default().with(Code::TooWeak, treatment);
        let test = TestSettings { policy, ..TestSettings::default() };
        let report = grade(&weak, &ADC, &Calibration::default(), &test, None);
        assert_eq!(report.findings[0].severity, treatment.severity());
        assert_eq!(report.good(), treatment != HitTreatment::Reject);
    }
}

#[test]
fn signals_in_units_are_graded_without_ranges() {
    let range = ChannelRange {
        scale: 1.0,
        rails: [f64::NEG_INFINITY, f64::INFINITY],
        range: f64::INFINITY,
        resolution: 1e-6,
        noise: 0.0,
    };
    let (test, ranges) = (TestSettings::default(), [range; 2]);
    let grader = |pre_trigger| HitGrader {
        ranges: &ranges,
        rate: 4000.0,
        pre_trigger,
        test: &test,
        last: None,
    };
    let force: Vec<f64> = (0..2048).map(|i| f64::from(half_sine(3000.0, i))).collect();
    let response: Vec<f64> = force.iter().map(|f| -0.2 * f).collect();
    let hit = [force.as_slice(), response.as_slice()];
    assert!(grader(80).grade(&hit).findings.is_empty());
    let early = [&force[70..], &response[70..]];
    assert_eq!(codes(&grader(10).grade(&early)), [(Code::TriggerTooEarly, Subject::Whole)]);
    // A report is returned for any signal.
    for wild in [f64::NAN, f64::INFINITY, 0.0, -1e308] {
        let _ = grader(80).grade(&[[wild; 100].as_slice(), &[wild; 90]]);
        let _ = grader(80).grade(&[[].as_slice(), &[]] as &[&[f64]; 2]);
    }
}

/// Noise of a quarter to half a code, different in every channel.
fn noise(k: usize, i: usize) -> f32 {
    let mixed = (i as u32).wrapping_mul(2_654_435_761) ^ (k as u32).wrapping_mul(2_246_822_519);
    let hashed = (mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519) >> 24;
    (hashed as f32 / 255.0 - 0.5) * if k == HAMMER { 0.05 } else { 0.2 }
}

#[test]
fn a_response_that_stays_at_a_level_while_the_force_changes_is_clipped_at_any_level() {
    // 24 m/s² are 190 steps of the converter.
    for peak in [32.0_f32, -32.0, 60.0] {
        let limited = |share: f32| {
            graded(|k, i| {
                let limit = share * peak.abs();
                let clean = match k {
                    HAMMER => half_sine(30.0, i),
                    4 => half_sine(peak, i).clamp(-limit, limit),
                    _ => half_sine(5.0, i),
                };
                clean + noise(k, i)
            })
        };
        let code_list = codes(&limited(0.75));
        assert_eq!(code_list, [(Code::Overload, Subject::channel(4))], "{peak}");
        assert!(limited(1.1).good(), "{peak}");
    }
}

#[test]
fn hum_hides_no_clipped_response_and_clips_none() {
    // 0.75 m/s² are six steps of the converter. The mains are met at any phase.
    for phase in 0..12 {
        let hum = |i: usize| {
            let turned = core::f32::consts::TAU * (50.0 * i as f32 / 4000.0 + phase as f32 / 12.0);
            0.75 * turned.sin()
        };
        for (share, behind) in [(0.75, 0.0), (0.75, 1.0), (1.5, 0.0)] {
            let report = graded(|k, i| {
                let before = hum(i) * (1.0 - behind);
                let clean = match k {
                    HAMMER => half_sine(30.0, i),
                    4 => (half_sine(40.0, i) + before).clamp(-share * 40.0, share * 40.0),
                    _ => half_sine(5.0, i) + before,
                };
                clean + hum(i) * behind + noise(k, i)
            });
            let clipped = codes(&report) == [(Code::Overload, Subject::channel(4))];
            assert_eq!(
                (clipped, report.good()),
                (share < 1.0, share > 1.0),
                "{phase} {share} {behind}"
            );
        }
    }
}

#[test]
fn a_response_that_an_elastic_mode_flattens_is_not_clipped() {
    // Force and second derivative cancel at the peak.
    let report = graded(|k, i| {
        let clean = match k {
            HAMMER => half_sine(30.0, i),
            4 => {
                let t = core::f32::consts::PI * (i as f32 - 80.0) / 20.0;
                half_sine(40.0, i) * (1.0 - 0.25 * t.sin() * t.sin())
            }
            _ => half_sine(5.0, i),
        };
        clean + noise(k, i)
    });
    assert!(report.good(), "{:?}", report.findings);
}
