use std::vec::Vec;

use super::windows::GROUP;
use super::*;

const RATE: f64 = 4000.0;
const REST: usize = 72;
const QUIET: usize = 176;

/// Ten channels of a hit: a pulse, slow motion, ringing, noise, and what `hum` adds to each channel.
fn record(hum: impl Fn(usize, f64) -> f64) -> Vec<Vec<f64>> {
    let noise = |k: usize, n: usize| {
        let mixed = (n as u32).wrapping_mul(2_654_435_761) ^ (k as u32 * 97).wrapping_mul(40_503);
        let hashed = (mixed ^ (mixed >> 15)).wrapping_mul(2_246_822_519);
        f64::from(hashed >> 16) / 65_536.0 * 3.0 - 1.5
    };
    let reading = |k: usize, n: usize| {
        let t = n as f64 / RATE;
        let pulse = if (80..100).contains(&n) { 500.0 } else { 0.0 };
        let after = if n < 90 || k == 0 { 0.0 } else { 1.0 };
        let slow = 15.0 * (12.0 * t).sin() * after;
        let ringing = 40.0 * (-20.0 * t).exp() * (1970.0 * t).sin() * after;
        (2000.0 + pulse + slow + ringing + noise(k, n) + hum(k, t)).round()
    };
    (0..CHANNELS).map(|k| (0..2048).map(|n| reading(k, n)).collect()).collect()
}

fn find_hum(hum: impl Fn(usize, f64) -> f64) -> Option<Hum<f64>> {
    let channels = record(hum);
    let slices: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
    searched(slices.as_slice(), RATE)
}

fn fitted<R: Real>(record: &[&[R]], rate: R) -> Option<HumFit<R>> {
    let mut search = HumSearch::new(record[0].len(), REST..QUIET, rate)?;
    let mut room = std::vec![R::zero(); 2048 / GROUP];
    (0..CHANNELS).for_each(|channel| search.add(record, channel, &mut room));
    let mut fit = search.start_fit()?;
    (0..CHANNELS).for_each(|channel| fit.add(record, channel, &mut room));
    Some(fit)
}

fn searched<R: Real>(record: &[&[R]], rate: R) -> Option<Hum<R>> {
    fitted(record, rate).map(|fit| *fit.hum())
}

/// What may be left at the contact, in the channel with most of it.
fn left(hum: impl Fn(usize, f64) -> f64) -> f64 {
    let channels = record(hum);
    let slices: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
    let fit = fitted(slices.as_slice(), RATE).unwrap();
    (0..CHANNELS).map(|k| fit.left(k)).fold(0.0, f64::max)
}

#[test]
fn without_hum_there_is_none() {
    assert_eq!(find_hum(|_, _| 0.0), None);
}

#[test]
fn frequency_amplitude_and_phase_are_found_and_taken_out() {
    for frequency in [49.6, 50.0, 50.4, 59.7, 60.2] {
        let tone = |k: usize, t: f64| {
            (3.0 + k as f64) * (core::f64::consts::TAU * frequency * t + 0.7 * k as f64).cos()
        };
        let hum = find_hum(tone).unwrap();
        assert_eq!(hum.code, MAINS[usize::from(frequency > 55.0)].1);
        // Noise of one code over a quarter of a second, twice.
        assert!((hum.frequency - frequency).abs() < 0.03, "{frequency}: {}", hum.frequency);
        for k in 0..CHANNELS {
            let mut left: Vec<f64> = (0..2048).map(|n| tone(k, n as f64 / RATE)).collect();
            hum.remove(k, &mut left);
            let rms = (left.iter().map(|v| v * v).sum::<f64>() / 2048.0).sqrt();
            // The tone is 2 to 8 codes rms; what is left comes from noise and slow motion.
            assert!(rms < 0.3, "{frequency} Hz, channel {k}: {rms}");
        }
    }
}

#[test]
fn harmonics_are_taken_out_too() {
    let tone = |_: usize, t: f64| {
        let phase = core::f64::consts::TAU * 50.1 * t;
        4.0 * phase.cos() + 2.0 * (2.0 * phase + 1.0).cos() + 1.5 * (3.0 * phase - 2.0).cos()
    };
    let hum = find_hum(tone).unwrap();
    let mut left: Vec<f64> = (0..2048).map(|n| tone(0, n as f64 / RATE)).collect();
    hum.remove(2, &mut left);
    let rms = (left.iter().map(|v| v * v).sum::<f64>() / 2048.0).sqrt();
    assert!(rms < 0.4, "{rms}");
}

