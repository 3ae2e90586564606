//! The smallest uncertainty that any unbiased method can reach: the Cramér-Rao bound.

use nalgebra::{SMatrix, SVector, Vector3};

use super::answer::covariance_of;
use super::fit_problem::FitProblem;
use super::model::{HIT_NUISANCES, Model};
use super::normal_equations::NormalEquations;
use crate::body::RigidBody;
use crate::capacity::Capacity;
use crate::identify::MassLines;
use crate::layout::Layout;
use crate::linalg::cholesky;
use crate::real::Real;
use crate::responses::{ResponseSquare, Responses};

/// The bound of the ten properties.
#[derive(Clone, Debug, PartialEq)]
pub struct Bound<R> {
    /// Covariance of `theta`.
    pub covariance: SMatrix<R, 10, 10>,
    /// `ln det` of the information about `phi / [1, L, L, L, L² × 6]`.
    pub log_det_information: R,
}

impl<R: Real> Bound<R> {
    /// Standard deviations of `theta`.
    pub fn sigma(&self) -> SVector<R, 10> {
        self.covariance.diagonal().map(|v| v.max(R::zero()).sqrt())
    }
}

/// The bound for a body under a layout with its whole error budget, its priors and the attached bodies
/// (theory, section 4).
///
/// `body` is the object; `noise(index)` gives the standard deviation of each accelerance of a hit DOF
/// averaged over `hits` hits, (m/s²)/N. `None` when the layout does not determine the ten properties, or
/// when the covariance of the readings of a hit is singular.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::maximum_likelihood::{bound, workspace};
/// # use massline_shared::responses::Responses;
/// let mut layout = frame::layout();
/// let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
/// let noise = |_hit| Responses::repeat(3, 0.002);
/// let mass_sigma = |layout: &_, memory: &mut [f64]| {
///     bound(layout, &frame::body(), noise, 5, memory).unwrap().sigma()[0]
/// };
/// let uncalibrated = mass_sigma(&layout, &mut memory);
/// layout.apparatus.hammer_gain = 0.0; // after a calibration of sensors against the hammer
/// assert!(mass_sigma(&layout, &mut memory) < 0.7 * uncalibrated);
/// ```
pub fn bound<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    body: &RigidBody<R>,
    noise: impl Fn(usize) -> Responses<R, C>,
    hits: u16,
    workspace: &mut [R],
) -> Option<Bound<R>> {
    let problem = FitProblem::<R, C>::new(layout);
    let object = problem.balance.body(body);
    let whole = problem.body_of(&object.phi())?;
    let mut equations = NormalEquations::new(workspace, problem.nuisances())?;
    let dofs = (0..layout.hits.len()).map(|index| {
        // The information does not depend on the readings.
        let noise = noise(index);
        let mut lines = MassLines::without_scatter(Responses::zeros(noise.sensors()));
        lines.noise = noise;
        lines.hits = hits;
        (index, lines)
    });
    problem.assemble(&whole, dofs, &mut equations)?;
    problem.add_priors(&object, &mut equations);
    equations.eliminate()?;
    let information = equations.information();
    let covariance = problem.balance.covariance_back(&covariance_of(&information, &object)?);
    let factor = cholesky(&information)?;
    let log_det_information =
        factor.diagonal().iter().fold(R::zero(), |sum, v| sum + v.ln() * R::of(2.0));
    log_det_information.finite().then_some(Bound { covariance, log_det_information })
}

/// Covariance of the readings of one hit DOF with those of another (theory, section 4), ((m/s²)/N)²: the
/// weights of the fit, written out. Different DOFs are correlated only by the nuisance parameters that stay
/// the same over the test.
///
/// `first` is a DOF with its mass lines, which contain noise and number of hits. `None` when the layout does
/// not have the DOFs or the body has no inertia.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::maximum_likelihood::readings_covariance;
/// let layout = frame::layout();
/// let dofs = frame::mass_lines(&layout);
/// let first = (dofs[0].0, &dofs[0].1);
/// let own = readings_covariance(&layout, &frame::body(), first, 0).unwrap();
/// let between = readings_covariance(&layout, &frame::body(), first, 1).unwrap();
/// // Response 1 is the y axis of the sensor that hit 1:+Y drives: the hammer alone contributes 2 % of it.
/// assert!(own[(1, 1)].sqrt() > 0.02 * dofs[0].1.accelerance[1]);
/// // Nuisance parameters that stay the same over the test correlate the hits.
/// assert!(between[(1, 5)] != 0.0);
/// ```
pub fn readings_covariance<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    body: &RigidBody<R>,
    first: (usize, &MassLines<R, C>),
    second: usize,
) -> Option<ResponseSquare<R, C>> {
    let problem = FitProblem::<R, C>::new(layout);
    let whole = problem.body_of(&problem.balance.body(body).phi())?;
    let model = Model::new(layout, &problem.balance, &whole)?;
    let (index, lines) = first;
    let errors = [R::zero(); HIT_NUISANCES];
    let of_first = problem.terms(&model, index, lines, &errors)?;
    let of_second = problem.terms(&model, second, lines, &errors)?;
    let mut sum = ResponseSquare::<R, C>::zeros(lines.scatter.rows() / 3);
    problem.with_rows(&model, &of_first, |one| {
        problem.with_rows(&model, &of_second, |other| {
            for (i, columns) in one.sensors.iter().enumerate() {
                let Some(others) = other.sensors.get(i) else { continue };
                for (a, b) in columns.iter().zip(others) {
                    let [a, b] = [a, b].map(|column| of_sensor(i, column, sum.rows() / 3));
                    sum.add_outer(&a, &b);
                }
            }
            // The columns of the ten properties follow those of the hammer and the attached bodies.
            let nuisances = one.shared.len().saturating_sub(10);
            for (a, b) in one.shared.iter().zip(other.shared).take(nuisances) {
                sum.add_outer(a, b);
            }
        });
    });
    if index == second {
        for column in &of_first.model.spread.0 {
            sum.add_outer(column, column);
        }
        for k in 0..problem.channels {
            sum[(k, k)] += lines.noise[k] * lines.noise[k];
        }
    }
    Some(sum)
}

/// Responses of one of the sensors, with zeros for the others.
fn of_sensor<R: Real, C: Capacity>(
    i: usize,
    readings: &Vector3<R>,
    sensors: usize,
) -> Responses<R, C> {
    let mut responses = Responses::<R, C>::zeros(sensors);
    responses.set_sensor(i, (*readings).into());
    responses
}
