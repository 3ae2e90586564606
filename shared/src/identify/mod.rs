//! From mass lines to the ten rigid body properties with their covariance.

pub mod inertia_restraint;

mod estimate;
mod mass_lines;
mod response_inverse;
mod weighting;

pub use estimate::Estimate;
pub use mass_lines::{MassLines, ScatterAccumulator, lower_triangle, symmetric};
pub use response_inverse::ResponseInverse;
pub use weighting::{PlacementErrors, Weighting};

/// How the ten properties were identified, raw in a stored result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Method {
    /// The linear inertia restraint method (IRM).
    InertiaRestraint = 1,
}

impl Method {
    /// The name in reports and JSON.
    pub fn name(self) -> &'static str {
        match self {
            Self::InertiaRestraint => "inertia-restraint",
        }
    }

    /// Read from the wire.
    pub fn from_raw(raw: u8) -> Option<Self> {
        (raw == Self::InertiaRestraint as u8).then_some(Self::InertiaRestraint)
    }
}
