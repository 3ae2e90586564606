//! What hits from opposite sides of a block show of the electronics.
//!
//! A rigid body answers a hit from the other side with the opposite acceleration, so half the sum of both
//! accelerances holds nothing that is linear in the motion: no gain, no cross-axis sensitivity, no rotated sensor.
//! What remains is
//!
//! ```text
//! (A₊ + A₋)/2 = errors of the hits: t₁, t₂ across the direction, α × r
//!             + e u/m             the sensors answer pushes along +u more strongly by the share 2 e
//!             + κ s_F S⁻¹ e_c     the channel c, converted after the hammer, keeps the share κ of its voltage
//! ```
//! with the sensitivity s_F of the hammer and S of the sensor, and m the mass. The force has one sign whatever the
//! side, which tells κ from all motions. Six unknowns of each direction and κ are fitted to the readings of at least
//! three sensors, of which the second term leaves at least two over.
//!
//! κ is the memory of the multiplexer. e is its even nonlinearity near the level at rest: a converter, buffer or
//! sensor whose slope above that level differs from the slope below it.

use heapless::Vec;
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};

use super::block::BlockHit;
use crate::capacity::Capacity;
use crate::estimated::EstimatedValue;
use crate::layout::Sensor;
use crate::real::Real;
use crate::responses::Responses;
use crate::signal::{Calibration, HAMMER};

/// Unknowns of one direction: two accelerations across it, three angular accelerations, the asymmetry.
const UNKNOWNS: usize = 6;
/// Place of the asymmetry among them.
const ASYMMETRY: usize = 5;
/// Largest number of directions.
const DIRECTIONS: usize = 3;
/// Smallest part of a column that the columns before it may leave, squared; with less it is not determined.
const INDEPENDENT: f64 = 1e-3;
/// Cosine beyond which two directions are opposite.
const OPPOSITE: f64 = 0.99;

/// The block, its sensors, and the calibration in force.
#[derive(Clone, Copy, Debug)]
pub struct Setup<'a, R> {
    /// The sensors, whose positions are relative to the centre of mass.
    pub sensors: &'a [Sensor<R>],
    /// Mass of the block, kg.
    pub mass: R,
    /// The calibration in force during the hits.
    pub calibration: &'a Calibration,
    /// The channel that is converted after the hammer's by the same converter; `None` when no sensor's is.
    pub after_hammer: Option<usize>,
}

/// What opposite hits show.
#[derive(Clone, Debug, PartialEq)]
pub struct OppositeHits<R> {
    /// Share of the hammer's voltage that remains in the channel converted after it.
    pub memory: Option<EstimatedValue<R>>,
    /// Response to pushes along a direction over that to pushes against it, minus one; by direction.
    pub asymmetry: Vec<(Vector3<R>, EstimatedValue<R>), DIRECTIONS>,
}

/// One direction: the half sum of both sides.
struct Pair<R: Real, C: Capacity> {
    direction: Vector3<R>,
    sum: Responses<R, C>,
}

/// Evaluates the hits of a block test. `None` when fewer than three sensors were hit from opposite sides, or their
/// places do not tell the terms apart.
pub fn opposite_hits<R: Real, C: Capacity>(
    hits: &[BlockHit<R, C>],
    setup: &Setup<'_, R>,
) -> Option<OppositeHits<R>> {
    let count = setup.sensors.len();
    let room = hits.iter().map(|hit| hit.lines.accelerance.sensors()).min().unwrap_or(0);
    if count < 3 || count > room || setup.mass <= R::zero() {
        return None;
    }
    let pairs = pairs(hits);
    let kept = setup.after_hammer.and_then(|channel| kept_column(setup, channel));
    // κ from each direction alone, combined by the information that each has on it.
    let (mut weights, mut sum) = (R::zero(), R::zero());
    for pair in &pairs {
        if let Some(column) = kept
            && let Some((value, information)) = memory_of(pair, setup, &column)
        {
            weights += information;
            sum += information * value;
        }
    }
    let memory = (weights > R::zero()).then(|| sum / weights);
    let mut asymmetry: Vec<(Vector3<R>, EstimatedValue<R>), DIRECTIONS> = Vec::new();
    let (mut square, mut freedom) = (R::zero(), 0);
    for pair in &pairs {
        let known = memory.zip(kept);
        let Some((value, variance, left)) = asymmetry_of(pair, setup, known) else { continue };
        square += left;
        freedom += 3 * count - UNKNOWNS;
        let two = R::of(2.0);
        let estimated = EstimatedValue { value: two * value, sigma: two * variance.sqrt() };
        // There are at most as many pairs as places.
        let _ = asymmetry.push((pair.direction, estimated));
    }
    let freedom = freedom.checked_sub(usize::from(memory.is_some()))?;
    if freedom == 0 || asymmetry.is_empty() {
        return None;
    }
    // The readings scatter about the fit as they do, whatever the cause.
    let noise = (square / R::of(freedom as f64)).sqrt();
    asymmetry.iter_mut().for_each(|(_, estimate)| estimate.sigma *= noise);
    let memory = memory.map(|value| EstimatedValue { value, sigma: noise / weights.sqrt() });
    let finite = |estimate: &EstimatedValue<R>| estimate.value.finite() && estimate.sigma.finite();
    let sound = memory.iter().chain(asymmetry.iter().map(|(_, estimate)| estimate)).all(finite);
    sound.then_some(OppositeHits { memory, asymmetry })
}

