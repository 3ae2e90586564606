//! The answers of the methods to the motions as they are.

use super::MethodAnswer;
use crate::diagnosis::Diagnostics;
use crate::identify::Method;
use crate::identify::dppim::{Form, FormSolver, NearModes};
use crate::identify::suspension::Answer;
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

/// The methods that need the modes alone, and what belongs to each.
pub(super) fn of_modes_alone<T>(all: &mut [T]) -> impl Iterator<Item = (Method, &mut T)> {
    let is_direct = |method: &Method| matches!(method, Method::Dppim | Method::DppimStructural);
    Method::of_modes().zip(all).filter(move |(method, _)| !is_direct(method))
}
