//! The suspension modes.

use serde::{Deserialize, Serialize};

use crate::finding::Finding;
use crate::properties::Spread;

/// The suspension modes of a test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Modes {
    /// The suspension band.
    pub band_hz: [f64; 2],
    /// The modes, in the order of their frequencies.
    pub modes: Vec<Mode>,
    /// How many of six do not show.
    pub modes_missing: usize,
    /// DOF of a hit that is unlike those of the test, where modes are missing.
    pub hit_for_missing: Option<String>,
    /// Modal assurance criterion of every mode with every other.
    pub modal_assurance: Vec<Vec<f64>>,
    /// The fits of every order.
    pub orders: Vec<Order>,
    /// Standard deviation of the noise of a reading, of a complex number.
    pub noise_m_per_s2_per_n: Option<f64>,
    /// Gravity as the readings have it, where it was taken instead of the layout's.
    pub fitted_gravity_m_per_s2: Option<[f64; 3]>,
    /// Findings about modes, sensors and hits, where the modes are all that was asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagnostics: Option<Vec<Finding>>,
}

impl Modes {
    /// The natural frequencies, Hz.
    pub fn frequencies_hz(&self) -> Vec<f64> {
        self.modes.iter().map(|mode| mode.frequency_hz.value).collect()
    }
}

/// A mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Mode {
    /// Natural frequency.
    pub frequency_hz: Spread<f64>,
    /// Damping ratio.
    pub damping_ratio: Spread<f64>,
    /// Mass-normalised shape at the origin of the body frame: three displacements, 1/√kg, and three rotations, 1/(m
    /// √kg).
    pub shape: Spread<[f64; 6]>,
    /// Imaginary over real part of the residues.
    pub complexity: Option<f64>,
    /// How much of the mode every hit shows.
    pub norm_indicators: Vec<Indicator>,
    /// A hit that shows much more of the mode.
    pub better_hit: Option<BetterHit>,
}

/// The Norm Indicator of a hit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Indicator {
    /// The DOF.
    pub dof: String,
    /// The indicator.
    pub value: f64,
}

/// A hit that shows much more of a mode.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct BetterHit {
    /// The DOF.
    pub dof: String,
    /// Which part of what it would show the best hit of the test shows.
    pub shown: f64,
}

/// The fit of one order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Order {
    /// Whether the modes come from it.
    pub used: bool,
    /// Its poles.
    pub poles: Vec<Pole>,
}

/// A pole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Pole {
    /// Its frequency.
    pub frequency_hz: f64,
    /// Its damping ratio.
    pub damping_ratio: f64,
    /// Whether the next smaller order has it as well.
    pub stable: bool,
}

/// What the points measured so far show of the suspension modes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ModesSoFar {
    /// Number of DOFs with lines.
    pub dofs_measured: usize,
    /// The same with the DOFs that are still to be measured; a skipped one does not count.
    pub dofs: usize,
    /// The modes that show clearly, in the order of their frequencies.
    pub modes: Vec<SeenMode>,
    /// How many of six do not show.
    pub modes_missing: usize,
    /// The point to hit next; `null` where every mode shows well, or no point would help.
    pub next: Option<NextPoint>,
}

/// A mode that the points measured so far show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SeenMode {
    /// Natural frequency.
    pub frequency_hz: f64,
    /// Damping ratio.
    pub damping_ratio: f64,
    /// The measured DOF that shows it best.
    pub dof: String,
    /// Its Norm Indicator.
    pub norm_indicator: f64,
    /// The same as a share of the largest of any hit along an axis of the body at a point of the layout.
    pub share_of_possible: f64,
}

/// A point that would show what is missing.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct NextPoint {
    /// The DOF; along an axis of the body where it is none of the layout.
    pub dof: String,
    /// Number of points that the rig asks for before it; `null` for one that is not in the layout.
    pub points_before: Option<usize>,
}
