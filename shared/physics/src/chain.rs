//! The electrical chain of every channel: clipping, low-pass, noise, and what converts it to codes.

use std::f64::consts::{FRAC_PI_2, TAU};

use massline_shared::STANDARD_GRAVITY;
use massline_shared::signal::{CHANNELS, Scan};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

pub use super::channels::Channels;
use super::channels::{SampledOutputs, UNLIMITED, per_channel};
use super::converter::Converter;
use super::errors::{TestErrors, normal};
use super::faults;
use super::flicker::Flicker;
use super::streams::{Branch, branch};
use crate::bench::Bench;

/// The chains of all channels. Inputs are newtons for the hammer and m/s² for the others.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Largest input that is not clipped.
    range: Channels,
    /// Channels that compress softly towards the end of their range.
    compresses: [bool; CHANNELS],
    /// Time constant of the low-pass, s.
    tau: Channels,
    /// Step of the low-pass over one interval of the grid: factors of the output, of the input before and
    /// of the input after.
    whole: [Channels; 3],
    /// The same, up to the instant at which the channel is sampled.
    partial: [Channels; 3],
    /// Interval of the grid within a scan in which the channel is sampled.
    sampled_in: [usize; CHANNELS],
    /// Share of that interval before the sample.
    sampled_at: Channels,
    noise: FilteredNoise,
    flicker: Option<Flicker>,
    /// Source of the 1/f noise.
    flicker_rng: ChaCha8Rng,
    converter: Converter,
    /// Limited input at the last point of the grid and output of the low-pass there.
    input: Channels,
    output: Channels,
}

/// State of the chain at one instant.
#[derive(Clone, Copy, Debug)]
pub(super) struct ChainState {
    /// Input at the last point of the grid.
    pub(super) input: Channels,
    /// Output of the low-pass there.
    pub(super) output: Channels,
}

impl Chain {
    pub(super) fn new(bench: &Bench, errors: &TestErrors) -> Self {
        let (sensor, hammer, adc) = (&bench.sensor, &bench.hammer, &bench.adc);
        let range = per_channel(f64::INFINITY, sensor.range_g * STANDARD_GRAVITY);
        let nominal_cutoff = nominal_cutoffs(bench);
        let density =
            per_channel(hammer.noise_n_per_sqrt_hz, sensor.noise_g_per_sqrt_hz * STANDARD_GRAVITY);
        let cutoff: Channels = std::array::from_fn(|k| nominal_cutoff[k] * (1.0 + errors.rc[k]));
        let tau = cutoff.map(|cutoff| (TAU * cutoff).recip());
        let scan = adc.rate_hz.recip();
        let h = scan / f64::from(adc.oversampling);
        let (true_scan, true_h) = (scan * adc.clock_stretch(), h * adc.clock_stretch());
        let mut chain = Self {
            range,
            compresses: faults::compresses(bench),
            tau,
            whole: [[0.0; CHANNELS]; 3],
            partial: [[0.0; CHANNELS]; 3],
            sampled_in: [0; CHANNELS],
            sampled_at: [0.0; CHANNELS],
            noise: FilteredNoise::new(&density, &cutoff, true_scan),
            flicker: Flicker::new(&per_channel(0.0, density[1]), sensor.noise_corner_hz, true_scan),
            flicker_rng: ChaCha8Rng::seed_from_u64(0),
            converter: Converter::new(bench, errors, &tau),
            input: [0.0; CHANNELS],
            output: [0.0; CHANNELS],
        };
        for k in 0..CHANNELS {
            let at = k as f64 * adc.channel_delay_s / h;
            (chain.sampled_in[k], chain.sampled_at[k]) = (at as usize, at.fract());
            let step = |part| low_pass_step(chain.tau[k], true_h, part);
            let [whole, partial] = [1.0, at.fract()].map(step);
            for i in 0..3 {
                chain.whole[i][k] = whole[i];
                chain.partial[i][k] = partial[i];
            }
        }
        chain
    }

    /// Sets the chain to its steady state for a constant input. The white noise of the sensors is drawn
    /// from `noise`, mains and jitter from `disturbances`, 1/f noise, wander and supply from branches of it.
    pub(super) fn settle(
        &mut self,
        input: &Channels,
        noise: &mut ChaCha8Rng,
        disturbances: ChaCha8Rng,
    ) {
        self.follow(input);
        self.noise.settle(noise);
        self.flicker_rng = branch(&disturbances, Branch::Flicker);
        if let Some(flicker) = &mut self.flicker {
            flicker.settle(&mut self.flicker_rng);
        }
        self.converter.restart(&self.output, disturbances);
    }

