//! Identifies the ten rigid body properties with their covariance from the observations of a test.
//!
//! [`identify`] is the entry point: it takes [`Observations`] and the requested [`Method`]s, and returns a
//! list of [`Estimate`]s. A method is one file with an [`Entry`] and a solver, and a variant of
//! [`Method`]; programs that show or store answers read [`Method::ALL`].

pub mod agreement;
pub mod conti_bretl;
pub mod dppim;
pub mod driving_points;
pub mod global_fit;
pub mod inertia_restraint;
pub mod influence;
pub mod maximum_likelihood;
pub mod modal_constant;
pub mod single_fault;
pub mod suspension;
pub mod toivola_nuutila;

mod applicability;
mod attached;
mod budget;
mod estimate;
mod identification;
mod mass_lines;
mod method;
mod observations;
mod perturbation;
mod reciprocity;
mod response_inverse;
mod rigidity;
mod verdict;
mod weighting;

pub use crate::progress::Progress;
pub use applicability::{Applicability, information_spectrum};
pub use estimate::{Consistency, Estimate, HALF_WIDTH_95, REJECTION_Z};
pub use identification::{Identification, MASS_LINE_METHODS, Methods, identify, workspace};
pub use mass_lines::{
    DofMassLines, ForceTrend, MassLines, ScatterAccumulator, lower_triangle, symmetric,
};
pub(crate) use mass_lines::{by_reference, check_mass_lines};
pub use method::{Entry, Observable};
pub use observations::{NoSpectrumBins, Observations, SpectrumBins};
pub use perturbation::{Perturbation, random_signs};
pub use reciprocity::check_reciprocity;
pub use response_inverse::ResponseInverse;
pub use rigidity::{RIGIDITY_LIMIT, rigid_residuals};
pub use verdict::{Verdict, is_of_data};
pub use weighting::{PlacementErrors, Weighting};

use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::listed::listed;
use crate::real::Real;
use method::Solver;

listed! {
    /// How the ten properties were identified; the best method stands first.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Method {
        /// Maximum likelihood with the complete covariance.
        MaximumLikelihood,
        /// The linear inertia restraint method (IRM).
        InertiaRestraint,
        /// Body and suspension fitted to all bins.
        GlobalFit,
        /// Orthogonality of the mode shapes.
        ToivolaNuutila,
        /// Mass matrix from six mode shapes.
        ContiBretl,
        /// Direct identification, viscous damping.
        Dppim,
        /// Direct identification, structural damping.
        DppimStructural,
        /// Inertia restraint on the constant of the modal fit.
        ModalConstant,
    }
}

/// Number of methods.
pub const METHODS: usize = Method::ALL.len();

impl Method {
    /// Description given in the method's file. Inlined, so that a rig links only the texts that it shows.
    #[inline(always)]
    pub const fn entry(self) -> Entry {
        match self {
            Self::MaximumLikelihood => maximum_likelihood::ENTRY,
            Self::InertiaRestraint => inertia_restraint::ENTRY,
            Self::GlobalFit => global_fit::ENTRY,
            Self::ToivolaNuutila => toivola_nuutila::ENTRY,
            Self::ContiBretl => conti_bretl::ENTRY,
            Self::Dppim => dppim::ENTRY,
            Self::DppimStructural => dppim::structural::ENTRY,
            Self::ModalConstant => modal_constant::ENTRY,
        }
    }

    /// Number of the method in stored results; never changes.
    pub const fn number(self) -> u8 {
        match self {
            Self::InertiaRestraint => 1,
            Self::MaximumLikelihood => 2,
            Self::GlobalFit => 3,
            Self::ContiBretl => 4,
            Self::ToivolaNuutila => 5,
            Self::Dppim => 6,
            Self::DppimStructural => 7,
            Self::ModalConstant => 8,
        }
    }

