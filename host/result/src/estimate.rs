//! One estimate of the ten properties.

use massline_shared::body::{INERTIA_ELEMENTS, RigidBody, tensor};
use massline_shared::diagnosis::Code;
use massline_shared::identify::{HALF_WIDTH_95, Method};
use nalgebra::{SMatrix, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use crate::details::LearnedFrom;
use crate::finding::Finding;
use crate::named::NamedValue;
use crate::properties::{Properties, Spread};

/// The answer of a method: the ten properties in the body frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Estimate {
    /// The method.
    pub method: NamedValue<Method>,
    /// The mass.
    pub mass_kg: Spread<f64>,
    /// The centre of mass.
    pub center_of_mass_m: Spread<[f64; 3]>,
    /// The inertia tensor about the centre of mass, row by row; products have the sign of the tensor's elements.
    pub inertia_kg_m2: Spread<[[f64; 3]; 3]>,
    /// The ends of the 95 % interval of each property.
    pub interval95: Option<Properties<[f64; 2]>>,
    /// Covariance of the ten properties, in the order m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz.
    pub covariance: Option<[[f64; 10]; 10]>,
    /// Principal moments of inertia, ascending.
    #[serde(default)]
    pub principal_moments_kg_m2: PrincipalMoments,
    /// The principal axes as columns, row by row.
    pub principal_axes: Option<[[f64; 3]; 3]>,
    /// Whether a body can have these properties.
    pub physically_consistent: bool,
    /// Condition of the balanced equations.
    pub condition: Option<f64>,
    /// What the answer leaves of the data, against their uncertainty.
    pub chi_squared: Option<ChiSquared>,
    /// What the data have taught about the error budget.
    pub learned_budget: Option<LearnedBudget>,
    /// Findings about this answer.
    #[serde(default)]
    pub diagnostics: Vec<Finding>,
}

impl Estimate {
    /// The ten properties: m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz.
    pub fn theta(&self) -> [f64; 10] {
        ten(self.mass_kg.value, self.center_of_mass_m.value, self.inertia_kg_m2.value)
    }

    /// Their standard deviations; `None` where the method gives none.
    pub fn sigma(&self) -> Option<[f64; 10]> {
        Some(ten(self.mass_kg.sigma?, self.center_of_mass_m.sigma?, self.inertia_kg_m2.sigma?))
    }

    /// Half the widths of their 95 % intervals; `None` where they are not known, also of standard deviations that cover
    /// the scatter between hits only.
    pub fn half_widths(&self) -> Option<[f64; 10]> {
        let sigma = self.complete_sigma()?;
        Some(match &self.interval95 {
            Some(intervals) => intervals.in_order().map(|[low, high]| (high - low) / 2.0),
            None => sigma.map(|sigma| HALF_WIDTH_95 * sigma),
        })
    }

    /// The standard deviations where they cover all that they should: not the scatter between hits only.
    pub fn complete_sigma(&self) -> Option<[f64; 10]> {
        self.sigma().filter(|_| !self.covers_scatter_only())
    }

    /// Half the widths of the 95 % intervals of the principal moments; `None` where they are not known.
    pub fn principal_half_widths(&self) -> Option<[f64; 3]> {
        let sigma = self.body().principal()?.moment_sigmas(&self.widened_covariance()?);
        Some(<[f64; 3]>::from(sigma).map(|sigma| HALF_WIDTH_95 * sigma))
    }

    /// The covariance with which normal 95 % intervals are those of the answer: a learned budget widens them property
    /// by property. `None` where they are not known.
    pub fn widened_covariance(&self) -> Option<SMatrix<f64, 10, 10>> {
        let (covariance, half) = (self.covariance?, self.half_widths()?);
        let widening: [f64; 10] = std::array::from_fn(|k| {
            let sigma = covariance[k][k].max(0.0).sqrt();
            if sigma > 0.0 { half[k] / (HALF_WIDTH_95 * sigma) } else { 1.0 }
        });
        // The lower half: a file may round the two differently.
        Some(SMatrix::from_fn(|i, j| widening[i] * covariance[i.max(j)][i.min(j)] * widening[j]))
    }

    /// The body with these properties.
    pub fn body(&self) -> RigidBody<f64> {
        let elements = INERTIA_ELEMENTS.map(|(row, column)| self.inertia_kg_m2.value[row][column]);
        RigidBody {
            mass: self.mass_kg.value,
            center_of_mass: Vector3::from(self.center_of_mass_m.value),
            inertia: tensor(&Vector6::from(elements)),
        }
    }

    /// Whether the standard deviations cover the scatter between hits only: 1.96 of them hold the truth in 64 of 100
    /// tests.
    pub fn covers_scatter_only(&self) -> bool {
        self.diagnostics.iter().any(|finding| finding.code == Code::SigmaCoversScatterOnly)
    }
}

/// The ten properties, or their standard deviations, in order.
fn ten(mass: f64, center: [f64; 3], inertia: [[f64; 3]; 3]) -> [f64; 10] {
    let [x, y, z] = center;
    let [xx, yy, zz, xy, xz, yz] = INERTIA_ELEMENTS.map(|(row, column)| inertia[row][column]);
    [mass, x, y, z, xx, yy, zz, xy, xz, yz]
}

/// Principal moments of inertia.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PrincipalMoments {
    /// The values.
    pub value: Option<[f64; 3]>,
    /// Their standard deviations.
    pub sigma: Option<[f64; 3]>,
}

/// χ².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChiSquared {
    /// The value.
    pub value: f64,
    /// Its degrees of freedom.
    pub degrees_of_freedom: u16,
    /// The value over the degrees of freedom.
    pub reduced: f64,
}

/// The learned error budget: factors of the stated standard deviations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LearnedBudget {
    /// What it was learned from.
    pub learned_from: LearnedFrom,
    /// Of the position of a hit.
    pub hit_position_scale: f64,
    /// Of the direction of a hit.
    pub hit_direction_scale: f64,
    /// Of all that stays the same during a test.
    pub constant_scale: f64,
    /// Degrees of freedom of the scatter of the hits.
    pub scatter_degrees_of_freedom: u16,
    /// Standard deviation of the logarithm of `constant_scale`.
    pub constant_log_sigma: f64,
    /// Factors by which the intervals of the ten properties are wider, because the scales are uncertain.
    pub interval_widening: [f64; 10],
}
