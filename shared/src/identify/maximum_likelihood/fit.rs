//! The fit, step by step: Levenberg-Marquardt over phi, held to the physical bodies where the free minimum is none, or
//! over log-Cholesky parameters on the way from a crude start.

use nalgebra::SVector;

use super::damped_step::damped_step;
use super::fit_problem::FitProblem;
use super::intervals::Shares;
use super::nearest_body::{raised, step_to_body};
use super::normal_equations::NormalEquations;
use super::parameters::Parameters;
use super::score::SuspectedResponse;
use super::{check_data, equations_in, fatal, pulls, start, undetermined};
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::identify::budget::{BudgetScales, ErrorBudget, LearnedBudget};
use crate::identify::inertia_restraint::{self, InertiaRestraintSettings};
use crate::identify::{Consistency, DofMassLines, Progress, by_reference};
use crate::layout::Layout;
use crate::real::Real;

/// Largest number of steps; ten are already many.
const MOST_STEPS: u8 = 60;
/// Number of full steps; a fit that has not converged by then learns its budget, or goes on by half steps. Six are
/// usual.
pub(super) const STEADY_STEPS: u8 = 15;
/// χ² over its degrees of freedom below which a fit that does not end may end at a physical body; above it the errors
/// are three times those stated, and the budget is learned first.
const NEAR_ENOUGH: f64 = 9.0;
/// First damping, relative to the diagonal of the information.
const FIRST_DAMPING: f64 = 1e-6;

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
/// mass lines and workspace must be the same in every call. A step is at most 1.6 million instructions on a
/// rig.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::Progress;
/// # use massline_shared::identify::maximum_likelihood::{Fit, ErrorBudget, Start, workspace};
/// let layout = frame::layout();
/// let dofs = frame::mass_lines(&layout);
/// let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
/// // The readings of this example are exact: the hits do not scatter.
/// let mut fit = Fit::start(&layout, &dofs, Start::Crude, ErrorBudget::FirstOrder)?;
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
    pub(super) damping: R,
    pub(super) steps: u8,
    /// Cost at the last evaluation.
    pub(super) cost: R,
    /// Rounding error of the cost; smaller differences are not significant.
    pub(super) rounding: R,
    /// Characteristic length L, m.
    pub(super) length: R,
    /// Number of readings and priors.
    pub(super) equations: usize,
    pub(super) condition: R,
    pub(super) diagnostics: Diagnostics,
    pub(super) stage: Stage<R>,
    pub(super) budget: ErrorBudget,
    /// What the data have taught; the budget in use.
    pub(super) learned: Option<LearnedBudget<R>>,
    /// Reduced χ² under the stated budget, before anything is learned.
    pub(super) stated: R,
    pub(super) shares: Shares<R>,
}

/// The course of a refinement.
#[derive(Clone, Copy, Debug)]
pub(super) struct Refinement<R> {
    pub(super) steps: u8,
    /// Reduction of χ² that the last step promised.
    pub(super) gain: R,
    /// Fraction of the full step that is taken.
    pub(super) fraction: R,
}

impl<R: Real> Refinement<R> {
    pub(super) fn begin() -> Self {
        Self { steps: 0, gain: R::zero(), fraction: R::one() }
    }
}

