//! Maximum likelihood with the complete covariance: the estimator that reaches the Cramér-Rao bound.
//!
//! The accelerances are wrong by noise, by where and how the hammer landed, by the sensitivity,
//! rotation and place of every sensor, and by the hammer's gain. All of it is part of the model, with
//! the standard deviations that the layout carries, so the fit weighs every reading by what it is
//! worth and the covariance covers everything in the budget (theory, section 4).
//!
//! The augmented form is used: every cause that stays the same over the test is an unknown with a
//! prior, which leaves one small covariance per hit DOF and one normal matrix of a fixed size. The
//! causes come out with the answer ([`Learned`]). Steps are those of Levenberg and Marquardt; the
//! covariance of the readings is evaluated anew after every step.
//!
//! [`solve`] does it all; a rig takes [`Fit::step`] by step, with other work between:
//!
//! ```text
//! start ─▶ step ─▶ step ─▶ … ─▶ answer, or finish
//! ```
//! A step is an *evaluation* of model, covariance and equations, or a *trial* of one damping.

mod balance;
mod bound;
mod learned;
mod model;
mod normal_equations;
mod problem;
mod start;
mod strain;

pub use bound::{Bound, bound, readings_covariance};
pub use learned::{Learned, LearnedHit, LearnedSensor, Learnt};

use core::borrow::Borrow;

use nalgebra::{SMatrix, SVector};

use super::{Consistency, Estimate, MassLines};
use crate::Real;
use crate::body::{LogCholesky, RigidBody};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::layout::{Layout, MAX_ATTACHED, RIG_SENSORS, is_finite};
use crate::linalg::{all_finite, cholesky};
use model::SENSOR_CAUSES;
use normal_equations::NormalEquations;
use problem::Problem;

/// A step of the ten that lowers the cost by less than this part of χ² over its degrees of freedom, or of
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
/// Longest step in log-Cholesky parameters, which are logarithms and lengths over L.
const LONGEST_STEP: f64 = 1.0;
/// Part of the largest to which the eigenvalues of `½ tr(J) I − J` are raised at a restart.
const RAISED: f64 = 0.05;
/// Data whose χ² would be exceeded by chance in one of a thousand tests contradict the budget: this
/// many standard deviations of a normal variable.
pub const CONTRADICTION: f64 = 3.09;

/// Numbers of workspace for a layout of so many sensors.
pub const fn workspace(sensors: usize) -> usize {
    normal_equations::workspace(SENSOR_CAUSES * sensors + 1 + MAX_ATTACHED + 10)
}

/// Numbers of workspace on the rig.
pub const RIG_WORKSPACE: usize = workspace(RIG_SENSORS);

/// What the fit answers.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution<R, const S: usize, const H: usize> {
    /// The ten with their covariance, and χ² with its verdict.
    pub estimate: Estimate<R>,
    /// What the fit found out about sensors, hammer and hits.
    pub learned: Learned<R, S, H>,
}

/// Whether another step is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Call [`Fit::step`] again.
    Going,
    /// Call [`Fit::answer`] or [`Fit::finish`].
    Done,
}

/// The ten that are varied.
#[derive(Clone, Copy, Debug)]
enum Parameters<R> {
    /// phi of the object, balanced.
    Free(SVector<R, 10>),
    /// Only physical bodies: on the way from a crude start, and where the free minimum is none.
    Consistent { body: LogCholesky<R>, on_the_way: bool },
}

/// A fit in progress.
#[derive(Clone, Debug)]
pub struct Fit<R> {
    parameters: Parameters<R>,
    damping: R,
    steps: u8,
    /// Of the last evaluation.
    cost: R,
    /// L, m.
    length: R,
    /// Readings and priors.
    equations: usize,
    rank: usize,
    condition: R,
    diagnostics: Diagnostics,
    stage: Stage<R>,
}

/// What the next step does.
#[derive(Clone, Copy, Debug)]
enum Stage<R> {
    /// Evaluates.
    Arrived,
    /// Tries a damping.
    Evaluated(Slope<R>),
    /// Evaluates for the last time.
    Settled,
    /// Nothing: the answer can be given.
    Done,
}

