//! What the computation has found.

use nalgebra::{Complex, SVector, Vector3, Vector6};

use super::{MethodAnswer, RigLayout, SolverMemory, Stage, SuspensionSolver};
use crate::diagnosis::Diagnostics;
use crate::identify::agreement::{Agreement, Comparing};
use crate::identify::suspension::{Answer, add_doubts, judged_estimate};
use crate::identify::{Estimate, Method, SUSPENSION_METHODS};
use crate::layout::motion_at;
use crate::modes::{Mode, norm_indicator_of_shape};
use crate::{Progress, Real};

/// A suspension mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SuspensionMode<R> {
    /// Natural frequency, Hz.
    pub frequency_hz: R,
    /// Damping ratio.
    pub damping_ratio: R,
    /// Mass-normalised shape at the [reference point](SuspensionSolver::reference), `[x; θ]`, 1/√kg and 1/(m √kg).
    pub shape: Vector6<R>,
    /// Imaginary over real part of the residues.
    pub complexity: R,
}

impl<R: Real> SuspensionMode<R> {
    pub(super) fn of(mode: &Mode<R>) -> Self {
        let Mode { frequency_hz, damping_ratio, shape, complexity, .. } = *mode;
        Self { frequency_hz, damping_ratio, shape, complexity }
    }

    /// Its shape at the origin of the body frame.
    pub fn shape_at_origin(&self, reference: &Vector3<R>) -> Vector6<R> {
        motion_at(&self.shape, &-*reference)
    }
}

impl<R: Real> SuspensionSolver<R> {
    /// True when there is no answer of any method, for the reasons in [`Self::diagnostics`].
    pub fn has_failed(&self) -> bool {
        matches!(self.stage, Stage::Failed)
    }

    /// Findings about the modes; errors when there is no answer.
    pub fn diagnostics(&self) -> &Diagnostics {
        &self.diagnostics
    }

    /// The point that shapes refer to, in the body frame, m.
    pub fn reference(&self) -> Vector3<R> {
        self.reference
    }

    /// Standard deviation of the noise of a reading, (m/s²)/N, of a complex number.
    pub fn noise(&self) -> R {
        self.fit.noise
    }

    /// The suspension modes, in the order of their frequencies.
    pub fn modes(&self) -> &[SuspensionMode<R>] {
        &self.fit.modes
    }

    /// Standard deviations of frequency (Hz), damping ratio and shape at the origin of the body frame of a mode; not a number
    /// before the changes are done.
    pub fn mode_sigma(&self, mode: usize) -> [R; 8] {
        self.deviations.sigma(mode)
    }

