//! `[[node]]` and `[[elastic_mode]]`.

use serde::Deserialize;

/// A point at which the motion in the elastic modes is defined.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[node]]")]
pub struct Node {
    /// Its number in layouts.
    pub id: u16,
    /// Position in the body frame, m.
    pub position_m: [f64; 3],
}

/// An elastic mode of the free object.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[elastic_mode]]")]
pub struct ElasticMode {
    /// Undamped frequency, Hz.
    pub frequency_hz: f64,
    /// Fraction of critical damping.
    #[serde(default = "half_percent")]
    pub damping_ratio: f64,
    /// Motion of every node.
    pub shape: Vec<NodeShape>,
}

/// Mass-normalised motion of one node in an elastic mode.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table [[elastic_mode.shape]]")]
pub struct NodeShape {
    /// The node.
    pub node: u16,
    /// Translation along the body axes, kg^(−1/2).
    pub translation: [f64; 3],
    /// Rotation about the body axes, rad/(m √kg).
    pub rotation: [f64; 3],
}

fn half_percent() -> f64 {
    0.005
}
