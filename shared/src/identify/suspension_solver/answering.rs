//! The answers of the methods to the motions as they are.

use super::changes::Change;
use super::{MethodAnswer, RigLayout, SolverMemory, Stage, Stored, SuspensionSolver};
use crate::diagnosis::{Diagnostic, Diagnostics, Severity};
use crate::identify::Method;
use crate::identify::agreement::PackedPropagation;
use crate::identify::dppim::{Form, FormSolver, NearModes, worse_form};
use crate::identify::suspension::{Answer, of_object};
use crate::{Progress, Real};

/// The two forms of the direct method, one after the other.
#[derive(Clone, Debug)]
pub(super) struct Forms<R> {
    /// The form in hand, as a place in [`FORMS`].
    next: usize,
    solver: Option<FormSolver<R>>,
}

/// The forms, and their methods.
const FORMS: [(Form, Method); 2] =
    [(Form::Viscous, Method::Dppim), (Form::Structural, Method::DppimStructural)];

impl<R> Default for Forms<R> {
    fn default() -> Self {
        Self { next: 0, solver: None }
    }
}

impl<R: Real> Forms<R> {
    /// Runs one step of the forms whose methods are `wanted`, and gives each answer about the reference point to `answered`.
    /// Responses, lines and noise must be the same in every step.
    pub(super) fn step(
        &mut self,
        near: &NearModes<'_, R>,
        wanted: impl Fn(Method) -> bool,
        answered: impl FnOnce(Method, Result<Answer<R>, Diagnostics>),
    ) -> Progress {
        let Some((form, method)) = FORMS.get(self.next).copied() else { return Progress::Done };
        if !wanted(method) {
            self.next += 1;
        } else if let Some(solver) = &mut self.solver {
            match solver.step(near) {
                Ok(Progress::Going) => return Progress::Going,
                Ok(Progress::Done) => answered(method, solver.answer()),
                Err(reasons) => answered(method, Err(reasons)),
            }
            self.solver = None;
            self.next += 1;
        } else {
            match FormSolver::new(form, near) {
                Ok(solver) => self.solver = Some(solver),
                Err(reasons) => {
                    answered(method, Err(reasons));
                    self.next += 1;
                }
            }
        }
        if self.next < FORMS.len() { Progress::Going } else { Progress::Done }
    }
}

/// The place of a method among those that use the modes.
pub(super) fn place_of(method: Method) -> usize {
    Method::of_modes().position(|other| other == method).unwrap_or(0)
}

impl<R: Real> MethodAnswer<R> {
    pub(super) fn of(answer: Result<Answer<R>, Diagnostics>) -> Self {
        match answer {
            Ok(answer) => Self::Answer(answer),
            // A method has one reason.
            Err(reasons) => reasons.first().map_or(Self::None, |reason| Self::Refused(*reason)),
        }
    }

    pub(super) fn answer(&self) -> Option<&Answer<R>> {
        if let Self::Answer(answer) = self { Some(answer) } else { None }
    }
}

impl<R: Real> SuspensionSolver<R> {
    /// Runs one step of the direct method.
    #[inline(never)]
    pub(super) fn step_forms(
        &mut self,
        layout: &RigLayout<R>,
        memory: &mut SolverMemory<'_, R>,
    ) -> Progress {
        let forces = self.mixing(layout).forces(layout, &self.reference);
        let Self { grid, units, stage, fit, answers, reference, .. } = self;
        let Stage::Forms(forms) = stage else { return Progress::Going };
        let SolverMemory { codes, weights, lines, .. } = memory;
        let stored = Stored { codes, units: &units[0], lines, weights };
        let length = layout.characteristic_length();
        let Some(responses) = stored.responses(grid.count(), &forces, length) else {
            return Progress::Going;
        };
        let of_modes = fit.lines(responses.s);
        let near = NearModes { responses: &responses, lines: &of_modes, noise: fit.noise };
        let progress = forms.step(
            &near,
            |_| true,
            |method, answer| {
                let of_object = answer.and_then(|answer| of_object(layout, reference, &answer));
                answers[place_of(method)] = MethodAnswer::of(of_object);
            },
        );
        if progress == Progress::Done {
            self.refuse_worse_form();
            self.propagation = PackedPropagation::new(memory.readings);
            self.stage = Stage::Changes(Change::first(layout));
        }
        Progress::Going
    }

    /// Refuses the form of the direct method that fits clearly worse than the other.
    fn refuse_worse_form(&mut self) {
        let misfit = |method: Method| self.answers[place_of(method)].answer()?.misfit;
        let pair = misfit(Method::Dppim).zip(misfit(Method::DppimStructural));
        let worse = pair.and_then(|(viscous, structural)| worse_form(viscous, structural));
        if let Some((method, code, times)) = worse {
            let reason = Diagnostic::whole(code, Severity::Error, times.to_f32());
            self.answers[place_of(method)] = MethodAnswer::Refused(reason);
        }
    }
}
