//! What modes near the ends of the band do to the properties.
//!
//! Mass lines that are no plateaus carry their change when the ends of the band are left out. To first order, the
//! properties change by `N⁻¹ Xᵀ W` times these (theory, section 5).

use nalgebra::SVector;

use super::fit::Fit;
use super::fit_problem::FitProblem;
use super::model::Model;
use super::normal_equations::NormalEquations;
use super::undetermined;
use crate::body::scale;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::identify::DofMassLines;
use crate::real::Real;

/// Smallest change of the mass that is told, relative. That of another property is told when it is the largest.
const TOLD: f64 = 0.005;

impl<R: Real> Fit<R> {
    /// Reports how far the mass and the property that moves most would move, from completed equations.
    ///
    /// # Errors
    /// When the model cannot be evaluated.
    pub(super) fn tell_band_shift<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<(), Diagnostics> {
        if dofs.iter().all(|(_, lines)| lines.band_shift.largest() == R::zero()) {
            return Ok(());
        }
        let object = self.object().ok_or_else(undetermined)?;
        let body = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
        let model = Model::new(problem.layout, &problem.balance, &body).ok_or_else(undetermined)?;
        let nuisances = problem.nuisances();
        let mut phi = SVector::<R, 10>::zeros();
        for (place, (index, lines)) in dofs.iter().enumerate() {
            let errors = equations.hit_errors(place);
            let terms = problem.terms(&model, *index, lines, &errors).ok_or_else(undetermined)?;
            let weighted = terms.weight.times(&lines.band_shift);
            problem.with_rows(&model, &terms, |rows| {
                let solved = equations.solve_readings(rows, &weighted);
                phi += SVector::from_fn(|k, _| solved[nuisances + k]);
            });
        }
        // The equations are those of a body whose lengths are over the characteristic length.
        let change = object.dtheta_dphi() * phi / object.mass;
        let mass = Some(0).filter(|_| change[0].abs() > R::of(TOLD));
        let largest = Some(change.iamax()).filter(|largest| mass != Some(*largest));
        for property in mass.into_iter().chain(largest) {
            let (code, subject) = (Code::MovesWithBand, Subject::property(property));
            let unit = scale(object.mass, self.length)[property];
            let value = (change[property] * unit).to_f32();
            // There are only a handful of diagnostics.
            let _ =
                self.diagnostics.push(Diagnostic::about(code, Severity::Warning, subject, value));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::vec::Vec;

    use super::super::learning::tests::calibrated;
    use super::super::tests::exact;
    use super::super::{ErrorBudget, RIG_WORKSPACE, Start, solve};
    use super::*;
    use crate::body::RigidBody;
    use crate::layout::tests::bar_body;

    /// What is told of mass lines of the bar that become those of another body without the ends of the band.
    fn find_moves(factors: [f64; 10]) -> Vec<(Subject, f32)> {
        let (layout, body) = (calibrated(), bar_body());
        let other = SVector::from(factors).component_mul(&body.theta());
        let mut dofs = exact(&layout, &body);
        for ((_, lines), (_, others)) in
            dofs.iter_mut().zip(exact(&layout, &RigidBody::from_theta(&other)))
        {
            lines.band_shift = &others.accelerance - &lines.accelerance;
        }
        let mut memory = [0.0; RIG_WORKSPACE];
        let solution =
            solve(&layout, &dofs, Start::InertiaRestraint, ErrorBudget::Learned, &mut memory);
        let diagnostics = solution.unwrap().estimate.diagnostics.into_iter();
        let moves = diagnostics.filter(|d| d.code == Code::MovesWithBand);
        moves.map(|d| (d.subject, d.value)).collect()
    }

    #[test]
    fn plateaus_move_nothing() {
        assert_eq!(find_moves([1.0; 10]), []);
    }

    #[test]
    fn the_property_that_moves_is_told_with_its_change() {
        let mut factors = [1.0; 10];
        factors[0] = 1.02;
        let mass = 0.02 * bar_body().mass;
        let moves_with_mass = find_moves(factors);
        let [(Subject::Property(0), change)] = moves_with_mass[..] else {
            panic!("{moves_with_mass:?}")
        };
        // Of first order, and the errors of the budget explain a part.
        assert!((f64::from(change) - mass).abs() < 0.2 * mass, "{change} instead of {mass}");
        factors = [1.0; 10];
        factors[6] = 1.05;
        let moment = 0.05 * bar_body().theta()[6];
        let moves_with_moment = find_moves(factors);
        let [(Subject::Property(6), change)] = moves_with_moment[..] else {
            panic!("{moves_with_moment:?}")
        };
        assert!((f64::from(change) - moment).abs() < 0.2 * moment, "{change} instead of {moment}");
    }
}
