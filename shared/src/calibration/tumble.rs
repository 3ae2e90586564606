//! The tumble test: a triaxial sensor is held still in six positions, each axis up and down.
//!
//! An accelerometer that does not move reads `g` along the axis that points up. With `V±a` the output for
//! axis `a` up and down,
//!
//! ```text
//! S e_a = (V+a − V−a) / 2g        zero_k = (V+k + V−k)_k / 2
//! ```
//! A small tilt of a position changes the readings of the two other axes, but that of its own axis only in
//! second order. So zero and sensitivity of an axis are computed from its own two positions, and the tilts
//! appear in the six midpoints `(V+a + V−a)_k / 2 − zero_k`, `k ≠ a`, which are zero for level positions: 18
//! numbers, 12 unknowns.

#[cfg(test)]
mod fixture;
mod readings;
mod rest_record;

use core::f64::consts::FRAC_1_SQRT_2;
use core::fmt;
use core::str::FromStr;

use heapless::Vec;
use nalgebra::{Matrix3, Vector3};

use crate::layout::{Axis, Sign};
use crate::real::Real;
use crate::signal::Calibration;

pub use readings::{RestVoltages, SensorProblem, Tumble, TumbleTest};
pub use rest_record::RestHum;

/// Position of the sensors: the axis that points up or down.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Position {
    /// Plus when the axis points up, minus when it points down.
    pub sign: Sign,
    /// The axis.
    pub axis: Axis,
}

impl Position {
    /// The six positions in the order in which the user is asked for them.
    pub const ALL: [Self; 6] = [
        Self { sign: Sign::Plus, axis: Axis::X },
        Self { sign: Sign::Minus, axis: Axis::X },
        Self { sign: Sign::Plus, axis: Axis::Y },
        Self { sign: Sign::Minus, axis: Axis::Y },
        Self { sign: Sign::Plus, axis: Axis::Z },
        Self { sign: Sign::Minus, axis: Axis::Z },
    ];

    /// Unit vector that points up, in sensor axes.
    pub fn up<R: Real>(self) -> Vector3<R> {
        Vector3::ith(self.axis.index(), R::of(self.sign.factor()))
    }

    /// Its name: `+X` when x points up, `-X` when it points down.
    pub fn name(self) -> &'static str {
        match (self.sign, self.axis) {
            (Sign::Plus, Axis::X) => "+X",
            (Sign::Minus, Axis::X) => "-X",
            (Sign::Plus, Axis::Y) => "+Y",
            (Sign::Minus, Axis::Y) => "-Y",
            (Sign::Plus, Axis::Z) => "+Z",
            (Sign::Minus, Axis::Z) => "-Z",
        }
    }
}

impl fmt::Display for Position {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The text is none of `+X`, `-X`, `+Y`, `-Y`, `+Z`, `-Z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PositionError;

impl fmt::Display for PositionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a position is +X, -X, +Y, -Y, +Z or -Z")
    }
}

impl core::error::Error for PositionError {}

impl FromStr for Position {
    type Err = PositionError;

    fn from_str(text: &str) -> Result<Self, PositionError> {
        let named = Self::ALL.into_iter().find(|p| p.name().eq_ignore_ascii_case(text.trim()));
        named.ok_or(PositionError)
    }
}

/// Output of the three channels of a sensor in one position, V.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorVoltages<R> {
    /// The position that the user was asked for.
    pub position: Position,
    /// Mean over the scans.
    pub mean: Vector3<R>,
    /// Standard deviation of the scans.
    pub deviation: Vector3<R>,
    /// Standard deviation of the mean.
    pub sigma: Vector3<R>,
}

/// Cutoff of the low-pass before the converter, Hz. It makes consecutive scans dependent.
const CUTOFF_HZ: f64 = Calibration::RC_CUTOFF.0;

/// Standard deviation of the mean of `scans` codes with the standard deviation `deviation` at `rate` in Hz.
///
/// The low-pass correlates the scans. The noise dithers the rounding to codes, whose remaining error is
/// `e^(−2π²σ²)/π` of a code (Widrow and Kollár, Quantization Noise, 2008).
///
/// ```
/// # use massline_shared::calibration::tumble::sigma_of_mean;
/// // 2048 scans at 4 kS/s that deviate by two codes: correlated, so more than 2/√2048.
/// let sigma: f64 = sigma_of_mean(2.0, 2048, 4000.0);
/// assert!(1.0 < sigma / (2.0 / 2048_f64.sqrt()) && sigma < 0.1);
/// ```
pub fn sigma_of_mean<R: Real>(deviation: R, scans: u32, rate: R) -> R {
    let memory = (R::of(-core::f64::consts::TAU * CUTOFF_HZ) / rate).exp();
    let correlated = (R::one() + memory) / (R::one() - memory);
    let noise = deviation * (correlated / R::of(f64::from(scans.max(1)))).sqrt();
    let pi = R::of(core::f64::consts::PI);
    let blurred = pi * deviation;
    let rounding = (R::of(-2.0) * blurred * blurred).exp() / pi;
    (noise * noise + rounding * rounding).sqrt()
}

/// Limits for the check of the readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TumbleLimits<R> {
    /// Local acceleration of gravity, m/s².
    pub gravity: R,
    /// Nominal sensitivity from the data sheet, V/(m/s²).
    pub sensitivity: R,
    /// Largest standard deviation of the scans of a sensor that does not move, m/s².
    pub unrest: R,
    /// Largest midpoint error of level positions, rad.
    pub tilt: R,
    /// Largest relative deviation of a reading's length from 1 g.
    pub length: R,
}