    /// Sets the gain of each channel, which is one at first.
    pub(super) fn set_gains(&mut self, gains: &Channels) {
        self.converter.set_gains(gains);
    }

    /// Sets the low-passes to their steady state for a constant input.
    pub(super) fn follow(&mut self, input: &Channels) {
        self.input = self.limit(input);
        self.output = self.input;
    }

    /// Advances over interval `step` of a scan to the input at its end, and writes the outputs of those
    /// channels that are sampled within it to `sampled`.
    pub(super) fn advance(&mut self, step: usize, input: &Channels, sampled: &mut SampledOutputs) {
        let input = self.limit(input);
        let step_of = |factors: &[Channels; 3], k: usize| {
            factors[0][k] * self.output[k]
                + factors[1][k] * self.input[k]
                + factors[2][k] * input[k]
        };
        for k in 0..CHANNELS {
            if self.sampled_in[k] == step {
                let value = step_of(&self.partial, k);
                let present = self.input[k] + self.sampled_at[k] * (input[k] - self.input[k]);
                sampled.value[k] = value;
                sampled.slope[k] = (present - value) / self.tau[k];
            }
        }
        self.output = std::array::from_fn(|k| step_of(&self.whole, k));
        self.input = input;
    }

    /// The state at this point of the grid.
    pub(super) fn held(&self) -> ChainState {
        ChainState { input: self.input, output: self.output }
    }

    /// Restores a state from [`Chain::held`].
    pub(super) fn hold(&mut self, held: &ChainState) {
        (self.input, self.output) = (held.input, held.output);
    }

    /// The inputs below which the low-passes follow linearly: the range, zero for a channel that
    /// compresses, so that its free motion is computed by steps.
    pub(super) fn linear_range(&self) -> Channels {
        std::array::from_fn(|k| if self.compresses[k] { 0.0 } else { self.range[k] })
    }

    /// The same chain that neither clips nor compresses.
    pub(super) fn without_limits(&self) -> Self {
        Self { range: UNLIMITED, compresses: [false; CHANNELS], ..self.clone() }
    }

    /// The present outputs of the low-passes as samples; those at rest while nothing moves.
    pub(super) fn at_rest(&self) -> SampledOutputs {
        SampledOutputs { value: self.output, slope: [0.0; CHANNELS] }
    }

    /// Converts the outputs of the low-passes to codes, with a fresh sample of noise; no channel moves
    /// further than `limits` from its value at rest.
    pub(super) fn convert(
        &mut self,
        sampled: &SampledOutputs,
        limits: &Channels,
        rng: &mut ChaCha8Rng,
    ) -> Scan {
        let mut noise = self.noise.next(rng);
        if let Some(flicker) = &mut self.flicker {
            flicker.add(&mut noise, &mut self.flicker_rng);
        }
        self.converter.convert(sampled, &noise, limits)
    }

    /// What the low-passes receive: the input, compressed and clipped.
    fn limit(&self, input: &Channels) -> Channels {
        std::array::from_fn(|k| {
            let range = self.range[k];
            let input =
                if self.compresses[k] { range * (input[k] / range).tanh() } else { input[k] };
            input.clamp(-range, range)
        })
    }
}

/// Cutoffs of the low-passes without their tolerances, Hz.
fn nominal_cutoffs(bench: &Bench) -> Channels {
    let (sensor, hammer) = (&bench.sensor, &bench.hammer);
    let axes = sensor.bandwidth_hz.unwrap_or([sensor.rc_cutoff_hz; 3]);
    std::array::from_fn(|k| {
        k.checked_sub(1).map_or(hammer.rc_cutoff_hz, |response| axes[response % 3])
    })
}

/// Exact step of `τ ẏ + y = u` over the share `part` of an interval `h` over which `u` is linear:
/// factors of `y`, of `u` at the beginning, and of `u` at the end of the whole interval.
fn low_pass_step(tau: f64, h: f64, part: f64) -> [f64; 3] {
    let delta = part * h;
    let gained = -(-delta / tau).exp_m1();
    let slope = (delta - tau * gained) / h;
    [1.0 - gained, gained - slope, slope]
}

/// White noise behind a first-order low-pass, exact at the scans: a first-order autoregressive process
/// with variance `density² · π/2 · cutoff`.
#[derive(Clone, Debug)]
struct FilteredNoise {
    deviation: Channels,
    memory: Channels,
    fresh: Channels,
    value: Channels,
}

