//! The fit recovers the terms and their standard deviations, and refuses bad input.

use super::*;
use proptest::prelude::*;
use std::vec::Vec;

/// The rig's bins: 4 kS/s over 2048 scans.
const RESOLUTION: f64 = 4000.0 / 2048.0;

fn bins<R: Real>() -> impl Iterator<Item = Bin<R>> + Clone {
    // The force spectrum of a soft tap falls with the frequency.
    (0..128).map(|k| {
        let frequency = RESOLUTION * f64::from(k);
        Bin { frequency: R::of(frequency), weight: R::of(3.0 / (1.0 + frequency / 100.0)) }
    })
}

fn model<R: Real>(abc: [f64; 3], decay: f64) -> Vec<Complex<R>> {
    let fitted = MassLine { coefficients: abc, sigma: [0.0; 3] };
    let at = |l: Bin<f64>| {
        let s = Complex::new(decay, 2.0 * core::f64::consts::PI * l.frequency);
        let h = fitted.at(s);
        Complex::new(R::of(h.re), R::of(h.im))
    };
    bins::<f64>().map(at).collect()
}

fn fit<R: Real + Default>(
    h: &[Complex<R>],
    decay: f64,
    terms: Terms,
) -> Result<MassLine<R>, MassLineError> {
    let mut workspace = [BasisRow::default(); 64];
    let band = [R::of(10.0), R::of(120.0)];
    MassLineBasis::new(bins(), band, R::of(decay), terms, &mut workspace)?.fit(h.iter().copied())
}

proptest! {
    #[test]
    fn the_fit_gives_the_three_terms_of_an_exact_mass_line(
        a in -3.0..3.0_f64,
        b in -2000.0..2000.0_f64,
        c in -1e-6..1e-6_f64,
        decay in prop_oneof![Just(0.0), 5.0..20.0_f64],
    ) {
        let exact = fit(&model::<f64>([a, b, c], decay), decay, Terms::Abc).unwrap();
        // The tolerance covers rounding times the condition 9 of the scaled basis; the scales of B and C are
        // those of the largest term within the band: ω from 63 to 750 rad/s.
        let error = [exact.coefficients[0] - a, exact.coefficients[1] - b, exact.coefficients[2] - c];
        prop_assert!(error[0].abs() < 1e-12 && error[1].abs() < 1e-8 && error[2].abs() < 1e-17);
        let single = fit(&model::<f32>([a, b, c], decay), decay, Terms::Abc).unwrap();
        // Theory, section 10: 1e-6 of the largest accelerance, here below 4.
        prop_assert!((f64::from(single.accelerance()) - a).abs() < 8e-6);
    }
}

#[test]
fn without_its_term_the_suspension_stays_in_the_mass_line() {
    let h = model::<f64>([1.0, 500.0, 0.0], 10.0);
    let a = fit(&h, 10.0, Terms::A).unwrap();
    let ab = fit(&h, 10.0, Terms::Ab).unwrap();
    assert!((a.accelerance() - 1.0).abs() > 1e-3 && a.coefficients[1..] == [0.0, 0.0]);
    assert!((ab.accelerance() - 1.0).abs() < 1e-12 && ab.coefficients[2] == 0.0);
    assert!(a.sigma[0] > 100.0 * ab.sigma[0]);
}

