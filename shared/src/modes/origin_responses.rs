//! The motion of a reference point per force: frequency responses without their sensors.

use heapless::Vec;
use nalgebra::{Complex, Vector3, Vector6};

use super::force_mixing::ForceMixing;
use super::{MOST_FORCES, MOST_LINES};
use crate::capacity::Capacity;
use crate::frequency_responses::FrequencyResponses;
use crate::layout::{Layout, balanced_force};
use crate::linalg::ComplexLeastSquares;
use crate::real::Real;

/// Accelerances of a reference point: its motion `[a; α]` per newton of every force, at every line.
///
/// Three or more sensors that are not on a line determine the motion of the body, so their responses reduce to six per
/// force, in which gravity is taken out exactly (theory, sections 2 and 7).
#[derive(Clone, Copy, Debug)]
pub struct OriginResponses<'a, R> {
    /// Laplace variable of each line, `s = σ + iω`, 1/s.
    pub s: &'a [Complex<R>],
    /// `[a; α]` per newton, (m/s²)/N and (rad/s²)/N: line by line, force by force.
    pub motions: &'a [Vector6<Complex<R>>],
    /// Standard deviation of each component of the motions, line by line, for a noise of one in every reading, in
    /// balanced variables: gravity makes the motion uncertain at low frequencies, where a tilt looks like a shift.
    pub sigma: &'a [[R; 6]],
    /// Force and torque `[F; T]` about the reference point of 1 N at each hit DOF.
    pub forces: &'a [Vector6<R>],
    /// Characteristic length L, m.
    pub length: R,
}

impl<R: Real> OriginResponses<'_, R> {
    /// True when the sizes agree and no number is NaN or infinite.
    pub fn is_sound(&self) -> bool {
        let finite = |z: &Complex<R>| z.re.finite() && z.im.finite();
        let positive = |v: &R| v.finite() && *v > R::zero();
        self.motions.len() == self.s.len() * self.forces.len()
            && self.motions.iter().flatten().all(finite)
            && self.sigma.len() == self.s.len()
            && self.sigma.iter().flatten().all(positive)
            && self.s.iter().all(finite)
            && self.forces.iter().flatten().all(|v| v.finite())
            && self.length.finite()
    }

    /// The motion under a force at a line.
    pub fn motion(&self, line: usize, force: usize) -> Vector6<Complex<R>> {
        self.motions[line * self.forces.len() + force]
    }

    /// One accelerance and the factor that gives it a noise of one: component 0 to 5 of the motion under a force, in
    /// balanced variables.
    pub(super) fn weighted(&self, line: usize, force: usize, component: usize) -> (Complex<R>, R) {
        let value = self.motions[line * self.forces.len() + force][component];
        let value = if component < 3 { value } else { value.scale(self.length) };
        (value, self.factor(line, component))
    }

    /// The factor that gives a component a noise of one in balanced variables.
    pub(super) fn factor(&self, line: usize, component: usize) -> R {
        self.sigma[line][component].recip()
    }
}

/// Memory for the motions of a test.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// use massline_shared::modes::{ForceMixing, Reduction};
/// use massline_shared::nalgebra::{Complex, Vector3};
/// let layout = frame::layout();
/// let mut reduction = Reduction::new();
/// let s = [Complex::new(0.0, 40.0)];
/// // Every sensor reads 1 (m/s²)/N along x under every hit; above the suspension gravity hardly matters.
/// let reading = |_line: usize, channel: usize, _hit: usize| Complex::new(f64::from(channel % 3 == 0), 0.0);
/// let mixing = ForceMixing::of(&layout, &Vector3::zeros());
/// reduction.fill(&layout, &Vector3::zeros(), &mixing, &s, reading).unwrap();
/// assert!((reduction.responses().motion(0, 0)[0].re - 1.0).abs() < 0.01);
/// ```
#[derive(Clone, Debug, Default)]
pub struct Reduction<R> {
    s: Vec<Complex<R>, MOST_LINES>,
    motions: Vec<Vector6<Complex<R>>, { MOST_LINES * MOST_FORCES }>,
    sigma: Vec<[R; 6], MOST_LINES>,
    forces: Vec<Vector6<R>, MOST_FORCES>,
    length: R,
}

impl<R: Real> Reduction<R> {
    /// Memory without lines.
    pub fn new() -> Self {
        Self {
            s: Vec::new(),
            motions: Vec::new(),
            sigma: Vec::new(),
            forces: Vec::new(),
            length: R::zero(),
        }
    }