    /// The answer of a method that uses the suspension modes; `None` for any other.
    pub fn of_suspension<R: Real>(
        self,
        observed: &suspension::Suspension<'_, R>,
    ) -> Option<Result<suspension::Answer<R>, Diagnostics>> {
        Some(match self {
            Self::MaximumLikelihood | Self::InertiaRestraint | Self::GlobalFit => return None,
            Self::ToivolaNuutila => toivola_nuutila::answer(observed),
            Self::ContiBretl => conti_bretl::answer(observed),
            Self::Dppim => dppim::answer(observed),
            Self::DppimStructural => dppim::structural::answer(observed),
            Self::ModalConstant => modal_constant::answer(observed),
        })
    }
}

/// The running method. The variant without a method is all zeros, so a static value takes no room in the image.
#[derive(Clone, Debug)]
#[repr(u8)]
#[allow(
    clippy::large_enum_variant,
    reason = "one is carried out at a time, without an allocator; on 32 bits the sizes are alike"
)]
enum RunningMethod<R> {
    /// No method is running.
    No,
    /// Maximum likelihood.
    MaximumLikelihood(maximum_likelihood::Solver<R>),
    /// The inertia restraint method.
    InertiaRestraint(inertia_restraint::Solver<R>),
    /// The global fit.
    GlobalFit(global_fit::Solver<R>),
}

impl<R> RunningMethod<R> {
    /// The running method.
    fn method(&self) -> Option<Method> {
        match self {
            Self::No => None,
            Self::MaximumLikelihood(_) => Some(Method::MaximumLikelihood),
            Self::InertiaRestraint(_) => Some(Method::InertiaRestraint),
            Self::GlobalFit(_) => Some(Method::GlobalFit),
        }
    }
}

impl<R: Real> RunningMethod<R> {
    fn start<C: Capacity, L: SpectrumBins<R>>(
        method: Method,
        observed: &Observations<'_, R, C, L>,
        settings: &IdentifySettings<R>,
        start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics> {
        match method {
            Method::MaximumLikelihood => {
                Solver::start(observed, settings, start).map(Self::MaximumLikelihood)
            }
            Method::InertiaRestraint => {
                Solver::start(observed, settings, start).map(Self::InertiaRestraint)
            }
            Method::GlobalFit => Solver::start(observed, settings, start).map(Self::GlobalFit),
            // These are answered together, from what they share.
            Method::ToivolaNuutila
            | Method::ContiBretl
            | Method::Dppim
            | Method::DppimStructural
            | Method::ModalConstant => Err(fatal(Code::FrfMissing, 0.0)),
        }
    }

    fn step<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        workspace: &mut [R],
    ) -> Result<Progress, Diagnostics> {
        match self {
            Self::No => Ok(Progress::Done),
            Self::MaximumLikelihood(solver) => Solver::step(solver, observed, workspace),
            Self::InertiaRestraint(solver) => Solver::step(solver, observed, workspace),
            Self::GlobalFit(solver) => Solver::step(solver, observed, workspace),
        }
    }

    fn finish<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics> {
        match self {
            Self::No => Err(Diagnostics::new()),
            Self::MaximumLikelihood(solver) => Solver::finish(solver, observed, workspace),
            Self::InertiaRestraint(solver) => Solver::finish(solver, observed, workspace),
            Self::GlobalFit(solver) => Solver::finish(solver, observed, workspace),
        }
    }
}

/// Settings that a caller may choose; the defaults are those of a rig.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IdentifySettings<R> {
    /// Settings of the inertia restraint method.
    pub inertia_restraint: inertia_restraint::InertiaRestraintSettings<R>,
    /// The error budget that maximum likelihood uses; one that is to be learned only where the layout permits
    /// it ([`Layout::learn_budget`](crate::layout::Layout::learn_budget)).
    pub error_budget: maximum_likelihood::ErrorBudget,
}

impl<R: Real> Default for IdentifySettings<R> {
    fn default() -> Self {
        Self {
            inertia_restraint: inertia_restraint::InertiaRestraintSettings::weighted(),
            error_budget: maximum_likelihood::ErrorBudget::default(),
        }
    }
}