impl FilteredNoise {
    fn new(density: &Channels, cutoff: &Channels, scan: f64) -> Self {
        let deviation: Channels =
            std::array::from_fn(|k| density[k] * (FRAC_PI_2 * cutoff[k]).sqrt());
        let memory: Channels = std::array::from_fn(|k| (-TAU * cutoff[k] * scan).exp());
        let fresh = std::array::from_fn(|k| deviation[k] * (1.0 - memory[k] * memory[k]).sqrt());
        Self { deviation, memory, fresh, value: [0.0; CHANNELS] }
    }

    fn settle(&mut self, rng: &mut ChaCha8Rng) {
        self.value = self.deviation.map(|d| d * normal(rng));
    }

    fn next(&mut self, rng: &mut ChaCha8Rng) -> Channels {
        for k in 0..CHANNELS {
            self.value[k] = self.memory[k] * self.value[k] + self.fresh[k] * normal(rng);
        }
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error_sizes::ErrorSizes;

    fn quiet_bench() -> (Bench, TestErrors) {
        let bench = Bench::named("ideal").unwrap();
        let mut errors = TestErrors::draw(
            &bench,
            &ErrorSizes::of_bench(&bench, 3, 0),
            &mut ChaCha8Rng::seed_from_u64(1),
        );
        errors.zero_v = [0.0; CHANNELS];
        errors.rc = [0.0; CHANNELS];
        (bench, errors)
    }

    #[test]
    fn the_low_pass_follows_a_ramp_exactly() {
        // u = t from rest: y = t − τ (1 − e^{−t/τ}).
        let (tau, h) = (3.2e-4, 1.5e-5);
        let [a, b, c] = low_pass_step(tau, h, 1.0);
        let [pa, pb, pc] = low_pass_step(tau, h, 0.4);
        let exact = |t: f64| t + tau * (-t / tau).exp_m1();
        let mut y = 0.0;
        for k in 0..100 {
            let (t, next) = (f64::from(k) * h, f64::from(k + 1) * h);
            let within = pa * y + pb * t + pc * next;
            // Rounding of values below 1.5e-3.
            assert!((within - exact(t + 0.4 * h)).abs() < 1e-17);
            y = a * y + b * t + c * next;
            assert!((y - exact(next)).abs() < 1e-17);
        }
    }

    #[test]
    fn noise_has_the_variance_of_its_density_and_the_memory_of_its_filter() {
        let (bench, errors) = quiet_bench();
        let mut chain = Chain::new(&bench, &errors);
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        chain.noise.settle(&mut rng);
        let values: Vec<f64> = (0..20_000).map(|_| chain.noise.next(&mut rng)[4]).collect();
        let moment = |lag: usize| {
            values.iter().zip(&values[lag..]).map(|(a, b)| a * b).sum::<f64>() / values.len() as f64
        };
        // 300 µg/√Hz over an equivalent noise bandwidth of 781 Hz: 8.4 mg. 2e4 nearly independent values
        // determine a variance to 1 % and a correlation to 0.7 %; four times that is allowed.
        let expected = (300e-6 * STANDARD_GRAVITY).powi(2) * FRAC_PI_2 * 497.359197;
        assert!((moment(0) / expected - 1.0).abs() < 0.05);
        let memory = (-TAU * 497.359197_f64 / 4000.0).exp();
        assert!((moment(1) / moment(0) - memory).abs() < 0.03);
    }

    #[test]
    fn an_input_beyond_the_range_is_clipped() {
        let (bench, errors) = quiet_bench();
        let mut chain = Chain::new(&bench, &errors);
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut input = [0.0; CHANNELS];
        input[3] = 300.0;
        input[5] = -300.0;
        chain.settle(&input, &mut rng, ChaCha8Rng::seed_from_u64(8));
        let volts = |code: u16| f64::from(code) * 3.0 / 4096.0;
        let scan = chain.convert(&chain.at_rest(), &UNLIMITED, &mut rng);
        // 16 g is 0.912 V from the zero; the noise of 8 mg is 0.5 mV, and one code is 0.7 mV.
        assert!((volts(scan[3]) - 2.412).abs() < 0.004);
        assert!((volts(scan[5]) - 0.588).abs() < 0.004);
        assert!((volts(scan[4]) - 1.5).abs() < 0.004);
    }

    #[test]
    fn the_converter_saturates_at_both_rails() {
        let (bench, errors) = quiet_bench();
        let mut chain = Chain::new(&bench, &errors);
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let mut sampled = chain.at_rest();
        sampled.value[0] = 500.0;
        assert_eq!(chain.convert(&sampled, &UNLIMITED, &mut rng)[0], 4095);
        sampled.value[0] = -50.0;
        assert_eq!(chain.convert(&sampled, &UNLIMITED, &mut rng)[0], 0);
    }
}