/// The directions that were hit from both sides.
fn pairs<R: Real, C: Capacity>(hits: &[BlockHit<R, C>]) -> Vec<Pair<R, C>, DIRECTIONS> {
    let mut pairs = Vec::new();
    for (k, one) in hits.iter().enumerate() {
        let opposite = hits
            .iter()
            .skip(k + 1)
            .find(|two| one.direction.dot(&two.direction) < R::of(-OPPOSITE));
        if let Some(two) = opposite {
            let mut sum = one.lines.accelerance.clone();
            sum += &two.lines.accelerance;
            sum *= R::of(0.5);
            // A fourth direction is left out.
            let _ = pairs.push(Pair { direction: one.direction, sum });
        }
    }
    pairs
}

/// The sensor of the channel after the hammer's, and what its axes read for κ = 1, (m/s²)/N.
fn kept_column<R: Real>(setup: &Setup<'_, R>, channel: usize) -> Option<(usize, Vector3<R>)> {
    let response = channel.checked_sub(1)?;
    let (sensor, axis) = (response / 3, response % 3);
    if sensor >= setup.sensors.len() {
        return None;
    }
    let inverse = setup.calibration.sensor_sensitivity(sensor).try_inverse()?;
    let hammer = f64::from(setup.calibration.channels[HAMMER].sensitivity);
    Some((sensor, (inverse.column(axis) * hammer).map(R::of)))
}

/// The rows of a sensor's three readings.
fn rows<R: Real>(
    setup: &Setup<'_, R>,
    sensor: &Sensor<R>,
    along: &Vector3<R>,
) -> SMatrix<R, 3, UNKNOWNS> {
    let axes = Matrix3::from_fn(|row, column| sensor.axes[row][column]);
    let place = Vector3::from(sensor.position);
    let first = across(along);
    let second = along.cross(&first);
    // Angular accelerations as those of points at a usual distance, so that all columns are of one size.
    let arm =
        setup.sensors.iter().fold(R::of(1e-6), |sum, s| sum + Vector3::from(s.position).norm())
            / R::of(setup.sensors.len() as f64);
    let turned = |axis: usize| Vector3::ith(axis, R::one() / arm).cross(&place);
    let columns = [first, second, turned(0), turned(1), turned(2), along / setup.mass];
    SMatrix::from_columns(&columns.map(|column| axes * column))
}

/// A unit vector across another.
fn across<R: Real>(along: &Vector3<R>) -> Vector3<R> {
    let least = Vector3::ith(along.iamin(), R::one());
    least.cross(along).normalize()
}

/// κ from one direction and its information, both for readings of unit noise. `None` when the direction does not
/// determine it.
fn memory_of<R: Real, C: Capacity>(
    pair: &Pair<R, C>,
    setup: &Setup<'_, R>,
    (follower, column): &(usize, Vector3<R>),
) -> Option<(R, R)> {
    const ALL: usize = UNKNOWNS + 1;
    let mut normal = SMatrix::<R, ALL, ALL>::zeros();
    let mut right = SVector::<R, ALL>::zeros();
    for (k, sensor) in setup.sensors.iter().enumerate() {
        let mut of_sensor = SMatrix::<R, 3, ALL>::zeros();
        of_sensor.fixed_columns_mut::<UNKNOWNS>(0).copy_from(&rows(setup, sensor, &pair.direction));
        if k == *follower {
            of_sensor.set_column(UNKNOWNS, column);
        }
        normal += of_sensor.transpose() * of_sensor;
        right += of_sensor.transpose() * Vector3::from(pair.sum.of_sensor(k));
    }
    let factor = normal.cholesky()?;
    // κ is the last unknown, so the last element of the factor is what the others leave of its column.
    let left = factor.l_dirty()[(UNKNOWNS, UNKNOWNS)];
    let information = left * left;
    let enough = information > normal[(UNKNOWNS, UNKNOWNS)] * R::of(INDEPENDENT);
    enough.then(|| (factor.solve(&right)[UNKNOWNS], information))
}

/// The asymmetry of one direction, its variance for readings of unit noise, and the sum of the squared residuals.
/// `known` is κ with its column.
fn asymmetry_of<R: Real, C: Capacity>(
    pair: &Pair<R, C>,
    setup: &Setup<'_, R>,
    known: Option<(R, (usize, Vector3<R>))>,
) -> Option<(R, R, R)> {
    let mut normal = SMatrix::<R, UNKNOWNS, UNKNOWNS>::zeros();
    let mut right = SVector::<R, UNKNOWNS>::zeros();
    let mut square = R::zero();
    for (k, sensor) in setup.sensors.iter().enumerate() {
        let of_sensor = rows(setup, sensor, &pair.direction);
        let mut read = Vector3::from(pair.sum.of_sensor(k));
        if let Some((memory, (_, column))) = known.filter(|(_, (follower, _))| *follower == k) {
            read -= column * memory;
        }
        normal += of_sensor.transpose() * of_sensor;
        right += of_sensor.transpose() * read;
        square += read.norm_squared();
    }
    let factor = normal.cholesky()?;
    let left = factor.l_dirty()[(ASYMMETRY, ASYMMETRY)];
    let information = left * left;
    if information <= normal[(ASYMMETRY, ASYMMETRY)] * R::of(INDEPENDENT) {
        return None;
    }
    let solved = factor.solve(&right);
    let residual = (square - solved.dot(&right)).max(R::zero());
    Some((solved[ASYMMETRY], R::one() / information, residual))
}

#[cfg(test)]
mod tests;