#[test]
fn the_standard_deviation_is_that_of_many_fits() {
    // Uniform noise of ±0.1 on both parts from a linear congruential generator: standard deviation 0.1/√3.
    let mut state = 1_u64;
    let mut noise = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5) * 0.2
    };
    let clean = model::<f64>([1.0, 100.0, 1e-7], 10.0);
    let mut workspace = [BasisRow::default(); 64];
    let flat = bins::<f64>().map(|l| Bin { weight: 1.0, ..l });
    let basis = MassLineBasis::new(flat, [10.0, 120.0], 10.0, Terms::Abc, &mut workspace).unwrap();
    let (mut sum, mut squares, mut formal) = (0.0, 0.0, 0.0);
    let runs = 2000;
    for _ in 0..runs {
        let noisy: Vec<_> = clean.iter().map(|h| h + Complex::new(noise(), noise())).collect();
        let fitted = basis.fit(noisy).unwrap();
        sum += fitted.accelerance();
        squares += fitted.accelerance() * fitted.accelerance();
        formal += fitted.sigma[0];
    }
    let runs = f64::from(runs);
    let mean: f64 = sum / runs;
    let sigma = (squares / runs - mean * mean).sqrt();
    // A standard deviation over 2000 runs is known to 1.6 %; the tolerance is four of those.
    assert!((formal / runs / sigma - 1.0).abs() < 0.064, "{} {sigma}", formal / runs);
    assert!((mean - 1.0).abs() < 4.0 * sigma / runs.sqrt());
}

#[test]
fn a_band_with_as_many_equations_as_unknowns_is_too_narrow() {
    let mut workspace = [BasisRow::default(); 64];
    let mut with = |band: [f64; 2], decay| {
        MassLineBasis::new(bins(), band, decay, Terms::Abc, &mut workspace).map(|b| b.bins())
    };
    let upto = |k: f64| [RESOLUTION, RESOLUTION * k];
    assert_eq!(with(upto(3.0), 0.0), Err(MassLineError::BandTooNarrow));
    assert_eq!(with(upto(4.0), 0.0), Ok(4));
    assert_eq!(with(upto(1.0), 10.0), Err(MassLineError::BandTooNarrow));
    assert_eq!(with(upto(2.0), 10.0), Ok(2));
    assert_eq!(with([1000.0, 2000.0], 10.0), Err(MassLineError::BandTooNarrow));
    assert_eq!(with([120.0, 10.0], 10.0), Err(MassLineError::BandTooNarrow));
}

#[test]
fn a_line_at_zero_hertz_says_nothing_about_the_suspension() {
    let mut workspace = [BasisRow::default(); 64];
    let basis = MassLineBasis::new(bins(), [0.0, 100.0], 0.0, Terms::Ab, &mut workspace).unwrap();
    let h: Vec<_> = model::<f64>([1.0, 0.0, 0.0], 1e-9);
    assert!((basis.fit(h).unwrap().accelerance() - 1.0).abs() < 1e-12);
}

#[test]
fn lines_that_are_not_finite_or_missing_are_refused() {
    let mut h = model::<f32>([1.0, 0.0, 0.0], 10.0);
    h[0] = Complex::new(f32::NAN, 0.0);
    assert!(fit(&h, 10.0, Terms::Abc).is_ok(), "outside the band");
    h[20].im = f32::INFINITY;
    assert_eq!(fit(&h, 10.0, Terms::Abc), Err(MassLineError::NotFinite));
    assert_eq!(fit(&h[..40], 10.0, Terms::Abc), Err(MassLineError::LinesMissing));
    let mut workspace = [BasisRow::default(); 64];
    let mut with = |spoil: fn(&mut Bin<f32>)| {
        let bins = bins().enumerate().map(|(k, mut bin)| {
            if k == 20 {
                spoil(&mut bin);
            }
            bin
        });
        let band = [10.0, 120.0];
        MassLineBasis::new(bins, band, 10.0, Terms::Abc, &mut workspace).err()
    };
    assert_eq!(with(|_| {}), None);
    assert_eq!(with(|l| l.weight = f32::NAN), Some(MassLineError::NotFinite));
    assert_eq!(with(|l| l.weight = -1.0), Some(MassLineError::NotFinite));
    assert_eq!(with(|l| l.frequency = 1.0), Some(MassLineError::NotAscending));
    let nothing = bins::<f32>().map(|l| Bin { weight: 0.0, ..l });
    let band = [10.0, 120.0];
    let error = MassLineBasis::new(nothing, band, 10.0, Terms::Abc, &mut workspace).err();
    assert_eq!(error, Some(MassLineError::NotFinite));
    let small = &mut [BasisRow::default(); 8];
    let error = MassLineBasis::new(bins::<f32>(), band, 10.0, Terms::Abc, small).err();
    assert_eq!(error, Some(MassLineError::WorkspaceTooSmall));
}

