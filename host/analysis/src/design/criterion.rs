//! The criterion for comparing layouts, whatever the profile of the test.

use massline_physics::suspension::RigidMode;
use massline_shared::body::RigidBody;
use massline_shared::capacity::Capacity;
use massline_shared::design::{Criterion, Predict};
use massline_shared::identify::suspension::undetermined_property;
use massline_shared::layout::{HostLayout, Layout};
use nalgebra::SVector;

use super::suspension::SuspensionCriterion;

/// The uncertainty predicted for a body.
#[derive(Clone, Debug, PartialEq)]
pub enum LayoutCriterion {
    /// From mass lines.
    MassLine(Criterion<f64>),
    /// From suspension modes.
    Suspension(Box<SuspensionCriterion>),
}

impl LayoutCriterion {
    /// That of mass lines, for this body under a layout; `noise` is relative to 1/m.
    pub fn of_mass_lines(body: RigidBody<f64>, layout: &HostLayout, noise: f64) -> Self {
        Self::MassLine(Criterion::new(body, layout.characteristic_length(), noise))
    }

    /// That of six modes, in records of `record_s`; otherwise as [`Self::of_mass_lines`].
    pub fn of_modes(
        body: RigidBody<f64>,
        layout: &HostLayout,
        noise: f64,
        modes: &[RigidMode; 6],
        record_s: f64,
    ) -> Self {
        let plain = Criterion::new(body, layout.characteristic_length(), noise);
        Self::Suspension(Box::new(SuspensionCriterion::new(plain, modes, layout, record_s)))
    }

    fn plain(&self) -> &Criterion<f64> {
        match self {
            Self::MassLine(criterion) => criterion,
            Self::Suspension(criterion) => criterion.plain(),
        }
    }

    /// The assumed body of the object.
    pub fn body(&self) -> &RigidBody<f64> {
        &self.plain().body
    }

    /// True for variances of `theta` with which the methods answer. Those that use the modes refuse a property whose
    /// standard deviation is too large for its scale.
    pub(super) fn is_determined(&self, variances: &SVector<f64, 10>, layout: &HostLayout) -> bool {
        let sigma = variances.map(f64::sqrt);
        let length = layout.characteristic_length();
        match self {
            Self::MassLine(_) => true,
            Self::Suspension(_) => {
                undetermined_property(&self.body().theta(), &sigma, length).is_none()
            }
        }
    }

    /// Standard deviation of the accelerance of a single hit, (m/s²)/N.
    pub fn noise(&self) -> f64 {
        self.plain().noise
    }
}

impl Predict<f64> for LayoutCriterion {
    fn scale(&self) -> &SVector<f64, 10> {
        &self.plain().scale
    }

    /// `workspace` as for [`Criterion::bound`]; suspension modes need none.
    fn variances<C: Capacity>(
        &self,
        layout: &Layout<f64, C>,
        workspace: &mut [f64],
    ) -> Option<SVector<f64, 10>> {
        match self {
            Self::MassLine(criterion) => criterion.variances(layout, workspace),
            Self::Suspension(criterion) => criterion.variances(layout, workspace),
        }
    }

    fn with_noise(&self, factor: f64) -> Self {
        match self {
            Self::MassLine(criterion) => Self::MassLine(criterion.with_noise(factor)),
            Self::Suspension(criterion) => Self::Suspension(Box::new(criterion.with_noise(factor))),
        }
    }
}
