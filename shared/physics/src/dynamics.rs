//! Motion of the hanging object: modal superposition on a fine grid of time.
//!
//! Every mode, rigid on the suspension or elastic, is an oscillator `q̈ + 2ζω q̇ + ω² q = f(t)`. The
//! modal force is assumed linear between two points of the grid; the step is then exact.

use nalgebra::{Matrix4, Vector3};

use super::settings::ElasticMode;
use super::suspension::RigidMode;
use crate::bench::{Bench, BenchError};

/// Mass-normalised motion of one point in one mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointShape {
    /// Translation of the point.
    pub translation: Vector3<f64>,
    /// Rotation of the material about the point.
    pub rotation: Vector3<f64>,
}

/// Largest allowed distance of a layout's node from the bench's node of the same number, m.
const NODE_TOLERANCE: f64 = 0.02;

/// Checks that the bench defines its elastic modes at this node of the layout.
///
/// # Errors
/// When it does not, or has the node at another position.
pub fn check_node(bench: &Bench, node: u16, position: [f64; 3]) -> Result<(), BenchError> {
    if bench.elastic.is_empty() {
        return Ok(());
    }
    let home = bench.node(node).ok_or(BenchError::NodeWithoutShape(node))?.position_m;
    if (Vector3::from(position) - Vector3::from(home)).norm() > NODE_TOLERANCE {
        return Err(BenchError::NodeElsewhere { node, layout: position, bench: home });
    }
    Ok(())
}

/// Motion of the material point near `node` in every mode, rigid ones first.
///
/// # Errors
/// When the bench has elastic modes but does not define their motion there.
pub fn point_shapes(
    bench: &Bench,
    rigid: &[RigidMode],
    node: u16,
    point: &Vector3<f64>,
) -> Result<Vec<PointShape>, BenchError> {
    let mut shapes: Vec<_> = rigid
        .iter()
        .map(|mode| {
            let rotation = mode.shape.fixed_rows::<3>(3).into_owned();
            let translation = mode.shape.fixed_rows::<3>(0) + rotation.cross(point);
            PointShape { translation, rotation }
        })
        .collect();
    if bench.elastic.is_empty() {
        return Ok(shapes);
    }
    let home = bench.node(node).ok_or(BenchError::NodeWithoutShape(node))?;
    let offset = point - Vector3::from(home.position_m);
    for mode in &bench.elastic {
        shapes.push(elastic_shape(mode, node, &offset)?);
    }
    Ok(shapes)
}

fn elastic_shape(
    mode: &ElasticMode,
    node: u16,
    offset: &Vector3<f64>,
) -> Result<PointShape, BenchError> {
    let shape =
        mode.shape.iter().find(|s| s.node == node).ok_or(BenchError::NodeWithoutShape(node))?;
    let rotation = Vector3::from(shape.rotation);
    Ok(PointShape {
        translation: Vector3::from(shape.translation) + rotation.cross(offset),
        rotation,
    })
}

/// The state of all oscillators at one instant.
#[derive(Clone, Debug)]
pub struct Oscillators {
    steps: Vec<Step>,
    /// Displacement and velocity of every mode.
    states: Vec<[f64; 2]>,
}

/// The exact step of one oscillator over the grid's interval.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    omega_squared: f64,
    decay: f64,
    /// Factors of displacement, velocity, force before and force after in the new displacement and
    /// velocity.
    pub(super) rows: [[f64; 4]; 2],
}

impl Oscillators {
    /// Oscillators at rest, from undamped angular frequency and damping ratio, for a grid of interval
    /// `h` seconds.
    pub fn new(modes: impl Iterator<Item = (f64, f64)>, h: f64) -> Self {
        let steps: Vec<_> = modes.map(|(omega, zeta)| Step::new(omega, zeta, h)).collect();
        let states = vec![[0.0; 2]; steps.len()];
        Self { steps, states }
    }

    /// Stops all motion.
    pub fn stop(&mut self) {
        self.states.fill([0.0; 2]);
    }

    /// Displacement and velocity of every mode.
    pub(super) fn states_mut(&mut self) -> &mut [[f64; 2]] {
        &mut self.states
    }

    /// Advances by one interval with the modal forces at its beginning and end.
    pub fn advance(&mut self, before: &[f64], after: &[f64]) {
        let forces = before.iter().zip(after);
        for ((state, step), (f0, f1)) in self.states.iter_mut().zip(&self.steps).zip(forces) {
            step.advance(state, *f0, *f1);
        }
    }

    /// Largest displacement and acceleration of every mode from now on without a force.
    pub(super) fn bounds(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.states.iter().zip(&self.steps).map(|(&[q, v], step)| {
            // The energy falls, and the damping's part of the acceleration is less than twice the spring's.
            let square = q * q + v * v / step.omega_squared;
            [
                square.sqrt(),
                (1.0 + step.decay / step.omega_squared.sqrt()) * step.omega_squared * square.sqrt(),
            ]
        })
    }

