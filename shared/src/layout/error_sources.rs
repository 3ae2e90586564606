//! The sources of error of a test one by one, to see what each does to an answer.

use nalgebra::{Matrix3, Vector3};

use super::{Layout, MAX_ATTACHED};
use crate::Real;

/// Sources of one sensor: nine sensitivities row by row, three rotations, three displacements.
pub const SENSOR_SOURCES: usize = 15;
/// Number of sensitivities, the first sources of a sensor.
const SENSITIVITIES: usize = 9;
/// Sources of one hit DOF: two displacements and two rotations across its direction.
pub const HIT_SOURCES: usize = 4;

/// A quantity of the layout that is not known exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorSource {
    /// One of the [`SENSOR_SOURCES`] of a sensor.
    Sensor {
        /// Index of the sensor.
        index: usize,
        /// Which one.
        source: usize,
    },
    /// One of the [`HIT_SOURCES`] of a hit DOF.
    Hit {
        /// Index of the hit.
        index: usize,
        /// Which one.
        source: usize,
    },
    /// The gain of the hammer.
    Hammer,
    /// The mass of an attached body.
    Attached(usize),
    /// A known property of the object.
    Prior(usize),
}

impl<R: Real, const S: usize, const H: usize> Layout<R, S, H> {
    /// Every source of error, sensor by sensor, hit by hit, then the hammer, the attached bodies and the priors.
    pub fn error_sources(&self) -> impl Iterator<Item = ErrorSource> + use<R, S, H> {
        let of_sensors = (0..self.sensors.len()).flat_map(|index| {
            (0..SENSOR_SOURCES).map(move |source| ErrorSource::Sensor { index, source })
        });
        let of_hits = (0..self.hits.len()).flat_map(|index| {
            (0..HIT_SOURCES).map(move |source| ErrorSource::Hit { index, source })
        });
        let attached = (0..self.attached.len().min(MAX_ATTACHED)).map(ErrorSource::Attached);
        let priors = (0..self.priors.len()).map(ErrorSource::Prior);
        of_sensors.chain(of_hits).chain([ErrorSource::Hammer]).chain(attached).chain(priors)
    }

    /// Shifts the layout by one standard deviation of a source, to first order. The deviation of a hit is that of the
    /// mean of [`hits_per_dof`](super::TestSettings::hits_per_dof) hits. Returns false when the source has none.
    pub fn shift(&mut self, source: ErrorSource) -> bool {
        match source {
            ErrorSource::Sensor { index, source } => self.shift_sensor(index, source),
            ErrorSource::Hit { index, source } => self.shift_hit(index, source),
            ErrorSource::Hammer => {
                let gain = self.hammer_gain;
                for hit in &mut self.hits {
                    // It reads too much, so the force is smaller.
                    hit.direction = hit.direction.map(|v| v * (R::one() - gain));
                }
                gain != R::zero()
            }
            ErrorSource::Attached(index) => {
                let Some(body) = self.attached.get_mut(index) else { return false };
                let sigma = body.relative_sigma;
                body.phi = body.phi.map(|v| v * (R::one() + sigma));
                sigma != R::zero()
            }
            ErrorSource::Prior(index) => {
                let Some(prior) = self.priors.get_mut(index) else { return false };
                prior.value += prior.sigma;
                prior.sigma != R::zero()
            }
        }
    }

    fn shift_sensor(&mut self, index: usize, source: usize) -> bool {
        let Some(sensor) = self.sensors.get_mut(index) else { return false };
        let uncertainty = sensor.uncertainty;
        let axes = sensor.axes_matrix();
        let (turned, sigma) = match source {
            0..SENSITIVITIES => {
                let (to, from) = (source / 3, source % 3);
                let sigma = if to == from { uncertainty.gain } else { uncertainty.cross_axis };
                let mut gains = Matrix3::<R>::identity();
                gains[(to, from)] += sigma;
                (gains * axes, sigma)
            }
            9..12 => {
                let sigma = uncertainty.rotation;
                let mut turn = Vector3::zeros();
                turn[source - SENSITIVITIES] = sigma;
                // A reading r of the sensor turns into r + r × ω.
                (axes - crate::linalg::skew(&turn) * axes, sigma)
            }
            _ => {
                let sigma = uncertainty.position;
                if let Some(coordinate) = sensor.position.get_mut(source - 12) {
                    *coordinate += sigma;
                }
                (axes, sigma)
            }
        };
        sensor.axes = core::array::from_fn(|i| core::array::from_fn(|j| turned[(i, j)]));
        sigma != R::zero()
    }

    fn shift_hit(&mut self, index: usize, source: usize) -> bool {
        let hits = u16::from(self.test.hits_per_dof);
        let Some(hit) = self.hits.get_mut(index) else { return false };
        let (position, direction) = hit.uncertainty.of_mean(hits);
        let [first, second] = across(&Vector3::from(hit.direction));
        let axis = if source.is_multiple_of(2) { first } else { second };
        let (to, sigma) = if source < 2 {
            (&mut hit.position, position)
        } else {
            (&mut hit.direction, direction)
        };
        to.iter_mut().zip(axis.iter()).for_each(|(v, along)| *v += *along * sigma);
        sigma != R::zero()
    }
}

/// Two unit vectors perpendicular to a direction and to each other, the first as near as possible to an axis.
pub(crate) fn across<R: Real>(direction: &Vector3<R>) -> [Vector3<R>; 2] {
    let axis = direction.iamin();
    let mut first = -direction * direction[axis];
    first[axis] += R::one();
    let first = first / first.norm();
    [first, direction.cross(&first)]
}
