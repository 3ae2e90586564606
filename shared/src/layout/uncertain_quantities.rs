//! What a test does not know exactly, one quantity after the other, to see what each does to an answer.

use nalgebra::{Matrix3, Vector3};

use super::{Layout, MAX_ATTACHED, TestProfile};
use crate::capacity::Capacity;
use crate::real::Real;

/// Uncertain quantities of one sensor: nine sensitivities row by row, three rotations, three displacements.
pub const SENSOR_QUANTITIES: usize = 15;
/// Number of sensitivities, the first quantities of a sensor.
const SENSITIVITIES: usize = 9;
/// Uncertain quantities of gravity: two rotations across its direction.
pub const GRAVITY_QUANTITIES: usize = 2;
/// Uncertain quantities of one hit DOF: two displacements and two rotations across its direction, and its length.
pub const HIT_QUANTITIES: usize = 5;

/// A quantity of the layout that is not known exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UncertainQuantity {
    /// One of the [`SENSOR_QUANTITIES`] of a sensor.
    Sensor {
        /// Index of the sensor.
        index: usize,
        /// Which one.
        quantity: usize,
    },
    /// One of the [`GRAVITY_QUANTITIES`] of gravity.
    Gravity(usize),
    /// One of the [`HIT_QUANTITIES`] of a hit DOF.
    Hit {
        /// Index of the hit.
        index: usize,
        /// Which one.
        quantity: usize,
    },
    /// The gain of the hammer.
    Hammer,
    /// The mass of an attached body.
    Attached(usize),
    /// A known property of the object.
    Prior(usize),
}

impl<R: Real, C: Capacity> Layout<R, C> {
    /// Every uncertain quantity, sensor by sensor, gravity, hit by hit, then the hammer, the attached bodies and the
    /// priors.
    pub fn uncertain_quantities(&self) -> impl Iterator<Item = UncertainQuantity> + use<R, C> {
        let of_sensors = (0..self.sensors.len()).flat_map(|index| {
            (0..SENSOR_QUANTITIES)
                .map(move |quantity| UncertainQuantity::Sensor { index, quantity })
        });
        let of_hits = (0..self.hits.len()).flat_map(|index| {
            (0..HIT_QUANTITIES).map(move |quantity| UncertainQuantity::Hit { index, quantity })
        });
        let attached = (0..self.attached.len().min(MAX_ATTACHED)).map(UncertainQuantity::Attached);
        let priors = (0..self.priors.len()).map(UncertainQuantity::Prior);
        let of_gravity = (0..GRAVITY_QUANTITIES).map(UncertainQuantity::Gravity);
        let hammer = [UncertainQuantity::Hammer];
        of_sensors.chain(of_gravity).chain(of_hits).chain(hammer).chain(attached).chain(priors)
    }

    /// Shifts the layout by one standard deviation of a quantity, to first order. The deviation of a hit is that of the
    /// mean of [`hits_per_dof`](super::TestSettings::hits_per_dof) hits. Returns false when the quantity has none.
    pub fn shift(&mut self, quantity: UncertainQuantity) -> bool {
        match quantity {
            UncertainQuantity::Sensor { index, quantity } => self.shift_sensor(index, quantity),
            UncertainQuantity::Gravity(quantity) => {
                let change = self.gravity_slopes()[quantity % GRAVITY_QUANTITIES];
                if let Some(gravity) = &mut self.gravity {
                    gravity.iter_mut().zip(change.iter()).for_each(|(g, change)| *g += *change);
                }
                change != Vector3::zeros() && self.senses_gravity()
            }
            UncertainQuantity::Hit { index, quantity } => self.shift_hit(index, quantity),
            UncertainQuantity::Hammer => {
                let gain = self.force_gain();
                for hit in self.hits.iter_mut() {
                    // It reads too much, so the force is smaller.
                    hit.direction = hit.direction.map(|v| v * (R::one() - gain));
                }
                gain != R::zero()
            }
            UncertainQuantity::Attached(index) => {
                let Some(body) = self.attached.get_mut(index) else { return false };
                let sigma = body.relative_sigma;
                body.phi = body.phi.map(|v| v * (R::one() + sigma));
                sigma != R::zero()
            }
            UncertainQuantity::Prior(index) => {
                let Some(prior) = self.priors.get_mut(index) else { return false };
                prior.value += prior.sigma;
                prior.sigma != R::zero()
            }
        }
    }

