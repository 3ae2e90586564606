//! The disturbances of the sensors' outputs in the codes: 1/f noise, wander, widths of codes.

use std::f64::consts::TAU;

use massline_shared::signal::CHANNELS;
use nalgebra::Complex;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use super::physics::no_errors;
use super::{exact, test_one};
use crate::bench::Bench;
use crate::chain::Chain;
use crate::channels::UNLIMITED;
use crate::nonlinearity::Nonlinearity;
use crate::operator::BenchSource;

/// The codes of 16 bits of sensors that lie still.
fn at_rest(bench: &Bench, count: usize, seed: u64) -> Vec<[f64; CHANNELS]> {
    let mut chain = Chain::new(bench, &no_errors(bench));
    let mut noise = ChaCha8Rng::seed_from_u64(seed);
    chain.settle(&[0.0; CHANNELS], &mut noise, ChaCha8Rng::seed_from_u64(1000 + seed));
    let rest = chain.at_rest();
    (0..count).map(|_| chain.convert(&rest, &UNLIMITED, &mut noise).map(f64::from)).collect()
}

#[test]
fn the_codes_of_a_sensor_have_the_density_of_its_white_and_its_1_over_f_noise() {
    let mut bench = exact(&[]);
    bench.adc.bits = 16;
    bench.sensor.noise_g_per_sqrt_hz = 300e-6;
    bench.sensor.noise_corner_hz = 2.0;
    let per_g = 0.057 * 65536.0 / 3.0;
    let (count, records) = (100_000, 8);
    // Whole periods of the window of 25 s, at least two beside zero.
    let hz = [0.12, 0.4, 2.0, 6.0, 20.0];
    let mut power = [0.0; 5];
    for seed in 0..records {
        let record = at_rest(&bench, count, seed);
        let mean: [f64; CHANNELS] =
            std::array::from_fn(|k| record.iter().map(|v| v[k]).sum::<f64>() / count as f64);
        for (power, hz) in power.iter_mut().zip(hz) {
            let mut sums = [Complex::new(0.0, 0.0); CHANNELS];
            for (n, values) in record.iter().enumerate() {
                let window = 1.0 - (TAU * n as f64 / count as f64).cos();
                let turn = Complex::new(0.0, -TAU * hz * n as f64 / 4000.0).exp() * window;
                for k in 0..CHANNELS {
                    sums[k] += turn * (values[k] - mean[k]);
                }
            }
            // One-sided; the mean square of the window is 1.5. The hammer has no noise.
            let scale = 2.0 / (1.5 * 4000.0 * count as f64) / (per_g * per_g);
            *power += sums[1..].iter().map(|sum| sum.norm_sqr() * scale).sum::<f64>();
        }
    }
    for (power, hz) in power.into_iter().zip(hz) {
        let expected = 300e-6_f64.powi(2) * (1.0 + 2.0 / hz);
        let ratio = power / (9.0 * records as f64) / expected;
        // The mean of 72 periodograms with an exponential distribution has 1 σ of 12 %; three times that is allowed,
        // and the seeds are fixed. The window's main lobe of 0.16 Hz averages 1/f to a tenth more at 0.12 Hz.
        assert!((ratio - 1.0).abs() < 0.36, "{hz}: {ratio}");
    }
}

#[test]
fn outputs_wander_by_their_deviation_and_keep_their_value_over_a_record() {
    let mut bench = exact(&[]);
    bench.adc.bits = 16;
    bench.sensor.wander_v = 0.01;
    bench.sensor.wander_s = 300.0;
    let per_volt = 65536.0 / 3.0;
    let (mut squares, mut changes, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..100 {
        let record = at_rest(&bench, 4000, seed);
        assert_eq!(record[0][0], record[3999][0], "a hammer does not wander");
        for k in 1..CHANNELS {
            let [first, last] = [0, 3999].map(|n| record[n][k] / per_volt - 1.5);
            squares += first * first;
            changes += (last - first).powi(2);
            count += 1.0;
        }
    }
    // 900 numbers determine a deviation to 2.4 %; four times that is allowed.
    assert!(((squares / count).sqrt() / 0.01 - 1.0).abs() < 0.1, "{}", (squares / count).sqrt());
    // In one second it changes by √(2/300) of that.
    let expected = 0.01 * (2.0_f64 / 300.0).sqrt();
    assert!(
        ((changes / count).sqrt() / expected - 1.0).abs() < 0.1,
        "{}",
        (changes / count).sqrt()
    );
}

#[test]
fn codes_differ_in_width_and_none_is_missing() {
    let mut bench = exact(&[]);
    bench.adc.dnl_lsb = 0.8;
    let seeded = |seed| {
        let errors = BenchSource::new(&bench, &test_one(), seed).unwrap().errors().clone();
        Nonlinearity::new(&bench, &errors)
    };
    const FINE: u32 = 1000;
    let begins = |converter: &Nonlinearity| {
        let mut begins = vec![-0.5];
        let mut before = converter.code(0.0);
        assert_eq!(before, 0);
        for n in 1..=4095 * FINE {
            let position = f64::from(n) / f64::from(FINE);
            let code = converter.code(position);
            assert!(code == before || code == before + 1, "{position}: {before} {code}");
            if code > before {
                begins.push(position);
            }
            before = code;
        }
        begins
    };
    let first = begins(&seeded(1));
    assert_eq!(first.len(), 4096, "every code occurs");
    let mut squares = 0.0;
    for (code, pair) in first.windows(2).enumerate().skip(1) {
        let error = pair[1] - pair[0] - 1.0;
        // A thousandth is the resolution of each end.
        assert!(error.abs() < 0.8 + 0.002, "{code}: {error}");
        assert!((pair[0] - code as f64 + 0.5).abs() < 0.4 + 0.001, "errors do not add up");
        squares += error * error;
    }
    // The difference of two even distributions over ±0.4 has the deviation 0.8/√6. Errors of neighbours are opposite:
    // 4094 widths determine it as 2000 would, to 1.6 %; four times that is allowed.
    let sigma = (squares / 4094.0).sqrt();
    assert!((sigma / (0.8 / 6.0_f64.sqrt()) - 1.0).abs() < 0.064, "{sigma}");
    assert_eq!(first, begins(&seeded(1)));
    assert_ne!(first, begins(&seeded(2)), "drawn for each test");
}

#[test]
fn the_ends_of_the_scale_stay_where_they_are() {
    let mut bench = exact(&[]);
    bench.adc.dnl_lsb = 1.0;
    bench.adc.inl_lsb = 2.0;
    let converter = Nonlinearity::new(&bench, &no_errors(&bench));
    assert_eq!([-1e9, -3.0].map(|x| converter.code(x)), [0, 0]);
    assert_eq!([4099.0, 1e9].map(|x| converter.code(x)), [4095, 4095]);
    assert_eq!(converter.code(f64::NAN), 0);
}
