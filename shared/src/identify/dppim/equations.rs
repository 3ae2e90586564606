//! The linear equations for the ten inertial parameters.

use heapless::Vec;
use nalgebra::{Complex, Matrix6, SMatrix, Vector6};

use crate::body::{RigidBody, regressor, scale};
use crate::linalg::{ComplexLeastSquares, LeastSquares, Spectrum};
use crate::real::Real;

/// A unit force at one frequency, and the motion that it excites, all about the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Excitation<R> {
    /// Laplace variable, `s = σ + iω`, 1/s.
    pub s: Complex<R>,
    /// Force and torque `[F; T]` of 1 N.
    pub force: Vector6<R>,
    /// Displacement `[x; θ]` per unit of the force, m/N and rad/N.
    pub receptance: Vector6<Complex<R>>,
}

impl<R: Real> Excitation<R> {
    /// The right sides of the two equations of this and a second excitation, `α = (s₂ y₂ᵀ f₁ − s₁ y₁ᵀ f₂)/(s₂ − s₁)`,
    /// and `β`, in which `s₁` and `y₁` are conjugate (Almeida, Maia and Urgueira, equations 6 and 7). The damping drops
    /// out: `α = y₁ᵀ K y₂ − s₁ s₂ y₁ᵀ M y₂`.
    ///
    /// ```
    /// # use massline_shared::identify::dppim::Excitation;
    /// # use massline_shared::nalgebra::{Complex, Vector6};
    /// // 2 kg along x without a suspension: only the mass is left.
    /// let at = |omega: f64| {
    ///     let s = Complex::new(0.0, omega);
    ///     let receptance = Vector6::x() * (Complex::new(0.5, 0.0) / (s * s));
    ///     Excitation { s, force: Vector6::x(), receptance }
    /// };
    /// let (first, second) = (at(3.0), at(5.0));
    /// let [alpha, _] = first.products(&second);
    /// let mass = -first.s * second.s * first.receptance[0] * second.receptance[0] * 2.0;
    /// assert!((alpha - mass).norm() < 1e-15);
    /// ```
    pub fn products(&self, second: &Self) -> [Complex<R>; 2] {
        let of_second = along(&second.receptance, &self.force);
        let of_first = along(&self.receptance, &second.force);
        [(self.s, of_first), (self.s.conj(), of_first.conj())]
            .map(|(s, of_first)| (second.s * of_second - s * of_first) / (second.s - s))
    }

    /// The same in balanced variables, in which forces and motions have one unit each.
    fn balanced(&self, length: R) -> Self {
        let mut to = *self;
        for i in 3..6 {
            to.force[i] /= length;
            to.receptance[i] = to.receptance[i].scale(length);
        }
        to
    }
}

/// A set of excitations. They are computed when they are needed: a set of all of them would be larger than the
/// responses.
pub trait Excitations<R> {
    /// Number of excitations.
    fn count(&self) -> usize;
    /// The excitation with this place.
    fn at(&self, place: usize) -> Excitation<R>;
}

impl<R: Real> Excitations<R> for [Excitation<R>] {
    fn count(&self) -> usize {
        self.len()
    }
    fn at(&self, place: usize) -> Excitation<R> {
        self[place]
    }
}

/// All excitations of a set, one after the other.
fn all<R, E: Excitations<R> + ?Sized>(set: &E) -> impl Iterator<Item = Excitation<R>> {
    (0..set.count()).map(|place| set.at(place))
}

/// The solution of the equations.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution<R> {
    /// The body; `None` when the equations do not determine it.
    pub body: Option<RigidBody<R>>,
    /// Rank of the equations: ten when they determine the ten properties.
    pub rank: usize,
    /// Condition of the equations.
    pub condition: R,
    /// Root mean square of what the body leaves of the equations, over that of their right sides: compares the forms.
    pub misfit: R,
}

/// `yᵀ f`.
fn along<R: Real>(motion: &Vector6<Complex<R>>, force: &Vector6<R>) -> Complex<R> {
    let products = motion.iter().zip(force.iter()).map(|(y, f)| y.scale(*f));
    products.fold(Complex::new(R::zero(), R::zero()), |sum, product| sum + product)
}