/// The action of the next step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stage<R> {
    /// Evaluates the model at new parameters.
    Arrived,
    /// Tries a damping; `trials` have failed before.
    Evaluated { trials: u8 },
    /// Evaluates the model with the errors of the hits.
    Refining(Refinement<R>),
    /// Takes the step of second order.
    Refined(Refinement<R>),
    /// Learns the scatter of the hits.
    LearnScatter,
    /// Evaluates the model with the learned budget.
    Moving { steps: u8 },
    /// Takes one step of second order under the learned budget.
    Moved { steps: u8 },
    /// Evaluates the model after that step.
    Learning { steps: u8 },
    /// Corrects the learned constant scale.
    LearnScale { steps: u8 },
    /// Computes which part of the variances comes from the sensors, or from the mark at this place.
    Sharing(Option<usize>),
    /// Tells what modes near the ends of the band do.
    BandShift,
    /// Looks for channels that are not proportional to the force.
    Linearity,
    /// Looks for the hammer's signal in each response.
    Crosstalk,
    /// Looks for a memory of the multiplexer, which may explain what a response contains.
    Memory(Option<SuspectedResponse<R>>),
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
    pub fn start<C: Capacity>(
        layout: &Layout<R, C>,
        dofs: &[DofMassLines<R, C>],
        start: Start<'_, R>,
        budget: ErrorBudget,
    ) -> Result<Self, Diagnostics> {
        check_data(layout, dofs)?;
        let problem = FitProblem::<R, C>::new(layout);
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
            budget,
            learned: None,
            stated: R::zero(),
            shares: Shares::none(),
        })
    }

    /// Runs one step, an evaluation or a trial. The workspace must be passed on unchanged to the next step.
    ///
    /// # Errors
    /// When the equations can no longer be solved, or sixty steps were not enough.
    pub fn step<C: Capacity>(
        &mut self,
        layout: &Layout<R, C>,
        dofs: &[DofMassLines<R, C>],
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics> {
        let problem = self.problem(layout);
        let mut equations = equations_in(workspace, &problem)?;
        match self.stage {
            Stage::Arrived => {
                if self.steps == 0 {
                    equations.clear_hit_errors();
                }
                self.steps += 1;
                if self.steps > MOST_STEPS {
                    return Err(fatal(Code::NotConverged, MOST_STEPS as f32));
                }
                self.evaluate(&problem, dofs, &mut equations)?;
                self.stage = Stage::Evaluated { trials: 0 };
                if self.goes_astray() {
                    let is_far = self.consistency().reduced() >= R::of(NEAR_ENOUGH);
                    if !(is_far && self.is_to_learn()) {
                        self.hold_to_consistency(&equations);
                    }
                    if self.is_to_learn() && !self.parameters.are_physical() {
                        self.stage = Stage::LearnScatter;
                    }
                }
            }
            Stage::Evaluated { trials } => {
                let progress = self.descend(&problem, dofs, &mut equations, trials)?;
                if let Progress::Done = progress {
                    self.settle(&equations);
                }
            }
            Stage::Refining(refinement) => {
                self.evaluate(&problem, dofs, &mut equations)?;
                self.stage = Stage::Refined(refinement);
            }
            Stage::Refined(mut refinement) => {
                let progress = self.refine(&mut refinement, &problem, dofs, &mut equations)?;
                self.stage = match (progress, &self.learned) {
                    (Progress::Going, _) => Stage::Refining(refinement),
                    (Progress::Done, Some(_)) => Stage::Sharing(None),
                    (Progress::Done, None) if self.budget == ErrorBudget::Learned => {
                        Stage::LearnScatter
                    }
                    (Progress::Done, None) => Stage::BandShift,
                };
            }
            Stage::LearnScatter => {
                self.stated = self.consistency().reduced();
                self.learn_scatter(&problem, dofs)?;
                self.rescale_hit_errors(&problem, layout, dofs, &mut equations);
                // phi suits the stated scale, which is the first.
                self.stage = if self.can_learn_scale(&problem) {
                    Stage::Learning { steps: 0 }
                } else {
                    Stage::Refining(Refinement::begin())
                };
            }
            Stage::Moving { steps } => {
                self.evaluate(&problem, dofs, &mut equations)?;
                self.stage = Stage::Moved { steps };
            }
            Stage::Moved { steps } => {
                self.refine(&mut Refinement::begin(), &problem, dofs, &mut equations)?;
                self.stage = Stage::Learning { steps };
            }
            Stage::Learning { steps } => {
                self.evaluate(&problem, dofs, &mut equations)?;
                self.stage = Stage::LearnScale { steps: steps + 1 };
            }
            Stage::LearnScale { steps } => {
                let progress = self.learn_scale(steps, &problem, &mut equations)?;
                self.rescale_hit_errors(&problem, layout, dofs, &mut equations);
                self.stage = match progress {
                    Progress::Going => Stage::Moving { steps },
                    Progress::Done => Stage::Refining(Refinement::begin()),
                };
            }
            Stage::Sharing(place) => {
                self.stage = match self.add_shares(place, &problem, dofs, &mut equations)? {
                    Progress::Going => Stage::Sharing(Some(place.map_or(0, |place| place + 1))),
                    Progress::Done => Stage::BandShift,
                };
            }
            Stage::BandShift => {
                self.tell_band_shift(&problem, dofs, &mut equations)?;
                self.stage = Stage::Linearity;
            }
            Stage::Linearity => {
                self.test_linearity(&problem, dofs, &mut equations)?;
                self.stage = Stage::Crosstalk;
            }
            Stage::Crosstalk => {
                let suspected = self.test_responses(&problem, dofs, &mut equations)?;
                self.stage = Stage::Memory(suspected);
            }
            Stage::Memory(suspected) => {
                self.test_memory(suspected, &problem, dofs, &mut equations)?;
                equations.restore();
                self.stage = Stage::Final;
                self.hold_to_consistency(&equations);
            }
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

    /// The layout with the budget in use.
    pub(super) fn problem<'l, C: Capacity>(
        &self,
        layout: &'l Layout<R, C>,
    ) -> FitProblem<'l, R, C> {
        let scales = self.learned.map_or_else(BudgetScales::default, |learned| learned.scales);
        FitProblem::new(layout).with_budget(scales, self.budget != ErrorBudget::FirstOrder)
    }

    /// True when no minimum is found under the budget in use: the data may teach a larger one, or the way leads ever
    /// further from the physical bodies.
    fn goes_astray(&self) -> bool {
        self.steps > STEADY_STEPS && !self.parameters.are_physical()
    }

    /// True before the data have taught the budget that they are to teach.
    fn is_to_learn(&self) -> bool {
        self.budget == ErrorBudget::Learned && self.learned.is_none()
    }

    /// Number of steps so far.
    pub fn steps(&self) -> u8 {
        self.steps
    }

    /// Computes the equations at the present parameters, eliminates the nuisance parameters and updates the
    /// cost.
    pub(super) fn evaluate<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
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

    pub(super) fn object(&self) -> Option<RigidBody<R>> {
        RigidBody::from_phi(&self.parameters.phi())
    }

    /// Final check at the minimum: whether the body is physical, whether the data contradict their error
    /// budget and, if so, which sensor or hit is suspect.
    fn judge<C: Capacity>(
        &mut self,
        problem: &FitProblem<'_, R, C>,
        dofs: &[DofMassLines<R, C>],
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
        self.judge_learning(problem);
        let consistency = self.consistency();
        let doubtful = self.learned.is_some_and(|learned| learned.exceeds_statement());
        if consistency.rejects_budget() || doubtful {
            let reduced = if doubtful { self.stated } else { consistency.reduced() };
            self.push_diagnostic(Code::DataInconsistentWithBudget, Severity::Warning, reduced);
            let body = problem.body_of(&object.phi()).ok_or_else(undetermined)?;
            if let Some(suspect) = pulls::suspect(problem, dofs, &body, equations) {
                let _ = self.diagnostics.push(suspect);
            }
        }
        Ok(())
    }

    pub(super) fn consistency(&self) -> Consistency<R> {
        let degrees_of_freedom = self.equations.saturating_sub(10) as u16;
        Consistency { chi_squared: self.cost, degrees_of_freedom }
    }

    /// Called at a minimum. A fit that has come from a crude start continues with free parameters; a free
    /// minimum that is not a physical body is abandoned for a fit over physical bodies, once it has taught the
    /// budget.
    fn settle(&mut self, equations: &NormalEquations<'_, R>) {
        self.stage = Stage::Settled;
        match self.parameters {
            // Held on the way: where the stated budget does not suffice, it is learned first, and the minimum may be
            // a physical body all the same. Either way the fit goes on freely, and whether its end is held is seen
            // there.
            Parameters::Bounded(phi) if self.is_to_learn() => {
                let free = free_minimum(phi, equations);
                self.stage = if self.consistency().rejects_budget() {
                    Stage::LearnScatter
                } else if free.is_some_and(|body| body.is_physically_consistent()) {
                    Stage::Refining(Refinement::begin())
                } else {
                    return;
                };
                self.diagnostics.retain(|diagnostic| diagnostic.code != Code::HeldToConsistency);
            }
            Parameters::Bounded(_) => {}
            Parameters::OnTheWay(body) => {
                self.depart(Parameters::Free(body.body().phi()));
            }
            // A body without a positive inertia teaches nothing.
            Parameters::Free(_)
                if self.budget == ErrorBudget::FirstOrder
                    || self.object().is_none_or(|object| !start::is_usable(&object)) =>
            {
                self.hold_to_consistency(equations);
            }
            Parameters::Free(_) => self.stage = Stage::Refining(Refinement::begin()),
        }
    }

    /// Abandons a free minimum that is not a physical body for a fit over physical bodies.
    fn hold_to_consistency(&mut self, equations: &NormalEquations<'_, R>) {
        let inconsistent = self.object().filter(|body| !body.is_physically_consistent());
        let Some(object) = inconsistent else { return };
        let (phi, none) = (object.phi(), SVector::zeros());
        let step = step_to_body(&phi, &equations.information(), &none, R::zero(), &none);
        let nearest = match step {
            Some(step) => Some(phi + step),
            None => raised(&object).map(|body| body.phi()),
        };
        let Some(phi) = nearest else { return };
        self.push_diagnostic(Code::HeldToConsistency, Severity::Warning, self.margin(&object));
        self.depart(Parameters::Bounded(phi));
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

/// The body at the minimum of the quadratic model of the cost, whether physical or not.
fn free_minimum<R: Real>(
    phi: SVector<R, 10>,
    equations: &NormalEquations<'_, R>,
) -> Option<RigidBody<R>> {
    let none = SVector::zeros();
    let step = damped_step(&equations.information(), &equations.gradient(), R::zero(), &none)?;
    RigidBody::from_phi(&(phi + step))
}
