//! The block test: a hanging block of known mass, hit through its centre of mass.
//!
//! A hit through the centre of mass gives every point of the block the same acceleration, `a = F/m`. So the
//! mass line accelerance times the mass is the response of a sensor to a unit acceleration over that of the
//! hammer to a unit force, relative to the calibration in use: the unit matrix when that calibration is
//! right. A hit whose line of action passes the centre of mass at a distance δ adds a rotation, which a
//! sensor at the distance `r` from the centre reads as `δ r / k²` of `a`, with `k` the radius of gyration.
//! This error changes from hit to hit, so it averages out and appears in the scatter. Mount the sensors near
//! the centre of mass to keep it small.
//!
//! Depending on what is known of the sensors, the test gives:
//!
//! * [`sensor_ratios`]: the 3 × 3 matrix of a sensor against the hammer. The direction error of the hits
//!   enters its cross-axis elements: 30 mrad / √5 for five hits.
//! * [`force_ratio`]: the hammer alone, when the sensitivity of the sensors is known from a tumble test. The
//!   length of the acceleration is `|F|/m` in any direction, so the direction of the hits does not matter.

use core::fmt;

use nalgebra::{Matrix3, Vector3};

use crate::capacity::Capacity;
use crate::identify::MassLines;
use crate::real::Real;
use crate::responses::Responses;

/// The block of known mass.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockMass<R> {
    /// Mass with everything that is glued to the block, kg.
    pub mass: R,
    /// Standard deviation of the mass, kg.
    pub sigma: R,
}

/// The hits along one direction and the readings of the sensors.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockHit<R: Real, C: Capacity> {
    /// Unit vector of the force in the frame of the block.
    pub direction: Vector3<R>,
    /// Mass lines with the calibration in use, (m/s²)/N.
    pub lines: MassLines<R, C>,
}

/// Why a block test gives no calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockError {
    /// Fewer than two hits along a direction: without scatter there is no standard deviation.
    TooFewHits,
    /// The hits do not cover three independent directions.
    DirectionsMissing,
    /// A number is NaN or infinite, or the mass is not positive.
    NotFinite,
    /// A sensor does not respond: its accelerance is nearly zero.
    Dead {
        /// The sensor, 0-based.
        sensor: usize,
    },
}

impl fmt::Display for BlockError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewHits => f.write_str(
                "a direction has fewer than two hits, so their scatter is not known: hit each \
                 direction five times",
            ),
            Self::DirectionsMissing => f.write_str(
                "the hits do not cover three independent directions: hit along x, y and z",
            ),
            Self::NotFinite => {
                f.write_str("a mass line is not a number, or the mass is not positive")
            }
            Self::Dead { sensor } => write!(f, "sensor {} does not answer to the hits", sensor + 1),
        }
    }
}

impl core::error::Error for BlockError {}

/// Sensitivity of a sensor against the hammer, relative to the calibration in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorRatio<R> {
    /// Row `k` is the reading of channel `k` for a unit acceleration along each of the sensor's axes. The
    /// unit matrix when the calibration in use is right.
    pub ratio: Matrix3<R>,
    /// Standard deviation of each element, from the scatter of the hits and the uncertainty of the mass.
    pub sigma: Matrix3<R>,
}

/// Sensitivity of the hammer against sensors of known sensitivity, relative to the calibration in use.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceRatio<R> {
    /// True force over the force computed with the calibration in use: divide the hammer's sensitivity by it.
    pub ratio: R,
    /// Standard deviation of the ratio.
    pub sigma: R,
    /// Departure from the mean of the direction whose departure is the largest in units of its standard
    /// deviation, and that standard deviation.
    pub departure: (R, R),
}

impl<R: Real> ForceRatio<R> {
    /// False when one direction contradicts the others: the sensitivity of a sensor is not the stated one, or
    /// hits did not pass through the centre of mass.
    pub fn is_consistent(&self) -> bool {
        // Four standard deviations, which are themselves estimated from a dozen numbers.
        self.departure.0 <= self.departure.1 * R::of(4.0)
    }
}