    /// Change of gravity with one standard deviation of each of its rotations, m/s²; zero without gravity.
    pub(crate) fn gravity_slopes(&self) -> [Vector3<R>; GRAVITY_QUANTITIES] {
        let gravity = Vector3::from(self.gravity.unwrap_or([R::zero(); 3]));
        let Some(direction) = gravity.try_normalize(R::zero()) else {
            return [Vector3::zeros(); GRAVITY_QUANTITIES];
        };
        across(&direction)
            .map(|across| across * (gravity.norm() * self.apparatus.gravity_direction))
    }

    /// Relative standard deviation of the hammer's gain against the sensors: `hammer_gain`, and in the
    /// suspension profile, whose responses are a few codes, also the converter's (`converter_gain`).
    pub fn force_gain(&self) -> R {
        match self.test.profile {
            TestProfile::MassLine => self.apparatus.hammer_gain,
            TestProfile::Suspension => {
                self.apparatus.hammer_gain.hypot(self.apparatus.converter_gain)
            }
        }
    }

    fn shift_sensor(&mut self, index: usize, quantity: usize) -> bool {
        let Some(sensor) = self.sensors.get_mut(index) else { return false };
        let uncertainty = sensor.uncertainty;
        let axes = sensor.axes_matrix();
        let (turned, sigma) = match quantity {
            0..SENSITIVITIES => {
                let (to, from) = (quantity / 3, quantity % 3);
                let sigma = if to == from { uncertainty.gain } else { uncertainty.cross_axis };
                let mut gains = Matrix3::<R>::identity();
                gains[(to, from)] += sigma;
                (gains * axes, sigma)
            }
            9..12 => {
                let sigma = uncertainty.rotation;
                let mut turn = Vector3::zeros();
                turn[quantity - SENSITIVITIES] = sigma;
                // A reading r of the sensor turns into r + r × ω.
                (axes - crate::linalg::skew(&turn) * axes, sigma)
            }
            _ => {
                let sigma = uncertainty.position;
                if let Some(coordinate) = sensor.position.get_mut(quantity - 12) {
                    *coordinate += sigma;
                }
                (axes, sigma)
            }
        };
        sensor.axes = core::array::from_fn(|i| core::array::from_fn(|j| turned[(i, j)]));
        sigma != R::zero()
    }

