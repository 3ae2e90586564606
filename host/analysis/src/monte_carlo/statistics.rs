//! Statistics of a method over many runs: bias, error relative to the bound, coverage of the intervals.

use massline_shared::diagnosis::{Code, Diagnostics};
use massline_shared::identify::agreement::Agreement;
use massline_shared::identify::{Estimate, HALF_WIDTH_95, Method};
use nalgebra::SVector;

/// An answer with its intervals.
pub trait Answer {
    /// The ten properties, SI.
    fn theta(&self) -> SVector<f64, 10>;
    /// Half widths of their 95 % intervals; `None` when they are unknown.
    fn half_widths(&self) -> Option<SVector<f64, 10>>;
}

impl Answer for Estimate<f64> {
    fn theta(&self) -> SVector<f64, 10> {
        Self::theta(self)
    }

    fn half_widths(&self) -> Option<SVector<f64, 10>> {
        Self::half_widths(self)
    }
}

impl Answer for Agreement<f64> {
    fn theta(&self) -> SVector<f64, 10> {
        self.theta
    }

    fn half_widths(&self) -> Option<SVector<f64, 10>> {
        Some(self.covariance.diagonal().map(|variance| HALF_WIDTH_95 * variance.sqrt()))
    }
}

/// Statistics of a method over all runs.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodStatistics {
    /// The method; `None` for the combined estimate of all methods.
    pub method: Option<Method>,
    /// Number of runs with an answer; all statistics below are over these.
    pub answers: usize,
    /// Number of runs in which the method had no answer.
    pub unanswered: usize,
    /// The reason in the first of those runs that had mass lines.
    pub refusal: Option<Diagnostics>,
    /// The first reason in each of them: how often which, the most frequent first.
    pub reasons: Vec<(Code, usize)>,
    /// The ten properties, in the order of `theta`; empty without an answer.
    pub properties: Vec<PropertyStatistics>,
}

/// Statistics of one property over all runs of a method; SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PropertyStatistics {
    /// The true value on the bench.
    pub truth: f64,
    /// Mean error.
    pub bias: f64,
    /// Root mean square error, the bias included; `None` for a single answer.
    pub rms: Option<f64>,
    /// Cramér-Rao bound of the standard deviation; `None` when the layout has no bound.
    pub bound: Option<f64>,
    /// Share of the answers with a standard deviation whose 95 % interval contains the truth; `None` when
    /// there is no such answer or only a single one.
    pub coverage95: Option<f64>,
    /// Mean half width of the 95 % intervals; `None` without a standard deviation.
    pub half_width95: Option<f64>,
}

/// How the runs came to the target of their layout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StoppingStatistics {
    /// Hits of a whole campaign.
    pub hits: u64,
    /// Number of runs with mass lines.
    pub runs: u64,
    /// Number of runs that reached the target, at the last DOF or before.
    pub reached: u64,
    /// Hits saved in all runs.
    pub hits_saved: u64,
    /// Number of 95 % intervals of the best answers, ten for each, in the runs that reached the target, and how
    /// many of them hold the truth.
    pub at_target: [u64; 2],
    /// The same of the other runs.
    pub missed: [u64; 2],
}

impl StoppingStatistics {
    /// Adds a run; `holding` is the number of its ten intervals that hold the truth.
    pub fn add(&mut self, reached: bool, hits_saved: u64, holding: Option<u64>) {
        self.runs += 1;
        self.reached += u64::from(reached);
        self.hits_saved += hits_saved;
        if let Some(holding) = holding {
            let [intervals, hold] = if reached { &mut self.at_target } else { &mut self.missed };
            (*intervals, *hold) = (*intervals + 10, *hold + holding);
        }
    }

    /// Share of the intervals of all runs that hold the truth, each run at its end.
    pub fn coverage95(&self) -> Option<f64> {
        share([0, 1].map(|k| self.at_target[k] + self.missed[k]))
    }

    /// The same of the runs that reached the target.
    pub fn coverage95_at_target(&self) -> Option<f64> {
        share(self.at_target)
    }

    /// Mean number of hits that a run saved.
    pub fn mean_hits_saved(&self) -> f64 {
        self.hits_saved as f64 / self.runs.max(1) as f64
    }
}

fn share([intervals, hold]: [u64; 2]) -> Option<f64> {
    (intervals > 0).then(|| hold as f64 / intervals as f64)
}

impl PropertyStatistics {
    /// Root mean square error over the bound.
    pub fn ratio(&self) -> Option<f64> {
        Some(self.rms? / self.bound?)
    }

