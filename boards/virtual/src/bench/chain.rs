//! The electrical chain of every channel: clipping, low-pass, noise and converter.

use std::f64::consts::{FRAC_PI_2, TAU};

use massline_shared::STANDARD_GRAVITY;
use massline_shared::signal::{CHANNELS, Scan};
use rand_chacha::ChaCha8Rng;

use super::Bench;
use super::errors::{TestErrors, normal};

/// One value per channel.
pub type Channels = [f64; CHANNELS];

/// The chains of all channels. Inputs are newtons for the hammer and m/s² for the others.
#[derive(Clone, Debug)]
pub struct Chain {
    /// Largest input that is not clipped.
    range: Channels,
    volts_per_unit: Channels,
    zero: Channels,
    /// Step of the low-pass over one interval of the grid: factors of the output, of the input before and
    /// of the input after.
    whole: [Channels; 3],
    /// The same, up to the instant at which the channel is sampled.
    partial: [Channels; 3],
    /// Interval of the grid within a scan in which the channel is sampled.
    sampled_in: [usize; CHANNELS],
    noise: FilteredNoise,
    volts_per_code: f64,
    full_scale: f64,
    /// Clipped input at the last point of the grid and output of the low-pass there.
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
        let per_channel = |hammer: f64, sensor: f64| {
            std::array::from_fn(|k: usize| if k == 0 { hammer } else { sensor })
        };
        let range = per_channel(f64::INFINITY, sensor.range_g * STANDARD_GRAVITY);
        let nominal = per_channel(hammer.zero_v, sensor.zero_v);
        let nominal_cutoff: Channels = per_channel(hammer.rc_cutoff_hz, sensor.rc_cutoff_hz);
        let density: Channels =
            per_channel(hammer.noise_n_per_sqrt_hz, sensor.noise_g_per_sqrt_hz * STANDARD_GRAVITY);
        let volts_per_unit =
            per_channel(hammer.sensitivity_v_per_n, sensor.sensitivity_v_per_g / STANDARD_GRAVITY);
        let cutoff: Channels = std::array::from_fn(|k| nominal_cutoff[k] * (1.0 + errors.rc[k]));
        let scan = adc.rate_hz.recip();
        let h = scan / f64::from(adc.oversampling);
        let mut chain = Self {
            range,
            volts_per_unit,
            zero: std::array::from_fn(|k| nominal[k] + errors.zero_v[k]),
            whole: [[0.0; CHANNELS]; 3],
            partial: [[0.0; CHANNELS]; 3],
            sampled_in: [0; CHANNELS],
            noise: FilteredNoise::new(&density, &cutoff, scan),
            volts_per_code: adc.reference_v / f64::from(1_u32 << adc.bits),
            full_scale: f64::from((1_u32 << adc.bits) - 1),
            input: [0.0; CHANNELS],
            output: [0.0; CHANNELS],
        };
        for (k, cutoff) in cutoff.iter().enumerate() {
            let tau = (TAU * cutoff).recip();
            let at = k as f64 * adc.channel_delay_s / h;
            chain.sampled_in[k] = at as usize;
            let [whole, partial] = [1.0, at.fract()].map(|part| low_pass_step(tau, h, part));
            for i in 0..3 {
                chain.whole[i][k] = whole[i];
                chain.partial[i][k] = partial[i];
            }
        }
        chain
    }

    /// Sets the chain to its steady state for a constant input.
    pub(super) fn settle(&mut self, input: &Channels, rng: &mut ChaCha8Rng) {
        self.input = self.clip(input);
        self.output = self.input;
        self.noise.settle(rng);
    }

    /// Advances over interval `step` of a scan to the input at its end, and writes the outputs of those
    /// channels that are sampled within it to `sampled`.
    pub(super) fn advance(&mut self, step: usize, input: &Channels, sampled: &mut Channels) {
        let input = self.clip(input);
        let step_of = |factors: &[Channels; 3], k: usize| {
            factors[0][k] * self.output[k]
                + factors[1][k] * self.input[k]
                + factors[2][k] * input[k]
        };
        for (k, value) in sampled.iter_mut().enumerate() {
            if self.sampled_in[k] == step {
                *value = step_of(&self.partial, k);
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

    /// The largest inputs that are not clipped.
    pub(super) fn range(&self) -> &Channels {
        &self.range
    }

    /// The same chain that never clips.
    pub(super) fn without_limits(&self) -> Self {
        Self { range: [f64::INFINITY; CHANNELS], ..self.clone() }
    }

    /// The present outputs of the low-passes; those at rest while nothing moves.
    pub(super) fn at_rest(&self) -> Channels {
        self.output
    }

    /// Converts the outputs of the low-passes to codes, with a fresh sample of noise.
    pub(super) fn convert(&mut self, sampled: &Channels, rng: &mut ChaCha8Rng) -> Scan {
        let noise = self.noise.next(rng);
        std::array::from_fn(|k| {
            let volts = self.zero[k] + self.volts_per_unit[k] * (sampled[k] + noise[k]);
            (volts / self.volts_per_code).round().clamp(0.0, self.full_scale) as u16
        })
    }

    fn clip(&self, input: &Channels) -> Channels {
        std::array::from_fn(|k| input[k].clamp(-self.range[k], self.range[k]))
    }
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
    use rand::SeedableRng;

    fn quiet_bench() -> (Bench, TestErrors) {
        let bench = Bench::named("ideal").unwrap();
        let mut errors = TestErrors::draw(&bench, 3, &mut ChaCha8Rng::seed_from_u64(1));
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
        chain.settle(&input, &mut rng);
        let volts = |code: u16| f64::from(code) * 3.0 / 4096.0;
        let scan = chain.convert(&chain.at_rest(), &mut rng);
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
        let mut input = [0.0; CHANNELS];
        input[0] = 500.0;
        assert_eq!(chain.convert(&input, &mut rng)[0], 4095);
        input[0] = -50.0;
        assert_eq!(chain.convert(&input, &mut rng)[0], 0);
    }
}
