//! Layout of a test: where the sensors are and where the hammer hits.
//!
//! A *node* is a numbered point of the object with local axes. A *sensor* is a triaxial
//! accelerometer on a node; a *hit* is a degree of freedom (DOF) `node:±axis` along which the hammer
//! pushes. All positions are in the body frame, all directions are unit vectors of the body frame.
//! Nodes and local axes of the layout file have already been converted to positions and directions here.

mod check;
mod dof;
mod error_source;
mod kinematics;
mod policy;
mod profile;
mod settings;
mod target;
mod uncertain_quantities;
mod uncertainty;

pub use crate::capacity::{RIG_HITS, RIG_SENSORS};
pub(crate) use check::is_finite;
pub use check::{
    AXES_TOLERANCE, DEGENERACY_RATIO, LayoutReport, assumed_body, check_geometry, check_hits,
    extent,
};
pub use dof::{AXIS_LETTERS, Axis, Dof, DofError, Sign};
pub use error_source::ErrorSource;
pub use kinematics::{balanced_force, balanced_motion, motion_at, sensor_shift, unit_force};
pub use policy::{HitPolicy, HitTreatment};
pub use profile::TestProfile;
pub use settings::{
    AUTOMATIC, Choice, FrfEstimator, TEST_KEYS, TestForm, TestKey, TestSettings, TestValue,
    check_settings, highest_frequency,
};
pub use target::{TARGET_KEYS, Target, TargetKey};
pub(crate) use uncertain_quantities::across;
pub use uncertain_quantities::{
    GRAVITY_QUANTITIES, HIT_QUANTITIES, SENSOR_QUANTITIES, UncertainQuantity,
};
pub use uncertainty::{
    ApparatusUncertainty, AttachedBody, CALIBRATED_HAMMER_GAIN, DEFAULT_HAMMER_GAIN,
    HitUncertainty, MAX_ATTACHED, Prior, SensorUncertainty, UncertaintyKey, UncertaintyUnit,
    uncertainty_keys,
};

use heapless::{String, Vec};

#[cfg(any(test, feature = "alloc"))]
use crate::capacity::Unbounded;
use crate::capacity::{Capacity, List, Rig};
use crate::real::Real;

/// Largest number of triaxial sensors that the host accepts: its memory has room for any, its time not.
pub const HOST_SENSORS: usize = 8;
/// Largest number of hit DOFs that the host accepts, for the same reason.
pub const HOST_HITS: usize = 24;

/// The layout in the precision and capacity of the rig.
pub type RigLayout = Layout<f32, Rig>;
/// The layout in the precision and capacity of the host.
#[cfg(any(test, feature = "alloc"))]
pub type HostLayout = Layout<f64, Unbounded>;

/// A triaxial accelerometer on the object.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Sensor<R> {
    /// Number of the node that it is glued to.
    pub node: u16,
    /// Position in the body frame, m.
    pub position: [R; 3],
    /// The sensor's x, y and z axis as unit vectors in the body frame: row `a` is axis `a`, so this is `Rᵀ`
    /// of theory, section 1.
    pub axes: [[R; 3]; 3],
    /// False for sensors that do not sense gravity (laser, camera).
    pub senses_gravity: bool,
    /// Uncertainty of mounting and calibration.
    pub uncertainty: SensorUncertainty<R>,
    /// Standard deviations that a calibration supplies, because none are stated.
    pub calibrated: CalibratedGains,
}

/// Which standard deviations of a sensor a calibration supplies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct CalibratedGains {
    /// [`SensorUncertainty::gain`].
    pub gain: bool,
    /// [`SensorUncertainty::cross_axis`].
    pub cross_axis: bool,
}

/// A degree of freedom that the hammer excites.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Hit<R> {
    /// Name of the DOF, `node:±axis`.
    pub dof: Dof,
    /// Point of action in the body frame, m.
    pub position: [R; 3],
    /// Unit vector along which the force on the body acts, body frame.
    pub direction: [R; 3],
    /// Uncertainty of position and direction.
    pub uncertainty: HitUncertainty<R>,
}

/// Sensors, hits and settings of one test.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(
    feature = "serde",
    serde(bound(
        serialize = "R: serde::Serialize, C::Sensors<Sensor<R>>: serde::Serialize, C::Hits<Hit<R>>: serde::Serialize",
        deserialize = "R: serde::Deserialize<'de>, C::Sensors<Sensor<R>>: serde::Deserialize<'de>, \
                       C::Hits<Hit<R>>: serde::Deserialize<'de>"
    ))
)]
pub struct Layout<R: Real, C: Capacity> {
    /// Free text.
    pub title: String<48>,
    /// Gravity in the body frame of the suspended object, m/s², if given.
    pub gravity: Option<[R; 3]>,
    /// The sensors, in the order of the rig's channels.
    pub sensors: C::Sensors<Sensor<R>>,
    /// The hits, in the order of the campaign.
    pub hits: C::Hits<Hit<R>>,
    /// How the test is run.
    pub test: TestSettings<R>,
    /// Uncertainty of hammer, converter and gravity.
    pub apparatus: ApparatusUncertainty<R>,
    /// True when a calibration supplies the uncertainty of the hammer's gain, because none is stated.
    pub calibrated_hammer: bool,
    /// True when the error budget is a prior that the data may correct (theory, section 12); otherwise it is
    /// used as stated.
    pub learn_budget: bool,
    /// The precision that the user wants.
    pub target: Target<R>,
    /// Prior knowledge of the object.
    pub priors: Vec<Prior<R>, 10>,
    /// Bodies attached to the object, which are subtracted from the result.
    pub attached: Vec<AttachedBody<R>, MAX_ATTACHED>,
}