    /// Mean half width of the 95 % intervals over that which the bound permits.
    pub fn width_ratio(&self) -> Option<f64> {
        Some(self.half_width95? / (HALF_WIDTH_95 * self.bound?))
    }
}

impl MethodStatistics {
    /// Computes the statistics from the runs' answers, in the order of the runs; an error without a reason
    /// belongs to a run without mass lines.
    pub fn of<A: Answer>(
        method: Option<Method>,
        answers: &[Result<A, Option<Diagnostics>>],
        truth: &[f64; 10],
        bound: Option<&[f64; 10]>,
    ) -> Self {
        let answered: Vec<&A> = answers.iter().flatten().collect();
        let properties = if answered.is_empty() {
            Vec::new()
        } else {
            (0..10).map(|k| property(&answered, k, truth[k], bound.map(|b| b[k]))).collect()
        };
        Self {
            method,
            answers: answered.len(),
            unanswered: answers.len() - answered.len(),
            refusal: answers.iter().find_map(|a| a.as_ref().err()?.clone()),
            reasons: counted(answers.iter().filter_map(|a| a.as_ref().err()?.as_ref())),
            properties,
        }
    }

    /// Name of the method, or `combined`.
    pub fn name(&self) -> &'static str {
        self.method.map_or("combined", Method::name)
    }

    /// True when there was a single run, which has an error but no statistics.
    pub fn is_single(&self) -> bool {
        self.answers == 1
    }

    /// Geometric mean over the inertial parameters of the ratio of error to bound.
    pub fn geometric_mean_ratio(&self) -> Option<f64> {
        Some(geometric_mean(&self.all(PropertyStatistics::ratio)?))
    }

    /// Geometric mean over the inertial parameters of the mean width of the intervals over that which the
    /// bound permits.
    pub fn geometric_mean_width(&self) -> Option<f64> {
        Some(geometric_mean(&self.all(PropertyStatistics::width_ratio)?))
    }

    /// Largest ratio of error to bound of the ten properties.
    pub fn worst_ratio(&self) -> Option<f64> {
        Some(self.all(PropertyStatistics::ratio)?.into_iter().fold(0.0, f64::max))
    }

    /// Share of all intervals, those of the ten properties together, that contain the truth.
    pub fn pooled_coverage95(&self) -> Option<f64> {
        let shares: Option<Vec<f64>> = self.properties.iter().map(|p| p.coverage95).collect();
        let shares = shares.filter(|shares| !shares.is_empty())?;
        Some(shares.iter().sum::<f64>() / shares.len() as f64)
    }

    /// A number of all ten properties; `None` when one lacks it.
    fn all(&self, number: fn(&PropertyStatistics) -> Option<f64>) -> Option<Vec<f64>> {
        let numbers: Option<Vec<f64>> = self.properties.iter().map(number).collect();
        numbers.filter(|numbers| !numbers.is_empty())
    }
}

/// How often each code is the first of the reasons.
fn counted<'d>(refusals: impl Iterator<Item = &'d Diagnostics>) -> Vec<(Code, usize)> {
    let mut counts: Vec<(Code, usize)> = Vec::new();
    for code in refusals.filter_map(|reasons| Some(reasons.first()?.code)) {
        match counts.iter_mut().find(|(counted, _)| *counted == code) {
            Some((_, count)) => *count += 1,
            None => counts.push((code, 1)),
        }
    }
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    counts
}

fn geometric_mean(values: &[f64]) -> f64 {
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len() as f64).exp()
}

