//! Finds what channels contain of one another: a multiplexer that does not settle, or the hammer in a response.
//!
//! A converter that samples too briefly keeps a part of the voltage of the channel before. One number describes that
//! for all channels, and the test of it is sharp. A response that alone contains the hammer, as through cables side
//! by side, has the same constant added to its accelerances, whatever is hit. No body and no error of the budget
//! does either.

use super::fit::Fit;
use super::fit_problem::FitProblem;
use super::normal_equations::NormalEquations;
use super::pulls::UnknownValues;
use super::score::{Score, ScoresOfResponses, SuspectedResponse, TOGETHER};
use super::undetermined;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::identify::DofMassLines;
use crate::real::Real;
use crate::responses::Responses;

/// A constant is significant beyond this number of standard deviations. Nine responses are tested, so chance
/// exceeds it in one of a thousand tests.
const SIGNIFICANT: f64 = 3.9;
/// The same for the memory of the multiplexer, which is positive: one of five hundred tests, for two orders of
/// conversion.
const SIGNIFICANT_MEMORY: f64 = 3.1;
/// The channels between one and the next of the same converter: one converter takes them in order, and two take
/// every other one.
const STRIDES: [usize; 2] = [1, 2];
/// What a response that kept the hammer's whole voltage would read, (m/s²)/N: 22.5 mV/N over the 57 mV/g of the data
/// sheet. Another hammer changes the size that is found, not the probability of a false one.
const HAMMER: f64 = 3.87;

impl<R: Real> Fit<R> {
    /// Tests every response for the hammer, from completed equations; returns the most significant one.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    // Never inlined: this saves 1.2 KB of the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn test_responses<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<Option<SuspectedResponse<R>>, Diagnostics> {
        let sensors = problem.layout.sensors.len();
        let unknowns = UnknownValues::<R, C>::of(sensors, equations.solution());
        let unknowns = unknowns.ok_or_else(undetermined)?;
        let mut scores = ScoresOfResponses::new();
        let mut most = None;
        let mut limit = R::of(SIGNIFICANT);
        for first in (0..3 * sensors).step_by(TOGETHER) {
            Score::of_responses(&unknowns, first..3 * sensors, &mut scores);
            self.visit(problem, dofs, equations, &unknowns, |_, rows, left| {
                for (response, score) in &mut scores {
                    score.add_response(rows, (*response, R::one()), left);
                }
            })?;
            for (response, score) in &scores {
                let tested = self.tested(score, &unknowns, equations);
                // A comparison with NaN is false.
                if tested.significance.abs() > limit {
                    limit = tested.significance.abs();
                    most = Some((*response, tested));
                }
            }
        }
        Ok(most)
    }

    /// Tests for a memory of the multiplexer, and reports it or, if that is more significant, what is suspected of a
    /// single response.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    // Never inlined: this saves 0.5 KB of the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn test_memory<C: Capacity>(
        &mut self,
        suspected: Option<SuspectedResponse<R>>,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<(), Diagnostics> {
        let sensors = problem.layout.sensors.len();
        let unknowns = UnknownValues::<R, C>::of(sensors, equations.solution());
        let unknowns = unknowns.ok_or_else(undetermined)?;
        let mut scores = STRIDES.map(|_| Score::none(&unknowns));
        self.visit(problem, dofs, equations, &unknowns, |lines, rows, left| {
            for (score, stride) in scores.iter_mut().zip(STRIDES) {
                score.add(rows, &channels_before(&lines.accelerance, 3 * sensors, stride), left);
            }
        })?;
        let limit = suspected.map_or(R::zero(), |(_, one)| one.significance.abs());
        let limit = limit.max(R::of(SIGNIFICANT_MEMORY));
        let tested = scores.iter().map(|score| self.tested(score, &unknowns, equations));
        // A comparison with NaN is false.
        let memory = tested
            .filter(|one| one.significance > limit)
            .reduce(|a, b| if b.significance > a.significance { b } else { a });
        if let Some(memory) = memory {
            self.push_diagnostic(Code::MultiplexerKeepsVoltage, Severity::Warning, memory.size);
        } else if let Some((response, constant)) = suspected {
            let (code, subject) = (Code::HammerInResponse, Subject::channel(1 + response));
            let value = constant.size.to_f32();
            // There are only a handful of diagnostics.
            let _ =
                self.diagnostics.push(Diagnostic::about(code, Severity::Warning, subject, value));
        }
        Ok(())
    }
}

/// For every response, the accelerance that belongs to the channel converted before it, the hammer's included.
fn channels_before<R: Real, C: Capacity>(
    accelerance: &Responses<R, C>,
    responses: usize,
    stride: usize,
) -> Responses<R, C> {
    let mut before = Responses::zeros(accelerance.sensors());
    for response in 0..responses {
        let channel = 1 + response;
        before[response] = match channel.checked_sub(stride) {
            Some(0) => R::of(HAMMER),
            Some(other) => accelerance[other - 1],
            // The last channel of the same converter, in the scan before.
            None => accelerance[(responses - channel) / stride * stride + channel - 1],
        };
    }
    before
}

#[cfg(test)]
mod tests;
