//! Identifies the ten rigid body properties with their covariance from the observations of a test.
//!
//! [`identify`] is the entry point: it takes [`Observations`] and the requested [`Method`]s, and returns a
//! list of [`Estimate`]s. A method is one file with an [`Entry`] and a solver, and one line in the list
//! below; programs that show or store answers read that list.

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

pub use crate::Progress;
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

use crate::Real;
use crate::body::RigidBody;
use crate::diagnosis::Diagnostics;

method::methods! {
    in steps {
        /// Maximum likelihood with the complete covariance.
        MaximumLikelihood = 2 in maximum_likelihood;
        /// The linear inertia restraint method (IRM).
        InertiaRestraint = 1 in inertia_restraint;
        /// Body and suspension fitted to all bins.
        GlobalFit = 3 in global_fit;
    }
    of suspension modes {
        /// Orthogonality of the mode shapes.
        ToivolaNuutila = 5 in toivola_nuutila;
        /// Mass matrix from six mode shapes.
        ContiBretl = 4 in conti_bretl;
        /// Direct identification, viscous damping.
        Dppim = 6 in dppim;
        /// Direct identification, structural damping.
        DppimStructural = 7 in dppim::structural;
        /// Inertia restraint on the constant of the modal fit.
        ModalConstant = 8 in modal_constant;
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
