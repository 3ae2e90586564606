//! The method of Toivola and Nuutila: the ten properties from the orthogonality of five or six mode shapes.
//!
//! Mass-normalised shapes satisfy `φᵢᵀ M₀ φⱼ = δᵢⱼ`, which is linear in the ten inertial parameters. Six shapes give 21
//! equations and five give 15. Four give ten equations of rank nine, whatever the shapes (theory, section 7).

use nalgebra::Vector6;

use super::method::{Entry, Observable};
use super::suspension::{
    Answer, DOUBTS_OF_SHAPES, KnownProperty, Suspension, is_blocked, refuse_mixed_modes,
};
use crate::body::{RigidBody, regressor, scale};
use crate::diagnosis::{Code, Diagnostics, fatal};
use crate::linalg::{LeastSquares, Spectrum};
use crate::real::Real;

/// Description of the method for the registry.
pub const ENTRY: Entry = Entry {
    name: "toivola-nuutila",
    short_name: "toivola-nuutila",
    title: "Toivola-Nuutila",
    summary: "Orthogonality of five or six mode shapes, of Toivola and Nuutila",
    observes: Observable::Suspension,
    uses_priors: true,
    off_when: "a mode is missing, complex or mixed with its neighbour",
    doubted_by: DOUBTS_OF_SHAPES,
    is_blocked,
    workspace: |_, _| 0,
};

/// The answer of the method, or why there is none. Four modes are enough only with known properties; the rank of the
/// equations decides.
pub(super) fn answer<R: Real>(suspension: &Suspension<'_, R>) -> Result<Answer<R>, Diagnostics> {
    refuse_mixed_modes(suspension.modes, suspension.responses.length)?;
    let shapes: heapless::Vec<Vector6<R>, { crate::modes::MOST_PAIRS }> =
        suspension.modes.modes.iter().map(|mode| mode.shape).collect();
    let orthogonality = solve_with_known(&shapes, suspension.known, suspension.responses.length)
        .ok_or_else(|| fatal(Code::DataNotFinite, R::zero()))?;
    let Orthogonality { body, rank, condition, .. } = orthogonality;
    let body = body.ok_or_else(|| {
        let count = R::of(shapes.len() as f64);
        match shapes.len() {
            FOUR_MODES => fatal(Code::FourModesRankNine, R::of(rank as f64)),
            0..FOUR_MODES => fatal(Code::SuspensionModesMissing, count),
            _ => fatal(Code::SixModesNeeded, count),
        }
    })?;
    Ok(Answer { body, condition, misfit: None })
}

/// With this many modes there are ten equations, which are not independent.
const FOUR_MODES: usize = 4;
/// Error of an equation of orthogonality, against which the standard deviations of known properties are weighed.
const SHAPE_ERROR: f64 = 1e-3;

/// The equations of orthogonality, solved.
#[derive(Clone, Debug, PartialEq)]
pub struct Orthogonality<R> {
    /// The body; `None` when the equations do not determine it.
    pub body: Option<RigidBody<R>>,
    /// Number of equations.
    pub equations: usize,
    /// Rank of the equations: ten when they determine the ten properties.
    pub rank: usize,
    /// Rank with a known mass, of nine unknowns.
    pub rank_of_known_mass: usize,
    /// Condition of the equations.
    pub condition: R,
}

/// Solves the equations of orthogonality for these mass-normalised shapes at the origin. `length` is L in m, which
/// balances the unknowns. `None` when a number is not finite.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::toivola_nuutila::solve_orthogonality;
/// # use massline_shared::nalgebra::Vector6;
/// # use massline_shared::nalgebra::{Matrix6, SymmetricEigen};
/// // The modes on any springs: here φ = C⁻ᵀ v, where M₀ = C Cᵀ and v are orthonormal.
/// let factor = frame::body().mass_matrix().cholesky().unwrap().l();
/// let stiffness = Matrix6::from_fn(|i, j| 1.0 / (1 + i + j) as f64);
/// let shapes = factor.transpose().try_inverse().unwrap() * SymmetricEigen::new(stiffness).eigenvectors;
/// let shapes: Vec<Vector6<f64>> = shapes.column_iter().map(|shape| shape.into_owned()).collect();
/// let orthogonality = solve_orthogonality(&shapes, 0.136).unwrap();
/// assert!((orthogonality.body.unwrap().theta() - frame::body().theta()).norm() < 1e-12);
/// // Four modes are not enough, not even when the mass is known.
/// let four = solve_orthogonality(&shapes[..4], 0.136).unwrap();
/// assert_eq!((four.equations, four.rank, four.rank_of_known_mass), (10, 9, 8));
/// ```
pub fn solve_orthogonality<R: Real>(shapes: &[Vector6<R>], length: R) -> Option<Orthogonality<R>> {
    solve_with_known(shapes, &[], length)
}

/// The same with properties that are known besides.
fn solve_with_known<R: Real>(
    shapes: &[Vector6<R>],
    known: &[KnownProperty<R>],
    length: R,
) -> Option<Orthogonality<R>> {
    let scale = scale(R::one(), length);
    let mut equations = LeastSquares::<R, 10>::new();
    for KnownProperty { row, value, sigma } in known {
        let weight = R::of(SHAPE_ERROR) / *sigma;
        let row = core::array::from_fn(|k| row[k] * scale[k] * weight);
        equations.push(row, *value * weight);
    }
    let mut count = 0;
    for (j, second) in shapes.iter().enumerate() {
        let columns = regressor(second);
        for (i, first) in shapes.iter().take(j + 1).enumerate() {
            let coefficient =
                |k: usize| (0..6).fold(R::zero(), |sum, row| sum + first[row] * columns[row][k]);
            let row = core::array::from_fn(|k| coefficient(k) * scale[k]);
            equations.push(row, if i == j { R::one() } else { R::zero() });
            count += 1;
        }
    }
    let Spectrum { rank, condition } = equations.spectrum()?;
    let rank_of_known_mass = equations.last::<9>().spectrum()?.rank;
    let solution = equations.solve().filter(|_| rank == 10);
    let body = solution.and_then(|z| RigidBody::from_phi(&z.component_mul(&scale)));
    Some(Orthogonality { body, equations: count, rank, rank_of_known_mass, condition })
}
