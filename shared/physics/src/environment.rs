//! What moves the object besides the hammer: a draught, and cords that creak.
//!
//! Both are loads at the scans, between which they change linearly, so that the motion of a whole scan keeps its
//! closed form. A creak is a triangle over two scans.

use nalgebra::{DMatrix, DVector, Vector3, Vector6};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::dynamics::Step;
use super::errors::{normal, normal_vector};
use super::slow::Slow;
use super::suspension::{RigidMode, Suspension};
use crate::bench::Bench;

/// Force on the object, N, and moment about the origin, N m.
pub(super) type Load = Vector6<f64>;

/// Time for which the draught has been blowing when the rig arms, s; most objects are in steady state after a minute.
const BLOWING_S: f64 = 3600.0;

/// The loads of draught and creaks at the scans.
#[derive(Clone, Debug)]
pub(super) struct Environment {
    center_of_mass: Vector3<f64>,
    /// Force, and moment about the centre of mass.
    draught: Option<Slow<6>>,
    /// Factor of the covariance of displacement and velocity of all modes, one after the other, and of the draught.
    steady: DMatrix<f64>,
    creaks: Option<Creaks>,
    rng: ChaCha8Rng,
}

/// Creaks at random times.
#[derive(Clone, Debug)]
struct Creaks {
    /// Mean number in a scan.
    rate: f64,
    /// Peak of the force of a creak, 1 σ, N.
    sigma: f64,
    /// Where they come from, and in which direction; none is any.
    places: Vec<(Vector3<f64>, Option<Vector3<f64>>)>,
    /// Scans to the next.
    until_next: f64,
}

impl Environment {
    /// The environment of an object with these rigid modes, at scans of this interval, s; none when nothing moves it.
    pub(super) fn new(bench: &Bench, modes: &[RigidMode], scan: f64) -> Option<Self> {
        let settings = &bench.environment;
        let sigma =
            std::array::from_fn(|i| if i < 3 { settings.draught_n } else { settings.draught_n_m });
        let draught = Slow::new(sigma, settings.draught_s, scan);
        let center_of_mass = bench.body.center_of_mass;
        let steady = draught.as_ref().map_or_else(
            || DMatrix::zeros(0, 0),
            |draught| steady_state(draught, modes, &center_of_mass, scan),
        );
        let creaks = Creaks::new(bench, scan);
        (draught.is_some() || creaks.is_some()).then_some(Self {
            center_of_mass,
            draught,
            steady,
            creaks,
            rng: ChaCha8Rng::seed_from_u64(0),
        })
    }

    /// Draws the motion of the rigid modes in a draught that has been blowing for long, displacement and velocity of
    /// each; creaks come from now on.
    pub(super) fn settle(&mut self, states: &mut [[f64; 2]], rng: ChaCha8Rng) {
        self.rng = rng;
        if let Some(draught) = &mut self.draught {
            let size = self.steady.nrows();
            let white = DVector::from_fn(size, |_, _| normal(&mut self.rng));
            let drawn = &self.steady * white;
            for (i, state) in states.iter_mut().take((size - 6) / 2).enumerate() {
                *state = [drawn[2 * i], drawn[2 * i + 1]];
            }
            draught.hold(std::array::from_fn(|i| drawn[size - 6 + i]));
        }
        if let Some(creaks) = &mut self.creaks {
            creaks.wait(&mut self.rng);
        }
    }

    /// The load of the draught at the present scan.
    pub(super) fn load(&self) -> Load {
        self.draught.as_ref().map_or_else(Load::zeros, |draught| {
            let values = draught.value();
            let force = Vector3::from_column_slice(&values[..3]);
            let moment = Vector3::from_column_slice(&values[3..]);
            load(&force, &(moment + self.center_of_mass.cross(&force)))
        })
    }

    /// Goes on to the next scan and returns the load there.
    pub(super) fn advance(&mut self) -> Load {
        if let Some(draught) = &mut self.draught {
            draught.advance(&mut self.rng);
        }
        let creak = self.creaks.as_mut().and_then(|creaks| creaks.next(&mut self.rng));
        self.load() + creak.unwrap_or_else(Load::zeros)
    }
}