/// The cost about the present parameters.
#[derive(Clone, Copy, Debug)]
struct Slope<R> {
    information: SMatrix<R, 10, 10>,
    gradient: SVector<R, 10>,
    /// Dampings tried so far.
    trials: u8,
}

/// The ten properties from the mass lines, by as many steps as it takes.
///
/// `start` is the answer of another method where there is one, without what hangs on the object; else a
/// crude start is looked for.
/// `workspace` has [`workspace`] numbers for the layout's sensors.
///
/// # Errors
/// As [`Fit::start`].
pub fn solve<R, const S: usize, const H: usize, const CH: usize, I, B>(
    layout: &Layout<R, S, H>,
    dofs: I,
    start: Option<&RigidBody<R>>,
    workspace: &mut [R],
) -> Result<Solution<R, S, H>, Diagnostics>
where
    R: Real,
    I: IntoIterator<Item = (usize, B)>,
    I::IntoIter: Clone,
    B: Borrow<MassLines<R, CH>>,
{
    let dofs = dofs.into_iter();
    let mut fit = Fit::start::<S, H, CH, B>(layout, dofs.clone(), start)?;
    while fit.step::<S, H, CH, B>(layout, dofs.clone(), workspace)? == Progress::Going {}
    fit.finish::<S, H, CH, B>(layout, dofs, workspace)
}

