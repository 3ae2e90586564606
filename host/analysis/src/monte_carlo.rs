//! Many tests on the bench, each from ADC codes to the ten properties, against the truth and the
//! Cramér-Rao bound.
//!
//! ```text
//! seed ─▶ run 1, 2, … N: bench ─▶ ADC codes ─▶ record ─▶ grade ─▶ spectra ─▶ mass lines ─▶ every method
//!                                                                                              │
//!                          bias, rms error / bound, coverage of the intervals ◀────────────────┘
//! ```
//! A run does what the rig does, with the same measurement code, but in double precision: the rig's single
//! precision changes an estimate by a small part of its standard deviation. The seed of a run is derived from
//! the study's seed and the number of the run, so the answer does not depend on the number of threads.
//!
//! | module | subject |
//! | --- | --- |
//! | [`measurement`] | one test on the bench, without a rig |
//! | [`statistics`] | statistics of a method over many runs |

pub mod measurement;
pub mod statistics;

use std::num::NonZeroUsize;

use massline_physics::{Bench, BenchError, BenchSource, ErrorSizes};
use massline_result::Doubt;
use massline_shared::capacity::Rig;
use massline_shared::diagnosis::{Diagnostic, Diagnostics, Severity};
use massline_shared::identify::agreement::Agreement;
use massline_shared::identify::maximum_likelihood::{self, RIG_WORKSPACE};
use massline_shared::identify::{Estimate, Method};
use massline_shared::layout::{ApparatusUncertainty, CalibratedGains, RIG_SENSORS, TestProfile};
use massline_shared::responses::Responses;
use massline_shared::signal::Calibration;

use crate::bench_error::bench_error;
use crate::parallel::{Interrupted, pieces};
use measurement::{MeasureError, SimulatedTest, TestLayout, measure};
use statistics::{MethodStatistics, StoppingStatistics};

/// The settings of a study.
#[derive(Clone, Copy, Debug)]
pub struct MonteCarlo<'a> {
    /// The simulated object and measuring chain.
    pub bench: &'a Bench,
    /// The nominal places of sensors and marks, and the error budget that the methods assume.
    pub layout: &'a TestLayout,
    /// The calibration that the rig assumes.
    pub calibration: &'a Calibration,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Number of runs.
    pub runs: u64,
    /// Number of threads; `None` for all cores.
    pub threads: Option<NonZeroUsize>,
}

/// The results of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Study {
    /// Number of runs requested.
    pub wanted: u64,
    /// What was measured.
    pub profile: TestProfile,
    /// Number of runs completed: all, unless it was interrupted.
    pub runs: u64,
    /// Number of runs without mass lines, and the reason in the first of them.
    pub unmeasured: Option<(u64, MeasureError)>,
    /// Number of hits in all runs that were rejected and repeated.
    pub rejected_hits: u64,
    /// Number of runs whose result carries a warning or an error, or in which a hit was rejected.
    pub warned: u64,
    /// Number of other runs in which the best method is wrong about a property by more than three standard
    /// deviations.
    pub silent: u64,
    /// How the runs came to the target of the layout; `None` without one.
    pub stopping: Option<StoppingStatistics>,
    /// Statistics of each method; at the stop, for a layout with a target.
    pub methods: Vec<MethodStatistics>,
}

impl Study {
    /// True when there was only one run, which has errors but no statistics.
    pub fn is_single(&self) -> bool {
        self.runs == 1
    }

    /// True when there were runs, and no method has an answer in any of them.
    pub fn is_futile(&self) -> bool {
        self.runs > 0 && self.methods.iter().all(|method| method.answers == 0)
    }
}

/// The result of one run.
pub type Run = Result<SimulatedTest, MeasureError>;

