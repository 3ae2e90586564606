//! The unknowns of the fit and their order.
//!
//! ```text
//! sensors 15 each │ gravity 2 │ hits 5 each │ hammer │ attached bodies │ hits 1 each │ K │ C │ R │ Q │ phi
//! ```
//! The second group of the hits is the torque about the direction of the mean force, of second order.
//! Nuisance parameters are in standard deviations of the budget, everything else in balanced variables. The
//! properties come last, so that a Cholesky factor ends with their information under all other unknowns.

use core::array::from_fn;

use heapless::Vec;
use nalgebra::{Complex, Matrix6, Vector6};

use super::Damping;
use crate::identify::maximum_likelihood::model::SENSOR_NUISANCES;
use crate::layout::{GRAVITY_QUANTITIES, HIT_QUANTITIES};
use crate::real::Real;

/// Elements of a symmetric 6 × 6 matrix.
pub(super) const SYMMETRIC: usize = 21;
/// Most extra terms of the dynamic stiffness: R and Q.
pub const MOST_EXTRA_TERMS: usize = 2;
/// Most matrices besides the mass: K, C and the extra terms.
pub(super) const MOST_BLOCKS: usize = 2 + MOST_EXTRA_TERMS;
/// Stands for `i s⁻²` among the powers of s.
const LOSS: i8 = -3;
/// Elements of one matrix, and the ten properties.
pub(super) const ELEMENTS: usize = SYMMETRIC + 10;
/// Unknowns without nuisance parameters: at most.
pub(super) const MOST_SHARED: usize = SYMMETRIC * MOST_BLOCKS + 10;

/// Changes of a hit's force: its own errors, the hammer's gain, the torque.
pub(super) const FORCE_SLOPES: usize = HIT_QUANTITIES + 2;
/// Errors that change the rows of a sensor: its own, and the direction of gravity.
pub(super) const ROW_SLOPES: usize = SENSOR_NUISANCES + GRAVITY_QUANTITIES;
/// Errors that a reading depends on, without the attached bodies.
pub(super) const OWN_NUISANCES: usize = ROW_SLOPES + FORCE_SLOPES;

/// Row and column of the elements of a lower triangle, row by row.
pub(super) const PLACES: [(usize, usize); SYMMETRIC] = {
    let mut places = [(0, 0); SYMMETRIC];
    let (mut row, mut column, mut k) = (0, 0, 0);
    while k < SYMMETRIC {
        places[k] = (row, column);
        (row, column) = if column < row { (row, column + 1) } else { (row + 1, 0) };
        k += 1;
    }
    places
};

/// Which unknowns there are and where they start.
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    sensors: usize,
    hits: usize,
    attached: usize,
    pub(super) budget: bool,
    /// Power of s of each matrix besides the mass, relative to it: −2 for K, −1 for C, [`LOSS`] for D, 2 for R, 4 for
    /// Q.
    pub(super) powers: Vec<i8, MOST_BLOCKS>,
}

impl Unknowns {
    pub(super) fn new(counts: [usize; 3], budget: bool, damping: Damping, extra: usize) -> Self {
        let [sensors, hits, attached] = counts;
        let of_extra = [2, 4].into_iter().take(extra);
        let of_damping = match damping {
            Damping::None => None,
            Damping::Viscous => Some(-1),
            Damping::Structural => Some(LOSS),
        };
        let powers = [-2].into_iter().chain(of_damping).chain(of_extra).collect();
        Self { sensors, hits, attached, budget, powers }
    }

    pub(super) fn sensor_count(&self) -> usize {
        self.sensors
    }

    pub(super) fn sensor(&self, sensor: usize) -> usize {
        SENSOR_NUISANCES * sensor
    }

    /// The direction of gravity.
    pub(super) fn gravity(&self) -> usize {
        self.sensor(self.sensors)
    }

    pub(super) fn hit(&self, hit: usize) -> usize {
        self.gravity() + GRAVITY_QUANTITIES + HIT_QUANTITIES * hit
    }

    pub(super) fn hammer(&self) -> usize {
        self.hit(self.hits)
    }

    pub(super) fn attached(&self, body: usize) -> usize {
        self.hammer() + 1 + body
    }

    /// The torque of a hit about its direction.
    pub(super) fn torque(&self, hit: usize) -> usize {
        self.attached(self.attached) + hit
    }

    /// Number of nuisance parameters.
    pub(super) fn nuisances(&self) -> usize {
        if self.budget { self.torque(self.hits) } else { 0 }
    }

    /// First element of a matrix besides the mass.
    pub(super) fn block(&self, block: usize) -> usize {
        self.nuisances() + SYMMETRIC * block
    }

