//! Computes motion without a tap one whole scan at a time.
//!
//! Between taps nothing clips, and the loads of the environment change linearly over a scan, so the outputs at
//! the next scan are a linear function of the present state of the oscillators and low-passes and of the loads
//! at both ends of the scan. The factors are found by stepping through one scan from every unit state and
//! load; the results equal those of the steps up to rounding.

use massline_shared::signal::CHANNELS;

use super::chain::ChainState;
use super::channels::{Channels, SampledOutputs};
use super::dynamics::Step;
use super::environment::Load;

/// Readings beyond this fraction of a sensor's range are computed by steps, which clip.
const CERTAINLY_WITHIN: f64 = 0.5;

/// The factors of one scan.
#[derive(Clone, Debug)]
pub(super) struct FreeResponse {
    /// The step of every mode over a scan.
    modes: Vec<Step>,
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
    /// Factors of the loads at the beginning and at the end of the scan, empty without an environment.
    by_load: Vec<[Channels; 2]>,
    /// Factors of the output of the channel's low-pass.
    by_held: Channels,
    /// The value at rest.
    constant: Channels,
}

/// What acts on the object during a scan: the loads at its beginning and end, and their modal forces.
#[derive(Clone, Copy, Debug)]
pub(super) struct ActingForces<'a> {
    pub(super) loads: &'a [Load; 2],
    pub(super) forces: [&'a [f64]; 2],
}

/// Where a scan starts from, to find the factors: motion of the modes, outputs of the low-passes, loads.
#[derive(Clone, Debug)]
pub(super) struct Start {
    pub(super) states: Vec<[f64; 2]>,
    pub(super) output: Channels,
    pub(super) loads: [Load; 2],
}

impl FreeResponse {
    /// Determines the factors from scans that never clip: `rest` starts without motion and with low-pass
    /// outputs of zero; `bare` starts anywhere, with sensors that read zero at rest. Rates of change remain zero
    /// unless `with_slopes`, and loads are left out unless `with_loads`.
    pub(super) fn of(
        modes: Vec<Step>,
        [with_slopes, with_loads]: [bool; 2],
        rest: &FreeScan,
        bare: impl Fn(&Start) -> FreeScan,
    ) -> Self {
        let zero = Start {
            states: vec![[0.0; 2]; modes.len()],
            output: [0.0; CHANNELS],
            loads: [Load::zeros(); 2],
        };
        let by_held = bare(&Start { output: [1.0; CHANNELS], ..zero.clone() });
        let by_state: Vec<[FreeScan; 2]> = (0..modes.len())
            .map(|mode| {
                [0, 1].map(|component| {
                    let mut start = zero.clone();
                    start.states[mode][component] = 1.0;
                    bare(&start)
                })
            })
            .collect();
        let by_load: Vec<[FreeScan; 2]> = (0..if with_loads { 6 } else { 0 })
            .map(|component| {
                [0, 1].map(|end| {
                    let mut start = zero.clone();
                    start.loads[end][component] = 1.0;
                    bare(&start)
                })
            })
            .collect();
        let outputs = |pick: fn(&FreeScan) -> Channels| Outputs {
            by_state: by_state.iter().map(|pair| [0, 1].map(|i| pick(&pair[i]))).collect(),
            by_load: by_load.iter().map(|pair| [0, 1].map(|i| pick(&pair[i]))).collect(),
            by_held: pick(&by_held),
            constant: pick(rest),
        };
        Self {
            modes,
            slope: with_slopes.then(|| outputs(|s| s.sampled.slope)),
            sampled: outputs(|s| s.sampled.value),
            held: outputs(|s| s.held.output),
            input: outputs(|s| s.held.input),
        }
    }

    /// True when no reading is near the end of the range in which its channel is linear.
    pub(super) fn admits(readings: &Channels, range: &Channels) -> bool {
        readings.iter().zip(range).all(|(x, range)| x.abs() < CERTAINLY_WITHIN * range)
    }

    /// Advances states and chain by one scan and returns the samples taken in it. The input of the chain is left as it
    /// was unless it is wanted.
    pub(super) fn scan(
        &self,
        states: &mut [[f64; 2]],
        held: &mut ChainState,
        acting: &ActingForces,
        input_wanted: bool,
    ) -> SampledOutputs {
        let evaluate = |outputs: &Outputs| outputs.of(states, &held.output, acting.loads);
        let sampled = SampledOutputs {
            value: evaluate(&self.sampled),
            slope: self.slope.as_ref().map_or([0.0; CHANNELS], evaluate),
        };
        let input = if input_wanted { evaluate(&self.input) } else { held.input };
        *held = ChainState { output: evaluate(&self.held), input };
        let [before, after] = acting.forces;
        for ((state, step), (before, after)) in
            states.iter_mut().zip(&self.modes).zip(before.iter().zip(after))
        {
            step.advance(state, *before, *after);
        }
        sampled
    }
}

impl Outputs {
    fn of(&self, states: &[[f64; 2]], held: &Channels, [before, after]: &[Load; 2]) -> Channels {
        let mut values = self.constant;
        for k in 0..CHANNELS {
            values[k] += self.by_held[k] * held[k];
        }
        let loads = before.iter().zip(after).map(|(a, b)| (*a, *b));
        let states = states.iter().map(|[q, v]| (*q, *v));
        let contributions = states.zip(&self.by_state).chain(loads.zip(&self.by_load));
        for ((a, b), [by_a, by_b]) in contributions {
            for k in 0..CHANNELS {
                values[k] += by_a[k] * a + by_b[k] * b;
            }
        }
        values
    }
}

/// The outcome of one scan of free motion.
#[derive(Clone, Debug)]
pub(super) struct FreeScan {
    pub(super) sampled: SampledOutputs,
    pub(super) held: ChainState,
}
