//! The fit, step by step: Levenberg-Marquardt over phi, or over log-Cholesky parameters where only physical
//! bodies are admitted.

use nalgebra::{SMatrix, SVector};

use super::fit_problem::FitProblem;
use super::normal_equations::NormalEquations;
use super::parameters::{Parameters, RAISED};
use super::{check_data, equations_in, fatal, pulls, start, undetermined};
use crate::Real;
use crate::body::{LogCholesky, RigidBody};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::inertia_restraint::{self, InertiaRestraintSettings};
use crate::identify::{Consistency, DofMassLines, Progress, by_reference};
use crate::layout::Layout;
use crate::linalg::{all_finite, cholesky};

/// The fit ends with a step that lowers the cost by less than this fraction of χ² over its degrees of
/// freedom, or of one if that is larger: the square of a shift in standard deviations. In single precision
/// the limit is a hundred roundings.
const CLOSE: f64 = 1e-10;
/// The same limit where only physical bodies are admitted: on the way from a crude start, and at the boundary
/// of the physical bodies, which log-Cholesky parameters approach without ever reaching it.
const NEAR: f64 = 1e-3;
/// Largest number of steps; ten are already many.
const MOST_STEPS: u8 = 60;
/// Number of dampings tried before a step is given up.
const MOST_TRIALS: u8 = 20;
/// First damping, relative to the diagonal of the information.
const FIRST_DAMPING: f64 = 1e-6;
/// Below this, a damping does not shorten a step noticeably.
const UNDAMPED: f64 = 1e-2;
/// The start of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start<'a, R> {
    /// The answer of another method: a body without the attached ones.
    At(&'a RigidBody<R>),
    /// The answer of the inertia restraint method, or a crude start when it has none.
    InertiaRestraint,
    /// A ball in the middle of sensors and hits.
    Crude,
}

/// A fit that is running.
///
/// Call [`Fit::start`] once, [`Fit::step`] until it is done, then [`Fit::answer`] or [`Fit::finish`]; layout,
/// mass lines and workspace must be the same in every call. A step is at most a million instructions on a
/// rig.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::Progress;
/// # use massline_shared::identify::maximum_likelihood::{Fit, Start, workspace};
/// let layout = frame::layout();
/// let dofs = frame::mass_lines(&layout);
/// let mut memory = vec![0.0; workspace(layout.sensors.len())];
/// let mut fit = Fit::start(&layout, &dofs, Start::Crude)?;
/// while fit.step(&layout, &dofs, &mut memory)? == Progress::Going {
///     // Other work.
/// }
/// let estimate = fit.answer(&layout, &mut memory)?;
/// assert!((estimate.body.inertia.m11 - 0.011134).abs() < 1e-6);
/// # Ok::<(), massline_shared::diagnosis::Diagnostics>(())
/// ```
#[derive(Clone, Debug)]
pub struct Fit<R> {
    pub(super) parameters: Parameters<R>,
    damping: R,
    steps: u8,
    /// Cost at the last evaluation.
    pub(super) cost: R,
    /// Rounding error of the cost; smaller differences are not significant.
    rounding: R,
    /// Characteristic length L, m.
    length: R,
    /// Number of readings and priors.
    pub(super) equations: usize,
    pub(super) condition: R,
    pub(super) diagnostics: Diagnostics,
    pub(super) stage: Stage,
}

/// The action of the next step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stage {
    /// Evaluates the model at new parameters.
    Arrived,
    /// Tries a damping; `trials` have failed before.
    Evaluated { trials: u8 },
    /// Evaluates the model for the last time.
    Settled,
    /// Checks the body and the consistency of the data.
    Final,
    /// Does nothing: the answer is available.
    Done,
}

