//! The same computation on a rig: in single precision, with little memory, in steps of at most 1.6 million instructions.
//!
//! ```text
//! wants ─▶ take ─▶ motions ─▶ order ─▶ modes ─▶ answers ─▶ changes, one after the other ─▶ estimates, agreement
//! ```
//! The mathematics is that of [`SuspensionFit`](super::suspension::SuspensionFit), in the same functions. Four things differ:
//!
//! * The responses are reduced to the motions of the reference point as they come, and the motions are kept in
//!   [16 bits](crate::modes::CompactMotions).
//! * A change of the data or of the layout acts on readings, which are no longer there. They are predicted from the motions,
//!   `x = G(s) a`. What the sensors have measured besides a motion of a rigid body, noise above all, is therefore not reduced
//!   again under a changed layout: a second-order effect, the product of the noise and an error of the layout.
//! * There are fewer draws of noise; they are the same as the first ones of the full computation, as long as no hits are mixed.
//! * [`OrderSearch`] fits as few orders as it takes.
//!
//! | module | subject |
//! | --- | --- |
//! | `intake` | from responses to motions |
//! | `modal_fit` | from motions to modes, what they show, and the answers |
//! | `answering` | the direct method in steps |
//! | `changes` | what small changes do to modes and answers |
//! | `outcome` | the results |

mod answering;
mod changes;
mod intake;
mod modal_fit;
mod outcome;
#[cfg(test)]
mod tests;

use heapless::Vec;
use nalgebra::{Complex, Vector3, Vector6};

use self::answering::Forms;
use self::changes::Change;
use super::suspension::{Answer, ModeDeviations, lines_about};
use crate::diagnosis::{Diagnostic, Diagnostics};
use crate::identify::SUSPENSION_METHODS;
use crate::identify::agreement::{Comparing, PackedPropagation};
use crate::layout::{Layout, RIG_HITS, RIG_SENSORS};
use crate::modes::{
    CompactMotions, Exponents, ForceMixing, Lines, LinesPerSide, MOST_FORCES, MOST_LINES, Motions,
    OrderSearch, OriginResponses, Poles, ResidueFit, SEARCH_MEMORY, SUSPENSION_MODES,
};
use crate::{Progress, Real};

pub use self::outcome::SuspensionMode;

/// A layout with the capacity of a rig.
type RigLayout<R> = Layout<R, RIG_SENSORS, RIG_HITS>;

/// The lines of the responses: those of a transform, from zero on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineGrid<R> {
    /// Distance of the lines, Hz.
    pub resolution_hz: R,
    /// First and last frequency that is used, Hz.
    pub band_hz: [R; 2],
    /// σ of the exponential window on the records, 1/s.
    pub decay: R,
    /// Factor on standard deviations because the window correlates neighbouring lines:
    /// [`window_correlation`](crate::mass_line::window_correlation).
    pub correlation: R,
}

impl<R: Real> LineGrid<R> {
    /// The first line that is used. The line at zero is not, since an accelerance vanishes there.
    fn first(&self) -> usize {
        let line = (self.band_hz[0] / self.resolution_hz).ceil().to_f32();
        // The conversion keeps what is not a number of lines at the end of its range.
        (line as usize).max(1)
    }

    /// Number of lines that are used, of those that there are.
    fn count(&self) -> usize {
        let end = (self.band_hz[1] / self.resolution_hz).floor().to_f32() as usize;
        end.saturating_add(1).min(MOST_LINES).saturating_sub(self.first())
    }

    /// Laplace variable of a line that is used.
    fn s(&self, line: usize) -> Complex<R> {
        let frequency = self.resolution_hz * R::of((self.first() + line) as f64);
        Complex::new(self.decay, frequency * R::two_pi())
    }
}

