//! The block test: a hanging block of known mass, hit through its centre of mass.
//!
//! A hit through the centre of mass moves every point of the block alike, `a = F/m`. So the mass line
//! accelerance times the mass is the response of a sensor to a unit acceleration over that of the
//! hammer to a unit force, as the calibration in force has them: the unit matrix when that calibration
//! is right. A hit that misses the centre of mass by δ adds a rotation, which a sensor at the distance
//! `r` from it feels as `δ r / k²` of `a`, `k` the radius of gyration; it changes from hit to hit, so
//! it averages out and is seen in the scatter. Hence: sensors near the centre of mass.
//!
//! Two things follow, depending on what is known of the sensors:
//!
//! * [`sensor_ratios`]: the 3 × 3 matrix of a sensor against the hammer. The direction of the hits
//!   enters its cross-axis elements, 30 mrad / √5 for five hits.
//! * [`force_ratio`]: with sensors whose sensitivity is known, from a tumble test, the hammer alone.
//!   Whatever way a hit goes, the length of the acceleration is `|F|/m`, so directions do not matter.

use core::fmt;

use nalgebra::{Matrix3, Vector3};

use crate::Real;
use crate::identify::MassLines;
use crate::responses::Responses;

/// The block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockMass<R> {
    /// With everything that is glued to it, kg.
    pub mass: R,
    /// Its standard deviation, kg.
    pub sigma: R,
}

/// The hits along one direction and what the sensors read of them.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockHit<R, const S: usize> {
    /// Unit vector of the push in the frame of the block.
    pub direction: Vector3<R>,
    /// Mass lines with the calibration in force, (m/s²)/N.
    pub lines: MassLines<R, S>,
}

/// Why a block test gives no calibration.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BlockError {
    /// Fewer than two hits along a direction: no scatter, so no standard deviation.
    TooFewHits,
    /// The hits do not cover three independent directions.
    DirectionsMissing,
    /// A number is NaN or infinite, or the mass is not positive.
    NotFinite,
    /// A sensor does not answer: its accelerance is zero.
    Dead {
        /// Which sensor, 0-based.
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
            Self::NotFinite => f.write_str("a mass line is no number, or the mass is not positive"),
            Self::Dead { sensor } => write!(f, "sensor {} does not answer to the hits", sensor + 1),
        }
    }
}

impl core::error::Error for BlockError {}

/// A sensor against the hammer, relative to the calibration in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SensorRatio<R> {
    /// Row `k`: what channel `k` reads of a unit acceleration along each of the sensor's axes. The
    /// unit matrix when the calibration in force is right.
    pub ratio: Matrix3<R>,
    /// Standard deviation of each element: scatter of the hits and mass of the block.
    pub sigma: Matrix3<R>,
}

/// The hammer against sensors whose sensitivity is known, relative to the calibration in force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceRatio<R> {
    /// True force over the force that the calibration in force makes of the hammer's output: the
    /// hammer's sensitivity is to be divided by it.
    pub ratio: R,
    /// Its standard deviation.
    pub sigma: R,
    /// The departure of the direction that is furthest from the mean for its standard deviation, and
    /// that deviation.
    pub departure: (R, R),
}

impl<R: Real> ForceRatio<R> {
    /// False when one direction contradicts the others: a sensor of other sensitivity than told, or
    /// hits that did not pass the centre of mass.
    pub fn is_consistent(&self) -> bool {
        // Four standard deviations, themselves estimated from a dozen numbers.
        self.departure.0 <= self.departure.1 * R::of(4.0)
    }
}

