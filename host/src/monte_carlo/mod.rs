//! Many tests on the bench, each from ADC codes to the ten properties, against the truth and the
//! Cramér-Rao bound.
//!
//! ```text
//! seed ─▶ run 1, 2, … N: bench ─▶ ADC codes ─▶ record ─▶ grade ─▶ spectra ─▶ mass lines ─▶ every method
//!                                                                                              │
//!                          bias, rms error / bound, coverage of the intervals ◀────────────────┘
//! ```
//! A run is what the rig does, by the same measurement, in double precision: the rig's single
//! precision moves an estimate by a small part of its standard deviation. Every run has a seed of its
//! own, made of the study's seed and the number of the run, so the answer does not depend on how many
//! threads there are.
//!
//! | module | subject |
//! | --- | --- |
//! | [`measurement`] | one test on the bench, without a rig |
//! | [`statistics`] | what many runs say of a method |
//! | [`report`] | as JSON and as tables |

pub mod measurement;
pub mod report;
pub mod statistics;

use std::num::NonZeroUsize;

use massline_shared::diagnosis::Diagnostics;
use massline_shared::identify::maximum_likelihood::{self, RIG_WORKSPACE};
use massline_shared::identify::{Estimate, Method};
use massline_shared::layout::{HitUncertainty, RIG_SENSORS, SensorUncertainty};
use massline_shared::responses::Responses;
use massline_shared::signal::Calibration;
use massline_virtual::bench::{Bench, BenchError, BenchSource};
use rayon::ThreadPoolBuilder;

use crate::Error;
use crate::interrupt::Interrupt;
use crate::parallel::pieces;
use measurement::{SimulatedTest, TestLayout, Unmeasured, measure};
use statistics::MethodStatistics;

/// What is repeated.
#[derive(Clone, Copy, Debug)]
pub struct MonteCarlo<'a> {
    /// The object and the chain.
    pub bench: &'a Bench,
    /// Where sensors and marks are meant to be, and the budget that the methods believe in.
    pub layout: &'a TestLayout,
    /// What the rig believes of its channels.
    pub calibration: &'a Calibration,
    /// Seed of everything random.
    pub seed: u64,
    /// How often.
    pub runs: u64,
    /// Threads; all cores of the machine without a number.
    pub threads: Option<NonZeroUsize>,
}

/// What came of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Runs that were wanted.
    pub wanted: u64,
    /// Runs that were completed: all, unless Ctrl-C was pressed.
    pub runs: u64,
    /// Runs without mass lines, and the first one's reason.
    pub unmeasured: Option<(u64, Unmeasured)>,
    /// Hits over all runs that were rejected and repeated.
    pub rejected_hits: u64,
    /// Method by method.
    pub methods: Vec<MethodStatistics>,
}

impl Study {
    /// True when there was one run: there are errors, and no statistics.
    pub fn is_single(&self) -> bool {
        self.runs == 1
    }
}

/// What came of one run.
type Run = Result<SimulatedTest, Unmeasured>;