/// Memory that is lent to every step, always the same.
#[derive(Debug)]
pub struct SolverMemory<'m, R> {
    /// The motions, and those of a change: twice [`CompactMotions::CODES`].
    pub codes: &'m mut [u16],
    /// Equations: [`SEARCH_MEMORY`] numbers.
    pub scratch: &'m mut [R],
    /// The readings of a hit, [`READINGS`] numbers; afterwards the covariances.
    pub readings: &'m mut [Complex<R>],
    /// Standard deviations of the motions at every line: [`WEIGHTS`] numbers.
    pub weights: &'m mut [R],
    /// Laplace variables: [`MOST_LINES`] numbers.
    pub lines: &'m mut [Complex<R>],
}

/// Readings of a hit: all channels at all lines.
pub const READINGS: usize = 3 * RIG_SENSORS * MOST_LINES;
/// Standard deviations of the motions at all lines.
pub const WEIGHTS: usize = 6 * MOST_LINES;

const _: () = assert!(PackedPropagation::<SUSPENSION_METHODS>::MEMORY <= READINGS);

impl<R: Real> SolverMemory<'_, R> {
    fn is_large_enough(&self) -> bool {
        self.codes.len() >= 2 * CompactMotions::<R>::CODES
            && self.scratch.len() >= SEARCH_MEMORY
            && self.readings.len() >= READINGS
            && self.weights.len() >= WEIGHTS
            && self.lines.len() >= MOST_LINES
    }
}

/// The computation, between its steps.
///
/// The caller gives what [`wants`](Self::wants) asks for to [`take`](Self::take); when it asks for nothing, the caller
/// runs [`step`](Self::step), until that is done. Layout and memory must be the same every time.
#[derive(Clone, Debug)]
pub struct SuspensionSolver<R> {
    grid: LineGrid<R>,
    /// Hit DOFs that have been measured, as places in the layout.
    dofs: Vec<u8, RIG_HITS>,
    reference: Vector3<R>,
    /// Number of forces: the hits, or at most six combinations of them.
    forces: u8,
    /// Units of the motions and of those of a change.
    units: [Exponents; 2],
    stage: Stage<R>,
    fit: ModalFit<R>,
    deviations: ModeDeviations<R>,
    answers: [MethodAnswer<R>; SUSPENSION_METHODS],
    /// Answers without a change, as far as the changes go: those of the first of them.
    unchanged: [Option<nalgebra::SVector<R, 10>>; SUSPENSION_METHODS],
    propagation: Option<PackedPropagation<SUSPENSION_METHODS>>,
    /// The methods whose answers stand.
    accepted: [bool; SUSPENSION_METHODS],
    /// Findings about the modes, or why there are none.
    diagnostics: Diagnostics,
}

/// What is done next.
#[derive(Clone, Debug)]
enum Stage<R> {
    /// A response is wanted.
    Wanting(Wanted),
    /// The readings of a hit are reduced, from this line on.
    Reducing(Wanted, usize),
    /// The order is searched for.
    Orders(OrderSearch<R>),
    /// The residues at the poles of that order.
    Residues(ResidueFit),
    /// The residues are known.
    Modes,
    /// The direct method.
    Forms(Forms<R>),
    /// What changes do.
    Changes(Change<R>),
    /// Two or more answers are compared; there are results when that is done.
    Comparing(Comparing<R>),
    /// There are results, and nothing to compare.
    Done,
    /// There is no answer.
    Failed,
}

/// A response that is wanted next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Wanted {
    force: usize,
    /// The place among the measured DOFs.
    hit: usize,
    channel: usize,
}

/// The modal fit, as far as changes need it.
#[derive(Clone, Debug)]
struct ModalFit<R> {
    /// Poles of all modes that were fitted, and the places of the suspension modes among them.
    poles: Poles<R>,
    kept: Vec<u8, SUSPENSION_MODES>,
    /// These poles after one relocation under the unchanged data.
    relocated: Poles<R>,
    noise: R,
    modes: Vec<SuspensionMode<R>, SUSPENSION_MODES>,
}

