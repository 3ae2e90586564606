//! Maximum likelihood that learns the error budget where no repeat hits show their scatter: three scales, all from
//! the residuals of the fit (theory, section 12).
//!
//! Averages of a universal file, a shaker or a finite element model show neither how well somebody has hit nor that
//! anybody has hit at all. The mean loss of directions that scatter is then that of the directions that were learned.
//!
//! A rig always has its single hits, and never calls this.

mod scales;

use nalgebra::SVector;

use super::fit::{Fit, Refinement, Stage};
use super::fit_problem::FitProblem;
use super::learning::{LEAST_RESIDUAL_FREEDOM, MOST_SCATTER};
use super::model::{HIT_NUISANCES, Model};
use super::normal_equations::NormalEquations;
use super::{MaximumLikelihoodSolution, Start, equations_in, pulls, undetermined};
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::budget::{BudgetScales, ErrorBudget, LearnedBudget};
use crate::identify::{DofMassLines, Estimate, Progress};
use crate::layout::Layout;
use crate::real::Real;
pub use scales::{DIRECTION, Evidence, GROUPS, POSITION, SENSORS, Scales};

/// Fewest single hits at each DOF that show their scatter.
const FEWEST_HITS: u16 = 3;

/// True when three or more single hits are known at each DOF. [`solve`](super::solve) then learns their scatter from
/// them; [`solve`] of this module is for all other mass lines.
pub fn have_repeats<R: Real, C: Capacity>(dofs: &[DofMassLines<R, C>]) -> bool {
    dofs.iter().all(|(_, lines)| {
        let known = (0..lines.scatter.rows()).any(|k| lines.scatter[(k, k)] > R::zero());
        known && lines.hits >= FEWEST_HITS
    })
}

/// Size of the workspace of [`solve`] for this number of sensors and hit DOFs.
pub const fn workspace(sensors: usize, hits: usize) -> usize {
    super::workspace(sensors, hits) + HIT_NUISANCES * hits * super::unknowns(sensors)
}

/// Determines the ten properties and learns the error budget from the residuals of these mass lines. Where the data
/// contradict it so much that no fit ends, the answer is that of [`super::solve`], with hits as stated.
///
/// `workspace` needs the length that [`workspace`] gives for the layout's sensors and hits.
///
/// # Errors
/// As [`super::solve`].
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::maximum_likelihood::{Start, without_repeats};
/// let layout = frame::layout();
/// let dofs = frame::mass_lines(&layout);
/// assert!(!without_repeats::have_repeats(&dofs));
/// let mut memory = vec![0.0; without_repeats::workspace(layout.sensors.len(), layout.hits.len())];
/// let solution = without_repeats::solve(&layout, &dofs, Start::InertiaRestraint, &mut memory).unwrap();
/// // Exact readings show no scatter of the hits, although the layout states one: no mean loss is taken out.
/// assert!((solution.estimate.body.mass / 1.23 - 1.0).abs() < 1e-5);
/// ```
pub fn solve<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
    start: Start<'_, R>,
    workspace: &mut [R],
) -> Result<MaximumLikelihoodSolution<R, C>, Diagnostics> {
    let own = super::workspace(layout.sensors.len(), layout.hits.len());
    let (workspace, products) = workspace.split_at_mut_checked(own).ok_or_else(undetermined)?;
    solve_in(layout, dofs, start, workspace, products)
        .or_else(|_| super::solve(layout, dofs, start, ErrorBudget::Learned, workspace))
}

fn solve_in<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
    start: Start<'_, R>,
    workspace: &mut [R],
    products: &mut [R],
) -> Result<MaximumLikelihoodSolution<R, C>, Diagnostics> {
    let mut fit = Fit::start(layout, dofs, start, ErrorBudget::Learned)?;
    while !matches!(fit.stage, Stage::LearnScatter | Stage::Done) {
        fit.step(layout, dofs, workspace)?;
    }
    let few = fit.consistency().degrees_of_freedom < LEAST_RESIDUAL_FREEDOM;
    if few || matches!(fit.stage, Stage::Done) {
        while fit.step(layout, dofs, workspace)? == Progress::Going {}
        return fit.finish(layout, dofs, workspace);
    }
    let (scaled, learning) = LearnedScales::of(&mut fit, layout, dofs, workspace, products)?;
    while !matches!(fit.stage, Stage::Sharing(_) | Stage::Done) {
        fit.step(&scaled, dofs, workspace)?;
    }
    let mut widening = SVector::repeat(R::one());
    if let Stage::Sharing(_) = fit.stage {
        let problem = fit.problem(&scaled);
        let mut equations = equations_in(workspace, &problem)?;
        widening = learning.scales.widening(&fit.group_shares(&problem, dofs, &mut equations)?);
        fit.stage = Stage::BandShift;
    }
    while fit.step(&scaled, dofs, workspace)? == Progress::Going {}
    let mut solution = fit.finish(&scaled, dofs, workspace)?;
    learning.conclude(layout, widening.into(), &mut solution.estimate);
    Ok(solution)
}