impl<R: Real> Fit<R> {
    /// Checks layout and data and chooses the start.
    ///
    /// # Errors
    /// Whatever keeps the data from determining the ten by any method: numbers that are not finite,
    /// hits that are too few, parallel or concurrent, an information matrix of a rank below ten.
    pub fn start<const S: usize, const H: usize, const CH: usize, B>(
        layout: &Layout<R, S, H>,
        dofs: impl Iterator<Item = (usize, B)> + Clone,
        start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics>
    where
        B: Borrow<MassLines<R, CH>>,
    {
        check_data(layout, dofs.clone())?;
        let problem = Problem::<R, S, H, CH>::new(layout);
        let given = start.map(|object| problem.balance.body(object)).filter(start::is_usable);
        let (whole, parameters) = match given {
            Some(object) => {
                let whole = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
                (whole, Parameters::Free(object.phi()))
            }
            None => {
                let whole = start::crude(&problem, dofs.clone()).ok_or_else(undetermined)?;
                (whole, problem.on_the_way(&whole).ok_or_else(undetermined)?)
            }
        };
        let (spectrum, diagnostics) = start::identifiable(&problem, dofs.clone(), &whole)?;
        Ok(Self {
            parameters,
            damping: R::of(FIRST_DAMPING),
            steps: 0,
            cost: R::zero(),
            length: problem.balance.length,
            equations: dofs.count() * problem.channels + layout.priors.len(),
            rank: spectrum.rank,
            condition: spectrum.condition,
            diagnostics,
            stage: Stage::Arrived,
        })
    }

    /// One step: an evaluation or a trial. What it leaves in the workspace is what the next begins
    /// with.
    ///
    /// # Errors
    /// When the equations cannot be solved any more, or [`MOST_STEPS`] were not enough.
    #[inline(never)]
    pub fn step<const S: usize, const H: usize, const CH: usize, B>(
        &mut self,
        layout: &Layout<R, S, H>,
        dofs: impl Iterator<Item = (usize, B)> + Clone,
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics>
    where
        B: Borrow<MassLines<R, CH>>,
    {
        let problem = Problem::<R, S, H, CH>::new(layout);
        let mut equations = equations_in(workspace, &problem)?;
        match self.stage {
            Stage::Arrived => {
                self.steps += 1;
                if self.steps > MOST_STEPS {
                    return Err(fatal(Code::NotConverged, MOST_STEPS as f32));
                }
                self.evaluate(&problem, dofs, &mut equations)?;
                let slopes = self.slopes();
                self.stage = Stage::Evaluated(Slope {
                    information: slopes.transpose() * equations.information() * slopes,
                    gradient: slopes.transpose() * equations.gradient(),
                    trials: 0,
                });
            }
            Stage::Evaluated(slope) => self.descend(&problem, dofs, &mut equations, slope)?,
            Stage::Settled => {
                self.evaluate(&problem, dofs, &mut equations)?;
                self.stage = Stage::Done;
            }
            Stage::Done => {}
        }
        Ok(if let Stage::Done = self.stage { Progress::Done } else { Progress::Going })
    }

    /// Tries the next damping: moves on where the cost falls.
    fn descend<const S: usize, const H: usize, const CH: usize, B>(
        &mut self,
        problem: &Problem<'_, R, S, H, CH>,
        dofs: impl Iterator<Item = (usize, B)> + Clone,
        equations: &mut NormalEquations<'_, R>,
        slope: Slope<R>,
    ) -> Result<(), Diagnostics>
    where
        B: Borrow<MassLines<R, CH>>,
    {
        let Slope { information, gradient, trials } = slope;
        let levels = self.levels(&information);
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
            && let Some(moved) = self.moved(&step)
        {
            if step.dot(&gradient) < close && self.damping <= R::of(UNDAMPED) {
                self.parameters = moved;
                self.settle();
                return Ok(());
            }
            let body = problem.body_of(&moved.phi());
            let cost = body.and_then(|body| self.trial(problem, dofs, equations, &body));
            // Rounding of a sum of squares, a few ulp a term.
            let slack = self.cost * R::default_epsilon() * R::of(64.0);
            if let Some(cost) = cost.filter(|cost| *cost <= self.cost + slack) {
                self.parameters = moved;
                self.damping = (self.damping * R::of(0.1)).max(R::of(1e-9));
                self.stage = Stage::Arrived;
                if self.is_held() && self.cost - cost < close + slack {
                    self.settle();
                }
                return Ok(());
            }
        }
        self.damping *= R::of(10.0);
        self.stage = Stage::Evaluated(Slope { trials: trials + 1, ..slope });
        Ok(())
    }

    /// The answer, without what the fit found out about the rig; `workspace` as the last step left it.
    ///
    /// # Errors
    /// When the information about the ten is not positive definite, a number is not finite, or steps
    /// are missing.
    #[inline(never)]
    pub fn answer<const S: usize, const H: usize, const CH: usize, B>(
        self,
        layout: &Layout<R, S, H>,
        dofs: impl Iterator<Item = (usize, B)>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics>
    where
        B: Borrow<MassLines<R, CH>>,
    {
        let problem = Problem::<R, S, H, CH>::new(layout);
        let mut equations = equations_in(workspace, &problem)?;
        self.conclude(&problem, dofs, &mut equations)
    }

    /// The answer and what the fit found out about the rig; `workspace` as the last step left it.
    ///
    /// # Errors
    /// As [`Self::answer`].
    pub fn finish<const S: usize, const H: usize, const CH: usize, B>(
        self,
        layout: &Layout<R, S, H>,
        dofs: impl Iterator<Item = (usize, B)> + Clone,
        workspace: &mut [R],
    ) -> Result<Solution<R, S, H>, Diagnostics>
    where
        B: Borrow<MassLines<R, CH>>,
    {
        let problem = Problem::<R, S, H, CH>::new(layout);
        let mut equations = equations_in(workspace, &problem)?;
        let body = problem.body_of(&self.parameters.phi()).ok_or_else(undetermined)?;
        let estimate = self.conclude(&problem, dofs.clone(), &mut equations)?;
        let learned = learned::learn(&problem, dofs, &body, &mut equations);
        Ok(Solution { estimate, learned: learned.ok_or_else(undetermined)? })
    }

    fn conclude<const S: usize, const H: usize, const CH: usize, B>(
        mut self,
        problem: &Problem<'_, R, S, H, CH>,
        dofs: impl Iterator<Item = (usize, B)>,
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<Estimate<R>, Diagnostics>
    where
        B: Borrow<MassLines<R, CH>>,
    {
        let Stage::Done = self.stage else {
            return Err(fatal(Code::NotConverged, f32::from(self.steps)));
        };
        let object = self.object().ok_or_else(undetermined)?;
        if object.mass <= R::zero() {
            let code = if problem.layout.attached.is_empty() {
                Code::MassNotPositive
            } else {
                Code::AttachedTooHeavy
            };
            return Err(fatal(code, object.mass.to_f32()));
        }
        let covariance = covariance_of(&equations.information(), &object);
        let covariance = covariance.ok_or_else(undetermined)?;
        let consistency = self.consistency();
        if !object.is_physically_consistent() {
            self.say(Code::NotPhysicallyConsistent, Severity::Warning, self.margin(&object));
        }
        if consistency.surprise() > R::of(CONTRADICTION) {
            self.say(Code::DataContradictBudget, Severity::Warning, consistency.reduced());
            let body = problem.body_of(&self.parameters.phi()).ok_or_else(undetermined)?;
            if let Some(suspect) = strain::suspect(problem, dofs, &body, equations) {
                let _ = self.diagnostics.push(suspect);
            }
        }
        let layout = problem.layout;
        if layout.gravity.is_none() && layout.sensors.iter().any(|s| s.senses_gravity) {
            self.say(Code::GravityNotGiven, Severity::Note, R::zero());
        }
        Ok(Estimate {
            body: problem.balance.body_back(&object),
            covariance: Some(problem.balance.covariance_back(&covariance)),
            rank: self.rank,
            condition: self.condition,
            response_condition: None,
            rms: (self.cost / R::of(self.equations as f64)).sqrt(),
            consistency: Some(consistency),
            diagnostics: self.diagnostics,
        })
    }

    /// Steps so far.
    pub fn steps(&self) -> u8 {
        self.steps
    }

    /// The equations at the present parameters, the causes eliminated; the cost with them.
    fn evaluate<const S: usize, const H: usize, const CH: usize, B>(
        &mut self,
        problem: &Problem<'_, R, S, H, CH>,
        dofs: impl Iterator<Item = (usize, B)>,
        equations: &mut NormalEquations<'_, R>,
    ) -> Result<(), Diagnostics>
    where
        B: Borrow<MassLines<R, CH>>,
    {
        let phi = self.parameters.phi();
        let body = problem.body_of(&phi).ok_or_else(undetermined)?;
        let squares = problem.assemble(&body, dofs, equations).ok_or_else(undetermined)?;
        let object = RigidBody::from_phi(&phi).ok_or_else(undetermined)?;
        let priors = problem.add_priors(&object, equations);
        equations.eliminate().ok_or_else(undetermined)?;
        self.cost = squares + priors - equations.explained();
        Ok(())
    }

    /// The cost of another body under the covariance of the present one.
    fn trial<const S: usize, const H: usize, const CH: usize, B>(
        &self,
        problem: &Problem<'_, R, S, H, CH>,
        dofs: impl Iterator<Item = (usize, B)> + Clone,
        equations: &mut NormalEquations<'_, R>,
        body: &RigidBody<R>,
    ) -> Option<R>
    where
        B: Borrow<MassLines<R, CH>>,
    {
        let present = problem.body_of(&self.parameters.phi())?;
        let squares = problem.assemble_second(&present, body, dofs, equations)?;
        let object = RigidBody::from_phi(&(body.phi() - problem.attached_sum()))?;
        let cost = squares + problem.cost_of_priors(&object) - equations.explained_second();
        cost.finite().then_some(cost)
    }

    fn object(&self) -> Option<RigidBody<R>> {
        RigidBody::from_phi(&self.parameters.phi())
    }

    /// `∂phi` over the parameters.
    fn slopes(&self) -> SMatrix<R, 10, 10> {
        match &self.parameters {
            Parameters::Free(_) => SMatrix::identity(),
            Parameters::Consistent { body, .. } => body.dphi(),
        }
    }

    /// The parameters after a step; `None` when it is too long.
    fn moved(&self, step: &SVector<R, 10>) -> Option<Parameters<R>> {
        match &self.parameters {
            Parameters::Free(phi) => Some(Parameters::Free(phi + step)),
            Parameters::Consistent { body: LogCholesky(z), on_the_way } => {
                let body = LogCholesky(z + step);
                (step.norm() <= R::of(LONGEST_STEP))
                    .then_some(Parameters::Consistent { body, on_the_way: *on_the_way })
            }
        }
    }

    /// What the damping is relative to: of free properties each has its own unit (Marquardt); the
    /// log-Cholesky parameters are comparable, and near the edge of what is physical some have no
    /// information left (Levenberg).
    fn levels(&self, information: &SMatrix<R, 10, 10>) -> SVector<R, 10> {
        if self.is_held() {
            SVector::from_element(information.trace() * R::of(0.1))
        } else {
            information.diagonal()
        }
    }

    fn is_held(&self) -> bool {
        matches!(self.parameters, Parameters::Consistent { .. })
    }

    /// A gain that is not worth another step.
    fn close(&self) -> R {
        let least = match self.parameters {
            Parameters::Free(_) => R::of(CLOSE).max(R::default_epsilon() * R::of(100.0)),
            Parameters::Consistent { .. } => R::of(NEAR),
        };
        least * self.consistency().reduced().max(R::one())
    }

    fn consistency(&self) -> Consistency<R> {
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
                self.say(Code::HeldToConsistency, Severity::Warning, self.margin(&object));
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
    fn margin(&self, object: &RigidBody<R>) -> R {
        object.physical_margin().unwrap_or(R::zero()) * self.length * self.length
    }

    fn say(&mut self, code: Code, severity: Severity, value: R) {
        // A handful at most.
        let _ = self.diagnostics.push(Diagnostic::whole(code, severity, value.to_f32()));
    }
}

impl<R: Real, const S: usize, const H: usize, const CH: usize> Problem<'_, R, S, H, CH> {
    /// The parameters of a crude start.
    fn on_the_way(&self, whole: &RigidBody<R>) -> Option<Parameters<R>> {
        let object = RigidBody::from_phi(&(whole.phi() - self.attached_sum()));
        // What hangs on the object may outweigh a start that is far off.
        let object = object.filter(|object| object.mass > R::zero()).unwrap_or(*whole);
        let body = LogCholesky::from_body(&object.made_consistent(R::of(RAISED))?)?;
        Some(Parameters::Consistent { body, on_the_way: true })
    }
}

impl<R: Real> Parameters<R> {
    fn phi(&self) -> SVector<R, 10> {
        match self {
            Self::Free(phi) => *phi,
            Self::Consistent { body, .. } => body.body().phi(),
        }
    }
}

/// `(I + λ D)⁻¹ g` with diagonal `D`; `None` when that is not positive definite.
fn damped_step<R: Real>(
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

/// Covariance of theta from the information about phi.
fn covariance_of<R: Real>(
    information: &SMatrix<R, 10, 10>,
    object: &RigidBody<R>,
) -> Option<SMatrix<R, 10, 10>> {
    let mut covariance = SMatrix::<R, 10, 10>::zeros();
    for k in 0..10 {
        let mut unit = SVector::<R, 10>::zeros();
        unit[k] = R::one();
        covariance.set_column(k, &damped_step(information, &unit, R::zero(), &SVector::zeros())?);
    }
    let to_theta = object.dtheta_dphi();
    let covariance = to_theta * covariance * to_theta.transpose();
    all_finite(&covariance).then_some(covariance)
}

/// Refuses what no arithmetic can repair.
fn check_data<R, const S: usize, const H: usize, const CH: usize, B>(
    layout: &Layout<R, S, H>,
    dofs: impl Iterator<Item = (usize, B)>,
) -> Result<(), Diagnostics>
where
    R: Real,
    B: Borrow<MassLines<R, CH>>,
{
    if !is_finite(layout) {
        return Err(fatal(Code::LayoutNotFinite, 0.0));
    }
    super::check_mass_lines(layout, dofs)
}

/// The equations as a step before has left them.
fn equations_in<'w, R: Real, const S: usize, const H: usize, const CH: usize>(
    workspace: &'w mut [R],
    problem: &Problem<'_, R, S, H, CH>,
) -> Result<NormalEquations<'w, R>, Diagnostics> {
    NormalEquations::new(workspace, problem.causes()).ok_or_else(undetermined)
}

/// The start was identifiable, so what cannot be computed any more is a fit that went astray.
fn undetermined() -> Diagnostics {
    fatal(Code::NotConverged, 0.0)
}

fn fatal(code: Code, value: f32) -> Diagnostics {
    let mut found = Diagnostics::new();
    let _ = found.push(Diagnostic::whole(code, Severity::Error, value));
    found
}

#[cfg(test)]
pub(super) mod tests;
