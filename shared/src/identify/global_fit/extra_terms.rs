//! How many extra terms of the dynamic stiffness the data ask for.
//!
//! The test is Rao's score test between nested models: at the minimum of the smaller model the linearised larger
//! model says by how much its 21 unknowns more would lower the cost. Of that decrease and of what is left, each
//! over its degrees of freedom, the ratio has an F distribution when the smaller model is true; Paulson's
//! transform turns it into a standard normal deviate. The term is taken when chance alone would give the
//! deviate in only one of a thousand tests, [`REJECTION_Z`].

use super::fit::Fit;
use super::unknowns::SYMMETRIC;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::identify::REJECTION_Z;
use crate::real::Real;

/// Largest deviate that is reported.
const MOST_Z: f64 = 1e3;

impl<R: Real, C: Capacity> Fit<'_, '_, '_, R, C> {
    /// Descends, and adds extra terms for as long as the test asks for them. Returns their number and the
    /// deviate of each test made.
    pub(super) fn descend_with_extra_terms(
        &mut self,
    ) -> Result<(usize, [Option<R>; 2]), Diagnostics> {
        self.check_start()?;
        self.descend()?;
        self.check_stiffness()?;
        let mut deviates = [None; 2];
        for (before, deviate) in deviates.iter_mut().enumerate() {
            if before == self.problem.settings.most_extra_terms {
                return Ok((before, deviates));
            }
            self.set_extra_terms(before + 1);
            *deviate = self.deviate();
            if deviate.is_none_or(|z| z <= R::of(REJECTION_Z)) {
                self.set_extra_terms(before);
                let refused = || fatal(Code::NotConverged, 0.0);
                self.linearise().ok_or_else(refused)?;
                self.complete().ok_or_else(refused)?;
                return Ok((before, deviates));
            }
            self.descend()?;
        }
        Ok((2, deviates))
    }

    /// Refuses a start that shows nothing of the stiffness, before any step.
    fn check_start(&mut self) -> Result<(), Diagnostics> {
        let refused = || fatal(Code::NotConverged, 0.0);
        self.linearise().ok_or_else(refused)?;
        self.complete().ok_or_else(refused)?;
        self.check_stiffness()
    }

    /// Changes the number of extra terms; new ones are zero.
    fn set_extra_terms(&mut self, extra: usize) {
        let from = self.unknowns.phi();
        self.unknowns = self.problem.unknowns(extra);
        let to = self.unknowns.phi();
        let x = &mut *self.memory.x;
        x.copy_within(from..from + 10, to);
        if to > from {
            x[from..to].fill(R::zero());
        }
    }

    /// Deviate of the test for the last block, whose elements are zero; `None` when there are too few readings
    /// or the equations have no solution.
    fn deviate(&mut self) -> Option<R> {
        self.linearise()?;
        let freedom = self.degrees_of_freedom();
        let decrease = self.expected_decrease()?;
        let left = freedom - decrease;
        let terms = R::of(SYMMETRIC as f64);
        if !(freedom > R::zero() && decrease.finite()) {
            return None;
        }
        if left <= R::zero() {
            return Some(R::of(MOST_Z));
        }
        let ratio = (decrease / terms) / (left / freedom);
        Some(normal_deviate(ratio, terms, freedom))
    }
}

/// Standard normal deviate that is exceeded with the same probability as a ratio of mean squares with these
/// degrees of freedom (Paulson 1942).
fn normal_deviate<R: Real>(ratio: R, above: R, below: R) -> R {
    let [a, b] = [above, below].map(|freedom| R::of(2.0 / 9.0) / freedom);
    let cube = ratio.max(R::zero()).cbrt();
    let z = ((R::one() - b) * cube - (R::one() - a)) / (b * cube * cube + a).sqrt();
    z.min(R::of(MOST_Z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_deviate_is_that_of_tables() {
        // The 99.9 % points of F with 21 and 60, and with 20 and 120 degrees of freedom are 2.81 and 2.53; the
        // transform is good to 1 %.
        for (ratio, above, below) in [(2.81, 21.0, 60.0), (2.53, 20.0, 120.0)] {
            let z: f64 = normal_deviate(ratio, above, below);
            assert!((z - REJECTION_Z).abs() < 0.03, "{z}");
        }
    }
}
