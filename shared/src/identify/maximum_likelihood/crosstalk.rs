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
use super::score::{Score, ScoresOfResponses, Tested};
use super::undetermined;
use crate::Real;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::identify::DofMassLines;
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
    /// Tests for a memory of the multiplexer and every response, from completed equations, and reports the most
    /// significant finding.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    // Not inlined, for the firmware's deepest stack.
    #[inline(never)]
    pub(super) fn test_crosstalk<const S: usize, const H: usize>(
        &mut self,
        problem: &FitProblem<'_, R, S, H>,
        dofs: &[DofMassLines<R, S>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<(), Diagnostics> {
        let sensors = problem.layout.sensors.len();
        let unknowns = UnknownValues::<R, S>::of(sensors, equations.solution());
        let unknowns = unknowns.ok_or_else(undetermined)?;
        let mut constants = ScoresOfResponses::new();
        Score::of_responses(&unknowns, &mut constants);
        let mut memories = STRIDES.map(|_| Score::none(&unknowns));
        let constants = constants.as_flattened_mut();
        self.visit(problem, dofs, equations, &unknowns, |lines, rows, left| {
            for (response, score) in constants.iter_mut().enumerate() {
                score.add_response(rows, (response, R::one()), left);
            }
            for (score, stride) in memories.iter_mut().zip(STRIDES) {
                score.add(rows, &channels_before(&lines.accelerance, 3 * sensors, stride), left);
            }
        })?;
        // A comparison with NaN is false.
        let more = |a: Tested<R>, b: Tested<R>| if b.significance > a.significance { b } else { a };
        let memories = memories.iter().map(|score| self.tested(score, &unknowns, equations));
        let memory = memories.reduce(more).filter(|m| m.significance > R::of(SIGNIFICANT_MEMORY));
        let mut largest = (R::of(SIGNIFICANT), None);
        for (response, score) in constants.iter().enumerate() {
            let tested = self.tested(score, &unknowns, equations);
            if tested.significance.abs() > largest.0 {
                largest = (tested.significance.abs(), Some((response, tested.size)));
            }
        }
        let (constant, in_response) = largest;
        let memory = memory.filter(|m| in_response.is_none() || m.significance > constant);
        if let Some(memory) = memory {
            self.push_diagnostic(Code::MultiplexerKeepsVoltage, Severity::Warning, memory.size);
        } else if let Some((response, value)) = in_response {
            let (code, subject) = (Code::HammerInResponse, Subject::channel(1 + response));
            let found = Diagnostic::about(code, Severity::Warning, subject, value.to_f32());
            // There are only a handful of diagnostics.
            let _ = self.diagnostics.push(found);
        }
        Ok(())
    }
}

/// For every response, the accelerance that belongs to the channel converted before it, the hammer's included.
fn channels_before<R: Real, const S: usize>(
    accelerance: &Responses<R, S>,
    responses: usize,
    stride: usize,
) -> Responses<R, S> {
    let mut before = Responses::zeros();
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
