//! The interface of an identification method: the description in its file, and how it is run.

use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics};
use crate::progress::Progress;
use crate::real::Real;

use super::observations::{Observations, SpectrumBins};
use super::{Estimate, IdentifySettings};

/// The kind of data that a method uses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observable {
    /// One accelerance for each response and hit DOF.
    MassLines,
    /// Frequency responses at every bin.
    SpectrumBins,
    /// The modes of the body on its suspension, and the frequency responses around them.
    Suspension,
}

/// Description of a method, given in its file.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name in reports, files and JSON.
    pub name: &'static str,
    /// Name as a command-line argument.
    pub short_name: &'static str,
    /// Title on a screen of 21 characters.
    pub title: &'static str,
    /// Description in one line of help.
    pub summary: &'static str,
    /// The data that it uses.
    pub observes: Observable,
    /// True for a method that uses what `[prior]` says about the object.
    pub uses_priors: bool,
    /// When its answer is off while others are not, to complete the sentence "it is off when …".
    pub off_when: &'static str,
    /// Codes of findings about the modes that put its answer off.
    pub doubted_by: &'static [Code],
    /// Whether a layout with this code rules out the method; the flag is true when priors compensate for the
    /// hits.
    pub is_blocked: fn(Code, bool) -> bool,
    /// Size of the workspace for this number of sensors and hits.
    pub workspace: fn(sensors: usize, hits: usize) -> usize,
}

/// A running method, in steps between which other work can be done. A step of a method that uses mass lines
/// is at most 1.6 million instructions on a rig.
pub(super) trait Solver<R: Real>: Sized {
    /// Checks layout and data, and chooses the start. `start` is the answer of another method, if there is
    /// one, without the attached bodies.
    fn start<C: Capacity, L: SpectrumBins<R>>(
        observed: &Observations<'_, R, C, L>,
        settings: &IdentifySettings<R>,
        start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics>;

    /// Runs one step. The workspace must be passed on unchanged to the next step.
    fn step<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics>;

    /// Returns the answer once no further step is needed.
    fn finish<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics>;
}
