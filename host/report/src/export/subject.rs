//! What is exported: a result in some frame and some units.

use massline_result::{Estimate, Verdict};
use massline_shared::body::RigidBody;
use massline_shared::identify::HALF_WIDTH_95;
use nalgebra::{SMatrix, SVector};

use super::frame::Placement;
use super::number::shortest;
use super::test_data::TestData;
use super::units::UnitSystem;
use massline_result::{Error, Result};

/// A covariance of the ten properties in the order [m, c_x, c_y, c_z, J_xx, J_yy, J_zz, J_xy, J_xz, J_yz].
pub type Matrix10 = SMatrix<f64, 10, 10>;
/// The ten properties in the same order.
pub type Vector10 = SVector<f64, 10>;

/// A result to be exported: an answer seen in some frame and in some units.
///
/// It is read in SI and in the body frame of the layout; [`ExportedResult::in_frame`] and [`ExportedResult::in_units`]
/// change that for the properties and their covariance, not for nodes and frequency responses.
#[derive(Clone, Debug, PartialEq)]
pub struct ExportedResult {
    /// The answer, in SI units and in the body frame.
    estimate: Estimate,
    /// The body in the frame and the units of the export, the inertia about the centre of mass.
    pub body: RigidBody<f64>,
    /// The ten properties there, from those of the answer: their change with them.
    map: Matrix10,
    /// The verdict on the result.
    pub verdict: Verdict,
    /// What puts the answer in doubt, a sentence each, the gravest first.
    pub doubts: Vec<String>,
    /// The frame of the properties.
    pub placement: Placement,
    /// The units of the properties and of the placement.
    pub units: UnitSystem,
    /// What is known of the test besides its answer.
    pub test: TestData,
}

impl ExportedResult {
    /// An answer, of a test of which only the source is known.
    pub fn new(estimate: Estimate, verdict: Verdict, source: &str) -> Self {
        Self {
            body: estimate.body(),
            estimate,
            map: Matrix10::identity(),
            verdict,
            doubts: Vec::new(),
            placement: Placement::body(),
            units: UnitSystem::Si,
            test: TestData::of_source(source),
        }
    }

    /// Name of the method.
    pub fn method(&self) -> &'static str {
        self.estimate.method.name()
    }

    /// The ten properties.
    pub fn theta(&self) -> Vector10 {
        self.body.theta()
    }

    /// Their covariance; `None` when the method gives none.
    pub fn covariance(&self) -> Option<Matrix10> {
        self.of_answer().map(|covariance| self.map * covariance * self.map.transpose())
    }

    /// Their standard deviations.
    pub fn sigma(&self) -> Option<Vector10> {
        match self.is_as_answered() {
            true => self.estimate.sigma().map(Vector10::from),
            false => self.covariance().map(|c| deviations(&c)),
        }
    }

    /// Half widths of their 95 % intervals; `None` without a covariance.
    pub fn half_widths(&self) -> Option<Vector10> {
        if self.is_as_answered() {
            return self.estimate.half_widths().map(Vector10::from);
        }
        let mapped = self.map * self.estimate.widened_covariance()? * self.map.transpose();
        Some(HALF_WIDTH_95 * deviations(&mapped))
    }

    /// Lower and upper ends of the 95 % intervals.
    pub fn interval(&self) -> Option<[Vector10; 2]> {
        // Another origin moves the values, and their intervals with them.
        let is_unmoved =
            self.is_as_answered() && self.theta() == Vector10::from(self.estimate.theta());
        if let Some(stated) =
            self.estimate.interval95.filter(|_| is_unmoved && !self.covers_scatter_only())
        {
            let ends = stated.in_order();
            return Some([0, 1].map(|end| Vector10::from_fn(|k, _| ends[k][end])));
        }
        let (theta, half) = (self.theta(), self.half_widths()?);
        Some([theta - half, theta + half])
    }

    /// Whether the standard deviations cover the scatter between hits only.
    pub fn covers_scatter_only(&self) -> bool {
        self.estimate.covers_scatter_only()
    }

    /// Whether axes and units are those of the answer itself.
    fn is_as_answered(&self) -> bool {
        self.map == Matrix10::identity()
    }

    /// The same answer after a further linear map of the ten properties, whose value is `body`.
    pub(super) fn mapped(self, map: &Matrix10, body: RigidBody<f64>) -> Self {
        Self { body, map: map * self.map, ..self }
    }

    /// The covariance of the answer itself.
    fn of_answer(&self) -> Option<Matrix10> {
        let rows = self.estimate.covariance?;
        Some(Matrix10::from_fn(|i, j| rows[i.max(j)][i.min(j)]))
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
        (!self.estimate.physically_consistent)
            .then(|| "the result says that it is not physically consistent".into())
    }

    /// Checks that the properties are numbers and, unless `despite_verdict` is set, those of a real body and not
    /// contradicted.
    ///
    /// # Errors
    /// Exit 3; the message names the violated condition, or what the verdict says.
    pub fn check(&self, despite_verdict: bool) -> Result<()> {
        let covariance = self.covariance().into_iter().flat_map(|c| Vec::from(c.as_slice()));
        let interval =
            self.interval().into_iter().flatten().flat_map(|end| Vec::from(end.as_slice()));
        let origin = self.placement.origin.iter().copied();
        let source = &self.test.source;
        if !self.body.is_finite() || !covariance.chain(interval).chain(origin).all(f64::is_finite) {
            return Err(Error::undetermined(
                "not_finite",
                format!(
                    "{source}: the answer by {} is too large for a number in {}; solve again",
                    self.method(),
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
                    self.method()
                ),
            ));
        }
        if self.verdict == Verdict::DoNotUse {
            let reason = self.doubts.first().map_or("see its verdict_reasons", String::as_str);
            return Err(Error::undetermined(
                "do_not_use",
                format!(
                    "{source}: the verdict on this result is not to use it: {reason}. Correct the layout or the data \
                     and solve again, or write it all the same with --despite-verdict"
                ),
            ));
        }
        Ok(())
    }
}

/// Standard deviations, from a covariance.
fn deviations(covariance: &Matrix10) -> Vector10 {
    covariance.diagonal().map(|variance| variance.max(0.0).sqrt())
}
