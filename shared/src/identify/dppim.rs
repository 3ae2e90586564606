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
use crate::real::Real;

use equations::solve_spanning;
pub use equations::{Excitation, Excitations, Solution, solve_structural, solve_viscous, span};

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
    is_blocked,
    workspace: |_, _| 0,
};

/// The answer of the viscous form, or why there is none.
pub(super) fn answer<R: Real>(suspension: &Suspension<'_, R>) -> Result<Answer<R>, Diagnostics> {
    let ([below, above], length) = (sides(suspension), suspension.responses.length);
    let rank = span_above_noise(suspension).min(span(&below, length).unwrap_or(0));
    if rank < 6 {
        return Err(fatal(Code::ResponsesDoNotSpanSix, R::of(rank as f64)));
    }
    accepted(solve_spanning(&below, &above, length))
}

/// When the viscous form fits worse than the structural one by this factor, it has no answer.
const CLEARLY_WORSE: f64 = 1.2;
/// The same for the structural form, which has to be needed.
const WORSE: f64 = 1.05;

/// The form that fits clearly worse than the other, the code that says so, and by which factor, from what both leave of
/// their equations.
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
fn span_above_noise<R: Real>(suspension: &Suspension<'_, R>) -> usize {
    let responses = suspension.responses;
    let mut motions = ComplexLeastSquares::<R, 6, 0>::new();
    let forces = responses.forces.len();
    for line in &suspension.lines.below {
        let sigma =
            responses.sigma[*line].iter().fold(R::zero(), |top, v| top.max(*v)) * suspension.noise;
        for force in 0..forces {
            let motion = balanced_motion(&responses.motion(*line, force), responses.length);
            motions.push(motion.unscale(sigma).into(), []);
        }
    }
    let rows = R::of((suspension.lines.below.len() * forces) as f64);
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
fn sides<'a, R: Real>(suspension: &'a Suspension<'a, R>) -> [Side<'a, R>; 2] {
    [&suspension.lines.below, &suspension.lines.above].map(|lines| Side { suspension, lines })
}

/// The excitations at the lines on one side of the modes: line by line, force by force.
struct Side<'a, R> {
    suspension: &'a Suspension<'a, R>,
    lines: &'a [usize],
}

impl<R: Real> Excitations<R> for Side<'_, R> {
    fn count(&self) -> usize {
        self.lines.len() * self.suspension.responses.forces.len()
    }

    fn at(&self, place: usize) -> Excitation<R> {
        let responses = self.suspension.responses;
        let forces = responses.forces.len();
        let (line, force) = (self.lines[place / forces], place % forces);
        let s = responses.s[line];
        let receptance = responses.motion(line, force).map(|v| v / (s * s));
        Excitation { s, force: responses.forces[force], receptance }
    }
}