/// Rank of the motions of these excitations: six when the viscous form can be solved. `length` is L in m. `None` when
/// a number is not finite.
pub fn span<R: Real>(excitations: &(impl Excitations<R> + ?Sized), length: R) -> Option<usize> {
    let mut motions = ComplexLeastSquares::<R, 6, 0>::new();
    for one in all(excitations) {
        motions.push(one.balanced(length).receptance.map(|y| y.conj()).into(), []);
    }
    Some(motions.spectrum::<12>()?.rank)
}

/// Solves the viscous form for all pairs of a `first` and a `second` excitation, which must have different frequencies.
/// `length` is L in m, which balances the unknowns. `None` when the motions of the first do not [span] six
/// directions, or a number is not finite.
///
/// `(T S₁* Y₁ᴴ − S₁ Y₁ᵀ) M₀ Y₂ S₂ = α − T β` with `T = Y₁ᵀ (Y₁ᴴ)⁺` (Almeida, Maia and Urgueira, equation 8).
pub fn solve_viscous<R: Real>(
    first: &(impl Excitations<R> + ?Sized),
    second: &(impl Excitations<R> + ?Sized),
    length: R,
) -> Option<Solution<R>> {
    if span(first, length)? < 6 {
        return None;
    }
    solve_spanning(first, second, length)
}

/// The same where the motions of the first are known to span six directions.
pub(super) fn solve_spanning<R: Real>(
    first: &(impl Excitations<R> + ?Sized),
    second: &(impl Excitations<R> + ?Sized),
    length: R,
) -> Option<Solution<R>> {
    let mut equations = Equations::new(length);
    // `(Y₁ᴴ)⁺ S₁* Y₁ᴴ`, with which K is eliminated.
    let row = |one: &Excitation<R>| one.receptance.map(|y| (one.s * y).conj()).into();
    let eliminated = inverse_of_motions(first, length, row)?;
    for others in chunks(second, length) {
        let betas: SMatrix<_, 6, CHUNK> = inverse_of_motions(first, length, |one| {
            of_each(&others, |other| one.products(other)[1])
        })?;
        let rows =
            all(first).map(|one| viscous_row(&one.balanced(length), &others, &eliminated, &betas));
        let motion = |other: &Excitation<R>| other.receptance.map(|y| y * other.s);
        equations.push_chunk(&others, motion, rows);
    }
    equations.solve()
}

/// Solves the structural form for all pairs of a `first` and a `second` excitation, which must have different
/// frequencies and no window: `y₁ᵀ M y₂ = (y₂ᵀ f₁ − y₁ᵀ f₂)/(ω₂² − ω₁²)` (theory, section 6). `length` is L in m, which
/// balances the unknowns. `None` when a number is not finite.
pub fn solve_structural<R: Real>(
    first: &(impl Excitations<R> + ?Sized),
    second: &(impl Excitations<R> + ?Sized),
    length: R,
) -> Option<Solution<R>> {
    let mut equations = Equations::new(length);
    for others in chunks(second, length) {
        let rows = all(first).map(|one| structural_row(&one.balanced(length), &others));
        equations.push_chunk(&others, |other| other.receptance, rows);
    }
    equations.solve()
}

/// Left and right sides of the viscous form for one first excitation.
fn viscous_row<R: Real>(
    one: &Excitation<R>,
    others: &[Excitation<R>],
    eliminated: &Matrix6<Complex<R>>,
    betas: &SMatrix<Complex<R>, 6, CHUNK>,
) -> (Vector6<Complex<R>>, [Complex<R>; CHUNK]) {
    let y = one.receptance.transpose();
    let left = y * eliminated - y * one.s;
    let mut right = of_each(others, |other| one.products(other)[0]);
    right.iter_mut().zip((y * betas).iter()).for_each(|(alpha, beta)| *alpha -= beta);
    (left.transpose(), right)
}

/// The same for the structural form.
fn structural_row<R: Real>(
    one: &Excitation<R>,
    others: &[Excitation<R>],
) -> (Vector6<Complex<R>>, [Complex<R>; CHUNK]) {
    let right = of_each(others, |other| {
        let difference =
            along(&other.receptance, &one.force) - along(&one.receptance, &other.force);
        // −s² is ω².
        difference / (one.s * one.s - other.s * other.s)
    });
    (one.receptance, right)
}

/// Second excitations that are treated together.
const CHUNK: usize = 6;