/// Ratio matrix, 3 × 3, of sensor `sensor` (0-based), whose axes are the rows of `axes` in the frame of the
/// block: least squares over all hits. Theory, section 9.
///
/// # Errors
/// See [`BlockError`].
///
/// ```
/// # use massline_shared::capacity::Fixed;
/// # use massline_shared::calibration::block::{BlockHit, BlockMass, sensor_ratios};
/// # use massline_shared::identify::MassLines;
/// # use massline_shared::nalgebra::Vector3;
/// # use massline_shared::responses::Responses;
/// // 2 kg, hit along x, y and z; channel x of the sensor reads 3 % too much.
/// let hits = [0, 1, 2].map(|axis| {
///     let direction: Vector3<f64> = Vector3::ith(axis, 1.0);
///     let read = direction.component_mul(&Vector3::new(1.03, 1.0, 1.0)) / 2.0;
///     let lines = MassLines::without_scatter(Responses::<f64, Fixed<1, 1>>::from([read.into()]));
///     BlockHit { direction, lines: MassLines { hits: 5, ..lines } }
/// });
/// let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let block = BlockMass { mass: 2.0, sigma: 0.002 };
/// let estimate = sensor_ratios(&hits, 0, &axes, block)?;
/// assert!((estimate.ratio[(0, 0)] - 1.03).abs() < 1e-12 && estimate.ratio[(0, 1)].abs() < 1e-12);
/// // The mass is known to 0.1 %.
/// assert!((estimate.sigma[(1, 1)] - 0.001).abs() < 1e-12);
/// assert!(sensor_ratios(&hits[..2], 0, &axes, block).is_err());
/// # Ok::<(), massline_shared::calibration::block::BlockError>(())
/// ```
pub fn sensor_ratios<R: Real, C: Capacity>(
    hits: &[BlockHit<R, C>],
    sensor: usize,
    axes: &[[R; 3]; 3],
    block: BlockMass<R>,
) -> Result<SensorRatio<R>, BlockError> {
    if !hits.iter().flat_map(|hit| &hit.direction).all(|v| v.finite()) {
        return Err(BlockError::NotFinite);
    }
    check(hits.iter().map(|hit| &hit.lines), block)?;
    let axes = Matrix3::from_fn(|row, column| axes[row][column]);
    // X U = m A by least squares over the hits, U the forces in sensor axes: X = m A Uᵀ (U Uᵀ)⁻¹.
    let mut normal = Matrix3::zeros();
    for hit in hits {
        let push = axes * hit.direction;
        normal += push * push.transpose();
    }
    let inverse = invert(&normal).ok_or(BlockError::DirectionsMissing)?;
    let mut ratio = Matrix3::<R>::zeros();
    let mut variance = Matrix3::<R>::zeros();
    for hit in hits {
        let weights = inverse * (axes * hit.direction) * block.mass;
        let count = R::of(f64::from(hit.lines.hits));
        for row in 0..3 {
            let channel = 3 * sensor + row;
            let read =
                hit.lines.accelerance.as_slice().get(channel).copied().unwrap_or_else(R::zero);
            let known = channel < hit.lines.scatter.rows();
            let scatter =
                if known { hit.lines.scatter[(channel, channel)] } else { R::zero() } / count;
            for column in 0..3 {
                ratio[(row, column)] += read * weights[column];
                variance[(row, column)] += scatter * weights[column] * weights[column];
            }
        }
    }
    if ratio.diagonal().iter().any(|v| v.abs() < R::of(DEAD)) {
        return Err(BlockError::Dead { sensor });
    }
    let of_mass = block.sigma / block.mass;
    let sigma = variance.zip_map(&ratio, |v, r| (v + r * r * of_mass * of_mass).sqrt());
    Ok(SensorRatio { ratio, sigma })
}

/// A sensor whose response is below this share of the expected one is not connected.
const DEAD: f64 = 0.05;