impl<R: Real> ModalFit<R> {
    /// The lines about the suspension modes.
    fn lines(&self, s: &[Complex<R>]) -> Lines {
        let pole = |place: &u8| self.poles.get(usize::from(*place)).copied();
        let poles: Poles<R> = self.kept.iter().filter_map(pole).collect();
        lines_about(&poles, s, LinesPerSide::Width)
    }
}

/// What a method has answered.
#[derive(Clone, Copy, Debug, PartialEq)]
enum MethodAnswer<R> {
    Answer(Answer<R>),
    Refused(Diagnostic),
    None,
}

impl<R: Real> SuspensionSolver<R> {
    /// A computation that has not begun.
    pub fn idle() -> Self {
        let zero = R::zero();
        Self {
            grid: LineGrid {
                resolution_hz: zero,
                band_hz: [zero; 2],
                decay: zero,
                correlation: zero,
            },
            dofs: Vec::new(),
            reference: Vector3::zeros(),
            forces: 0,
            units: [[[0; 6]; MOST_FORCES]; 2],
            stage: Stage::Wanting(Wanted::default()),
            fit: ModalFit {
                poles: Poles::new(),
                kept: Vec::new(),
                relocated: Poles::new(),
                noise: zero,
                modes: Vec::new(),
            },
            deviations: ModeDeviations::new(Vector3::zeros()),
            answers: [MethodAnswer::None; SUSPENSION_METHODS],
            unchanged: [None; SUSPENSION_METHODS],
            propagation: None,
            accepted: [false; SUSPENSION_METHODS],
            diagnostics: Diagnostics::new(),
        }
    }

    /// Begins an idle computation with the measured hit DOFs, as places in the layout.
    ///
    /// It [has failed](Self::has_failed) at once with `layout_not_finite`, with `frf_missing` without DOFs or with one
    /// that the layout does not have, and with `response_rank_deficient` when the sensors do not determine the motion.
    // It fills what is already in its place: a computation that is returned would be on the stack twice.
    pub fn begin(&mut self, layout: &RigLayout<R>, grid: LineGrid<R>, dofs: &[usize]) {
        if let Err(reasons) = intake::check(layout, &grid, dofs) {
            self.fail(reasons);
            return;
        }
        let all = 0..layout.hits.len();
        self.grid = grid;
        self.dofs = all.filter(|dof| dofs.contains(dof)).map(|dof| dof as u8).collect();
        self.reference = layout.sensor_centroid();
        self.deviations = ModeDeviations::new(self.reference);
        let mixing = ForceMixing::of(&measured(layout, &self.dofs), &self.reference);
        self.forces = mixing.count() as u8;
        self.want(Wanted::default(), &mixing);
    }

    /// The response that is needed next: the hit DOF and the channel. `None` when a step is needed instead.
    pub fn wants(&self) -> Option<(usize, usize)> {
        let Stage::Wanting(Wanted { hit, channel, .. }) = self.stage else { return None };
        Some((usize::from(*self.dofs.get(hit)?), channel))
    }

    /// Runs one step, at most 1.6 million instructions on a rig. It fails with `data_not_finite` when the memory is smaller than
    /// [`SolverMemory`] states.
    pub fn step(&mut self, layout: &RigLayout<R>, memory: &mut SolverMemory<'_, R>) -> Progress {
        if !memory.is_large_enough() {
            return self.fail(crate::diagnosis::fatal(crate::diagnosis::Code::DataNotFinite, 0.0));
        }
        match &self.stage {
            Stage::Wanting(_) => Progress::Going,
            Stage::Changes(_) => self.step_change(layout, memory),
            Stage::Comparing(_) => self.step_comparing(memory),
            Stage::Done | Stage::Failed => Progress::Done,
            _ => self.step_unchanged(layout, memory),
        }
    }