impl<R: Real> Default for TumbleLimits<R> {
    /// Values for an ADXL326 under standard gravity: its noise is 0.08 m/s², a level table and a square block
    /// are level to 5 mrad, and sensitivities are within 10 %.
    fn default() -> Self {
        let g = crate::units::STANDARD_GRAVITY;
        Self {
            gravity: R::of(g),
            sensitivity: R::of(crate::signal::Calibration::ADXL326_VOLT_PER_G / g),
            unrest: R::of(0.3),
            tilt: R::of(0.02),
            length: R::of(0.3),
        }
    }
}

/// Why a set of readings is not a valid tumble test.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TumbleProblem<R> {
    /// A position is missing.
    Missing(Position),
    /// A position was read twice.
    Repeated(Position),
    /// A reading is not finite.
    NotFinite(Position),
    /// The sensor moved.
    NotAtRest {
        /// The position.
        position: Position,
        /// Largest standard deviation of the three channels, m/s².
        deviation: R,
    },
    /// The reading fits another position: the sensor was not turned, was turned the wrong way, or two of its
    /// cables are swapped.
    ReadsAs {
        /// The position that the user was asked for.
        position: Position,
        /// The position that the reading fits.
        like: Position,
    },
    /// The length of the reading is far from 1 g: a channel is not connected, or the sensor is of another
    /// type.
    WrongLength {
        /// The position.
        position: Position,
        /// Length of the reading, in units of g.
        length: R,
    },
}

/// Room for every problem that six readings can have.
pub type TumbleProblems<R> = Vec<TumbleProblem<R>, 12>;

/// Zero and sensitivity of a triaxial sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorSensitivity<R> {
    /// Output at zero acceleration, V.
    pub zero: Vector3<R>,
    /// Standard deviation of the zero, V.
    pub zero_sigma: Vector3<R>,
    /// S in V/(m/s²): row `k` is the output of channel `k` for a unit acceleration along each axis.
    pub sensitivity: Matrix3<R>,
    /// Standard deviation of each element, V/(m/s²).
    pub sensitivity_sigma: Matrix3<R>,
    /// Root mean square tilt of the positions about each of two axes, from the six midpoints, rad.
    pub tilt: R,
    /// The axis whose two positions are tilted most, and the angle, rad.
    pub worst: (Axis, R),
}

impl<R: Real> SensorSensitivity<R> {
    /// True when the six positions were level within the limit.
    pub fn is_level(&self, limits: &TumbleLimits<R>) -> bool {
        self.worst.1 <= limits.tilt
    }

    /// Largest relative standard deviation of a sensitivity.
    pub fn relative_gain_sigma(&self) -> R {
        let relative = |k: usize| (self.sensitivity_sigma[(k, k)] / self.sensitivity[(k, k)]).abs();
        relative(0).max(relative(1)).max(relative(2))
    }