impl Creaks {
    fn new(bench: &Bench, scan: f64) -> Option<Self> {
        let settings = &bench.environment;
        let places = match &bench.suspension {
            Suspension::Cords { cords, .. } => cords
                .iter()
                .map(|cord| {
                    let along = Vector3::from(cord.direction).normalize();
                    (cord.point_m.into(), cord.spring_n_per_m.is_none().then_some(along))
                })
                .collect(),
            Suspension::Frequencies { .. } => vec![(bench.body.center_of_mass, None)],
        };
        let creaks = settings.creak_rate_per_s > 0.0 && settings.creak_n_s > 0.0;
        (creaks && !places.is_empty()).then(|| Self {
            rate: settings.creak_rate_per_s * scan,
            sigma: settings.creak_n_s / scan,
            places,
            until_next: f64::INFINITY,
        })
    }

    /// Draws the time to the next creak.
    fn wait(&mut self, rng: &mut ChaCha8Rng) {
        self.until_next = -(1.0 - rng.random::<f64>()).ln() / self.rate;
    }

    /// The load of a creak at the next scan, if there is one.
    fn next(&mut self, rng: &mut ChaCha8Rng) -> Option<Load> {
        self.until_next -= 1.0;
        if self.until_next > 0.0 {
            return None;
        }
        self.wait(rng);
        let place = rng.random_range(0..self.places.len());
        let (point, along) = self.places.get(place)?;
        let any = normal_vector(rng).normalize();
        let force = along.unwrap_or(any) * (self.sigma * normal(rng));
        Some(load(&force, &point.cross(&force)))
    }
}

fn load(force: &Vector3<f64>, moment: &Vector3<f64>) -> Load {
    Load::from_iterator(force.iter().chain(moment).copied())
}

/// Factor of the covariance of modes and draught after [`BLOWING_S`], from rest.
///
/// From one knot of the draught to the next the state is multiplied by a matrix `A` and receives fresh noise. The
/// covariance after twice as many knots is `S + A S Aᵀ` with the square of `A` from then on.
fn steady_state(
    draught: &Slow<6>,
    modes: &[RigidMode],
    center_of_mass: &Vector3<f64>,
    scan: f64,
) -> DMatrix<f64> {
    let knot = draught.interval() as f64 * scan;
    let (memory, sigma) = draught.statistics();
    let motions = 2 * modes.len();
    let size = motions + 6;
    let mut a = DMatrix::zeros(size, size);
    let mut input = DMatrix::zeros(size, 6);
    for (i, mode) in modes.iter().enumerate() {
        let rotation = mode.shape.fixed_rows::<3>(3).into_owned();
        let translation = mode.shape.fixed_rows::<3>(0) + rotation.cross(center_of_mass);
        let shape = load(&translation, &rotation);
        for (row, [of_q, of_v, before, after]) in
            Step::new(mode.omega, mode.damping_ratio, knot).rows.into_iter().enumerate()
        {
            a[(2 * i + row, 2 * i)] = of_q;
            a[(2 * i + row, 2 * i + 1)] = of_v;
            for (k, factor) in shape.iter().enumerate() {
                a[(2 * i + row, motions + k)] = factor * (before + memory * after);
                input[(2 * i + row, k)] = factor * after;
            }
        }
    }
    for k in 0..6 {
        a[(motions + k, motions + k)] = memory;
        input[(motions + k, k)] = 1.0;
    }
    let variance = Vector6::from(*sigma).map(|sigma| sigma * sigma);
    let fresh = DMatrix::from_diagonal(&DVector::from_column_slice(
        (variance * (1.0 - memory * memory)).as_slice(),
    ));
    let mut sum = &input * fresh * input.transpose();
    let mut time = knot;
    while time < BLOWING_S {
        sum = &sum + &a * &sum * a.transpose();
        a = &a * &a;
        time *= 2.0;
    }
    // The draught itself has been blowing for ever.
    let mut start = DMatrix::zeros(size, size);
    for k in 0..6 {
        start[(motions + k, motions + k)] = variance[k];
    }
    square_root(&(sum + &a * start * a.transpose()))
}

/// A factor of a positive semidefinite matrix, by the eigenvectors of the matrix of correlations.
fn square_root(covariance: &DMatrix<f64>) -> DMatrix<f64> {
    let size = covariance.nrows();
    let deviation = covariance.diagonal().map(|variance| variance.max(0.0).sqrt());
    let correlation = DMatrix::from_fn(size, size, |i, j| {
        let scale = deviation[i] * deviation[j];
        if scale > 0.0 { covariance[(i, j)] / scale } else { 0.0 }
    });
    let Some(eigen) = correlation.try_symmetric_eigen(f64::EPSILON, 10_000) else {
        return DMatrix::zeros(size, size);
    };
    let roots = eigen.eigenvalues.map(|value| value.max(0.0).sqrt());
    DMatrix::from_diagonal(&deviation) * eigen.eigenvectors * DMatrix::from_diagonal(&roots)
}
