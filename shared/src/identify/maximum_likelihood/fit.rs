//! The fit, step by step: Levenberg and Marquardt over phi, or over log-Cholesky parameters where only
//! physical bodies are looked at.

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

/// A step of the inertial parameters that lowers the cost by less than this part of χ² over its degrees of freedom, or of
/// one, ends the fit: a square of standard deviations. In single precision a hundred roundings.
const CLOSE: f64 = 1e-10;
/// The same where parameters are held to physical bodies: on the way from a crude start, and at the edge
/// of what is physical, which log-Cholesky parameters approach without end.
const NEAR: f64 = 1e-3;
/// Steps after which the fit gives up. Ten are many.
const MOST_STEPS: u8 = 60;
/// Dampings that are tried before a step is given up.
const MOST_TRIALS: u8 = 20;
/// First damping, relative to the diagonal of the information.
const FIRST_DAMPING: f64 = 1e-6;
/// A damping below this does not shorten a step noticeably.
const UNDAMPED: f64 = 1e-2;
/// Where a fit starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start<'a, R> {
    /// At a body without what hangs on it: the answer of another method.
    At(&'a RigidBody<R>),
    /// At the answer of the inertia restraint method; crudely where it has none.
    InertiaRestraint,
    /// At a ball in the middle of sensors and hits.
    Crude,
}

/// A fit in progress.
///
/// [`Fit::start`] once, [`Fit::step`] until it is done, then [`Fit::answer`] or [`Fit::finish`]; layout, mass lines
/// and workspace are the same in every call. A step is at most a million instructions on a rig.
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
    /// Of the last evaluation.
    pub(super) cost: R,
    /// Its rounding: what cannot be told from nothing.
    rounding: R,
    /// L, m.
    length: R,
    /// Readings and priors.
    pub(super) equations: usize,
    pub(super) condition: R,
    pub(super) diagnostics: Diagnostics,
    pub(super) stage: Stage,
}

/// What the next step does.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stage {
    /// Evaluates.
    Arrived,
    /// Tries a damping, after so many others.
    Evaluated { trials: u8 },
    /// Evaluates for the last time.
    Settled,
    /// Asks whether body and data are what they can be.
    Final,
    /// Nothing: the answer can be given.
    Done,
}

impl<R: Real> Fit<R> {
    /// Checks layout and data and chooses the start.
    ///
    /// # Errors
    /// Whatever keeps the data from determining the inertial parameters by any method: numbers that are not finite,
    /// hits that are too few, parallel or concurrent, an information matrix of a rank below ten.
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
        // The body at which the layout has to determine the ten.
        let (judged, parameters) = match given {
            Some(object) => {
                let whole = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
                (whole, Parameters::Free(object.phi()))
            }
            None => {
                let whole = start::crude(&problem, dofs).ok_or_else(undetermined)?;
                let parameters = Parameters::on_the_way(&problem, &whole);
                // A ball in the middle is a special body: another one may be determined where it is not.
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

    /// One step: an evaluation or a trial. What it leaves in the workspace is what the next begins
    /// with.
    ///
    /// # Errors
    /// When the equations cannot be solved any more, or sixty of them were not enough.
    // Never inlined: 0.6 KB less of the firmware's deepest stack.
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

    /// Information and gradient of what is varied, of the equations that [`Fit::evaluate`] leaves.
    fn slope(&self, equations: &NormalEquations<'_, R>) -> (SMatrix<R, 10, 10>, SVector<R, 10>) {
        match self.parameters.slopes() {
            None => (equations.information(), equations.gradient()),
            Some(slopes) => (
                slopes.transpose() * equations.information() * slopes,
                slopes.transpose() * equations.gradient(),
            ),
        }
    }

    /// Tries the next damping: moves on where the cost falls.
    // Never inlined: 2.4 KB less of the firmware's deepest stack.
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
            // No step lowers the cost: this is the minimum as far as the precision tells.
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
                if self.parameters.is_held() && self.cost - cost < close + self.rounding {
                    self.settle();
                }
                return Ok(());
            }
        }
        self.damping *= R::of(10.0);
        self.stage = Stage::Evaluated { trials: trials + 1 };
        Ok(())
    }

    /// Steps so far.
    pub fn steps(&self) -> u8 {
        self.steps
    }

    /// The equations at the present parameters, the nuisance parameters eliminated; the cost with them.
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
        // A few ulp a term. What the nuisance parameters explain is part of the terms: it may be a thousand times
        // what they leave.
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

    /// At the minimum: whether the body is a physical one, whether the data contradict their error budget, and
    /// what is to be suspected then.
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

    /// A gain that is not worth another step.
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

    /// A minimum is found. From the way it goes on freely; a free minimum that is no physical body is
    /// left for the consistent one.
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

    /// Begins anew from other parameters.
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
        // A handful at most.
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
    // With a unit diagonal: the properties have different units.
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