    /// Largest standard deviation of a cross-axis sensitivity over the sensitivity of its channel.
    pub fn relative_cross_axis_sigma(&self) -> R {
        let mut largest = R::zero();
        for (row, column) in OFF_DIAGONAL {
            let relative = self.sensitivity_sigma[(row, column)] / self.sensitivity[(row, row)];
            largest = largest.max(relative.abs());
        }
        largest
    }
}

/// Row and column of the cross-axis elements of a 3 × 3 matrix, row by row.
pub const OFF_DIAGONAL: [(usize, usize); 6] = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)];

/// Zero (V) and sensitivity (V/(m/s²), 3 × 3) of one sensor from its readings in the six positions, in any
/// order, by the formulas at the top of the module. Theory, section 9.
///
/// # Errors
/// All problems of the readings. Tilted positions are not an error: see [`SensorSensitivity::is_level`].
///
/// ```
/// # use massline_shared::calibration::tumble::*;
/// # use massline_shared::nalgebra::Vector3;
/// // 1.5 V at zero acceleration, 57 mV per g, 1 % cross-axis sensitivity of x to y.
/// let reading = |position: Position| {
///     let up: Vector3<f64> = position.up();
///     let read = Vector3::new(up.x + 0.01 * up.y, up.y, up.z) * 0.057;
///     let (deviation, sigma) = (Vector3::repeat(1e-4), Vector3::repeat(1e-6));
///     SensorVoltages { position, mean: read + Vector3::repeat(1.5), deviation, sigma }
/// };
/// let limits = TumbleLimits::default();
/// let six = Position::ALL.map(reading);
/// let sensor = solve(&six, &limits).unwrap();
/// assert!((sensor.zero - Vector3::repeat(1.5)).norm() < 1e-12);
/// assert!((sensor.sensitivity[(0, 0)] - 0.057 / limits.gravity).abs() < 1e-12);
/// assert!((sensor.sensitivity[(0, 1)] / sensor.sensitivity[(0, 0)] - 0.01).abs() < 1e-12);
/// // Five positions are no tumble test.
/// assert_eq!(solve(&six[1..], &limits).unwrap_err()[0], TumbleProblem::Missing(Position::ALL[0]));
/// ```
pub fn solve<R: Real>(
    readings: &[SensorVoltages<R>],
    limits: &TumbleLimits<R>,
) -> Result<SensorSensitivity<R>, TumbleProblems<R>> {
    let mut problems = TumbleProblems::new();
    let mut six = [None; 6];
    for (place, position) in six.iter_mut().zip(Position::ALL) {
        let mut matching_readings = readings.iter().filter(|r| r.position == position);
        *place = matching_readings.next();
        if place.is_none() {
            note(&mut problems, TumbleProblem::Missing(position));
        } else if matching_readings.next().is_some() {
            note(&mut problems, TumbleProblem::Repeated(position));
        }
    }
    let [Some(a), Some(b), Some(c), Some(d), Some(e), Some(f)] = six else {
        return Err(problems);
    };
    let six = [a, b, c, d, e, f];
    check(&six, limits, &mut problems);
    if problems.is_empty() { Ok(fit(&six, limits.gravity)) } else { Err(problems) }
}

/// Checks one reading as soon as it has been taken: its numbers must be finite and the sensor must not have
/// moved.
///
/// # Errors
/// [`TumbleProblem::NotFinite`] and [`TumbleProblem::NotAtRest`].
pub fn check_reading<R: Real>(
    reading: &SensorVoltages<R>,
    limits: &TumbleLimits<R>,
) -> Result<(), TumbleProblem<R>> {
    let position = reading.position;
    let numbers = reading.mean.iter().chain(&reading.deviation).chain(&reading.sigma);
    if !numbers.into_iter().all(|v| v.finite()) {
        return Err(TumbleProblem::NotFinite(position));
    }
    let deviation = reading.deviation.amax() / limits.sensitivity;
    if deviation > limits.unrest {
        return Err(TumbleProblem::NotAtRest { position, deviation });
    }
    Ok(())
}