impl<R: Real> Fit<R> {
    /// Checks layout and data, and chooses the start.
    ///
    /// # Errors
    /// Everything that keeps any method from determining the inertial parameters: numbers that are not
    /// finite, hits that are too few, parallel or concurrent, an information matrix of a rank below ten.
    pub fn start<const S: usize, const H: usize>(
        layout: &Layout<R, S, H>,
        dofs: &[DofMassLines<R, S>],
        start: Start<'_, R>,
    ) -> Result<Self, Diagnostics> {
        check_data(layout, dofs)?;
        let problem = FitProblem::<R, S, H>::new(layout);
        let given = match start {
            Start::At(object) => Some(*object),
            Start::InertiaRestraint => {
                let linear =
                    inertia_restraint::solve(layout, dofs, InertiaRestraintSettings::weighted());
                linear.ok().map(|estimate| estimate.body)
            }
            Start::Crude => None,
        };
        let given = given.map(|object| problem.balance.body(&object)).filter(start::is_usable);
        // The body for which the layout has to determine the ten properties.
        let (judged, parameters) = match given {
            Some(object) => {
                let whole = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
                (whole, Parameters::Free(object.phi()))
            }
            None => {
                let whole = start::crude(&problem, dofs).ok_or_else(undetermined)?;
                let parameters = Parameters::on_the_way(&problem, &whole);
                // A ball in the middle is a special case: a layout may determine other bodies, but not this
                // one.
                (start::assumed(&problem), parameters.ok_or_else(undetermined)?)
            }
        };
        let (spectrum, diagnostics) = start::identifiable(&problem, dofs, &judged)?;
        Ok(Self {
            parameters,
            damping: R::of(FIRST_DAMPING),
            steps: 0,
            cost: R::zero(),
            rounding: R::zero(),
            length: problem.balance.length,
            equations: dofs.len() * problem.channels + layout.priors.len(),
            condition: spectrum.condition,
            diagnostics,
            stage: Stage::Arrived,
        })
    }

