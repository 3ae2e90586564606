//! Modes from poles and residues.

use heapless::Vec;
use nalgebra::{Complex, Vector6};

use super::MOST_FORCES;
use super::origin_responses::OriginResponses;
use super::residues::{Residues, fit_residues};
use super::shapes::{best_force, norm_indicator_of_shape, shape_of_force, shape_of_forces};
use super::vector_fitting::{FIT_MEMORY, MOST_PAIRS, Poles, find_poles};
use crate::layout::balanced_motion;
use crate::real::Real;

/// A mode of a body on its suspension.
#[derive(Clone, Debug, PartialEq)]
pub struct Mode<R> {
    /// Natural frequency `|p|/2π`, Hz.
    pub frequency_hz: R,
    /// Damping ratio `−Re p/|p|`.
    pub damping_ratio: R,
    /// Mass-normalised shape at the reference point, `[x; θ]`, 1/√kg and 1/(m √kg).
    pub shape: Vector6<R>,
    /// `φ (φᵀ f)` of each force.
    pub residues: Vec<Vector6<R>, MOST_FORCES>,
    /// Norm of the imaginary parts of these residues relative to that of the real parts: zero when the damping is
    /// proportional to mass and stiffness.
    pub complexity: R,
    /// The common phase of these residues: the tangent of the angle by which all of them are turned. Other damping
    /// turns them to either side, a record that ends too early turns them alike.
    pub common_phase: R,
    /// What one shape leaves of the residues, relative to them, wherever the hits are: two modes that were taken for
    /// one have no common shape.
    pub second_shape: R,
}

/// The modes of a test, and what else the same fit says.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes<R> {
    /// The modes, in the order of their frequencies.
    pub modes: Vec<Mode<R>, MOST_PAIRS>,
    /// Their poles, 1/s.
    pub poles: Poles<R>,
    /// The rigid body's accelerance under each force, `[a; α]` per newton: the constant of the fit.
    pub rigid: Vec<Vector6<R>, MOST_FORCES>,
    /// Sum of the squared residuals of the fit, relative to the noise of a reading.
    pub residual: R,
}

impl<R: Real> Modes<R> {
    /// The modes of known poles, and the places of their poles: a pole at which no force excites a shape is left out.
    /// `None` when a force has no residues.
    pub fn of_poles(
        responses: &OriginResponses<'_, R>,
        poles: &Poles<R>,
    ) -> Option<(Self, Vec<usize, MOST_PAIRS>)> {
        let mut memory = [R::zero(); FIT_MEMORY];
        let residues = fit_residues(responses, poles, &mut memory)?;
        let rigid = (0..residues.forces()).map(|force| residues.constant(force)).collect();
        let mut modes =
            Self { modes: Vec::new(), poles: Vec::new(), rigid, residual: residues.left() };
        let mut places = Vec::new();
        for (place, pole) in poles.iter().enumerate() {
            if let Some(mode) = Mode::new(responses, &residues, place, *pole) {
                modes.modes.push(mode).ok()?;
                modes.poles.push(*pole).ok()?;
                places.push(place).ok()?;
            }
        }
        Some((modes, places))
    }

    /// The same with each shape from the force that shows the mode best, as Almeida, Maia and Urgueira choose it.
    /// `None` when a mode has no shape.
    pub fn of_best_forces(&self, responses: &OriginResponses<'_, R>) -> Option<Self> {
        let mut modes = self.clone();
        for mode in &mut modes.modes {
            let best = best_force(&mode.residues, responses.length);
            mode.shape = shape_of_force(mode.residues.get(best)?, responses.forces.get(best)?)?;
        }
        Some(modes)
    }

    /// The same with only the modes at these places, which are different, in this order.
    pub fn only(mut self, places: &[usize]) -> Self {
        // Where each mode was.
        let mut was: Vec<usize, MOST_PAIRS> = (0..self.modes.len()).collect();
        let mut kept = 0;
        for place in places {
            let Some(now) = was.iter().position(|original| original == place) else { continue };
            was.swap(kept, now);
            self.modes.swap(kept, now);
            self.poles.swap(kept, now);
            kept += 1;
        }
        self.first(kept)
    }