    /// [Norm Indicator](crate::modes::norm_indicator) of a mode under every hit of the layout, measured or not: how much of the mode the hit
    /// shows. Nothing for a mode that there is not.
    pub fn norm_indicators<'a>(
        &'a self,
        layout: &'a RigLayout<R>,
        mode: usize,
    ) -> impl Iterator<Item = R> + 'a {
        let length = layout.characteristic_length();
        self.fit.modes.get(mode).into_iter().flat_map(move |mode| {
            layout.hits.iter().map(move |hit| {
                norm_indicator_of_shape(&mode.shape, &hit.unit_force(&self.reference), length)
            })
        })
    }

    /// The hit of the layout that shows a mode best, and its Norm Indicator: where it has not been measured yet, it is the
    /// remedy of a mode that the measured hits excite poorly.
    pub fn best_hit(&self, layout: &RigLayout<R>, mode: usize) -> Option<(usize, R)> {
        let all = self.norm_indicators(layout, mode).enumerate();
        all.reduce(|best, next| if next.1 > best.1 { next } else { best })
    }

    /// The hit DOFs that were measured, as places in the layout.
    pub fn measured(&self) -> impl Iterator<Item = usize> + '_ {
        self.dofs.iter().map(|dof| usize::from(*dof))
    }

    /// True until the methods have answered; then the changes follow, which show how certain the answers are.
    pub fn unanswered(&self) -> bool {
        matches!(
            self.stage,
            Stage::Wanting(_)
                | Stage::Reducing(..)
                | Stage::Orders(_)
                | Stage::Residues(_)
                | Stage::Modes
                | Stage::Forms(_)
        )
    }

    /// Number of changes that are done.
    pub fn changes_done(&self) -> u32 {
        if let Stage::Changes(change) = &self.stage { change.number() } else { 0 }
    }

    /// The answer of a method, without its covariance.
    pub fn answer(&self, method: Method) -> Option<&Answer<R>> {
        let place = Method::of_modes().position(|other| other == method)?;
        self.answers[place].answer()
    }

    /// The answer of a method with its covariance, or why it has none; `None` for a method that does not use the modes, and
    /// before the changes are done.
    pub fn estimate(
        &self,
        method: Method,
        layout: &RigLayout<R>,
        memory: &SolverMemory<'_, R>,
    ) -> Option<Result<Estimate<R>, Diagnostics>> {
        self.estimate_from(method, layout, memory.readings)
    }

    /// The same, given only the lent memory of the readings, in which the covariances are by then.
    // Not inlined: the firmware has room for one copy.
    #[inline(never)]
    pub fn estimate_from(
        &self,
        method: Method,
        layout: &RigLayout<R>,
        readings: &[Complex<R>],
    ) -> Option<Result<Estimate<R>, Diagnostics>> {
        if !self.is_done() {
            return None;
        }
        let place = Method::of_modes().position(|other| other == method)?;
        match &self.answers[place] {
            MethodAnswer::Answer(answer) => {
                let length = layout.characteristic_length();
                let judged = self.judged(place, method, answer, length, readings)?;
                Some(judged.map(|mut estimate| {
                    add_doubts(&mut estimate, &self.diagnostics);
                    estimate
                }))
            }
            MethodAnswer::Refused(reason) => Some(Err(Diagnostics::from_array::<1>([*reason]))),
            MethodAnswer::None => None,
        }
    }

    fn judged(
        &self,
        place: usize,
        method: Method,
        answer: &Answer<R>,
        length: R,
        readings: &[Complex<R>],
    ) -> Option<Result<Estimate<R>, Diagnostics>> {
        let covariances = self.propagation.as_ref()?.covariances(readings);
        Some(judged_estimate(method, answer, place, &covariances, length))
    }

    /// How the answers agree, and the combined estimate. The places are those in [`Method::of_modes`]. `None` with fewer than two
    /// answers, or before the work is done.
    pub fn agreement(&self) -> Option<&Agreement<R>> {
        let Stage::Comparing(comparing) = &self.stage else { return None };
        comparing.is_done().then(|| comparing.found())
    }

    /// True when there are results.
    fn is_done(&self) -> bool {
        match &self.stage {
            Stage::Comparing(comparing) => comparing.is_done(),
            Stage::Done => true,
            _ => false,
        }
    }

    /// Begins to compare the answers that stand; L in m.
    #[inline(never)]
    pub(super) fn compare(&mut self, length: R, memory: &SolverMemory<'_, R>) -> Progress {
        for (place, method) in Method::of_modes().enumerate() {
            let judged = self.answers[place]
                .answer()
                .and_then(|answer| self.judged(place, method, answer, length, memory.readings));
            self.accepted[place] = judged.is_some_and(|judged| judged.is_ok());
        }
        let thetas = self.accepted_answers();
        let sums = self.propagation.as_ref();
        let comparing =
            sums.and_then(|sums| Comparing::new(&thetas, &sums.covariances(memory.readings)));
        match comparing {
            Some(comparing) => {
                self.stage = Stage::Comparing(comparing);
                Progress::Going
            }
            None => self.done(),
        }
    }

    /// Runs one step of the comparison.
    #[inline(never)]
    pub(super) fn step_comparing(&mut self, memory: &SolverMemory<'_, R>) -> Progress {
        let thetas = self.accepted_answers();
        let (Stage::Comparing(comparing), Some(sums)) = (&mut self.stage, &self.propagation) else {
            return self.done();
        };
        let progress = comparing.step(&thetas, &sums.covariances(memory.readings));
        progress.unwrap_or_else(|| self.done())
    }

    fn done(&mut self) -> Progress {
        self.stage = Stage::Done;
        Progress::Done
    }

    fn accepted_answers(&self) -> [Option<SVector<R, 10>>; SUSPENSION_METHODS] {
        core::array::from_fn(|place| {
            let answer = self.answers[place].answer().filter(|_| self.accepted[place]);
            answer.map(|answer| answer.body.theta())
        })
    }
}
