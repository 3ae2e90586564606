//! A checked bench: what all other modules read.

use massline_shared::body::RigidBody;
use massline_shared::signal::RESPONSES;
use nalgebra::Vector3;

use crate::body;
use crate::locate::BenchFileError;
use crate::settings::{
    AdcSettings, ElasticMode, EnvironmentSettings, ErrorsFrom, Fault, HammerSettings,
    MainsSettings, Node, OperatorSettings, SensorSettings, SupplySettings, TapSettings,
};
use crate::sprung_part::SprungPart;
use crate::suspension::{self, Suspension, SuspensionError};

/// Frequencies of the suspension of a rigid object over the highest: three translations, three rotations. No two are
/// equal, as on cords.
const RELATIVE_FREQUENCIES: [f64; 6] = [0.38, 0.45, 0.9, 0.55, 0.72, 1.0];
/// Its fraction of critical damping, that of the default bench.
const RIGID_DAMPING_RATIO: f64 = 0.01;

/// A checked bench.
#[derive(Clone, Debug, PartialEq)]
pub struct Bench {
    /// Free text.
    pub title: String,
    /// Acceleration of gravity in the body frame as suspended, m/s².
    pub gravity: Vector3<f64>,
    /// Tilt of the object, and so of gravity in its frame, about each axis across gravity, 1 σ, rad; drawn once for
    /// each test.
    pub gravity_tilt_sigma_rad: f64,
    /// What says how large the errors of sensors, hits, hammer and gravity are.
    pub errors: ErrorsFrom,
    /// The object.
    pub body: RigidBody<f64>,
    /// How the object hangs.
    pub suspension: Suspension,
    /// The part of the object that is on springs of its own, if there is one; the object includes it, and the
    /// sensors and hits are on the rest.
    pub sprung_part: Option<SprungPart>,
    /// Nodes at which the motion in the elastic modes is defined.
    pub nodes: Vec<Node>,
    /// Elastic modes of the free object.
    pub elastic: Vec<ElasticMode>,
    /// The accelerometers.
    pub sensor: SensorSettings,
    /// The hammer.
    pub hammer: HammerSettings,
    /// The converter.
    pub adc: AdcSettings,
    /// The hum of the mains in the channels.
    pub mains: MainsSettings,
    /// The supply of sensors and converter.
    pub supply: SupplySettings,
    /// What moves the object besides the hammer.
    pub environment: EnvironmentSettings,
    /// Properties of good taps.
    pub tap: TapSettings,
    /// Frequency of bad taps, and timing.
    pub operator: OperatorSettings,
    /// Number of the mounting of the sensors: with another number the same sensors have other errors of
    /// position and rotation.
    pub mounting: u16,
    /// Mistakes made in setting up the test.
    pub faults: Vec<Fault>,
}

/// Why a bench cannot be made, or why a layout cannot be measured on it.
#[derive(Debug, thiserror::Error)]
pub enum BenchError {
    /// The file has invalid content.
    #[error(transparent)]
    File(#[from] BenchFileError),
    /// No bundled bench has this name.
    #[error("there is no bench named {name:?}; the bundled ones are {bundled}")]
    UnknownName {
        /// The name.
        name: String,
        /// The names of the bundled benches.
        bundled: String,
    },
    /// The object cannot hang as described.
    #[error(transparent)]
    Suspension(#[from] SuspensionError),
    /// The layout has more sensors than the rig has channels.
    #[error("the layout has {0} triaxial sensors, the rig takes {max}", max = RESPONSES / 3)]
    TooManySensors(usize),
    /// The layout uses a node at which the motion in the elastic modes is not defined.
    #[error(
        "the bench does not know how node {0} moves in its elastic modes: give it a [[node]] and a \
         shape in every [[elastic_mode]], or write elastic_mode = []"
    )]
    NodeWithoutShape(u16),
    /// No object has these properties.
    #[error(
        "no object has these properties: the mass must be positive and the inertia about the centre of mass must \
         satisfy the triangle inequality"
    )]
    NoSuchBody,
    /// A fault refers to something that the layout does not have.
    #[error(
        "{fault}: there is no such {missing}; sensors and hits are counted from 1 in the order of the layout"
    )]
    FaultWithoutSubject {
        /// The fault.
        fault: Fault,
        /// What does not exist.
        missing: &'static str,
    },
    /// The layout has a node at another position than the bench.
    #[error(
        "node {node} lies at {layout:?} m in the layout and at {bench:?} m on the bench, whose \
         elastic modes are known there only"
    )]
    NodeElsewhere {
        /// The node.
        node: u16,
        /// Its position in the layout, m.
        layout: [f64; 3],
        /// Its position on the bench, m.
        bench: [f64; 3],
    },
}

impl Bench {
    /// The true properties of the object, in the body frame of the layouts.
    pub fn truth(&self) -> RigidBody<f64> {
        self.body
    }

    pub(crate) fn node(&self, id: u16) -> Option<&Node> {
        self.nodes.iter().find(|n| n.id == id)
    }

    /// The same measuring chain with a rigid object of these properties instead, whose highest suspension mode has the
    /// frequency `highest_hz`. Any point of it can be hit or carry a sensor.
    ///
    /// # Errors
    /// When no object has these properties, or it cannot hang.
    pub fn with_rigid_body(
        self,
        body: RigidBody<f64>,
        highest_hz: f64,
    ) -> Result<Self, BenchError> {
        if !body::is_physical(&body) {
            return Err(BenchError::NoSuchBody);
        }
        let hz = RELATIVE_FREQUENCIES.map(|relative| relative * highest_hz);
        let suspension = Suspension::Frequencies { hz, damping_ratio: RIGID_DAMPING_RATIO };
        suspension::rigid_modes(&body, &suspension, &self.gravity)?;
        Ok(Self {
            title: "rigid body".into(),
            body,
            suspension,
            sprung_part: None,
            nodes: Vec::new(),
            elastic: Vec::new(),
            ..self
        })
    }
}
