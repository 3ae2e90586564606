//! The pulls: how far the errors must have moved to explain the readings, and which sensor or hit is the first suspect.

use super::fit::Fit;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Severity, Subject};
use crate::identify::maximum_likelihood::model::SENSOR_NUISANCES;
use crate::identify::maximum_likelihood::pulls::{SUSPICIOUS, root_mean_square};
use crate::layout::HIT_QUANTITIES;
use crate::real::Real;

/// The length of a force is suspect from so many of the standard deviations that its error has under the model, which
/// chance exceeds once in 400 tests of five hits; that counts as a pull of [`SUSPICIOUS`].
const SUSPECT_LENGTH: f64 = 3.5;

impl<R: Real, C: Capacity> Fit<'_, '_, '_, R, C> {
    /// The error of the length of a hit's force in the standard deviations that it has under the model: those of the
    /// budget, less what the data leave open.
    fn pull_of_length(&mut self, hit: usize) -> R {
        let place = self.unknowns.hit(hit) + HIT_QUANTITIES - 1;
        let value = self.memory.x[place].abs();
        let open = self.covariances_with(place, self.unknowns.len())[place];
        let sigma = (R::one() - open).max(R::zero()).sqrt();
        // Without an error in the budget there is neither value nor deviation.
        if value > R::zero() { value / sigma } else { R::zero() }
    }

    /// The sensor or hit with the largest pull, as in maximum likelihood; `None` when no pull is large enough.
    pub(super) fn suspect(&mut self) -> Option<Diagnostic> {
        if self.unknowns.nuisances() == 0 {
            return None;
        }
        let hits = 0..self.problem.layout.hits.len();
        let lengths: C::Hits<R> = hits.map(|hit| self.pull_of_length(hit)).collect();
        let Self { problem, unknowns, .. } = self;
        let pull = |first: usize, count: usize| root_mean_square(&self.memory.x[first..][..count]);
        let of_sensors = (0..problem.layout.sensors.len()).map(|i| {
            let pull = pull(unknowns.sensor(i), SENSOR_NUISANCES);
            (pull, Code::LargeSensorPull, Subject::sensor(i))
        });
        let of_hits = lengths.iter().enumerate().map(|(j, length)| {
            let across = pull(unknowns.hit(j), HIT_QUANTITIES - 1);
            let pull = across.max(*length * R::of(SUSPICIOUS / SUSPECT_LENGTH));
            (pull, Code::LargeHitPull, Subject::hit(j))
        });
        let pulls = of_sensors.chain(of_hits).filter(|(pull, ..)| *pull > R::of(SUSPICIOUS));
        let (pull, code, subject) = pulls.reduce(|a, b| if b.0 > a.0 { b } else { a })?;
        Some(Diagnostic::about(code, Severity::Warning, subject, pull.to_f32()))
    }
}