/// The learned scales, and what the stated budget left unexplained.
struct LearnedScales<R> {
    scales: Scales<R>,
    /// Reduced χ² under the stated budget.
    stated: R,
    /// The first suspect under the stated budget.
    suspect: Option<Diagnostic>,
}

impl<R: Real> LearnedScales<R> {
    /// Learns from a fit under the stated budget; the layout that is returned has the learned one.
    fn of<C: Capacity>(
        fit: &mut Fit<R>,
        layout: &Layout<R, C>,
        dofs: &[DofMassLines<R, C>],
        workspace: &mut [R],
        products: &mut [R],
    ) -> Result<(Layout<R, C>, Self), Diagnostics> {
        let problem = fit.problem(layout);
        let mut equations = equations_in(workspace, &problem)?;
        fit.evaluate(&problem, dofs, &mut equations)?;
        let body = problem.body_of(&fit.parameters.phi()).ok_or_else(undetermined)?;
        let suspect = pulls::suspect(&problem, dofs, &body, &mut equations);
        let stated = fit.consistency().reduced();
        let mut scales = Scales::stated();
        let mut scaled = layout.clone();
        loop {
            let before = scaled;
            let problem = fit.problem(&before);
            let mut equations = equations_in(workspace, &problem)?;
            let evidence = fit.evidence(&problem, dofs, &mut equations, products)?;
            let progress = scales.improve(&evidence).ok_or_else(undetermined)?;
            scaled = layout.clone();
            scales.learned().apply_to(&mut scaled);
            fit.rescale_hit_errors(&problem, &scaled, dofs, &mut equations);
            if progress == Progress::Done {
                break;
            }
            let problem = fit.problem(&scaled);
            fit.evaluate(&problem, dofs, &mut equations)?;
            fit.refine(&mut Refinement::begin(), &problem, dofs, &mut equations)?;
            fit.evaluate(&problem, dofs, &mut equations)?;
        }
        // The scaled layout states what was learned; the fit knows only how certain that is.
        fit.learned = Some(LearnedBudget { scales: BudgetScales::default(), ..scales.learned() });
        fit.stage = Stage::Refining(Refinement::begin());
        Ok((scaled, Self { scales, stated, suspect }))
    }

    /// States in the estimate what was learned, and doubts it where that is far from what the layout states.
    fn conclude<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        widening: [R; 10],
        estimate: &mut Estimate<R>,
    ) {
        let learned = LearnedBudget { widening, ..self.scales.learned() };
        estimate.learned = Some(learned);
        let diagnostics = &mut estimate.diagnostics;
        diagnostics.retain(|d| d.code != Code::ScatterNotLearned);
        let directions = layout.hits.iter().map(|hit| hit.uncertainty.direction);
        let largest = directions.fold(R::zero(), R::max) * learned.scales.hit_direction;
        if largest > R::of(MOST_SCATTER) {
            let milliradians = (largest * R::of(1e3)).to_f32();
            // There are only a handful of diagnostics.
            let code = Code::HitsScatterMuch;
            let _ = diagnostics.push(Diagnostic::whole(code, Severity::Warning, milliradians));
        }
        let is_doubted = |d: &Diagnostic| d.code == Code::DataInconsistentWithBudget;
        if self.scales.exceed_statement() && !estimate.diagnostics.iter().any(is_doubted) {
            let (code, value) = (Code::DataInconsistentWithBudget, self.stated.to_f32());
            let doubt = Diagnostic::whole(code, Severity::Warning, value);
            let _ = estimate.diagnostics.push(doubt);
            let _ = self.suspect.map(|suspect| estimate.diagnostics.push(suspect));
        }
    }
}

impl<R: Real> Fit<R> {
    /// Shares of positions, directions and sensors in the variance of each property, from completed equations.
    fn group_shares<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<[SVector<R, 10>; GROUPS], Diagnostics> {
        self.add_shares(None, problem, dofs, equations)?;
        let mut parts = [SVector::<R, 10>::zeros(); GROUPS];
        parts[SENSORS] = self.shares.constant;
        let object = self.object().ok_or_else(undetermined)?;
        let (slopes, nuisances) = (object.dtheta_dphi(), problem.nuisances());
        let body = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
        let model = Model::new(problem.layout, &problem.balance, &body).ok_or_else(undetermined)?;
        for (place, (index, lines)) in dofs.iter().enumerate() {
            let errors = equations.hit_errors(place);
            let terms = problem.terms(&model, *index, lines, &errors).ok_or_else(undetermined)?;
            problem.with_rows(&model, &terms, |rows| {
                for (k, spread) in terms.model.spread.0.iter().enumerate() {
                    let solved = equations.solve_readings(rows, &terms.weight.times(spread));
                    let moved = slopes * SVector::<R, 10>::from_fn(|i, _| solved[nuisances + i]);
                    parts[scales::group_of_hit(k)] += moved.component_mul(&moved);
                }
            });
        }
        let variance = self.shares.variance;
        Ok(parts.map(|part| {
            part.zip_map(
                &variance,
                |part, whole| {
                    if whole > R::zero() { part / whole } else { R::zero() }
                },
            )
        }))
    }
}

#[cfg(test)]
mod tests;