impl MonteCarlo<'_> {
    /// Runs until all runs are done or it `is_interrupted`; `progress` is called after each run.
    ///
    /// # Errors
    /// When the layout cannot be measured on the bench.
    pub fn run(
        &self,
        is_interrupted: Interrupted<'_>,
        progress: impl FnMut(u64) + Send,
    ) -> crate::Result<Study> {
        Ok(self.study(&self.runs(is_interrupted, progress)?))
    }

    /// The first runs of the study, at most so many.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn first_runs(&self, most: u64, is_interrupted: Interrupted<'_>) -> crate::Result<Study> {
        let few = Self { runs: self.runs.min(most), ..*self };
        Ok(Study { wanted: self.runs, ..few.run(is_interrupted, |_| ())? })
    }

    /// The single runs, in the order of their numbers.
    ///
    /// # Errors
    /// As [`Self::run`].
    pub fn runs(
        &self,
        is_interrupted: Interrupted<'_>,
        progress: impl FnMut(u64) + Send,
    ) -> crate::Result<Vec<Run>> {
        // An error does not depend on the seed, so one attempt finds it.
        self.source(0).map_err(bench_error)?;
        let one = |(): &mut (), number| self.one(number);
        let runs = pieces(self.runs, self.threads, is_interrupted, progress, || (), one);
        runs.into_iter().collect::<Result<Vec<Run>, _>>().map_err(bench_error)
    }

    fn source(&self, number: u64) -> Result<BenchSource, BenchError> {
        let layout = self.layout.cast().unwrap_or_default();
        BenchSource::new(self.bench, &layout, seed_of_run(self.seed, number))
    }

    fn one(&self, number: u64) -> Result<Run, BenchError> {
        let mut source = self.source(number)?;
        Ok(measure(&mut source, self.layout, self.calibration))
    }

    /// The Cramér-Rao bound at the truth, with the errors that the bench really has and the mean noise that the
    /// mass line fits estimate.
    ///
    /// In the suspension profile: the root mean square of the standard deviations of the global fit, which reaches the
    /// bound.
    fn bound(&self, runs: &[Run]) -> Option<[f64; 10]> {
        if self.layout.test.profile == TestProfile::Suspension {
            return mean_sigma(Method::GlobalFit, runs);
        }
        let mut layout = self.layout.clone();
        apply_bench_budget(&mut layout, self.bench);
        let noise = mean_noise(runs, self.layout.hits.len());
        let noise = |index: usize| noise[index].clone();
        let hits = u16::from(self.layout.test.hits_per_dof);
        let mut workspace = [0.0; RIG_WORKSPACE];
        let truth = self.bench.truth();
        let bound = maximum_likelihood::bound(&layout, &truth, noise, hits, &mut workspace)?;
        Some(bound.sigma().into())
    }

    fn stopping(&self, runs: &[Run], truth: &[f64; 10]) -> StoppingStatistics {
        let test = self.layout;
        let mut sums = StoppingStatistics {
            hits: test.hits.len() as u64 * u64::from(test.test.hits_per_dof),
            ..StoppingStatistics::default()
        };
        for measured in runs.iter().flatten() {
            let holding = intervals_that_hold(measured, truth);
            sums.add(measured.reached, measured.hits_saved as u64, holding);
        }
        sums
    }

    /// The statistics of runs.
    pub fn study(&self, runs: &[Run]) -> Study {
        let truth: [f64; 10] = self.bench.truth().theta().into();
        let bound = self.bound(runs);
        let profile = self.layout.test.profile;
        let statistics = |method| {
            let answers: Vec<_> = runs.iter().map(|run| answer_of(method, run)).collect();
            MethodStatistics::of(Some(method), &answers, &truth, bound.as_ref())
        };
        let methods = match profile {
            TestProfile::MassLine => Method::of_mass_lines().map(statistics).collect(),
            TestProfile::Suspension => {
                let combined: Vec<_> = runs.iter().map(combined_answer).collect();
                let combined = MethodStatistics::of(None, &combined, &truth, bound.as_ref());
                Method::of_modes()
                    .chain([Method::GlobalFit])
                    .map(statistics)
                    .chain([combined])
                    .collect()
            }
        };
        let failed = || runs.iter().filter_map(|run| run.as_ref().err());
        let measured = runs.iter().flatten();
        Study {
            wanted: self.runs,
            profile,
            runs: runs.len() as u64,
            unmeasured: failed().next().map(|first| (failed().count() as u64, first.clone())),
            rejected_hits: runs.iter().map(|run| u64::from(rejected(run))).sum(),
            warned: measured.clone().filter(|m| m.warns()).count() as u64,
            stopping: self.layout.target.is_set().then(|| self.stopping(runs, &truth)),
            silent: measured.filter(|m| !m.warns() && is_wrong(m, &truth)).count() as u64,
            methods,
        }
    }
}