    /// The same with only the first modes.
    pub fn first(mut self, count: usize) -> Self {
        self.modes.truncate(count);
        self.poles.truncate(count);
        self
    }
}

/// Identifies this many modes. `None` when there are more forces than [`MOST_FORCES`], no poles or residues, or a mode
/// that no force excites.
pub fn identify_modes<R: Real>(
    responses: &OriginResponses<'_, R>,
    count: usize,
) -> Option<Modes<R>> {
    let (modes, places) = Modes::of_poles(responses, &find_poles(responses, count)?.poles)?;
    (places.len() == count).then_some(modes)
}

impl<R: Real> Mode<R> {
    /// The mode of the pole with this place, from the residues of all forces.
    fn new(
        responses: &OriginResponses<'_, R>,
        of_forces: &Residues<'_, R>,
        place: usize,
        pole: Complex<R>,
    ) -> Option<Self> {
        // 2 i ω r, which is real for proportional damping.
        let turned = |force: usize| {
            let residue = of_forces.of_pole(force, place);
            residue.map(|r| Complex::new(-r.im, r.re).scale(pole.im + pole.im))
        };
        let mut residues = Vec::<_, MOST_FORCES>::new();
        // Sums of the squares of the real and the imaginary parts, and of their products.
        let (mut real, mut imaginary, mut both) = (R::zero(), R::zero(), R::zero());
        for force in 0..of_forces.forces() {
            let turned = turned(force);
            let [re, im] = [turned.map(|z| z.re), turned.map(|z| z.im)];
            residues.push(re).ok()?;
            let [re, im] = [re, im].map(|part| balanced_motion(&part, responses.length));
            real += re.norm_squared();
            imaginary += im.norm_squared();
            both += re.dot(&im);
        }
        let shape = shape_of_forces(&residues, responses.forces, responses.length)?;
        let magnitude = pole.norm_sqr().sqrt();
        Some(Self {
            frequency_hz: magnitude / R::two_pi(),
            damping_ratio: -pole.re / magnitude,
            shape,
            second_shape: second_shape(&residues, responses.length),
            residues,
            complexity: (imaginary / real).sqrt(),
            common_phase: both / real,
        })
    }

    /// How much of the mode a force shows: its [Norm Indicator](norm_indicator_of_shape).
    pub fn indicator(&self, force: &Vector6<R>, length: R) -> R {
        norm_indicator_of_shape(&self.shape, force, length)
    }
}

/// Steps of the power iteration for the common shape of residues.
const POWER_STEPS: usize = 10;

/// The norm of the residues across their common direction, relative to all, in balanced variables.
fn second_shape<R: Real>(residues: &[Vector6<R>], length: R) -> R {
    let balanced = |residue: &Vector6<R>| balanced_motion(residue, length);
    let best = residues.get(best_force(residues, length)).map_or(Vector6::zeros(), balanced);
    let mut common = best / best.norm();
    for _ in 0..POWER_STEPS {
        let along = |sum: Vector6<R>, residue: &Vector6<R>| {
            let residue = balanced(residue);
            sum + residue * residue.dot(&common)
        };
        let next = residues.iter().fold(Vector6::zeros(), along);
        common = next / next.norm();
    }
    let parts = residues.iter().fold((R::zero(), R::zero()), |(across, total), residue| {
        let residue = balanced(residue);
        let left = residue - common * common.dot(&residue);
        (across + left.norm_squared(), total + residue.norm_squared())
    });
    (parts.0 / parts.1).sqrt()
}

/// Modal assurance criterion of two shapes in balanced variables, `|φᵃ·φᵇ|²/(|φᵃ|²|φᵇ|²)`: one for the same shape.
pub fn modal_assurance<R: Real>(first: &Vector6<R>, second: &Vector6<R>, length: R) -> R {
    let [first, second] = [first, second].map(|shape| balanced_motion(shape, length));
    let across = first.dot(&second);
    across * across / (first.norm_squared() * second.norm_squared())
}
