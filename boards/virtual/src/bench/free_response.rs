//! Computes motion without a force one whole scan at a time.
//!
//! Between taps nothing clips and no force acts, so the outputs at the next scan are a linear function of
//! the present state of the oscillators and low-passes. The factors are found by stepping through one
//! scan from every unit state; the results equal those of the steps up to rounding.

use massline_shared::signal::CHANNELS;

use super::chain::ChainState;
use super::channels::{Channels, Sampled};

/// Readings beyond this fraction of a sensor's range are computed by steps, which clip.
const CERTAINLY_WITHIN: f64 = 0.5;

/// The factors of one scan.
#[derive(Clone, Debug)]
pub(super) struct FreeResponse {
    /// New displacement and velocity of each mode as a function of the present ones.
    modes: Vec<[[f64; 2]; 2]>,
    /// The rates of change at the samples, when they are asked for.
    slope: Option<Outputs>,
    /// The samples, and the outputs and inputs of the low-passes at the end of the scan.
    sampled: Outputs,
    held: Outputs,
    input: Outputs,
}

/// One value per channel as a linear function of the state.
#[derive(Clone, Debug)]
struct Outputs {
    /// Factors of displacement and velocity of each mode.
    by_state: Vec<[Channels; 2]>,
    /// Factors of the output of the channel's low-pass.
    by_held: Channels,
    /// The value at rest.
    constant: Channels,
}

impl FreeResponse {
    /// Determines the factors from scans that never clip: `rest` starts without motion and with low-pass
    /// outputs of zero; `bare` starts with any motion of the modes and any outputs of the low-passes,
    /// with sensors that read zero at rest. Rates of change remain zero unless `with_slopes`.
    pub(super) fn of(
        modes: usize,
        with_slopes: bool,
        rest: &Scanned,
        bare: impl Fn(&[[f64; 2]], Channels) -> Scanned,
    ) -> Self {
        let zero = vec![[0.0; 2]; modes];
        let by_held = bare(&zero, [1.0; CHANNELS]);
        let outputs = |pick: fn(&Scanned) -> Channels| Outputs {
            by_state: Vec::new(),
            by_held: pick(&by_held),
            constant: pick(rest),
        };
        let mut free_response = Self {
            modes: vec![[[0.0; 2]; 2]; modes],
            slope: with_slopes.then(|| outputs(|s| s.sampled.slope)),
            sampled: outputs(|s| s.sampled.value),
            held: outputs(|s| s.held.output),
            input: outputs(|s| s.held.input),
        };
        for mode in 0..modes {
            let responses = [0, 1].map(|component| {
                let mut state = zero.clone();
                state[mode][component] = 1.0;
                let scanned = bare(&state, [0.0; CHANNELS]);
                for row in 0..2 {
                    free_response.modes[mode][row][component] = scanned.states[mode][row];
                }
                scanned
            });
            if let Some(slope) = &mut free_response.slope {
                slope.by_state.push([0, 1].map(|c| responses[c].sampled.slope));
            }
            free_response.sampled.by_state.push([0, 1].map(|c| responses[c].sampled.value));
            free_response.held.by_state.push([0, 1].map(|c| responses[c].held.output));
            free_response.input.by_state.push([0, 1].map(|c| responses[c].held.input));
        }
        free_response
    }

    /// True when no reading is near the end of the range in which its channel is linear.
    pub(super) fn admits(held: &ChainState, range: &Channels) -> bool {
        held.input.iter().zip(range).all(|(x, range)| x.abs() < CERTAINLY_WITHIN * range)
    }

    /// Advances states and chain by one scan and returns the samples taken in it.
    pub(super) fn scan(&self, states: &mut [[f64; 2]], held: &mut ChainState) -> Sampled {
        let slope = self.slope.as_ref().map(|slope| slope.of(states, &held.output));
        let sampled = Sampled {
            value: self.sampled.of(states, &held.output),
            slope: slope.unwrap_or([0.0; CHANNELS]),
        };
        *held = ChainState {
            output: self.held.of(states, &held.output),
            input: self.input.of(states, &held.output),
        };
        for (state, rows) in states.iter_mut().zip(&self.modes) {
            *state = rows.map(|[of_q, of_v]| of_q * state[0] + of_v * state[1]);
        }
        sampled
    }
}

impl Outputs {
    fn of(&self, states: &[[f64; 2]], held: &Channels) -> Channels {
        let mut values = self.constant;
        for k in 0..CHANNELS {
            values[k] += self.by_held[k] * held[k];
        }
        for ([q, v], [by_q, by_v]) in states.iter().zip(&self.by_state) {
            for k in 0..CHANNELS {
                values[k] += by_q[k] * q + by_v[k] * v;
            }
        }
        values
    }
}

/// The outcome of one scan of free motion.
#[derive(Clone, Debug)]
pub(super) struct Scanned {
    pub(super) sampled: Sampled,
    pub(super) held: ChainState,
    pub(super) states: Vec<[f64; 2]>,
}
