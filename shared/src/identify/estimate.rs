//! The answer of every identification method.

use nalgebra::{SMatrix, SVector, Vector3};

use super::Method;
use super::budget::LearnedBudget;
use crate::body::RigidBody;
use crate::diagnosis::Diagnostics;
use crate::real::Real;

/// The data contradict the error budget when chance alone would exceed their χ² in only one of a thousand
/// tests: when the equivalent z is above this value.
pub const REJECTION_Z: f64 = 3.09;

/// Half width of a 95 % interval, in standard deviations.
pub const HALF_WIDTH_95: f64 = 1.959_963_984_540_054;

/// The ten properties with their covariance and quality figures.
#[derive(Clone, Debug, PartialEq)]
pub struct Estimate<R> {
    /// The method that produced the estimate.
    pub method: Method,
    /// The body, in the body frame of the layout.
    pub body: RigidBody<R>,
    /// Covariance of [`RigidBody::theta`]; `None` when it cannot be determined.
    pub covariance: Option<SMatrix<R, 10, 10>>,
    /// Condition of the balanced regression matrix.
    pub condition: R,
    /// Whether the data agree with their error budget; only for methods that use one.
    pub consistency: Option<Consistency<R>>,
    /// What the data have taught about the error budget; only for a method that learns it.
    pub learned: Option<LearnedBudget<R>>,
    /// Diagnostics of the estimate; none of them is an error.
    pub diagnostics: Diagnostics,
}

/// How well the data agree with their error budget.
///
/// ```
/// # use massline_shared::identify::Consistency;
/// let mean = Consistency { chi_squared: 17.0, degrees_of_freedom: 17 };
/// assert!(!mean.rejects_budget());
/// // The 99.9 % point of χ² with 17 degrees of freedom is 40.8.
/// assert!(!Consistency { chi_squared: 40.0, ..mean }.rejects_budget());
/// assert!(Consistency { chi_squared: 42.0, ..mean }.rejects_budget());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Consistency<R> {
    /// Weighted sum of squared residuals, priors included.
    pub chi_squared: R,
    /// Equations minus unknowns: the expected value of χ².
    pub degrees_of_freedom: u16,
}

impl<R: Real> Consistency<R> {
    /// χ² over its degrees of freedom: one on average.
    pub fn reduced(&self) -> R {
        self.chi_squared / R::of(f64::from(self.degrees_of_freedom.max(1)))
    }

    /// Standard normal deviate that is exceeded with the same probability as χ² (Wilson & Hilferty 1931).
    pub fn equivalent_z(&self) -> R {
        let spread = R::of(2.0 / (9.0 * f64::from(self.degrees_of_freedom.max(1))));
        (self.reduced().max(R::zero()).cbrt() - (R::one() - spread)) / spread.sqrt()
    }

    /// True when the data contradict their error budget; chance alone does this in one of a thousand tests.
    pub fn rejects_budget(&self) -> bool {
        self.equivalent_z() > R::of(REJECTION_Z)
    }
}

impl<R: Real> Estimate<R> {
    /// The same estimate in another precision.
    pub fn cast<Q: Real>(&self) -> Estimate<Q> {
        let to = |v: R| Q::of(v.to_f64());
        Estimate {
            method: self.method,
            body: RigidBody::from_theta(&self.theta().map(to)),
            covariance: self.covariance.map(|c| c.map(to)),
            condition: to(self.condition),
            consistency: self.consistency.map(|c| Consistency {
                chi_squared: to(c.chi_squared),
                degrees_of_freedom: c.degrees_of_freedom,
            }),
            learned: self.learned.map(|learned| learned.cast()),
            diagnostics: self.diagnostics.clone(),
        }
    }

    /// [m, c, J about the centre of mass].
    pub fn theta(&self) -> SVector<R, 10> {
        self.body.theta()
    }

    /// Standard deviations of [`Estimate::theta`].
    pub fn sigma(&self) -> Option<SVector<R, 10>> {
        self.covariance.map(|c| c.diagonal().map(|v| v.max(R::zero()).sqrt()))
    }

    /// Half widths of the 95 % intervals of [`Estimate::theta`]. Under a learned budget they are wider than
    /// [`HALF_WIDTH_95`] standard deviations.
    pub fn half_widths(&self) -> Option<SVector<R, 10>> {
        let widening = self.learned.map_or([R::one(); 10], |learned| learned.widening);
        let half = self.sigma()? * R::of(HALF_WIDTH_95);
        Some(half.component_mul(&SVector::from(widening)))
    }

    /// Index of the property with the largest relative standard deviation, and that value. The standard
    /// deviations are relative to the mass, the radius of gyration or the mean moment. `None` without
    /// standard deviations.
    pub fn least_known(&self) -> Option<(usize, R)> {
        let moment = self.body.inertia.trace() / R::of(3.0);
        let radius = (moment * R::of(1.5) / self.body.mass).max(R::zero()).sqrt();
        let mut worst = None;
        for (k, sigma) in self.sigma()?.iter().enumerate() {
            let size = [self.body.mass, radius, moment][usize::from(k > 0) + usize::from(k > 3)];
            let relative = *sigma / size;
            // The value is not finite for a body without size.
            if relative.finite() && worst.is_none_or(|(_, most)| relative > most) {
                worst = Some((k, relative));
            }
        }
        worst
    }

    /// Standard deviations of the principal moments, in ascending order of the moments, kg m².
    pub fn principal_moment_sigmas(&self) -> Option<Vector3<R>> {
        Some(self.body.principal()?.moment_sigmas(self.covariance.as_ref()?))
    }
}
