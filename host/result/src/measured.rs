//! What was measured, and what the answers were found from.

use serde::{Deserialize, Serialize};

/// The mass lines of a DOF.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MassLine {
    /// The DOF.
    pub dof: String,
    /// Number of averaged hits; `null` where it is not known.
    pub hits: Option<u16>,
    /// Their band, where every DOF has its own.
    pub band_hz: Option<[f64; 2]>,
    /// Rigid-body accelerance of every response.
    pub accelerance_m_per_s2_per_n: Vec<f64>,
    /// Its standard deviation; `null` where it is not known.
    pub noise_m_per_s2_per_n: Vec<Option<f64>>,
    /// Mean coherence of every response; `null` where it is not known, as for a single hit, whose coherence is one by
    /// definition.
    pub coherence: Option<Vec<f64>>,
}

/// A DOF whose frequency responses about the suspension modes are stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct MeasuredDof {
    /// The DOF.
    pub dof: String,
    /// Number of averaged hits; `null` where it is not known.
    pub hits: Option<u16>,
    /// The band, where every DOF has its own.
    pub band_hz: Option<[f64; 2]>,
    /// Mean coherence of every response; `null` where it is not known.
    pub coherence: Option<Vec<f64>>,
}

impl MassLine {
    /// The DOF without its lines.
    pub fn measured(&self) -> MeasuredDof {
        MeasuredDof {
            dof: self.dof.clone(),
            hits: self.hits,
            band_hz: self.band_hz,
            coherence: self.coherence.clone(),
        }
    }
}

/// What the global fit finds besides the ten properties, about the origin of the body frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct GlobalFit {
    /// Stiffness: N/m, N/rad, N m/m, N m/rad.
    pub stiffness: Vec<[f64; 6]>,
    /// Damping: N s/m and so on, or as stiffness for structural damping.
    pub damping: Option<Vec<[f64; 6]>>,
    /// Number of extra terms of the dynamic stiffness.
    pub extra_terms: usize,
    /// What the tests for the extra terms found: standard normal deviates.
    pub extra_terms_z: Vec<Option<f64>>,
    /// Standard deviation of the noise of a reading, of a complex number.
    pub noise_m_per_s2_per_n: f64,
}
