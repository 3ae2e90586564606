//! The interface of an identification method: the description in its file, and how it is run.

use crate::body::RigidBody;
use crate::diagnosis::{Code, Diagnostics};
use crate::{Progress, Real};

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
    /// True for a method that runs only when it is requested by name.
    pub on_request: bool,
    /// Whether a layout with this code rules out the method; the flag is true when priors compensate for the
    /// hits.
    pub is_blocked: fn(Code, bool) -> bool,
    /// Size of the workspace for this number of sensors and bins.
    pub workspace: fn(sensors: usize, bins: usize) -> usize,
}

/// A running method, in steps between which other work can be done. A step of a method that uses mass lines
/// is at most 1.6 million instructions on a rig.
pub(super) trait Solver<R: Real>: Sized {
    /// Checks layout and data, and chooses the start. `start` is the answer of another method, if there is
    /// one, without the attached bodies.
    fn start<const S: usize, const H: usize, L: SpectrumBins<R>>(
        observed: &Observations<'_, R, S, H, L>,
        settings: &IdentifySettings<R>,
        start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics>;

    /// Runs one step. The workspace must be passed on unchanged to the next step.
    fn step<const S: usize, const H: usize, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, S, H, L>,
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics>;

    /// Returns the answer once no further step is needed.
    fn finish<const S: usize, const H: usize, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, S, H, L>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics>;
}

/// Generates [`Method`](super::Method) and its dispatch from the list of methods: variant, number and module,
/// best method first. The module must contain an `ENTRY`, and a `Solver` for a method in steps or a function `answer` for
/// one that uses the suspension modes.
macro_rules! methods {
    (
        in steps { $($(#[$doc:meta])* $variant:ident = $number:literal in $module:ident;)* }
        of suspension modes {
            $($(#[$modal_doc:meta])* $modal:ident = $modal_number:literal in $($modal_module:ident)::+;)*
        }
    ) => {
        /// How the ten properties were identified.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum Method { $($(#[$doc])* $variant,)* $($(#[$modal_doc])* $modal),* }

        /// Number of methods.
        pub const METHODS: usize = [$($number,)* $($modal_number),*].len();

        impl Method {
            /// Every method, best first.
            pub const ALL: [Self; METHODS] = [$(Self::$variant,)* $(Self::$modal),*];

            /// Description given in the method's file.
            pub const fn entry(self) -> Entry {
                match self {
                    $(Self::$variant => $module::ENTRY,)*
                    $(Self::$modal => $($modal_module)::+::ENTRY),*
                }
            }

            // What a rig needs of it: with the whole description a rig would link texts that it never shows.
            /// Title on a screen of 21 characters.
            pub const fn title(self) -> &'static str {
                match self {
                    $(Self::$variant => $module::ENTRY.title,)*
                    $(Self::$modal => $($modal_module)::+::ENTRY.title),*
                }
            }

            /// The data that it uses.
            pub const fn observes(self) -> Observable {
                match self {
                    $(Self::$variant => $module::ENTRY.observes,)*
                    $(Self::$modal => $($modal_module)::+::ENTRY.observes),*
                }
            }

            /// Codes of findings about the modes that put its answer off.
            pub const fn doubted_by(self) -> &'static [crate::diagnosis::Code] {
                match self {
                    $(Self::$variant => $module::ENTRY.doubted_by,)*
                    $(Self::$modal => $($modal_module)::+::ENTRY.doubted_by),*
                }
            }

            /// True when it runs only when it is requested by name.
            pub const fn on_request(self) -> bool {
                match self {
                    $(Self::$variant => $module::ENTRY.on_request,)*
                    $(Self::$modal => $($modal_module)::+::ENTRY.on_request),*
                }
            }

            /// Whether a layout with a code rules it out: see [`Entry::is_blocked`].
            pub const fn is_blocked(self) -> fn(crate::diagnosis::Code, bool) -> bool {
                match self {
                    $(Self::$variant => $module::ENTRY.is_blocked,)*
                    $(Self::$modal => $($modal_module)::+::ENTRY.is_blocked),*
                }
            }

            /// Size of its workspace for a number of sensors and bins.
            pub const fn workspace(self) -> fn(usize, usize) -> usize {
                match self {
                    $(Self::$variant => $module::ENTRY.workspace,)*
                    $(Self::$modal => $($modal_module)::+::ENTRY.workspace),*
                }
            }

            /// Number of the method in stored results; never changes.
            pub const fn number(self) -> u8 {
                match self { $(Self::$variant => $number,)* $(Self::$modal => $modal_number),* }
            }

            /// The answer of a method that uses the suspension modes; `None` for any other.
            pub fn of_suspension<R: Real>(
                self,
                observed: &suspension::Suspension<'_, R>,
            ) -> Option<Result<suspension::Answer<R>, Diagnostics>> {
                match self {
                    $(Self::$modal => Some($($modal_module)::+::answer(observed)),)*
                    _ => None,
                }
            }
        }

        /// The running method. The variant without a method is all zeros, so a static value takes no room in
        /// the image.
        #[derive(Clone, Debug)]
        #[repr(u8)]
        #[allow(clippy::large_enum_variant, reason = "one is carried out at a time, without an allocator; on 32 bits the sizes are alike")]
        enum Running<R> {
            /// No method is running.
            No,
            $($(#[$doc])* $variant($module::Solver<R>)),*
        }

        impl<R> Running<R> {
            /// The running method.
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
                    // These are answered together, from what they share.
                    _ => Err(crate::diagnosis::fatal(crate::diagnosis::Code::FrfMissing, 0.0)),
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
