//! Direct physical parameter identification (DPPIM) of Huang and Lallement: the ten properties from the responses at
//! pairs of frequencies, without modes.
//!
//! The dynamic stiffness `D(s)` of a body on springs and dampers is symmetric, so what one force does under the motion
//! of another at a second frequency gives an equation from which the damping drops out. The *viscous* form, `D = s² M +
//! s C + K`, also eliminates K and needs motions that span all six directions; the *structural* form, `D = K + iH − ω²
//! M`, needs no elimination (theory, section 6).

mod equations;
pub mod structural;

use super::Method;
use super::method::{Entry, Observable};
use super::suspension::{Answer, Suspension, is_blocked};
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::layout::balanced_motion;
use crate::linalg::ComplexLeastSquares;
use crate::modes::{Lines, OriginResponses};
use crate::{Progress, Real};

pub use equations::{
    DirectSolver, Excitation, Excitations, Form, Solution, solve_structural, solve_viscous, span,
};

/// Description of the viscous form for the registry.
pub const ENTRY: Entry = Entry {
    name: "dppim",
    short_name: "dppim",
    title: "DPPIM",
    summary: "Direct identification of Huang and Lallement, viscous damping",
    observes: Observable::Suspension,
    uses_priors: false,
    off_when: "the damping is structural, or there is hum at its lines",
    doubted_by: &[],
    on_request: false,
    is_blocked,
    workspace: |_, _| 0,
};

/// The answer of the viscous form, or why there is none.
pub(super) fn answer<R: Real>(of: &Suspension<'_, R>) -> Result<Answer<R>, Diagnostics> {
    answer_of_form(Form::Viscous, of)
}

fn answer_of_form<R: Real>(form: Form, of: &Suspension<'_, R>) -> Result<Answer<R>, Diagnostics> {
    let Suspension { responses, lines, noise, .. } = *of;
    let near = NearModes { responses, lines, noise };
    let mut solver = FormSolver::new(form, &near)?;
    while solver.step(&near)? == Progress::Going {}
    solver.answer()
}

/// What the direct method uses.
#[derive(Clone, Copy, Debug)]
pub(super) struct NearModes<'a, R> {
    /// The motions.
    pub(super) responses: &'a OriginResponses<'a, R>,
    /// The lines about the modes.
    pub(super) lines: &'a Lines,
    /// Standard deviation of the noise of a reading, (m/s²)/N, of a complex number.
    pub(super) noise: R,
}

/// One form on what the methods of the suspension share, in steps between which other work can be done. A step is at most
/// 1.6 million instructions on a rig.
#[derive(Clone, Debug)]
pub(super) struct FormSolver<R>(DirectSolver<R>);

impl<R: Real> FormSolver<R> {
    /// # Errors
    /// `responses_do_not_span_six` for the viscous form.
    pub(super) fn new(form: Form, of: &NearModes<'_, R>) -> Result<Self, Diagnostics> {
        let length = of.responses.length;
        if form == Form::Viscous {
            let [below, _] = sides(of);
            let rank = span_above_noise(of).min(span(&below, length).unwrap_or(0));
            if rank < 6 {
                return Err(fatal(Code::ResponsesDoNotSpanSix, R::of(rank as f64)));
            }
        }
        Ok(Self(DirectSolver::new(form, length)))
    }

    /// Runs one step.
    ///
    /// # Errors
    /// `data_not_finite`.
    pub(super) fn step(&mut self, of: &NearModes<'_, R>) -> Result<Progress, Diagnostics> {
        let [below, above] = sides(of);
        self.0.step(&below, &above).ok_or_else(|| fatal(Code::DataNotFinite, R::zero()))
    }

    /// The answer when the work is done.
    ///
    /// # Errors
    /// `data_not_finite` and `ten_parameters_not_identifiable`.
    pub(super) fn answer(&self) -> Result<Answer<R>, Diagnostics> {
        accepted(self.0.solution())
    }
}

/// When the viscous form fits worse than the structural one by this factor, it has no answer.
const CLEARLY_WORSE: f64 = 1.2;
/// The same for the structural form, which has to be needed.
const WORSE: f64 = 1.05;

/// The form that fits clearly worse than the other, the code that says so, and by which factor, from what both leave of their
/// equations.
pub fn worse_form<R: Real>(viscous: R, structural: R) -> Option<(Method, Code, R)> {
    if viscous > structural * R::of(CLEARLY_WORSE) {
        Some((Method::Dppim, Code::DampingNotViscous, viscous / structural))
    } else if structural > viscous * R::of(WORSE) {
        Some((Method::DppimStructural, Code::DampingNotStructural, structural / viscous))
    } else {
        None
    }
}

/// The noise alone makes singular values of up to the square root of the number of rows, when the rows are relative to
/// it; a motion counts from this many times that.
const ABOVE_NOISE: f64 = 3.0;

/// Number of independent motions below the modes that stand out of the noise.
fn span_above_noise<R: Real>(of: &NearModes<'_, R>) -> usize {
    let responses = of.responses;
    let mut motions = ComplexLeastSquares::<R, 6, 0>::new();
    let forces = responses.forces.len();
    for line in &of.lines.below {
        let sigma = responses.sigma[*line].iter().fold(R::zero(), |top, v| top.max(*v)) * of.noise;
        for force in 0..forces {
            let motion = balanced_motion(&responses.motion(*line, force), responses.length);
            motions.push(motion.unscale(sigma).into(), []);
        }
    }
    let rows = R::of((of.lines.below.len() * forces) as f64);
    motions.count_above::<12>(R::of(ABOVE_NOISE) * rows.sqrt())
}

/// Turns a solution into an answer.
fn accepted<R: Real>(solution: Option<Solution<R>>) -> Result<Answer<R>, Diagnostics> {
    let solution = solution.ok_or_else(|| fatal(Code::DataNotFinite, R::zero()))?;
    let Solution { body, rank, condition, misfit } = solution;
    let body = body.ok_or_else(|| fatal(Code::TenParametersNotIdentifiable, R::of(rank as f64)))?;
    Ok(Answer { body, condition, misfit: Some(misfit) })
}

/// The excitations below and above the modes.
fn sides<'a, R: Real>(of: &'a NearModes<'a, R>) -> [Side<'a, R>; 2] {
    [&of.lines.below, &of.lines.above].map(|lines| Side { of, lines })
}

/// The excitations at the lines on one side of the modes: line by line, force by force.
struct Side<'a, R> {
    of: &'a NearModes<'a, R>,
    lines: &'a [usize],
}

impl<R: Real> Excitations<R> for Side<'_, R> {
    fn count(&self) -> usize {
        self.lines.len() * self.of.responses.forces.len()
    }

    fn at(&self, place: usize) -> Excitation<R> {
        let responses = self.of.responses;
        let forces = responses.forces.len();
        let (line, force) = (self.lines[place / forces], place % forces);
        let s = responses.s[line];
        let receptance = responses.motion(line, force).map(|v| v / (s * s));
        Excitation { s, force: responses.forces[force], receptance }
    }
}