#[test]
fn the_window_correlation_is_the_quotient_of_its_integrals() {
    let (decay, record) = (10.0, 0.512);
    let steps = 200_000;
    let dt = record / f64::from(steps);
    let integral = |power: f64| -> f64 {
        (0..steps).map(|k| (-decay * power * (f64::from(k) + 0.5) * dt).exp() * dt).sum()
    };
    let expected = (integral(4.0) / integral(2.0).powi(2) * record).sqrt();
    // The reference is the midpoint rule with 200 000 steps.
    assert!((window_correlation(decay, record) - expected).abs() < 1e-8);
    assert_eq!(window_correlation(0.0, record), 1.0);
}

#[cfg(feature = "signal")]
#[test]
fn corrected_for_the_window_the_deviation_is_that_of_many_records() {
    use crate::signal::{RealFft, window};
    const RECORD: usize = 2048;
    let mut state = 7_u64;
    let mut noise = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
    };
    let mut workspace = [BasisRow::default(); 64];
    let flat = bins::<f64>().map(|l| Bin { weight: 1.0, ..l });
    let basis = MassLineBasis::new(flat, [10.0, 120.0], 10.0, Terms::Abc, &mut workspace).unwrap();
    let (mut squares, mut formal) = (0.0, 0.0);
    let runs = 400;
    let mut samples = [0.0; RECORD];
    let mut spectrum = [Complex::new(0.0, 0.0); 128];
    for _ in 0..runs {
        // A body without motion under a unit impulse, read with white noise.
        samples.fill_with(&mut noise);
        window::exponential(&mut samples, 0.0, 1.0, 10.0 / 4000.0);
        f64::real_fft(&mut samples, &mut spectrum).unwrap();
        let fitted = basis.fit(spectrum).unwrap();
        squares += fitted.accelerance().powi(2);
        formal += fitted.sigma[0];
    }
    let runs = f64::from(runs);
    let formal = formal / runs / (squares / runs).sqrt();
    let corrected = formal * window_correlation(10.0, RECORD as f64 / 4000.0);
    // A standard deviation over 400 runs is known to 3.5 %. The correction is that of a mean over many bins;
    // at the ends of the band, which determine B and C, there are fewer neighbours: 10 % too much.
    assert!((0.9..1.2).contains(&corrected), "{corrected}");
    assert!(formal < 0.5, "{formal}");
}

#[test]
fn total_weight_and_variance_are_those_of_the_weights_as_given() {
    let design = |factor: f64| {
        let mut workspace = [BasisRow::<f64>::default(); 64];
        let bins = bins().map(|bin: Bin<f64>| Bin { weight: bin.weight * factor, ..bin });
        let basis = MassLineBasis::new(bins, [10.0, 120.0], 10.0, Terms::Abc, &mut workspace);
        let design = basis.unwrap().design();
        (design.total_weight(), design.variance())
    };
    let (weight, variance) = design(1.0);
    let inside = bins::<f64>().filter(|bin| (10.0..=120.0).contains(&bin.frequency));
    // Rounding only.
    assert!((weight / inside.map(|bin| bin.weight).sum::<f64>() - 1.0).abs() < 1e-12);
    // Three terms tell less of A than its mean alone would.
    assert!(variance > 1.0 / weight);
    let (scaled_weight, scaled_variance) = design(400.0);
    assert!((scaled_weight / (400.0 * weight) - 1.0).abs() < 1e-12);
    assert!((scaled_variance * 400.0 / variance - 1.0).abs() < 1e-12);
}
