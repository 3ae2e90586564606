//! Mistakes that a person makes in setting up a test, as text: `flip:2y`, `swap:1,2`, `hit:2:4`.
//!
//! An error is small and affects everything (see [`errors`](crate::errors)); a *fault* is one gross mistake.

use massline_shared::layout::Axis;
use serde::Deserialize;

mod text;

pub use text::FaultError;

/// One mistake; here sensors and hits are counted from 0.
///
/// As text, sensors and hits are counted from 1, in the order of the layout.
///
/// | text | what is wrong |
/// | --- | --- |
/// | `flip:2y` | the y axis of sensor 2 is reversed |
/// | `swap:1,2` | the cables of sensors 1 and 2 are swapped |
/// | `swap:2x,2z` | the wires of two axes of sensor 2 are swapped |
/// | `rotate:3:z90` | sensor 3 is glued turned about its z axis by 90° (also 180, -90) |
/// | `hit:2:4` | the second hit DOF is hit at node 4, in its own direction |
/// | `reverse:2` | the second hit DOF is hit from the other side |
/// | `scale:1.1` | all sensors read 10 % too much |
/// | `hammer:0.97` | the hammer reads 3 % too little |
/// | `beside:2:0.005` | all hits of the second hit DOF land 5 mm beside the mark, to a side that is drawn |
/// | `boards:0.005` | a board of 5 g that the layout does not declare moves with each sensor |
/// | `cable:2:400` | a cable pulls node 2 back with 400 N/m in every direction |
/// | `rail:2y:50` | the buffer of sensor 2 y ends at 50 m/s² from its value at rest |
/// | `rail:hammer:20` | the buffer of the hammer ends at 20 N |
/// | `compress:2y` | sensor 2 y compresses softly: it reads `R tanh(x/R)` with `R` its range |
/// | `hum:0.005` | the mains add 5 mV (50 Hz, or what `[mains]` says) to every channel |
/// | `node:4z:0.01` | node 4, with the sensor and the hits on it, lies 10 mm further along z than the layout says |
/// | `lean:2:0.08` | all hits of the second hit DOF lean by 80 mrad to a side that is drawn |
/// | `turn:0.05` | all hits of the test are turned by 50 mrad about an axis that is drawn |
/// | `height:0.004` | the chips of all sensors lie 4 mm above their marks, along their z axes |
/// | `drift:hammer:0.05` | the gain of the hammer rises by 5 % from the first hit of the test to the last |
/// | `drift:2y:0.05` | the gain of sensor 2 y does |
/// | `pad:0.01` | a pad of 10 g is on the mark that is being hit |
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(try_from = "String")]
pub enum Fault {
    /// An axis of a sensor is reversed.
    Flip {
        /// The sensor.
        sensor: usize,
        /// Its axis.
        axis: Axis,
    },
    /// The cables of two sensors are swapped.
    SwapSensors([usize; 2]),
    /// The wires of two axes of a sensor are swapped.
    SwapAxes {
        /// The sensor.
        sensor: usize,
        /// Its axes.
        axes: [Axis; 2],
    },
    /// A sensor is glued turned about one of its axes.
    Rotate {
        /// The sensor.
        sensor: usize,
        /// The axis that it is turned about.
        axis: Axis,
        /// The angle in quarter turns.
        quarters: i8,
    },
    /// The hits at a DOF land on another node.
    HitNode {
        /// The DOF.
        hit: usize,
        /// The node where they land.
        node: u16,
    },
    /// The hits at a DOF push in the opposite direction.
    HitReversed {
        /// The DOF.
        hit: usize,
    },
    /// All sensor readings are multiplied by this factor.
    Scale(f64),
    /// The reading of the hammer is multiplied by this factor.
    HammerScale(f64),
    /// All hits at a DOF land beside the mark, on a side that is drawn once.
    HitBeside {
        /// The DOF.
        hit: usize,
        /// How far from the mark, m.
        distance_m: f64,
    },
    /// A board moves with the object at every sensor; the layout does not declare it.
    BoardMass {
        /// Mass of each board, kg.
        mass_kg: f64,
    },
    /// A cable between a node and the ground acts as a spring in every direction.
    Cable {
        /// The node.
        node: u16,
        /// Its stiffness, N/m.
        stiffness_n_per_m: f64,
    },
    /// The buffer of a response channel saturates.
    SensorRail {
        /// The sensor that the channel is meant for.
        sensor: usize,
        /// Its axis.
        axis: Axis,
        /// Largest distance from the value at rest, m/s².
        limit_m_per_s2: f64,
    },
    /// The buffer of the hammer saturates.
    HammerRail {
        /// Largest distance from the value at rest, N.
        limit_n: f64,
    },
    /// A response channel compresses softly towards the sensor's range.
    Compression {
        /// The sensor that the channel is meant for.
        sensor: usize,
        /// Its axis.
        axis: Axis,
    },
    /// The mains add to every channel.
    Hum {
        /// Amplitude of the fundamental, V.
        amplitude_v: f64,
    },
    /// A node is not where the layout has it.
    NodeMisplaced {
        /// The node.
        node: u16,
        /// The coordinate that is wrong, body frame.
        axis: Axis,
        /// True minus written, m.
        distance_m: f64,
    },
    /// All hits at a DOF lean to a side that is drawn once.
    HitLeans {
        /// The DOF.
        hit: usize,
        /// The angle, rad.
        angle_rad: f64,
    },
    /// All hits of the test are turned about an axis of the body that is drawn once.
    HitsTurned {
        /// The angle, rad.
        angle_rad: f64,
    },
    /// The chips of all sensors lie above their marks, along their z axes.
    ChipsAboveMarks {
        /// How far, m.
        height_m: f64,
    },
    /// The gain of the hammer drifts.
    HammerDrift {
        /// Relative change from the first hit of the test to the last.
        change: f64,
    },
    /// The gain of a response channel drifts.
    ChannelDrift {
        /// The sensor that the channel is meant for.
        sensor: usize,
        /// Its axis.
        axis: Axis,
        /// Relative change from the first hit of the test to the last.
        change: f64,
    },
    /// A pad moves with the object at the mark that is being hit.
    Pad {
        /// Its mass, kg.
        mass_kg: f64,
    },
}
