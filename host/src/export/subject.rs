//! What is exported: a result in some frame and some units.

use massline_shared::body::RigidBody;
use nalgebra::{SMatrix, SVector};

use super::frame::Placement;
use super::number::shortest;
use super::test_data::TestData;
use super::units::UnitSystem;
use crate::error::{Error, Result};
use crate::verdict::Verdict;

/// A covariance of the ten properties in the order [m, cx, cy, cz, Jxx, Jyy, Jzz, Jxy, Jxz, Jyz].
pub type Matrix10 = SMatrix<f64, 10, 10>;
/// The ten properties in the same order.
pub type Vector10 = SVector<f64, 10>;

/// A result to be exported.
///
/// It is read in SI and in the body frame of the layout; [`Exported::in_frame`] and [`Exported::in_units`] change that
/// for the properties and their covariance, not for nodes and frequency responses.
#[derive(Clone, Debug, PartialEq)]
pub struct Exported {
    /// Name of the method of the estimate.
    pub method: String,
    /// The properties, the inertia about the centre of mass.
    pub body: RigidBody<f64>,
    /// Covariance of the properties; `None` when the method gives none.
    pub covariance: Option<Matrix10>,
    /// Half widths of the 95 % intervals; `None` without a covariance.
    pub half_widths: Option<Vector10>,
    /// Whether the result itself says that a body with these properties exists.
    pub stated_consistent: bool,
    /// The verdict on the result; `None` where its document states none.
    pub verdict: Option<Verdict>,
    /// What puts the answer in doubt, a sentence each, the gravest first.
    pub doubts: Vec<String>,
    /// The frame of the properties.
    pub placement: Placement,
    /// The units of the properties and of the placement.
    pub units: UnitSystem,
    /// What is known of the test besides its answer.
    pub test: TestData,
}

impl Exported {
    /// The ten properties.
    pub fn theta(&self) -> Vector10 {
        self.body.theta()
    }

    /// Standard deviations of the ten properties.
    pub fn sigma(&self) -> Option<Vector10> {
        self.covariance.map(|c| c.diagonal().map(|variance| variance.max(0.0).sqrt()))
    }

    /// Lower and upper ends of the 95 % intervals.
    pub fn interval(&self) -> Option<[Vector10; 2]> {
        let (theta, half) = (self.theta(), self.half_widths?);
        Some([theta - half, theta + half])
    }

    /// The same with what `change` makes of the data of the test.
    pub fn with_test(self, change: impl FnOnce(TestData) -> TestData) -> Self {
        Self { test: change(self.test), ..self }
    }

    /// The condition of a real body that the properties violate, if there is one.
    pub fn violated_condition(&self) -> Option<String> {
        let unit = self.units;
        if self.body.mass <= 0.0 {
            let mass = shortest(self.body.mass);
            return Some(format!("the mass is {mass} {}, not positive", unit.mass_unit()));
        }
        let Some(principal) = self.body.principal() else {
            return Some("the inertia has no principal moments".into());
        };
        let [small, middle, large] = principal.moments.into();
        let inertia = unit.inertia_unit();
        if small <= 0.0 {
            let small = shortest(small);
            return Some(format!("a principal moment is {small} {inertia}, not positive"));
        }
        if !self.body.is_physically_consistent() {
            return Some(format!(
                "the largest principal moment, {large:.6e} {inertia}, is not below the sum of the other two, \
                 {middle:.6e} + {small:.6e}"
            ));
        }
        (!self.stated_consistent)
            .then(|| "the result says that it is not physically consistent".into())
    }

    /// Checks that the properties are numbers and, unless `despite_verdict` is set, those of a real body and not contradicted.
    ///
    /// # Errors
    /// Exit 3; the message names the violated condition, or what the verdict says.
    pub fn check(&self, despite_verdict: bool) -> Result<()> {
        let covariance = self.covariance.iter().flat_map(|c| c.iter().copied());
        let interval =
            self.interval().into_iter().flatten().flat_map(|end| Vec::from(end.as_slice()));
        let origin = self.placement.origin.iter().copied();
        let source = &self.test.source;
        if !self.body.is_finite() || !covariance.chain(interval).chain(origin).all(f64::is_finite) {
            return Err(Error::undetermined(
                "not_finite",
                format!(
                    "{source}: the answer by {} is too large for a number in {}; solve again",
                    self.method,
                    self.units.name()
                ),
            ));
        }
        if despite_verdict {
            return Ok(());
        }
        if let Some(condition) = self.violated_condition() {
            return Err(Error::undetermined(
                "unphysical_result",
                format!(
                    "{source}: the answer by {} is not that of a physical body: {condition}. Simulators refuse it; \
                     measure again, or write it all the same with --despite-verdict",
                    self.method
                ),
            ));
        }
        if self.verdict == Some(Verdict::DoNotUse) {
            let reason = self.doubts.first().map_or("see its verdict_reasons", String::as_str);
            return Err(Error::undetermined(
                "do_not_use",
                format!(
                    "{source}: the verdict on this result is not to use it: {reason}. Correct the layout or the data and \
                     solve again, or write it all the same with --despite-verdict"
                ),
            ));
        }
        Ok(())
    }
}