/// The excitations of a set in balanced variables, some at a time.
fn chunks<R: Real>(
    set: &(impl Excitations<R> + ?Sized),
    length: R,
) -> impl Iterator<Item = Vec<Excitation<R>, CHUNK>> {
    (0..set.count()).step_by(CHUNK).map(move |start| {
        let end = (start + CHUNK).min(set.count());
        (start..end).map(|place| set.at(place).balanced(length)).collect()
    })
}

/// A number for each excitation of a chunk, and zeros for those that it has not.
fn of_each<R: Real>(
    chunk: &[Excitation<R>],
    number: impl Fn(&Excitation<R>) -> Complex<R>,
) -> [Complex<R>; CHUNK] {
    let zero = Complex::new(R::zero(), R::zero());
    core::array::from_fn(|place| chunk.get(place).map_or(zero, &number))
}

/// `(Y₁ᴴ)⁺ X` in balanced variables, where `row` gives the row of X that belongs to an excitation.
fn inverse_of_motions<R: Real, const M: usize>(
    first: &(impl Excitations<R> + ?Sized),
    length: R,
    row: impl Fn(&Excitation<R>) -> [Complex<R>; M],
) -> Option<SMatrix<Complex<R>, 6, M>> {
    let mut motions = ComplexLeastSquares::<R, 6, M>::new();
    for one in all(first) {
        let one = one.balanced(length);
        motions.push(one.receptance.map(|y| y.conj()).into(), row(&one));
    }
    motions.solve()
}

/// Regressors of the real and of the imaginary part of a motion.
struct Motion<R>([[[R; 10]; 6]; 2]);

impl<R: Real> Motion<R> {
    fn of(motion: &Vector6<Complex<R>>) -> Self {
        Self([regressor(&motion.map(|y| y.re)), regressor(&motion.map(|y| y.im))])
    }
}

/// Equations `leftᵀ M motion = right`, in balanced variables.
#[derive(Clone, Debug)]
struct Equations<R> {
    equations: LeastSquares<R, 10>,
    /// Sum of the squared right sides, and of what nothing explains of them.
    squares: R,
    unexplained: R,
    length: R,
}

impl<R: Real> Equations<R> {
    fn new(length: R) -> Self {
        let (squares, unexplained) = (R::zero(), R::zero());
        Self { equations: LeastSquares::new(), squares, unexplained, length }
    }

    /// Adds the equations of all first excitations, which give the `rows` of left sides and right sides, with each of a
    /// chunk of second ones. The left sides are the same for all of these, so six equations stand for the rows.
    fn push_chunk(
        &mut self,
        others: &[Excitation<R>],
        motion: impl Fn(&Excitation<R>) -> Vector6<Complex<R>>,
        rows: impl Iterator<Item = (Vector6<Complex<R>>, [Complex<R>; CHUNK])>,
    ) {
        let mut six = ComplexLeastSquares::<R, 6, CHUNK>::new();
        for (left, right) in rows {
            self.squares += sum_of_squares(&right);
            self.unexplained += sum_of_squares(&six.push(left.into(), right));
        }
        for (place, other) in others.iter().enumerate() {
            let motion = Motion::of(&motion(other));
            for (left, right) in six.rows() {
                self.push(left, &motion, right[place]);
            }
        }
    }

    fn push(&mut self, left: &[Complex<R>; 6], motion: &Motion<R>, right: Complex<R>) {
        let [of_re, of_im] = &motion.0;
        let (mut re, mut im) = ([R::zero(); 10], [R::zero(); 10]);
        for (i, left) in left.iter().enumerate() {
            for k in 0..10 {
                re[k] += left.re * of_re[i][k] - left.im * of_im[i][k];
                im[k] += left.re * of_im[i][k] + left.im * of_re[i][k];
            }
        }
        self.equations.push(re, right.re);
        self.equations.push(im, right.im);
    }

    fn solve(&self) -> Option<Solution<R>> {
        let Spectrum { rank, condition } = self.equations.spectrum()?;
        let solution = self.equations.solve().filter(|_| rank == 10);
        let scale = scale(R::one(), self.length);
        let body = solution.and_then(|z| RigidBody::from_phi(&z.component_mul(&scale)));
        let left = self.equations.residual() + self.unexplained;
        Some(Solution { body, rank, condition, misfit: (left / self.squares).sqrt() })
    }
}

fn sum_of_squares<R: Real>(numbers: &[Complex<R>; CHUNK]) -> R {
    numbers.iter().fold(R::zero(), |sum, number| sum + number.norm_sqr())
}