fn note<R: Real>(problems: &mut TumbleProblems<R>, problem: TumbleProblem<R>) {
    // There is room for two problems in each of the six positions.
    let _ = problems.push(problem);
}

/// Checks each reading by its distance from the mean of all six. The mean is the zero when all readings are
/// right, and a third of g from it when one is wrong.
fn check<R: Real>(
    six: &[&SensorVoltages<R>; 6],
    limits: &TumbleLimits<R>,
    problems: &mut TumbleProblems<R>,
) {
    let unsound = six.iter().filter_map(|reading| check_reading(reading, limits).err());
    unsound.for_each(|problem| note(problems, problem));
    if !problems.is_empty() {
        return;
    }
    let center = six.iter().fold(Vector3::zeros(), |sum, r| sum + r.mean) / R::of(6.0);
    let scale = R::one() / (limits.sensitivity * limits.gravity);
    for reading in six {
        let position = reading.position;
        let up = (reading.mean - center) * scale;
        let axis = up.iamax();
        let sign = if up[axis] < R::zero() { Sign::Minus } else { Sign::Plus };
        let like = Position { sign, axis: Axis::ALL[axis] };
        let length = up.norm();
        if like != position {
            note(problems, TumbleProblem::ReadsAs { position, like });
        } else if (length - R::one()).abs() > limits.length {
            note(problems, TumbleProblem::WrongLength { position, length });
        }
    }
}

fn fit<R: Real>(six: &[&SensorVoltages<R>; 6], gravity: R) -> SensorSensitivity<R> {
    let half = R::of(0.5);
    let mut zero = Vector3::zeros();
    let mut noise = Matrix3::zeros();
    let mut sensitivity = Matrix3::zeros();
    let mut midpoints = Matrix3::zeros();
    for axis in 0..3 {
        let (plus, minus) = (six[2 * axis], six[2 * axis + 1]);
        sensitivity.set_column(axis, &((plus.mean - minus.mean) * (half / gravity)));
        midpoints.set_column(axis, &((plus.mean + minus.mean) * half));
        let both = plus.sigma.zip_map(&minus.sigma, |a, b| (a * a + b * b).sqrt() * half);
        noise.set_column(axis, &both);
        zero[axis] = midpoints[(axis, axis)];
    }
    // Common tilt of the two positions of an axis (column) towards another axis (row).
    let mut angles = Matrix3::zeros();
    for (row, column) in OFF_DIAGONAL {
        let volts = midpoints[(row, column)] - zero[row];
        angles[(row, column)] = volts / (sensitivity[(row, row)] * gravity);
    }
    // The mean of two tilts has half the variance of one.
    let tilt = (angles.norm_squared() * R::of(2.0 / 6.0)).sqrt();
    let mut worst = (Axis::X, R::zero());
    for axis in Axis::ALL {
        let angle = angles.column(axis.index()).norm();
        if angle > worst.1 {
            worst = (axis, angle);
        }
    }
    let mut sensitivity_sigma = noise / gravity;
    let mut zero_sigma = noise.diagonal();
    for k in 0..3 {
        let own = sensitivity[(k, k)].abs();
        let cross = (sensitivity.row(k).norm_squared() - own * own).max(R::zero()).sqrt();
        // A tilt reduces the reading of its own axis in second order and adds gravity through the cross-axis
        // sensitivity.
        let through = cross * tilt * R::of(FRAC_1_SQRT_2);
        add_in_square(&mut sensitivity_sigma[(k, k)], own * tilt * tilt);
        add_in_square(&mut sensitivity_sigma[(k, k)], through);
        add_in_square(&mut zero_sigma[k], through * gravity);
    }
    for (row, column) in OFF_DIAGONAL {
        let own = sensitivity[(row, row)].abs();
        let sigma = &mut sensitivity_sigma[(row, column)];
        add_in_square(sigma, own * tilt * R::of(FRAC_1_SQRT_2));
    }
    SensorSensitivity { zero, zero_sigma, sensitivity, sensitivity_sigma, tilt, worst }
}

fn add_in_square<R: Real>(sigma: &mut R, other: R) {
    *sigma = (*sigma * *sigma + other * other).sqrt();
}

#[cfg(test)]
mod tests;