    /// Runs one step, an evaluation or a trial. The workspace must be passed on unchanged to the next step.
    ///
    /// # Errors
    /// When the equations can no longer be solved, or sixty steps were not enough.
    // Not inlined, which saves 0.6 KB of the firmware's deepest stack.
    #[inline(never)]
    pub fn step<const S: usize, const H: usize>(
        &mut self,
        layout: &Layout<R, S, H>,
        dofs: &[DofMassLines<R, S>],
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics> {
        let problem = FitProblem::<R, S, H>::new(layout);
        let mut equations = equations_in(workspace, &problem)?;
        match self.stage {
            Stage::Arrived => {
                self.steps += 1;
                if self.steps > MOST_STEPS {
                    return Err(fatal(Code::NotConverged, MOST_STEPS as f32));
                }
                self.evaluate(&problem, dofs, &mut equations)?;
                self.stage = Stage::Evaluated { trials: 0 };
            }
            Stage::Evaluated { trials } => self.descend(&problem, dofs, &mut equations, trials)?,
            Stage::Settled => {
                self.evaluate(&problem, dofs, &mut equations)?;
                self.stage = Stage::Final;
            }
            Stage::Final => {
                self.judge(&problem, dofs, &mut equations)?;
                self.stage = Stage::Done;
            }
            Stage::Done => {}
        }
        Ok(if let Stage::Done = self.stage { Progress::Done } else { Progress::Going })
    }

    /// Information and gradient with respect to the varied parameters, from the equations that
    /// [`Fit::evaluate`] leaves.
    fn slope(&self, equations: &NormalEquations<'_, R>) -> (SMatrix<R, 10, 10>, SVector<R, 10>) {
        match self.parameters.slopes() {
            None => (equations.information(), equations.gradient()),
            Some(slopes) => (
                slopes.transpose() * equations.information() * slopes,
                slopes.transpose() * equations.gradient(),
            ),
        }
    }

    /// Tries the next damping and takes the step if it lowers the cost.
    // Not inlined, which saves 2.4 KB of the firmware's deepest stack.
    #[inline(never)]
    fn descend<const S: usize, const H: usize>(
        &mut self,
        problem: &FitProblem<'_, R, S, H>,
        dofs: &[DofMassLines<R, S>],
        equations: &mut NormalEquations<'_, R>,
        trials: u8,
    ) -> Result<(), Diagnostics> {
        let (information, gradient) = self.slope(equations);
        let levels = self.parameters.levels(&information);
        if trials >= MOST_TRIALS {
            // No step lowers the cost: this is the minimum within the precision.
            let undamped = damped_step(&information, &gradient, R::zero(), &levels);
            return match undamped.map(|step| step.dot(&gradient)) {
                Some(gain) if gain < R::of(1e-2) => {
                    self.settle();
                    Ok(())
                }
                _ => Err(fatal(Code::NotConverged, f32::from(self.steps))),
            };
        }
        let close = self.close();
        let step = damped_step(&information, &gradient, self.damping, &levels);
        if let Some(step) = step
            && let Some(moved) = self.parameters.moved(&step)
        {
            if step.dot(&gradient) < close && self.damping <= R::of(UNDAMPED) {
                self.parameters = moved;
                self.settle();
                return Ok(());
            }
            let body = problem.body_of(&moved.phi());
            let cost = body.and_then(|body| self.trial(problem, dofs, equations, &body));
            if let Some(cost) = cost.filter(|cost| *cost <= self.cost + self.rounding) {
                self.parameters = moved;
                self.damping = (self.damping * R::of(0.1)).max(R::of(1e-9));
                self.stage = Stage::Arrived;
                if self.parameters.is_consistent() && self.cost - cost < close + self.rounding {
                    self.settle();
                }
                return Ok(());
            }
        }
        self.damping *= R::of(10.0);
        self.stage = Stage::Evaluated { trials: trials + 1 };
        Ok(())
    }

    /// Number of steps so far.
    pub fn steps(&self) -> u8 {
        self.steps
    }

    /// Computes the equations at the present parameters, eliminates the nuisance parameters and updates the
    /// cost.
    fn evaluate<const S: usize, const H: usize>(
        &mut self,
        problem: &FitProblem<'_, R, S, H>,
        dofs: &[DofMassLines<R, S>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<(), Diagnostics> {
        let phi = self.parameters.phi();
        let body = problem.body_of(&phi).ok_or_else(undetermined)?;
        let squares =
            problem.assemble(&body, by_reference(dofs), equations).ok_or_else(undetermined)?;
        let object = RigidBody::from_phi(&phi).ok_or_else(undetermined)?;
        let priors = problem.add_priors(&object, equations);
        equations.eliminate().ok_or_else(undetermined)?;
        self.cost = squares + priors - equations.explained();
        // A few ulp per term. The part that the nuisance parameters explain is included: it may be a thousand
        // times the remainder.
        self.rounding = (squares + priors) * R::default_epsilon() * R::of(64.0);
        Ok(())
    }

    /// The cost of another body under the covariance of the present one.
    fn trial<const S: usize, const H: usize>(
        &self,
        problem: &FitProblem<'_, R, S, H>,
        dofs: &[DofMassLines<R, S>],
        equations: &mut NormalEquations<'_, R>,
        body: &RigidBody<R>,
    ) -> Option<R> {
        let present = problem.body_of(&self.parameters.phi())?;
        let squares = problem.assemble_second(&present, body, by_reference(dofs), equations)?;
        let object = RigidBody::from_phi(&(body.phi() - problem.attached_sum()))?;
        let cost = squares + problem.cost_of_priors(&object) - equations.explained_second();
        cost.finite().then_some(cost)
    }

    pub(super) fn object(&self) -> Option<RigidBody<R>> {
        RigidBody::from_phi(&self.parameters.phi())
    }

    /// Final check at the minimum: whether the body is physical, whether the data contradict their error
    /// budget and, if so, which sensor or hit is suspect.
    fn judge<const S: usize, const H: usize>(
        &mut self,
        problem: &FitProblem<'_, R, S, H>,
        dofs: &[DofMassLines<R, S>],
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<(), Diagnostics> {
        let object = self.object().ok_or_else(undetermined)?;
        if !object.is_physically_consistent() {
            self.push_diagnostic(
                Code::NotPhysicallyConsistent,
                Severity::Warning,
                self.margin(&object),
            );
        }
        let consistency = self.consistency();
        if consistency.rejects_budget() {
            self.push_diagnostic(
                Code::DataInconsistentWithBudget,
                Severity::Warning,
                consistency.reduced(),
            );
            let body = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
            if let Some(suspect) = pulls::suspect(problem, dofs, &body, equations) {
                let _ = self.diagnostics.push(suspect);
            }
        }
        Ok(())
    }

    /// The smallest gain that justifies another step.
    fn close(&self) -> R {
        let least = match self.parameters {
            Parameters::Free(_) => R::of(CLOSE).max(R::default_epsilon() * R::of(100.0)),
            Parameters::Consistent { .. } => R::of(NEAR),
        };
        let least = least * self.consistency().reduced().max(R::one());
        least.max(self.rounding)
    }

    pub(super) fn consistency(&self) -> Consistency<R> {
        let degrees_of_freedom = self.equations.saturating_sub(10) as u16;
        Consistency { chi_squared: self.cost, degrees_of_freedom }
    }

    /// Called at a minimum. A fit that has come from a crude start continues with free parameters; a free
    /// minimum that is not a physical body is abandoned for a fit over physical bodies.
    fn settle(&mut self) {
        self.stage = Stage::Settled;
        match self.parameters {
            Parameters::Consistent { on_the_way: false, .. } => {}
            Parameters::Consistent { body, on_the_way: true } => {
                self.depart(Parameters::Free(body.body().phi()));
            }
            Parameters::Free(_) => {
                let inconsistent = self.object().filter(|body| !body.is_physically_consistent());
                let Some(object) = inconsistent else { return };
                let projected = object.made_consistent(R::of(RAISED));
                let start = projected.and_then(|body| LogCholesky::from_body(&body));
                let Some(body) = start else { return };
                self.push_diagnostic(
                    Code::HeldToConsistency,
                    Severity::Warning,
                    self.margin(&object),
                );
                self.depart(Parameters::Consistent { body, on_the_way: false });
            }
        }
    }

    /// Starts again from other parameters.
    fn depart(&mut self, parameters: Parameters<R>) {
        self.parameters = parameters;
        self.damping = R::of(FIRST_DAMPING);
        self.stage = Stage::Arrived;
    }

    /// The physical margin of a balanced body, kg m².
    pub(super) fn margin(&self, object: &RigidBody<R>) -> R {
        object.physical_margin().unwrap_or(R::zero()) * self.length * self.length
    }

    pub(super) fn push_diagnostic(&mut self, code: Code, severity: Severity, value: R) {
        // There are only a handful of diagnostics.
        let _ = self.diagnostics.push(Diagnostic::whole(code, severity, value.to_f32()));
    }
}

/// `(I + λ D)⁻¹ g` with diagonal `D`; `None` when that is not positive definite.
pub(super) fn damped_step<R: Real>(
    information: &SMatrix<R, 10, 10>,
    gradient: &SVector<R, 10>,
    damping: R,
    levels: &SVector<R, 10>,
) -> Option<SVector<R, 10>> {
    // Scaled to a unit diagonal, since the properties have different units.
    let scale = information.diagonal().zip_map(levels, |i, d| (i + damping * d).sqrt().recip());
    let mut scaled =
        SMatrix::<R, 10, 10>::from_fn(|i, j| information[(i, j)] * scale[i] * scale[j]);
    for i in 0..10 {
        scaled[(i, i)] = R::one();
    }
    if !all_finite(&scaled) {
        return None;
    }
    let factor = cholesky(&scaled)?;
    let mut step = gradient.component_mul(&scale);
    crate::linalg::forward_substitute(&factor, &mut step);
    crate::linalg::back_substitute_transposed(&factor, &mut step);
    step.component_mul_assign(&scale);
    all_finite(&step).then_some(step)
}