    /// Reduces all lines. `reading(line, channel, hit)` is an accelerance, (m/s²)/N. `None` when the sensors do not
    /// determine the motion, and for more than [`MOST_LINES`] lines.
    pub fn fill<C: Capacity>(
        &mut self,
        layout: &Layout<R, C>,
        reference: &Vector3<R>,
        mixing: &ForceMixing<R, C>,
        s: &[Complex<R>],
        reading: impl Fn(usize, usize, usize) -> Complex<R>,
    ) -> Option<()> {
        self.motions.clear();
        self.sigma.clear();
        self.s = Vec::from_slice(s).ok()?;
        self.forces = mixing.forces(layout, reference);
        self.length = layout.characteristic_length();
        let mut motions = [Vector6::zeros(); MOST_FORCES];
        let motions = motions.get_mut(..self.forces.len())?;
        for (line, s) in s.iter().enumerate() {
            let of_force = |channel: usize, force: usize| {
                mixing.mixed(force, |hit| reading(line, channel, hit))
            };
            let sigma = reduce(layout, *s, reference, of_force, motions)?;
            self.sigma.push(sigma).ok()?;
            self.motions.extend_from_slice(motions).ok()?;
        }
        Some(())
    }

    /// The motions.
    pub fn responses(&self) -> OriginResponses<'_, R> {
        let Self { s, motions, sigma, forces, length } = self;
        OriginResponses { s, motions, sigma, forces, length: *length }
    }
}

/// Reduces the frequency responses of one line to the motions of the reference point: one for each force into
/// `motions`. Returns the standard deviations of [`OriginResponses::sigma`], or `None` when the sensors do not
/// determine the motion.
pub fn reduce_line<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    responses: &FrequencyResponses<'_, R>,
    reference: &Vector3<R>,
    line: usize,
    motions: &mut [Vector6<Complex<R>>],
) -> Option<[R; 6]> {
    let mut sigma = None;
    for (chunk, motions) in motions.chunks_mut(MOST_FORCES).enumerate() {
        let reading =
            |channel: usize, force: usize| responses.at(line, channel, chunk * MOST_FORCES + force);
        let forces = motions.len();
        let equations = equations_of_line(layout, responses.s(line), reference, reading, forces);
        // The matrix is that of the sensors, whatever the forces.
        if sigma.is_none() {
            sigma = Some(deviations(&equations)?);
        }
        solve_motions(layout, &equations, motions)?;
    }
    sigma
}

/// The motions under as many forces as `motions` has room for, at most [`MOST_FORCES`], from the readings of all
/// channels at one line.
fn reduce<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    s: Complex<R>,
    reference: &Vector3<R>,
    reading: impl Fn(usize, usize) -> Complex<R>,
    motions: &mut [Vector6<Complex<R>>],
) -> Option<[R; 6]> {
    let equations = equations_of_line(layout, s, reference, reading, motions.len());
    let sigma = deviations(&equations)?;
    solve_motions(layout, &equations, motions)?;
    Some(sigma)
}

/// The standard deviations of [`OriginResponses::sigma`]; `None` when the sensors do not determine the motion.
fn deviations<R: Real>(equations: &ComplexLeastSquares<R, 6, MOST_FORCES>) -> Option<[R; 6]> {
    let determined = equations.spectrum::<12>().is_some_and(|spectrum| spectrum.rank == 6);
    determined.then(|| equations.variances())?.map(|of_all| of_all.map(|variance| variance.sqrt()))
}

/// The motions that solve the equations, one for each right side.
fn solve_motions<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    equations: &ComplexLeastSquares<R, 6, MOST_FORCES>,
    motions: &mut [Vector6<Complex<R>>],
) -> Option<()> {
    let solved = equations.solve()?;
    for (motion, column) in motions.iter_mut().zip(solved.column_iter()) {
        *motion = balanced_force(&column.into_owned(), layout.characteristic_length());
    }
    Some(())
}

/// The readings of all channels under some forces as equations for the motions in balanced variables.
fn equations_of_line<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    s: Complex<R>,
    reference: &Vector3<R>,
    reading: impl Fn(usize, usize) -> Complex<R>,
    forces: usize,
) -> ComplexLeastSquares<R, 6, MOST_FORCES> {
    let length = layout.characteristic_length();
    let matrix = layout.response_matrix_at(reference, s);
    let mut equations = ComplexLeastSquares::<R, 6, MOST_FORCES>::new();
    for channel in 0..3 * layout.sensors.len() {
        let mut row = matrix.row(channel);
        row.iter_mut().skip(3).for_each(|value| *value = value.unscale(length));
        let mut readings = [Complex::new(R::zero(), R::zero()); MOST_FORCES];
        for (force, to) in readings.iter_mut().enumerate().take(forces) {
            *to = reading(channel, force);
        }
        equations.push(row, readings);
    }
    equations
}
