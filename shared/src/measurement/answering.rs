//! The methods under either profile, in the same memory.

use crate::Real;
use crate::diagnosis::Diagnostics;
use crate::identify::suspension_solver::SuspensionSolver;
use crate::identify::{Estimate, Identification, MASS_LINE_METHODS, Method};

/// The methods that run, or their answers.
// With its tag first, no methods are all zero bytes, as a static memory has to be.
#[repr(u8)]
pub(super) enum Answering<R> {
    /// Those that use mass lines.
    MassLines(Identification<R, MASS_LINE_METHODS>),
    /// Those that use the suspension modes.
    Suspension(SuspensionSolver<R>),
}

impl<R> Answering<R> {
    /// No methods.
    pub const fn idle() -> Self {
        Self::MassLines(Identification::idle())
    }

    /// Starts again with these methods of mass lines.
    pub fn begin(&mut self, wanted: impl IntoIterator<Item = Method>) {
        self.leave_modes();
        if let Self::MassLines(identification) = self {
            identification.begin(wanted);
        }
    }

    /// The computation of the suspension modes, which has not begun.
    // Not inlined: what is put in place is built on its stack.
    #[inline(never)]
    pub fn enter_modes(&mut self) -> Option<&mut SuspensionSolver<R>>
    where
        R: Real,
    {
        *self = Self::Suspension(SuspensionSolver::idle());
        match self {
            Self::MassLines(_) => None,
            Self::Suspension(solver) => Some(solver),
        }
    }

    /// Ends the methods of suspension modes.
    // Not inlined: what replaces them is built on its stack.
    #[inline(never)]
    fn leave_modes(&mut self) {
        if let Self::Suspension(_) = self {
            *self = Self::idle();
        }
    }

    /// The methods of mass lines that run.
    pub fn mass_lines(&mut self) -> Option<&mut Identification<R, MASS_LINE_METHODS>> {
        match self {
            Self::MassLines(identification) => Some(identification),
            Self::Suspension(_) => None,
        }
    }

    /// The answers of the methods of mass lines, best first.
    pub fn estimates(&self) -> &[Estimate<R>] {
        match self {
            Self::MassLines(identification) => identification.estimates(),
            Self::Suspension(_) => &[],
        }
    }

    /// Those of them without an answer, and why.
    pub fn refusals(&self) -> &[(Method, Diagnostics)] {
        match self {
            Self::MassLines(identification) => identification.refusals(),
            Self::Suspension(_) => &[],
        }
    }

    /// The computation of the suspension modes.
    pub fn solver(&self) -> Option<&SuspensionSolver<R>> {
        match self {
            Self::MassLines(_) => None,
            Self::Suspension(solver) => Some(solver),
        }
    }
}
