//! What a person sees of a tumble test: which face comes down next, and how the sensors lie at the moment.

use massline_shared::calibration::tumble::Position;
use nalgebra::Vector3;

/// The view of a tumble test.
#[derive(Clone, Debug, Default)]
pub struct Positions {
    /// Those that are still to be read.
    pub(super) wanted: Vec<Position>,
    /// The one that is to be read now.
    pub(super) now: Option<Position>,
    /// How each sensor lies at the moment.
    pub(super) lies: Vec<SensorOrientation>,
    /// Whether the zeros of the sensors are known, so that one reading tells how a sensor lies.
    pub(super) is_calibrated: bool,
    /// True while the reading is taken that counts.
    pub(super) reading: bool,
    /// The last note.
    pub(super) note: String,
}

/// How a sensor lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorOrientation {
    /// What it reads, in its own axes, g.
    pub reads: Vector3<f64>,
    /// Whether it moves.
    pub moves: bool,
}

impl Positions {
    /// A test of which these positions are still wanted.
    pub fn new(wanted: &[Position], is_calibrated: bool) -> Self {
        Self { wanted: wanted.to_vec(), is_calibrated, ..Self::default() }
    }

    /// Asks for a position.
    pub fn ask(&mut self, position: Position) {
        self.now = Some(position);
        self.reading = false;
    }

    /// Takes how the sensors lie at the moment.
    pub fn lies(&mut self, lies: Vec<SensorOrientation>) {
        self.lies = lies;
    }

    /// The reading that counts begins.
    pub fn read(&mut self) {
        self.reading = true;
    }

    /// A position has been read.
    pub fn done(&mut self, position: Position) {
        self.wanted.retain(|wanted| *wanted != position);
        self.note = format!("{position} read");
    }
}

/// What a person is to do.
pub fn in_words(position: Position) -> String {
    let [axis, way] = axis_and_way(position);
    format!(
        "turn the block so that the {axis} axes of all sensors point {way}, let go, and press Enter"
    )
}

/// The same for a small terminal.
pub(super) fn briefly(position: Position) -> String {
    let [axis, way] = axis_and_way(position);
    format!("{position}: {axis} axes of all sensors {way}, then press Enter")
}

/// `X` and `up` for `+X`.
fn axis_and_way(position: Position) -> [&'static str; 2] {
    let (sign, axis) = position.name().split_at(1);
    [axis, if sign == "+" { "up" } else { "down" }]
}
