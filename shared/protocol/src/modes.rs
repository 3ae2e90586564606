//! What a result of the suspension profile says besides its estimates: the modes, and how the methods agree.

use heapless::Vec;
use massline_shared::identify::agreement::{Agreement, Outcome};
use massline_shared::identify::suspension_solver::SuspensionSolver;
use massline_shared::identify::{Method, SUSPENSION_METHODS};
use nalgebra::{ComplexField, Vector6};
use serde::{Deserialize, Serialize};

use crate::diagnostic::WireDiagnostic;

/// A suspension mode.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredMode {
    /// Natural frequency, Hz.
    pub frequency_hz: f32,
    /// Damping ratio.
    pub damping_ratio: f32,
    /// Mass-normalised shape at the origin of the body frame, `[x; θ]`, 1/√kg and 1/(m √kg).
    pub shape: [f32; 6],
    /// Standard deviations of frequency, damping ratio and shape; zero where unknown.
    pub sigma: [f32; 8],
    /// Imaginary over real part of the residues.
    pub complexity: f32,
}

impl StoredMode {
    /// The mode at this place of the computation.
    pub fn of(solver: &SuspensionSolver<f32>, place: usize) -> Option<Self> {
        let mode = solver.modes().get(place)?;
        Some(Self {
            frequency_hz: mode.frequency_hz,
            damping_ratio: mode.damping_ratio,
            shape: mode.shape_at_origin(&solver.reference()).into(),
            sigma: solver.mode_sigma(place).map(finite_or_zero),
            complexity: mode.complexity,
        })
    }

    /// Its shape.
    pub fn shape(&self) -> Vector6<f32> {
        self.shape.into()
    }
}

/// Why a method has no answer.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredRefusal {
    /// [`Method::number`].
    pub method: u8,
    /// The reason.
    pub reason: WireDiagnostic,
}

/// How the methods agree, and their combined estimate. Methods are named by [`Method::number`], properties in the order of
/// [`StoredEstimate::properties`](crate::object::StoredEstimate::properties).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredAgreement {
    /// The combined estimate of all methods but those that are off.
    pub properties: [f32; 10],
    /// Its standard deviations.
    pub sigma: [f32; 10],
    /// The few methods without which no significant difference is left.
    pub off: Vec<u8, SUSPENSION_METHODS>,
    /// True when the methods differ by more than chance, and no few of them are off: the standard deviations include the
    /// differences.
    pub differ: bool,
    /// The difference that contradicts chance most.
    pub largest: Option<StoredDifference>,
}

/// A difference of two methods.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StoredDifference {
    /// The two methods.
    pub methods: [u8; 2],
    /// Index of the property.
    pub property: u8,
    /// The first minus the second, in SI units.
    pub difference: f32,
    /// Standard deviation of the difference.
    pub sigma: f32,
    /// True when chance does not explain it.
    pub significant: bool,
}

impl StoredAgreement {
    /// Whether the methods agree.
    pub fn outcome(&self) -> Outcome {
        Outcome::of(self.differ, !self.off.is_empty())
    }

    /// Converts the agreement of the methods that use the suspension modes.
    pub fn of(agreement: &Agreement<f32>) -> Self {
        let number = |place: usize| Method::of_modes().nth(place).map_or(0, Method::number);
        let largest = agreement.largest().map(|of| StoredDifference {
            methods: of.methods.map(number),
            property: of.property as u8,
            difference: of.difference,
            sigma: finite_or_zero(of.sigma),
            significant: of.significant,
        });
        let variances = agreement.covariance.diagonal();
        Self {
            properties: agreement.theta.into(),
            sigma: variances
                .map(|variance| finite_or_zero(ComplexField::sqrt(variance.max(0.0))))
                .into(),
            off: agreement.outliers.iter().map(|place| number(*place)).collect(),
            differ: agreement.outcome() == Outcome::Differ,
            largest,
        }
    }
}

fn finite_or_zero(value: f32) -> f32 {
    if value.is_finite() { value } else { 0.0 }
}
