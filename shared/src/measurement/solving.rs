//! Computes the suspension modes and the answers of their methods, from the stored lines of all DOFs.

use nalgebra::Complex;

use super::answering::Answering;
use super::campaign::Step;
use super::hits::Task;
use super::{Activity, Measurement, Memory, NextAction, Recorded, note};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::identify::suspension_solver::{LineGrid, SolverMemory, SuspensionSolver};
use crate::identify::{Estimate, Method, Progress};
use crate::mass_line::window_correlation;
use crate::signal::{RealFft, resolution};

impl<R: RealFft> Memory<R> {
    /// The computation, and the memory that is lent to it: nothing else needs it by then.
    fn of_solver(&mut self) -> Option<(&mut SuspensionSolver<R>, SolverMemory<'_, R>)> {
        let Self { record, spectra, scratch, force, answers, .. } = self;
        let Answering::Suspension(solver) = answers else { return None };
        let (readings, weights) = spectra.lend();
        let codes = record.lend();
        Some((solver, SolverMemory { codes, scratch, readings, weights, lines: force }))
    }
}

impl<R: RealFft> Measurement<'_, R> {
    /// Begins with the DOFs whose lines are stored.
    // Not inlined: the layout is on its stack.
    #[inline(never)]
    pub(super) fn begin_solving(&mut self) -> Task<R> {
        self.recorded = Recorded::Nothing;
        self.averaged = None;
        self.last_accepted.forget();
        self.memory.answers.begin([]);
        let Some(layout) = &self.layout else { return Task::Identified };
        let test = &layout.test;
        let resolution_hz: R = resolution(&self.adc, test.profile);
        let decay = test.exponential_decay;
        let grid = LineGrid {
            resolution_hz,
            band_hz: test.expected_band(),
            decay,
            // Bins of this distance depend on each other as in a record that is as long as their distance permits.
            correlation: window_correlation(decay, resolution_hz.recip()),
        };
        let mut dofs = [0; crate::layout::RIG_HITS];
        let stored = &self.memory.lines;
        dofs.iter_mut().zip(stored).for_each(|(to, lines)| *to = lines.dof.into());
        let dofs = &dofs[..stored.len()];
        if let Some(solver) = self.memory.answers.enter_modes() {
            solver.begin(layout, grid, dofs);
        }
        Task::Solve
    }

    /// Runs one step.
    // Not inlined: it has one of the deepest stacks.
    #[inline(never)]
    pub(super) fn step_solver(&mut self) -> Task<R> {
        let (Some(layout), Some((solver, mut memory))) = (&self.layout, self.memory.of_solver())
        else {
            return Task::Identified;
        };
        if solver.step(layout, &mut memory) == Progress::Going {
            return Task::Solve;
        }
        let found = solver.diagnostics().clone();
        for found in found {
            self.push_diagnostic(found);
        }
        Task::Identified
    }

    /// The response that the computation needs next: its DOF and its number.
    pub(super) fn wanted_lines(&self) -> Option<(usize, usize)> {
        self.memory.answers.solver().and_then(SuspensionSolver::wants)
    }

    /// Takes the stored lines of the response that [`NextAction::FetchLines`] names, (m/s²)/N.
    pub fn take_lines(&mut self, lines: &[Complex<R>]) {
        if let NextAction::FetchLines { .. } = self.next_action()
            && let (Some(layout), Some((solver, mut memory))) =
                (&self.layout, self.memory.of_solver())
        {
            solver.take(layout, lines, &mut memory);
        }
    }

    /// Reports that the stored lines of this response cannot be read: its DOF is left out.
    pub fn lines_not_readable(&mut self) {
        let NextAction::FetchLines { dof, .. } = self.next_action() else { return };
        self.memory.discard_dof(dof);
        let subject = Subject::hit(dof);
        let lost = Diagnostic::about(Code::LinesNotReadable, Severity::Error, subject, 0.0);
        note(&mut self.diagnostics, lost);
        if let Activity::Measuring(_, task) = &mut self.activity {
            *task = Task::None;
        }
    }

    /// Part of the computation of the suspension modes that is done, from zero to one; `None` unless it runs.
    pub fn computed(&self) -> Option<f32> {
        let Activity::Measuring(campaign, Task::Solve) = &self.activity else { return None };
        let runs = campaign.step() == Step::Identify;
        self.solver().filter(|_| runs).map(SuspensionSolver::completed)
    }

    /// The computation of the suspension modes, while it runs and when it is done.
    pub fn solver(&self) -> Option<&SuspensionSolver<R>> {
        self.memory.answers.solver()
    }

    /// The estimates of the methods that use the suspension modes, best first. They are computed when they are needed.
    pub fn modal_estimates(&self) -> impl Iterator<Item = Estimate<R>> + '_ {
        self.modal_answers().filter_map(|(_, answer)| answer.ok())
    }

    /// The methods that use the suspension modes and have no answer, best first, each with its reason.
    pub fn modal_refusals(&self) -> impl Iterator<Item = (Method, Diagnostic)> + '_ {
        self.modal_answers().filter_map(|(method, answer)| Some((method, *answer.err()?.first()?)))
    }

    fn modal_answers(
        &self,
    ) -> impl Iterator<Item = (Method, Result<Estimate<R>, Diagnostics>)> + '_ {
        let of_modes = self.solver().zip(self.layout.as_ref()).into_iter();
        of_modes.flat_map(|(solver, layout)| {
            let lent = self.memory.spectra.lent();
            Method::of_modes().filter_map(move |method| {
                Some((method, solver.estimate_from(method, layout, lent)?))
            })
        })
    }
}