    /// Runs one step under the layout as it is.
    // Not inlined, since a change has a layout of its own.
    #[inline(never)]
    fn step_unchanged(
        &mut self,
        layout: &RigLayout<R>,
        memory: &mut SolverMemory<'_, R>,
    ) -> Progress {
        let layout = &measured(layout, &self.dofs);
        match &self.stage {
            Stage::Reducing(..) => self.step_reducing(layout, memory),
            Stage::Orders(_) => self.step_orders(layout, memory),
            Stage::Residues(_) => self.step_residues(layout, memory),
            Stage::Modes => self.step_modes(layout, memory),
            Stage::Forms(_) => self.step_forms(layout, memory),
            _ => Progress::Going,
        }
    }

    /// The forces that the hits of this layout are mixed to. They are computed when they are needed, because that takes less
    /// than a step and the columns would be a tenth of the state.
    fn mixing(&self, layout: &RigLayout<R>) -> ForceMixing<R, RIG_HITS> {
        ForceMixing::of(layout, &self.reference)
    }

    /// Ends without an answer, for these reasons.
    fn fail(&mut self, reasons: Diagnostics) -> Progress {
        self.diagnostics = reasons;
        self.stage = Stage::Failed;
        Progress::Done
    }

    /// Part of the work that is done, from zero to one; it grows with the instructions that are executed.
    pub fn completed(&self) -> f32 {
        let dofs = self.dofs.len() as f32;
        let forces = f32::from(self.forces);
        // Every force is made of all hits that are mixed, or of one.
        let hits = if forces == dofs { forces } else { forces * dofs };
        let (intake, rest) = (INTAKE_OF_A_HIT * hits, SEARCH_SHARE.recip());
        (intake * self.taken() + rest * self.progress()) / (intake + rest)
    }

    /// Part of the work after all responses that is done, from zero to one.
    fn progress(&self) -> f32 {
        match &self.stage {
            Stage::Wanting(_) | Stage::Reducing(..) => 0.0,
            Stage::Orders(search) => SEARCH_SHARE * search.progress(),
            Stage::Residues(_) | Stage::Modes | Stage::Forms(_) => SEARCH_SHARE,
            Stage::Changes(change) => SEARCH_SHARE + (1.0 - SEARCH_SHARE) * change.progress(),
            Stage::Comparing(_) | Stage::Done | Stage::Failed => 1.0,
        }
    }

    /// Part of the responses that are taken, from zero to one.
    pub fn taken(&self) -> f32 {
        let (Stage::Wanting(wanted) | Stage::Reducing(wanted, _)) = self.stage else { return 1.0 };
        let forces = f32::from(self.forces.max(1));
        if usize::from(self.forces) == self.dofs.len() {
            return wanted.force as f32 / forces;
        }
        (wanted.force as f32 + wanted.hit as f32 / self.dofs.len() as f32) / forces
    }
}

/// Share of the search for the order in all work after the responses.
const SEARCH_SHARE: f32 = 0.09;
/// Work of taking the responses to a hit, in that of the search for the order: 20 million instructions, of
/// 1660 million.
const INTAKE_OF_A_HIT: f32 = 0.012;

/// The layout with only the measured hit DOFs.
// Not inlined, since the copy would be on the stack twice.
#[inline(never)]
fn measured<R: Real>(layout: &RigLayout<R>, dofs: &[u8]) -> RigLayout<R> {
    let mut part = layout.clone();
    let mut dof = 0;
    part.hits.retain(|_| {
        dof += 1;
        dofs.contains(&(dof - 1))
    });
    part
}

/// The parts of the memory that describe the motions.
struct Stored<'a, R> {
    codes: &'a [u16],
    units: &'a Exponents,
    lines: &'a [Complex<R>],
    weights: &'a [R],
}

impl<'a, R: Real> Stored<'a, R> {
    /// The motions under these forces; `None` when the memory is too small.
    fn responses(
        &self,
        count: usize,
        forces: &'a [Vector6<R>],
        length: R,
    ) -> Option<OriginResponses<'a, R>> {
        let motions = Motions::Compact(CompactMotions::new(self.codes, self.units)?);
        let sigma = self.weights.as_chunks::<6>().0.get(..count)?;
        Some(OriginResponses { s: self.lines.get(..count)?, motions, sigma, forces, length })
    }
}