    /// Displacement, velocity and acceleration of every mode under the modal forces of this instant.
    pub fn motion<'a>(&'a self, forces: &'a [f64]) -> impl Iterator<Item = [f64; 3]> + 'a {
        self.states
            .iter()
            .zip(&self.steps)
            .zip(forces)
            .map(|((&[q, v], step), f)| [q, v, f - step.decay * v - step.omega_squared * q])
    }
}

impl Step {
    /// The step over `h` seconds of an oscillator of this undamped angular frequency and damping ratio.
    pub(super) fn new(omega: f64, zeta: f64, h: f64) -> Self {
        let (omega_squared, decay) = (omega * omega, 2.0 * zeta * omega);
        // State, force and rate of force form one autonomous system, whose matrix exponential is the
        // exact step.
        #[rustfmt::skip]
        let system = Matrix4::new(
            0.0, h, 0.0, 0.0,
            -omega_squared * h, -decay * h, h, 0.0,
            0.0, 0.0, 0.0, 1.0,
            0.0, 0.0, 0.0, 0.0,
        );
        let e = system.exp();
        let row = |i: usize| [e[(i, 0)], e[(i, 1)], e[(i, 2)] - e[(i, 3)], e[(i, 3)]];
        Self { omega_squared, decay, rows: [row(0), row(1)] }
    }

    /// Advances displacement and velocity under a modal force that changes linearly.
    pub(super) fn advance(&self, state: &mut [f64; 2], before: f64, after: f64) {
        let input = [state[0], state[1], before, after];
        *state = self.rows.map(|row| row.iter().zip(input).map(|(a, x)| a * x).sum());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suspension::rigid_modes;

    #[test]
    fn a_constant_force_gives_the_textbook_step_response() {
        let (omega, zeta, h) = (20.0_f64, 0.05_f64, 1e-3_f64);
        let mut o = Oscillators::new(std::iter::once((omega, zeta)), h);
        for k in 1..=500 {
            o.advance(&[3.0], &[3.0]);
            let t = f64::from(k) * h;
            let damped = omega * (1.0 - zeta * zeta).sqrt();
            let envelope = (-zeta * omega * t).exp();
            let expected = 3.0 / (omega * omega)
                * (1.0
                    - envelope * ((damped * t).cos() + zeta * omega / damped * (damped * t).sin()));
            let [q, _, _] = o.motion(&[3.0]).next().unwrap();
            // The recurrence is exact; the tolerance is 500 rounding errors.
            assert!((q - expected).abs() < 1e-15 * 500.0, "{q} {expected}");
        }
    }

    #[test]
    fn a_ramp_is_integrated_exactly_without_a_spring() {
        let h = 0.01;
        let mut o = Oscillators::new(std::iter::once((0.0, 0.0)), h);
        for k in 0..100 {
            o.advance(&[f64::from(k) * h], &[f64::from(k + 1) * h]);
        }
        let [q, v, a] = o.motion(&[1.0]).next().unwrap();
        assert!((q - 1.0 / 6.0).abs() < 1e-13 && (v - 0.5).abs() < 1e-13 && a == 1.0);
    }

    #[test]
    fn a_short_blow_changes_the_velocities_by_the_inverse_mass_matrix() {
        let bench = Bench::named("default").unwrap();
        let rigid = rigid_modes(&bench.body, &bench.suspension, &bench.gravity).unwrap();
        let h = 1e-7;
        let mut o = Oscillators::new(rigid.iter().map(|m| (m.omega, m.damping_ratio)), h);
        let f0 = nalgebra::Vector6::new(0.3, -0.2, 1.0, 0.05, -0.1, 0.2);
        let forces: Vec<_> = rigid.iter().map(|m| m.shape.dot(&f0) / h).collect();
        o.advance(&forces, &forces);
        let zero = [0.0; 6];
        let velocity: nalgebra::Vector6<f64> =
            o.motion(&zero).zip(&rigid).map(|([_, v, _], mode)| mode.shape * v).sum();
        let momentum = bench.body.mass_matrix() * velocity;
        // In 0.1 µs the damping of the 3 Hz suspension takes the share 2ζω h of the momentum, below 1e-7.
        assert!((momentum - f0).norm() < 1e-6, "{momentum}");
    }

    #[test]
    fn an_undamped_mode_keeps_its_energy() {
        let omega = 2000.0;
        let mut o = Oscillators::new(std::iter::once((omega, 0.0)), 1.5e-5);
        o.advance(&[1e5], &[0.0]);
        let energy = |o: &Oscillators| {
            let [q, v, _] = o.motion(&[0.0]).next().unwrap();
            0.5 * (v * v + omega * omega * q * q)
        };
        let start = energy(&o);
        for _ in 0..100_000 {
            o.advance(&[0.0], &[0.0]);
        }
        // Rounding only: 1e5 steps with 1e-16 each, all in the same direction at worst.
        assert!((energy(&o) / start - 1.0).abs() < 1e-10);
    }
}