fn property<A: Answer>(
    answered: &[&A],
    k: usize,
    truth: f64,
    bound: Option<f64>,
) -> PropertyStatistics {
    let count = answered.len() as f64;
    let errors = answered.iter().map(|a| a.theta()[k] - truth);
    let bias = errors.clone().sum::<f64>() / count;
    let many = answered.len() > 1;
    let rms = many.then(|| (errors.clone().map(|e| e * e).sum::<f64>() / count).sqrt());
    let held: Vec<bool> = answered
        .iter()
        .zip(errors)
        .filter_map(|(a, error)| Some(error.abs() <= a.half_widths()?[k]))
        .collect();
    let coverage95 = (many && !held.is_empty())
        .then(|| held.iter().filter(|&&holds| holds).count() as f64 / held.len() as f64);
    let widths: Vec<f64> = answered.iter().filter_map(|a| Some(a.half_widths()?[k])).collect();
    let half_width95 =
        (!widths.is_empty()).then(|| widths.iter().sum::<f64>() / widths.len() as f64);
    PropertyStatistics { truth, bias, rms, bound, coverage95, half_width95 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use massline_shared::body::RigidBody;
    use massline_shared::diagnosis::{Diagnostic, Severity};
    use nalgebra::SMatrix;

    const TRUTH: [f64; 10] = [1.0; 10];

    type Answer = Result<Estimate<f64>, Option<Diagnostics>>;

    fn answer(error: f64, sigma: Option<f64>) -> Answer {
        Ok(Estimate {
            method: Method::InertiaRestraint,
            body: RigidBody::from_theta(&SVector::from(TRUTH.map(|v| v + error))),
            covariance: sigma.map(|s| SMatrix::identity() * (s * s)),
            condition: 1.0,
            consistency: None,
            learned: None,
            diagnostics: Diagnostics::new(),
        })
    }

    fn statistics(answers: &[Answer], bound: Option<f64>) -> MethodStatistics {
        let bound = bound.map(|b| [b; 10]);
        MethodStatistics::of(Some(Method::InertiaRestraint), answers, &TRUTH, bound.as_ref())
    }

    #[test]
    fn bias_and_rms_are_those_of_the_errors() {
        let s = statistics(&[answer(0.5, None), answer(-0.25, None)], Some(0.125));
        let p = s.properties[3];
        // Exact in binary except for the root.
        assert_eq!(p.bias, 0.125);
        assert!((p.rms.unwrap() - 0.15625_f64.sqrt()).abs() < 1e-15);
        assert!((s.worst_ratio().unwrap() - 0.15625_f64.sqrt() / 0.125).abs() < 1e-14);
        assert!((s.geometric_mean_ratio().unwrap() - s.worst_ratio().unwrap()).abs() < 1e-14);
        assert_eq!(s.pooled_coverage95(), None);
    }

    #[test]
    fn a_single_answer_has_an_error_and_no_statistics() {
        let s = statistics(&[answer(0.5, Some(0.1)), Err(None)], Some(0.125));
        let p = s.properties[0];
        assert!(s.is_single());
        assert_eq!((p.bias, p.rms, p.ratio(), p.coverage95), (0.5, None, None, None));
    }

    #[test]
    fn an_interval_holds_the_truth_within_196_sigma() {
        let runs =
            [answer(0.195, Some(0.1)), answer(0.197, Some(0.1)), answer(9.0, None), Err(None)];
        let s = statistics(&runs, None);
        assert_eq!((s.answers, s.unanswered), (3, 1));
        assert_eq!(s.properties[0].coverage95, Some(0.5));
        assert_eq!(s.pooled_coverage95(), Some(0.5));
        assert_eq!(s.worst_ratio(), None);
        let width = s.properties[0].half_width95.unwrap();
        assert!((width - 0.1 * HALF_WIDTH_95).abs() < 1e-12);
        // The bound of 0.05 permits half of that.
        let twice = statistics(&runs, Some(0.05)).geometric_mean_width().unwrap();
        assert!((twice - 2.0).abs() < 1e-12);
    }

    #[test]
    fn runs_that_stop_at_the_target_are_counted_apart() {
        let mut stopping = StoppingStatistics { hits: 60, ..StoppingStatistics::default() };
        stopping.add(true, 30, Some(9));
        stopping.add(false, 0, Some(10));
        stopping.add(true, 10, None);
        assert_eq!((stopping.runs, stopping.reached), (3, 2));
        assert_eq!(stopping.coverage95(), Some(0.95));
        assert_eq!(stopping.coverage95_at_target(), Some(0.9));
        assert!((stopping.mean_hits_saved() - 40.0 / 3.0).abs() < 1e-12);
        assert_eq!(StoppingStatistics::default().coverage95(), None);
    }

    #[test]
    fn without_answers_there_are_no_numbers_and_a_reason() {
        let reason = Diagnostic::whole(Code::NotConverged, Severity::Error, 60.0);
        let reasons: Diagnostics = [reason].into_iter().collect();
        let s = statistics(&[Err(None), Err(Some(reasons.clone()))], Some(1.0));
        assert_eq!((s.answers, s.unanswered), (0, 2));
        assert_eq!(s.refusal, Some(reasons.clone()));
        assert_eq!(s.reasons, [(Code::NotConverged, 1)]);
        let other = Diagnostic::whole(Code::ModelDoesNotFit, Severity::Error, 2.0);
        let of_model: Answer = Err(Some([other, reason].into_iter().collect()));
        let of_both = [of_model.clone(), Err(Some(reasons)), answer(0.0, None), of_model];
        let counts = [(Code::ModelDoesNotFit, 2), (Code::NotConverged, 1)];
        assert_eq!(statistics(&of_both, None).reasons, counts);
        assert!(s.properties.is_empty());
        assert_eq!(s.geometric_mean_ratio(), None);
        assert_eq!(s.pooled_coverage95(), None);
    }
}