/// The force ratio from the lengths of the accelerations that the first `sensors` sensors read.
///
/// Directions are weighted by the inverse of their scatter, so those whose position errors rotate the centre
/// of the sensors least count most. Each length is the root mean square over the hits,
/// `|Ā|² + tr(scatter) (n − 1)/n`, so the scatter of a direction does not shorten it. Theory, section 9.
///
/// # Errors
/// See [`BlockError`]. The directions may be any, so they are not passed in.
///
/// ```
/// # use massline_shared::capacity::Fixed;
/// # use massline_shared::calibration::block::{BlockMass, force_ratio};
/// # use massline_shared::identify::MassLines;
/// # use massline_shared::responses::Responses;
/// // The hammer reads 2 % too little, so every accelerance is 2 % too large, whatever its direction.
/// let accelerance = &Responses::<f64, Fixed<1, 1>>::from([[0.6, 0.8, 0.0]]) * (1.02 / 2.0);
/// let lines = MassLines { hits: 5, ..MassLines::without_scatter(accelerance) };
/// let estimate = force_ratio([&lines; 3].into_iter(), 1, BlockMass { mass: 2.0, sigma: 0.002 })?;
/// assert!((estimate.ratio - 1.02).abs() < 1e-12 && estimate.is_consistent());
/// # Ok::<(), massline_shared::calibration::block::BlockError>(())
/// ```
pub fn force_ratio<'a, R: Real, C: Capacity>(
    hits: impl Iterator<Item = &'a MassLines<R, C>> + Clone,
    sensors: usize,
    block: BlockMass<R>,
) -> Result<ForceRatio<R>, BlockError> {
    check(hits.clone(), block)?;
    let room = hits.clone().map(|lines| lines.accelerance.sensors()).min().unwrap_or(0);
    if sensors == 0 || sensors > room {
        return Err(BlockError::DirectionsMissing);
    }
    let floor = R::of(FLOOR * FLOOR);
    let (mut weights, mut sum) = (R::zero(), R::zero());
    for hit in hits.clone() {
        let (ratio, variance) = mean_ratio(hit, sensors, block.mass)?;
        let weight = R::one() / (variance + floor);
        weights += weight;
        sum += ratio * weight;
    }
    let mean = sum / weights;
    let mut noise = R::zero();
    let mut departure = (R::zero(), R::one());
    for hit in hits {
        let (ratio, variance) = mean_ratio(hit, sensors, block.mass)?;
        let weight = R::one() / (variance + floor);
        noise += variance * weight * weight / (weights * weights);
        let (off, allowed) = ((ratio - mean).abs(), (variance + floor).sqrt());
        if off * departure.1 > departure.0 * allowed {
            departure = (off, allowed);
        }
    }
    let of_mass = mean * block.sigma / block.mass;
    let sigma = (noise + floor + of_mass * of_mass).sqrt();
    Ok(ForceRatio { ratio: mean, sigma, departure })
}

/// Relative error that does not average out over the hits: sensor positions, filters, suspension.
const FLOOR: f64 = 1e-3;

/// Mass times the length of the accelerance of one direction, averaged over the sensors, and the variance of
/// that mean.
fn mean_ratio<R: Real, C: Capacity>(
    lines: &MassLines<R, C>,
    sensors: usize,
    mass: R,
) -> Result<(R, R), BlockError> {
    let MassLines { accelerance, scatter, hits, .. } = lines;
    let count = R::of(f64::from(*hits));
    let share = R::one() / R::of(sensors as f64);
    let mut along = Responses::<R, C>::zeros(accelerance.sensors());
    let mut sum = R::zero();
    for sensor in 0..sensors {
        let channels = 3 * sensor..3 * sensor + 3;
        let mut square = R::zero();
        let mut spread = R::zero();
        for k in channels.clone() {
            square += accelerance[k] * accelerance[k];
            spread += scatter[(k, k)];
        }
        let length = square.sqrt();
        if length <= R::zero() {
            return Err(BlockError::Dead { sensor });
        }
        for k in channels {
            along[k] = accelerance[k] / length * share;
        }
        sum += (square + spread * (count - R::one()) / count).sqrt() * share;
    }
    let variance = along.dot(&scatter.times(&along)) / count;
    Ok((sum * mass, variance.max(R::zero()) * mass * mass))
}

fn check<'a, R: Real, C: Capacity>(
    mut hits: impl Iterator<Item = &'a MassLines<R, C>> + Clone,
    block: BlockMass<R>,
) -> Result<(), BlockError> {
    let sound = block.mass.finite() && block.mass > R::zero() && block.sigma.finite();
    let finite = |lines: &MassLines<R, C>| {
        lines.accelerance.iter().chain(lines.scatter.as_slice()).all(|v| v.finite())
    };
    if !sound || !hits.clone().all(finite) {
        return Err(BlockError::NotFinite);
    }
    if hits.any(|lines| lines.hits < 2) {
        return Err(BlockError::TooFewHits);
    }
    Ok(())
}

/// The inverse of the normal matrix; `None` when the directions are nearly coplanar.
fn invert<R: Real>(normal: &Matrix3<R>) -> Option<Matrix3<R>> {
    let size = normal.trace();
    let inverse = normal.try_inverse()?;
    // Three orthogonal directions give 9; a direction within 6° of the plane of the others gives 300.
    (inverse.trace() * size < R::of(300.0)).then_some(inverse)
}

#[cfg(test)]
mod tests;