#[test]
fn the_ripple_of_a_rectifier_is_found_without_its_fundamental() {
    for frequency in [100.3, 119.8] {
        let tone = |_: usize, t: f64| 5.0 * (core::f64::consts::TAU * frequency * t).cos();
        let hum = find_hum(tone).unwrap();
        assert_eq!(hum.code, MAINS[usize::from(frequency > 110.0)].1);
        let mut left: Vec<f64> = (0..2048).map(|n| tone(0, n as f64 / RATE)).collect();
        hum.remove(0, &mut left);
        let rms = (left.iter().map(|v| v * v).sum::<f64>() / 2048.0).sqrt();
        // 3.5 codes rms; what is left comes from noise.
        assert!(rms < 0.3, "{frequency} Hz: {rms}");
    }
}

#[test]
fn an_elastic_mode_near_the_mains_is_no_hum() {
    let after = |t: f64| if t < 85.0 / RATE { 0.0 } else { 1.0 };
    for frequency in [48.0, 50.3, 55.0, 61.0, 98.0, 100.0, 104.0, 112.0, 119.0] {
        for damping in [0.0, 0.001, 0.01] {
            let omega = core::f64::consts::TAU * frequency;
            let mode = |k: usize, t: f64| {
                let loud = if k == 0 { 0.0 } else { 3.0 + 2.0 * k as f64 };
                loud * (-damping * omega * t).exp() * (omega * t).sin() * after(t)
            };
            let channels = record(mode);
            let slices: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
            let fit = fitted(slices.as_slice(), RATE);
            assert!(fit.is_none_or(|fit| !fit.is_there_before()), "{frequency} Hz, {damping}");
        }
    }
    for frequency in [49.5, 50.0, 50.5, 59.6, 60.4, 100.4, 119.5] {
        let tone = |k: usize, t: f64| {
            let phase = core::f64::consts::TAU * frequency * t + 0.4 * k as f64;
            // The loudest channel has 1.2 codes.
            (0.3 + 0.1 * k as f64) * phase.cos()
        };
        let channels = record(tone);
        let slices: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
        assert!(fitted(slices.as_slice(), RATE).unwrap().is_there_before(), "{frequency} Hz");
    }
}

#[test]
fn hum_that_changes_is_told_from_steady_hum() {
    let tone = |t: f64| 20.0 * (core::f64::consts::TAU * 50.1 * t).cos();
    // Noise, slow motion and ringing alone come to this.
    let steady = left(|_, t| tone(t));
    assert!(steady < 1.5, "{steady}");
    // It grows by 40 % a second: from the middle of the quiet part, 0.28 s, to the contact at 0.02 s by 2.1 codes.
    let growing = left(|_, t| tone(t) * (1.0 + 0.4 * t));
    assert!((1.5..4.5).contains(&growing), "{growing}");
    // It stops where the first half of the quiet part ends.
    let stopping = left(|_, t| if t < 0.28 { tone(t) } else { 0.0 });
    assert!(stopping > 20.0, "{stopping}");
}

#[test]
fn a_record_that_is_too_short_shows_nothing() {
    let channels = record(|_, t| 9.0 * (314.0 * t).cos());
    let slices: Vec<&[f64]> = channels.iter().map(|channel| &channel[..1000]).collect();
    assert_eq!(searched(slices.as_slice(), RATE), None);
}

#[test]
fn single_precision_suffices() {
    let channels = record(|k, t| (3.0 + k as f64) * (315.0 * t).cos());
    let single: Vec<Vec<f32>> =
        channels.iter().map(|c| c.iter().map(|&v| v as f32).collect()).collect();
    let slices: Vec<&[f64]> = channels.iter().map(Vec::as_slice).collect();
    let double = searched(slices.as_slice(), RATE).unwrap();
    let slices: Vec<&[f32]> = single.iter().map(Vec::as_slice).collect();
    let single = searched(slices.as_slice(), RATE as f32).unwrap();
    // Running products over 374 groups: 374 roundings of 6e-8 at worst, times 13 codes.
    for k in 0..CHANNELS {
        assert!((double.amplitude(k) - f64::from(single.amplitude(k))).abs() < 2e-3, "{k}");
    }
}
