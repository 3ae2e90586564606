//! From mass lines to the ten rigid body properties with their covariance.

pub mod global_fit;
pub mod inertia_restraint;
pub mod influence;
pub mod maximum_likelihood;
pub mod single_fault;

mod applicability;
mod attached;
mod estimate;
mod mass_lines;
mod response_inverse;
mod rigidity;
mod weighting;

pub use applicability::{Applicability, information_spectrum};
pub use estimate::{Consistency, Estimate};
pub(crate) use mass_lines::check_mass_lines;
pub use mass_lines::{MassLines, ScatterAccumulator, lower_triangle, symmetric};
pub use response_inverse::ResponseInverse;
pub use rigidity::{NOT_RIGID, rigid_residuals};
pub use weighting::{PlacementErrors, Weighting};

/// How the ten properties were identified, raw in a stored result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Method {
    /// The linear inertia restraint method (IRM).
    InertiaRestraint = 1,
    /// Maximum likelihood with the complete covariance.
    MaximumLikelihood = 2,
    /// Body and suspension fitted to all spectral lines.
    GlobalFit = 3,
}

impl Method {
    /// The name in reports and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::InertiaRestraint => "inertia-restraint",
            Self::MaximumLikelihood => "maximum-likelihood",
            Self::GlobalFit => "global-fit",
        }
    }

    /// Read from the wire.
    pub fn from_raw(raw: u8) -> Option<Self> {
        [Self::InertiaRestraint, Self::MaximumLikelihood, Self::GlobalFit]
            .into_iter()
            .find(|m| *m as u8 == raw)
    }
}