impl<R: Real> Sensor<R> {
    /// A sensor that senses gravity, with the default uncertainty.
    pub fn new(node: u16, position: [R; 3], axes: [[R; 3]; 3]) -> Self {
        let uncertainty = SensorUncertainty::default();
        let calibrated = CalibratedGains::default();
        Self { node, position, axes, senses_gravity: true, uncertainty, calibrated }
    }
}

impl<R: Real> Hit<R> {
    /// A hit with the default uncertainty.
    pub fn new(dof: Dof, position: [R; 3], direction: [R; 3]) -> Self {
        Self { dof, position, direction, uncertainty: HitUncertainty::default() }
    }
}

impl<R: Real, C: Capacity> Default for Layout<R, C> {
    /// A layout without sensors and hits.
    fn default() -> Self {
        Self {
            title: String::new(),
            gravity: None,
            sensors: Default::default(),
            hits: Default::default(),
            test: TestSettings::default(),
            apparatus: ApparatusUncertainty::default(),
            calibrated_hammer: false,
            learn_budget: true,
            target: Target::default(),
            priors: Vec::new(),
            attached: Vec::new(),
        }
    }
}

impl<R: Real, C: Capacity> Layout<R, C> {
    /// The same layout in another precision and capacity; `None` when it does not fit.
    pub fn cast<Q: Real, D: Capacity>(&self) -> Option<Layout<Q, D>> {
        let to = |v: R| Q::of(v.to_f64());
        let mut sensors = D::Sensors::default();
        for s in self.sensors.iter() {
            let sensor = Sensor {
                node: s.node,
                position: s.position.map(to),
                axes: s.axes.map(|axis| axis.map(to)),
                senses_gravity: s.senses_gravity,
                uncertainty: s.uncertainty.cast(),
                calibrated: s.calibrated,
            };
            sensors.push(sensor).ok()?;
        }
        let mut hits = D::Hits::default();
        for h in self.hits.iter() {
            let hit = Hit {
                dof: h.dof,
                position: h.position.map(to),
                direction: h.direction.map(to),
                uncertainty: h.uncertainty.cast(),
            };
            hits.push(hit).ok()?;
        }
        Some(Layout {
            title: self.title.clone(),
            gravity: self.gravity.map(|g| g.map(to)),
            sensors,
            hits,
            test: self.test.cast(),
            apparatus: self.apparatus.cast(),
            calibrated_hammer: self.calibrated_hammer,
            learn_budget: self.learn_budget,
            target: self.target.cast(),
            priors: self.priors.iter().map(Prior::cast).collect(),
            attached: self.attached.iter().map(AttachedBody::cast).collect(),
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::body::RigidBody;
    use nalgebra::SVector;

    /// Node positions of the three-bar frame of theory, section 11.
    const NODES: [[f64; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [0.207_850_606_8, -0.199_018_578_2, 0.0],
        [0.207_850_606_8, 0.0, 0.0],
        [0.207_850_606_8, -0.199_018_578_2, 0.149_130_815_1],
    ];

    /// The frame's ten properties.
    pub(crate) fn bar_body() -> RigidBody<f64> {
        RigidBody::from_theta(&SVector::from([
            1.23, 0.169, -0.089, 0.020, 0.011134, 0.006762, 0.013942, 0.004253, -0.000956, 0.002706,
        ]))
    }

    /// Test 1 of the frame: sensors on nodes 1, 2, 3; hits 1Y, 2Z, 4X.
    pub(crate) fn bar_layout() -> Layout<f64, Rig> {
        let dofs = [("1:+Y", 1), ("2:+Z", 2), ("4:+X", 0)];
        Layout {
            gravity: Some([0.0, 0.0, -9.80665]),
            sensors: (0..3).map(|i| sensor(i as u16 + 1, NODES[i])).collect(),
            hits: dofs
                .iter()
                .map(|&(name, axis)| {
                    let dof: Dof = name.parse().unwrap();
                    let mut direction = [0.0; 3];
                    direction[axis] = 1.0;
                    let position = NODES[usize::from(dof.node) - 1];
                    Hit::new(dof, position, direction)
                })
                .collect(),
            ..Layout::default()
        }
    }

    /// A sensor along the body's axes.
    pub(crate) fn sensor(node: u16, position: [f64; 3]) -> Sensor<f64> {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        Sensor::new(node, position, axes)
    }
}