/// The best answer of a run against the truth: how many of its ten 95 % intervals hold it.
fn intervals_that_hold(measured: &SimulatedTest, truth: &[f64; 10]) -> Option<u64> {
    let best = measured.estimates.first()?;
    let (theta, half) = (best.theta(), best.half_widths()?);
    let holds = |&k: &usize| (theta[k] - truth[k]).abs() <= half[k];
    Some((0..10).filter(holds).count() as u64)
}

/// Number of rejected hits in a run, with an answer or without.
fn rejected(run: &Run) -> u16 {
    run.as_ref().map_or_else(MeasureError::rejected, |measured| measured.rejected)
}

/// True when a property of the best answer is wrong by more than three of its standard deviations.
fn is_wrong(measured: &SimulatedTest, truth: &[f64; 10]) -> bool {
    let Some(best) = measured.estimates.first() else { return false };
    let Some(sigma) = best.sigma() else { return false };
    let theta = best.theta();
    (0..10).any(|k| (theta[k] - truth[k]).abs() > 3.0 * sigma[k])
}

/// Root mean square over the runs of the standard deviations that the mass line fits estimate, by hit DOF.
fn mean_noise(runs: &[Run], dofs: usize) -> Vec<Responses<f64, Rig>> {
    let mut sums = vec![(0.0, Responses::<f64, Rig>::zeros(RIG_SENSORS)); dofs];
    for (index, lines) in runs.iter().flatten().flat_map(|measured| &measured.dofs) {
        if let Some((count, sum)) = sums.get_mut(*index) {
            *count += 1.0;
            *sum += &lines.noise.map(|sigma| sigma * sigma);
        }
    }
    sums.into_iter().map(|(count, sum)| sum.map(|v| (v / f64::max(count, 1.0)).sqrt())).collect()
}

/// Replaces the budget of the layout by the true one of the bench, used as it is.
pub fn apply_bench_budget(layout: &mut TestLayout, bench: &Bench) {
    let sizes = ErrorSizes::of(bench, &layout.cast().unwrap_or_default());
    for (sensor, uncertainty) in layout.sensors.iter_mut().zip(sizes.sensors) {
        sensor.uncertainty = uncertainty;
        sensor.calibrated = CalibratedGains::default();
    }
    for (hit, uncertainty) in layout.hits.iter_mut().zip(sizes.hits) {
        hit.uncertainty = uncertainty;
    }
    let converter_gain = layout.apparatus.converter_gain;
    layout.apparatus = ApparatusUncertainty { converter_gain, ..sizes.apparatus };
    layout.calibrated_hammer = false;
    layout.learn_budget = false;
}

/// The seed of a run: element `number` of the SplitMix64 sequence (Steele, Lea, Flood 2014) that begins with
/// `seed`.
pub fn seed_of_run(seed: u64, number: u64) -> u64 {
    let mut z = seed.wrapping_add(number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15));
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// Root mean square over the runs of the standard deviations of a method; `None` without an answer.
fn mean_sigma(method: Method, runs: &[Run]) -> Option<[f64; 10]> {
    let answers = runs.iter().filter_map(|run| answer_of(method, run).ok()?.sigma());
    let squares: Vec<_> = answers.map(|sigma| sigma.component_mul(&sigma)).collect();
    let count = squares.len() as f64;
    let sum = squares.into_iter().reduce(|sum, next| sum + next)?;
    Some((sum / count).map(f64::sqrt).into())
}

/// What all methods of a run say together.
fn combined_answer(run: &Run) -> Result<Agreement<f64>, Option<Diagnostics>> {
    let measured = run.as_ref().map_err(|_| None)?;
    // Without a doubt, the reasons of the methods are those of the combination.
    let of_methods = || measured.refusals.first().map(|(_, reasons)| reasons.clone());
    let reason = |doubt: Doubt| Diagnostic::whole(doubt.code(), Severity::Error, 0.0);
    let reasons = || measured.doubt.map(|doubt| Diagnostics::from_array([reason(doubt)]));
    measured.combined.clone().ok_or_else(|| reasons().or_else(of_methods))
}

/// The answer of a method in a run; an error without a reason when the run has no mass lines.
fn answer_of(method: Method, run: &Run) -> Result<Estimate<f64>, Option<Diagnostics>> {
    let measured = run.as_ref().map_err(|_| None)?;
    let answer = measured.estimates.iter().find(|estimate| estimate.method == method);
    let refusal = || measured.refusals.iter().find(|(refused, _)| *refused == method);
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
