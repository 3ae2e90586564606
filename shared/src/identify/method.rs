//! What a method of identification is: what its file states about itself, and how it is carried out.

use crate::Real;
use crate::body::RigidBody;
use crate::diagnosis::{Code, Diagnostics};

use super::observations::{Observations, SpectrumBins};
use super::{Estimate, IdentifySettings};

/// What a method observes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Observable {
    /// One accelerance for each response and hit DOF.
    MassLines,
    /// Frequency responses, line by line.
    SpectrumBins,
}

/// What the file of a method states about it.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name in reports, files and JSON.
    pub name: &'static str,
    /// Name as an argument of a command.
    pub short_name: &'static str,
    /// Title on a screen of 21 characters.
    pub title: &'static str,
    /// What it is, in one line of help.
    pub summary: &'static str,
    /// What it observes.
    pub observes: Observable,
    /// True for a method that answers only when it is asked for by name.
    pub on_request: bool,
    /// True when a layout of which a code is reported gives the method no answer; the flag says that priors
    /// make up for the hits.
    pub is_blocked: fn(Code, bool) -> bool,
    /// Numbers of workspace for so many sensors and spectral lines.
    pub workspace: fn(sensors: usize, lines: usize) -> usize,
}

/// Whether another step is needed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Progress {
    /// Another step is needed.
    Going,
    /// There is nothing left to be done.
    Done,
}

/// A method that is being carried out, in steps between which other work can be done. A step of a method
/// that observes mass lines is at most a million instructions on a rig.
pub(super) trait Solver<R: Real>: Sized {
    /// Checks layout and data and chooses the start. `start` is the answer of another method where there
    /// is one, without what hangs on the object.
    fn start<const S: usize, const H: usize, L: SpectrumBins<R>>(
        observed: &Observations<'_, R, S, H, L>,
        settings: &IdentifySettings<R>,
        start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics>;

    /// One step. What it leaves in the workspace is what the next begins with.
    fn step<const S: usize, const H: usize, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, S, H, L>,
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics>;

    /// The answer, once no step is needed any more.
    fn finish<const S: usize, const H: usize, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, S, H, L>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics>;
}

/// Makes [`Method`](super::Method) and its dispatch from the list of methods: variant, number and module,
/// the best method first. The module has an `ENTRY` and a `Solver`.
macro_rules! methods {
    ($($(#[$doc:meta])* $variant:ident = $number:literal in $module:ident;)*) => {
        /// How the ten properties were identified.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Method { $($(#[$doc])* $variant),* }

        /// How many methods there are.
        pub const METHODS: usize = [$($number),*].len();

        impl Method {
            /// Every method, the best first.
            pub const ALL: [Self; METHODS] = [$(Self::$variant),*];

            /// What its file states about it.
            pub const fn entry(self) -> Entry {
                match self { $(Self::$variant => $module::ENTRY),* }
            }

            /// The number that stands for it in stored results. Never changed.
            pub const fn number(self) -> u8 {
                match self { $(Self::$variant => $number),* }
            }
        }

        /// A method that is being carried out. No method is all zeros, so that a static one takes no room in
        /// an image.
        #[derive(Clone, Debug)]
        #[repr(u8)]
        #[expect(clippy::large_enum_variant, reason = "one is carried out at a time, without an allocator")]
        enum Running<R> {
            /// None.
            No,
            $($(#[$doc])* $variant($module::Solver<R>)),*
        }

        impl<R> Running<R> {
            /// Which method it is.
            fn method(&self) -> Option<Method> {
                match self {
                    Self::No => None,
                    $(Self::$variant(_) => Some(Method::$variant)),*
                }
            }
        }

        impl<R: Real> Running<R> {
            fn start<const S: usize, const H: usize, L: SpectrumBins<R>>(
                method: Method,
                observed: &Observations<'_, R, S, H, L>,
                settings: &IdentifySettings<R>,
                start: Option<&RigidBody<R>>,
            ) -> Result<Self, Diagnostics> {
                match method {
                    $(Method::$variant => {
                        <$module::Solver<R> as method::Solver<R>>::start(observed, settings, start)
                            .map(Self::$variant)
                    })*
                }
            }

            fn step<const S: usize, const H: usize, L: SpectrumBins<R>>(
                &mut self,
                observed: &Observations<'_, R, S, H, L>,
                workspace: &mut [R],
            ) -> Result<Progress, Diagnostics> {
                match self {
                    Self::No => Ok(Progress::Done),
                    $(Self::$variant(solver) => method::Solver::step(solver, observed, workspace)),*
                }
            }

            fn finish<const S: usize, const H: usize, L: SpectrumBins<R>>(
                &mut self,
                observed: &Observations<'_, R, S, H, L>,
                workspace: &mut [R],
            ) -> Result<Estimate<R>, Diagnostics> {
                match self {
                    Self::No => Err(Diagnostics::new()),
                    $(Self::$variant(solver) => method::Solver::finish(solver, observed, workspace)),*
                }
            }
        }
    };
}
pub(super) use methods;
