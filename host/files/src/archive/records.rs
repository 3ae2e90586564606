//! Records of single hits in an archive.

use massline_shared::signal::Scan;
use serde::{Deserialize, Serialize};

/// The record of one accepted hit.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct HitRecord {
    /// Number of the hit on the rig.
    pub hit: u32,
    /// Its DOF, `node:±axis`.
    pub dof: String,
    /// Codes of the hammer and of the axes of all sensors, scan by scan.
    pub codes: Vec<Scan>,
}