    /// First of the ten properties.
    pub(super) fn phi(&self) -> usize {
        self.block(self.powers.len())
    }

    pub(super) fn len(&self) -> usize {
        self.phi() + 10
    }
}

/// `sᵖ` for each matrix besides the mass, then one for the mass.
pub(super) fn powers_of<R: Real>(s: Complex<R>, unknowns: &Unknowns) -> Vec<Complex<R>, 5> {
    let inverse = real(R::one()) / s;
    let power = |p: &i8| match *p {
        -2 => inverse * inverse,
        -1 => inverse,
        LOSS => inverse * inverse * Complex::new(R::zero(), R::one()),
        2 => s * s,
        _ => s * s * s * s,
    };
    unknowns.powers.iter().map(power).chain([real(R::one())]).collect()
}

/// `aᵢ bⱼ + aⱼ bᵢ` for every element of a symmetric matrix, from the products `aᵢ bⱼ`: the change of `aᵀ S b`
/// with that element.
pub(super) fn symmetrized<T: Copy + core::ops::Add<Output = T>>(
    product: impl Fn(usize, usize) -> T,
) -> [T; SYMMETRIC] {
    PLACES.map(|(i, j)| if i == j { product(i, j) } else { product(i, j) + product(j, i) })
}

/// The change with each of the ten properties, from that with the elements of the mass matrix.
pub(super) fn of_properties<R: Real>(elements: &[Complex<R>; SYMMETRIC]) -> [Complex<R>; 10] {
    let at = |i: usize, j: usize| elements[i * (i + 1) / 2 + j];
    [
        at(0, 0) + at(1, 1) + at(2, 2),
        at(5, 1) - at(4, 2),
        at(3, 2) - at(5, 0),
        at(4, 0) - at(3, 1),
        at(3, 3),
        at(4, 4),
        at(5, 5),
        at(4, 3),
        at(5, 3),
        at(5, 4),
    ]
}

/// Both: 21 elements, then ten properties.
pub(super) fn with_properties<R: Real>(
    elements: [Complex<R>; SYMMETRIC],
) -> [Complex<R>; ELEMENTS] {
    let properties = of_properties(&elements);
    from_fn(|k| if k < SYMMETRIC { elements[k] } else { properties[k - SYMMETRIC] })
}

/// The symmetric matrix with these elements.
pub(super) fn matrix_of<R: Real>(elements: &[R]) -> Matrix6<R> {
    let mut matrix = Matrix6::zeros();
    for ((i, j), value) in PLACES.into_iter().zip(elements) {
        (matrix[(i, j)], matrix[(j, i)]) = (*value, *value);
    }
    matrix
}

/// `a · b` without conjugation.
pub(super) fn dot<R: Real>(a: &Vector6<Complex<R>>, b: &Vector6<Complex<R>>) -> Complex<R> {
    let mut sum = real(R::zero());
    for (a, b) in a.iter().zip(b) {
        sum += *a * *b;
    }
    sum
}

/// `a · b` with a real vector.
pub(super) fn dot_real<R: Real>(a: &Vector6<Complex<R>>, b: &Vector6<R>) -> Complex<R> {
    let mut sum = real(R::zero());
    for (a, b) in a.iter().zip(b) {
        sum += a.scale(*b);
    }
    sum
}

pub(super) fn real<R: Real>(value: R) -> Complex<R> {
    Complex::new(value, R::zero())
}

/// `Re(ā b)`.
pub(super) fn along<R: Real>(a: Complex<R>, b: Complex<R>) -> R {
    a.re * b.re + a.im * b.im
}

/// First unknown of a matrix and its elements among [`with_properties`]; the mass has the ten properties.
pub(super) fn block_of(
    unknowns: &Unknowns,
    block: usize,
    mass: usize,
) -> (usize, core::ops::Range<usize>) {
    let elements = if block == mass { SYMMETRIC..ELEMENTS } else { 0..SYMMETRIC };
    (unknowns.block(block), elements)
}

/// Place of a change of a sensor's rows.
pub(super) fn place_of_row(unknowns: &Unknowns, sensor: usize, parameter: usize) -> usize {
    match parameter {
        0..SENSOR_NUISANCES => unknowns.sensor(sensor) + parameter,
        _ => unknowns.gravity() + parameter - SENSOR_NUISANCES,
    }
}

/// Place of a change of a hit's force.
pub(super) fn place_of_hit(unknowns: &Unknowns, hit: usize, parameter: usize) -> usize {
    match parameter {
        0..HIT_QUANTITIES => unknowns.hit(hit) + parameter,
        HIT_QUANTITIES => unknowns.hammer(),
        _ => unknowns.torque(hit),
    }
}