impl MonteCarlo<'_> {
    /// Runs until all are done or the user presses Ctrl-C; `progress` hears of every run that is done.
    ///
    /// # Errors
    /// When the layout cannot be measured on the bench, or the system does not give so many threads.
    pub fn run(
        &self,
        interrupt: &Interrupt,
        progress: impl FnMut(u64) + Send,
    ) -> crate::Result<Study> {
        // What is wrong with one seed is wrong with all.
        self.source(0)?;
        // Zero threads are as many as there are cores.
        let threads = self.threads.map_or(0, NonZeroUsize::get);
        let threads = ThreadPoolBuilder::new().num_threads(threads).build().map_err(|e| {
            Error::internal("no_threads", format!("{e}; give fewer with --threads"))
        })?;
        let runs = threads.install(|| {
            pieces(self.runs, interrupt, progress, || (), |(), number| self.one(number))
        });
        Ok(self.study(&runs.into_iter().collect::<Result<Vec<Run>, _>>()?))
    }

    fn source(&self, number: u64) -> Result<BenchSource, BenchError> {
        let layout = self.layout.cast().unwrap_or_default();
        BenchSource::new(self.bench, &layout, seed_of_run(self.seed, number))
    }

    fn one(&self, number: u64) -> Result<Run, BenchError> {
        let mut source = self.source(number)?;
        Ok(measure(&mut source, self.layout, self.calibration))
    }

    /// The Cramér-Rao bound at the truth, under the layout's budget and the noise that the mass line
    /// fits have told in the mean.
    fn bound(&self, runs: &[Run]) -> Option<[f64; 10]> {
        let noise = mean_noise(runs, self.layout.hits.len());
        let noise = |index: usize| noise.get(index).copied().unwrap_or_else(Responses::zeros);
        let hits = u16::from(self.layout.test.hits_per_dof);
        let mut workspace = [0.0; RIG_WORKSPACE];
        let truth = self.bench.truth();
        let bound = maximum_likelihood::bound(self.layout, &truth, noise, hits, &mut workspace)?;
        Some(bound.sigma().into())
    }

    fn study(&self, runs: &[Run]) -> Study {
        let truth: [f64; 10] = self.bench.truth().theta().into();
        let bound = self.bound(runs);
        let methods = Method::of_mass_lines().map(|method| {
            let answers: Vec<_> = runs.iter().map(|run| answer_of(method, run)).collect();
            MethodStatistics::of(method, &answers, &truth, bound.as_ref())
        });
        let failed = || runs.iter().filter_map(|run| run.as_ref().err());
        let measured = runs.iter().flatten();
        Study {
            wanted: self.runs,
            runs: runs.len() as u64,
            unmeasured: failed().next().map(|first| (failed().count() as u64, first.clone())),
            rejected_hits: measured.map(|m| u64::from(m.rejected)).sum(),
            methods: methods.collect(),
        }
    }
}

/// Mean over the runs of the variances that the mass line fits tell, as standard deviations, hit DOF
/// by hit DOF.
fn mean_noise(runs: &[Run], dofs: usize) -> Vec<Responses<f64, RIG_SENSORS>> {
    let mut sums = vec![(0.0, Responses::<f64, RIG_SENSORS>::zeros()); dofs];
    for (index, lines) in runs.iter().flatten().flat_map(|measured| &measured.dofs) {
        if let Some((count, sum)) = sums.get_mut(*index) {
            *count += 1.0;
            *sum += lines.noise.map(|sigma| sigma * sigma);
        }
    }
    sums.into_iter().map(|(count, sum)| sum.map(|v| (v / f64::max(count, 1.0)).sqrt())).collect()
}

/// The budget of the layout becomes the true one of the bench, which has no errors of the marks.
pub fn apply_bench_budget(layout: &mut TestLayout, bench: &Bench) {
    for sensor in &mut layout.sensors {
        sensor.uncertainty = SensorUncertainty {
            position: bench.sensor.position_sigma_m,
            rotation: bench.sensor.rotation_sigma_rad,
            gain: bench.sensor.gain_sigma,
            cross_axis: bench.sensor.cross_axis_sigma,
        };
    }
    for hit in &mut layout.hits {
        hit.uncertainty = HitUncertainty {
            position: bench.tap.point_sigma_m,
            direction: bench.tap.direction_sigma_rad,
            ..HitUncertainty::none()
        };
    }
    layout.hammer_gain = bench.hammer.gain_sigma;
}

/// The seed of a run: SplitMix64 (Steele, Lea, Flood 2014) at place `number` of the sequence that
/// begins with `seed`.
pub fn seed_of_run(seed: u64, number: u64) -> u64 {
    let mut z = seed.wrapping_add(number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// What a method answers in a run; without a reason when the run has no mass lines.
fn answer_of(method: Method, run: &Run) -> Result<Estimate<f64>, Option<Diagnostics>> {
    let measured = run.as_ref().map_err(|_| None)?;
    let answer = measured.estimates.iter().find(|estimate| estimate.method == method);
    let refusal = || measured.refusals.iter().find(|(of, _)| *of == method);
    answer.cloned().ok_or_else(|| refusal().map(|(_, reasons)| reasons.clone()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seeds_of_runs_follow_splitmix64() {
        // The first three outputs of the published generator from state 1234567.
        let seeds = [0, 1, 2].map(|number| seed_of_run(1_234_567, number));
        assert_eq!(
            seeds,
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        );
    }
}