    fn shift_hit(&mut self, index: usize, quantity: usize) -> bool {
        let hits = u16::from(self.test.hits_per_dof);
        let Some(hit) = self.hits.get_mut(index) else { return false };
        let (position, direction) = hit.uncertainty.of_mean(hits);
        if quantity == HIT_QUANTITIES - 1 {
            let sigma = hit.uncertainty.second_order(hits).0.hypot(self.apparatus.hit_gain);
            hit.direction = hit.direction.map(|v| v * (R::one() + sigma));
            return sigma != R::zero();
        }
        let [first, second] = across(&Vector3::from(hit.direction));
        let axis = if quantity.is_multiple_of(2) { first } else { second };
        let (to, sigma) = if quantity < 2 {
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::bar_layout;

    #[test]
    fn responses_of_a_few_codes_have_the_gain_of_the_converter_as_well() {
        let mut layout = bar_layout();
        layout.apparatus.hammer_gain = 0.003;
        assert_eq!(layout.force_gain(), 0.003);
        layout.test.profile = TestProfile::Suspension;
        // 3 and 5 parts of a thousand; rounding.
        assert!((layout.force_gain() - 34_f64.sqrt() * 1e-3).abs() < 1e-15);
        let mut linear = layout.clone();
        linear.apparatus.converter_gain = 0.0;
        assert_eq!(linear.force_gain(), 0.003);
        let mut shifted = layout.clone();
        assert!(shifted.shift(UncertainQuantity::Hammer));
        let force = Vector3::from(shifted.hits[0].direction).norm();
        assert!((force - (1.0 - layout.force_gain())).abs() < 1e-12, "{force}");
    }

    /// What a shift does to every response row and unit force, by finite differences of what the budget says.
    #[test]
    fn a_shift_is_one_standard_deviation_of_what_it_names() {
        let layout = bar_layout();
        for quantity in layout.uncertain_quantities() {
            let mut shifted = layout.clone();
            let changes = shifted.shift(quantity);
            match quantity {
                UncertainQuantity::Sensor { index, quantity } => {
                    let [old, new] = [&layout.sensors[index], &shifted.sensors[index]];
                    let axes = (new.axes_matrix() - old.axes_matrix()).norm();
                    let moved = (Vector3::from(new.position) - Vector3::from(old.position)).norm();
                    let budget = old.uncertainty;
                    let expected = match quantity {
                        0 | 4 | 8 => [budget.gain, 0.0],
                        0..SENSITIVITIES => [budget.cross_axis, 0.0],
                        // Two of three axes turn.
                        9..12 => [budget.rotation * 2_f64.sqrt(), 0.0],
                        _ => [0.0, budget.position],
                    };
                    assert!((axes - expected[0]).abs() < 1e-12, "{quantity}: {axes}");
                    assert!((moved - expected[1]).abs() < 1e-12, "{quantity}: {moved}");
                    assert_eq!(changes, expected != [0.0; 2]);
                }
                UncertainQuantity::Gravity(_) => {
                    let [old, new] =
                        [&layout, &shifted].map(|layout| Vector3::from(layout.gravity.unwrap()));
                    let moved = (new - old).norm();
                    assert!(
                        (moved - 9.80665 * layout.apparatus.gravity_direction).abs() < 1e-12,
                        "{moved}"
                    );
                    assert!(moved > 0.1 && (new - old).dot(&old).abs() < 1e-12 && changes);
                }
                UncertainQuantity::Hit { index, quantity } => {
                    let [old, new] = [&layout.hits[index], &shifted.hits[index]];
                    let change = |a: [f64; 3], b: [f64; 3]| Vector3::from(a) - Vector3::from(b);
                    let moved = change(new.position, old.position);
                    let turned = change(new.direction, old.direction);
                    let (position, direction) =
                        old.uncertainty.of_mean(u16::from(layout.test.hits_per_dof));
                    if quantity == HIT_QUANTITIES - 1 {
                        // Half a per cent, and the squares of the angles of five hits (theory, section 12).
                        let longer = Vector3::from(new.direction).norm() - 1.0;
                        assert!((0.005..0.006).contains(&longer), "{longer}");
                        assert!(changes && moved.norm() == 0.0);
                        continue;
                    }
                    let expected = if quantity < 2 { [position, 0.0] } else { [0.0, direction] };
                    assert!((moved.norm() - expected[0]).abs() < 1e-12, "{quantity}: {moved}");
                    assert!((turned.norm() - expected[1]).abs() < 1e-12, "{quantity}: {turned}");
                    // Along the hit, a shift changes nothing.
                    let along = Vector3::from(old.direction);
                    assert!(moved.dot(&along).abs() < 1e-12 && turned.dot(&along).abs() < 1e-12);
                }
                UncertainQuantity::Hammer => {
                    let force = Vector3::from(shifted.hits[0].direction).norm();
                    assert!(
                        (force - (1.0 - layout.apparatus.hammer_gain)).abs() < 1e-12,
                        "{force}"
                    );
                }
                UncertainQuantity::Attached(_) | UncertainQuantity::Prior(_) => {
                    unreachable!("the frame has none")
                }
            }
        }
    }
}