/// The ratio matrix, 3 × 3, of sensor `sensor` (0-based) whose axes are the rows of `axes` in the block's
/// frame: least squares over all hits. Theory, section 9.
///
/// # Errors
/// See [`BlockError`].
///
/// ```
/// # use massline_shared::calibration::block::{BlockHit, BlockMass, sensor_ratios};
/// # use massline_shared::identify::MassLines;
/// # use massline_shared::nalgebra::Vector3;
/// # use massline_shared::responses::Responses;
/// // 2 kg, hit along x, y and z; channel x of the sensor reads 3 % too much.
/// let hits = [0, 1, 2].map(|axis| {
///     let direction: Vector3<f64> = Vector3::ith(axis, 1.0);
///     let read = direction.component_mul(&Vector3::new(1.03, 1.0, 1.0)) / 2.0;
///     let lines = MassLines::without_scatter(Responses::<f64, 1>::from_column_slice(read.as_slice()));
///     BlockHit { direction, lines: MassLines { hits: 5, ..lines } }
/// });
/// let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let block = BlockMass { mass: 2.0, sigma: 0.002 };
/// let found = sensor_ratios(&hits, 0, &axes, block)?;
/// assert!((found.ratio[(0, 0)] - 1.03).abs() < 1e-12 && found.ratio[(0, 1)].abs() < 1e-12);
/// // The mass is known to 0.1 %.
/// assert!((found.sigma[(1, 1)] - 0.001).abs() < 1e-12);
/// assert!(sensor_ratios(&hits[..2], 0, &axes, block).is_err());
/// # Ok::<(), massline_shared::calibration::block::BlockError>(())
/// ```
pub fn sensor_ratios<R: Real, const S: usize>(
    hits: &[BlockHit<R, S>],
    sensor: usize,
    axes: &[[R; 3]; 3],
    block: BlockMass<R>,
) -> Result<SensorRatio<R>, BlockError> {
    if !hits.iter().flat_map(|hit| &hit.direction).all(|v| v.finite()) {
        return Err(BlockError::NotFinite);
    }
    check(hits.iter().map(|hit| &hit.lines), block)?;
    let axes = Matrix3::from_fn(|row, column| axes[row][column]);
    // X U = m A in least squares over the hits, U the pushes in sensor axes: X = m A Uᵀ (U Uᵀ)⁻¹.
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
            let read = hit.lines.accelerance.get(channel).copied().unwrap_or_else(R::zero);
            let scatter = hit.lines.scatter.diagonal().get(channel).copied();
            let scatter = scatter.unwrap_or_else(R::zero) / count;
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

/// A sensor that answers with less than this share of what it should is not connected.
const DEAD: f64 = 0.05;

/// The hammer from the lengths of the accelerations that the first `sensors` sensors read.
///
/// Directions are weighted by their scatter: those whose misses do not turn the sensors' middle count
/// most. The root mean square over the hits is taken of each length, `|Ā|² + tr(scatter) (n − 1)/n`, so
/// that directions which scatter do not shorten it. Theory, section 9.
///
/// # Errors
/// See [`BlockError`]; any direction will do, so the hits come without theirs.
///
/// ```
/// # use massline_shared::calibration::block::{BlockMass, force_ratio};
/// # use massline_shared::identify::MassLines;
/// # use massline_shared::responses::Responses;
/// // The hammer reads 2 % too little, so every accelerance is 2 % too large, whatever its direction.
/// let accelerance = Responses::<f64, 1>::from([[0.6, 0.8, 0.0]]) * (1.02 / 2.0);
/// let lines = MassLines { hits: 5, ..MassLines::without_scatter(accelerance) };
/// let found = force_ratio([&lines; 3].into_iter(), 1, BlockMass { mass: 2.0, sigma: 0.002 })?;
/// assert!((found.ratio - 1.02).abs() < 1e-12 && found.is_consistent());
/// # Ok::<(), massline_shared::calibration::block::BlockError>(())
/// ```
pub fn force_ratio<'a, R: Real, const S: usize>(
    hits: impl Iterator<Item = &'a MassLines<R, S>> + Clone,
    sensors: usize,
    block: BlockMass<R>,
) -> Result<ForceRatio<R>, BlockError> {
    check(hits.clone(), block)?;
    if hits.clone().next().is_none() || sensors == 0 || sensors > S {
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

/// What does not average out over the hits, relative: places of the sensors, filters, suspension.
const FLOOR: f64 = 1e-3;

/// Mass times the mean over the sensors of the length of the accelerance of one direction, and the
/// variance of that.
fn mean_ratio<R: Real, const S: usize>(
    lines: &MassLines<R, S>,
    sensors: usize,
    mass: R,
) -> Result<(R, R), BlockError> {
    let MassLines { accelerance, scatter, hits, .. } = lines;
    let count = R::of(f64::from(*hits));
    let share = R::one() / R::of(sensors as f64);
    let mut along = Responses::<R, S>::zeros();
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

fn check<'a, R: Real, const S: usize>(
    mut hits: impl Iterator<Item = &'a MassLines<R, S>> + Clone,
    block: BlockMass<R>,
) -> Result<(), BlockError> {
    let sound = block.mass.finite() && block.mass > R::zero() && block.sigma.finite();
    let finite = |lines: &MassLines<R, S>| {
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

/// The inverse of the normal matrix; `None` when its directions are nearly in one plane.
fn invert<R: Real>(normal: &Matrix3<R>) -> Option<Matrix3<R>> {
    let size = normal.trace();
    let inverse = normal.try_inverse()?;
    // Three orthogonal directions give 9; a direction within 6° of the plane of the others, 300.
    (inverse.trace() * size < R::of(300.0)).then_some(inverse)
}

#[cfg(test)]
mod tests;
