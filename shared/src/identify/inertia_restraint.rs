//! The inertia restraint method (IRM): linear and direct, without start values.
//!
//! For each hit, the motion `x = G⁺ xm` follows from the mass lines; Newton and Euler then give six equations
//! in the ten unknowns `phi`. All hits together are solved by least squares (MATEC Web Conf. 148, 01003,
//! equations 3 to 5; theory, section 3). The unknowns are balanced by the characteristic length. Only the
//! triangular factor of the equations is stored, so the memory does not grow with the hits.

use core::array::from_fn;

use nalgebra::{Matrix6, SMatrix, SVector, Vector3, Vector6};

use super::method::{self, Entry, Observable};
use super::observations::{Observations, SpectrumBins};
use super::weighting::{Triangle6, Weighting, whiten};
use super::{DofMassLines, Estimate, MassLines, Method, ResponseInverse};
use crate::body::{RigidBody, regressor};
use crate::capacity::{Capacity, List};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, fatal};
use crate::layout::{Hit, Layout, balanced_force, balanced_motion, check_hits, is_finite};
use crate::linalg::{LeastSquares, Spectrum, all_finite, congruence};
use crate::progress::Progress;
use crate::real::Real;
use crate::responses::Responses;

/// A condition of the balanced regression matrix above this gives a warning: errors of 1 % in the mass lines
/// can then be as large as the properties themselves.
pub const ILL_CONDITIONED: f64 = 100.0;
/// Smallest number of hits at each DOF whose scatter is used for a covariance.
pub const HITS_FOR_SIGMA: u16 = 3;

/// Description of the method for the registry.
pub const ENTRY: Entry = Entry {
    name: "inertia-restraint",
    short_name: "irm",
    title: "Inertia restraint",
    summary: "Inertia restraint: linear, of the literature",
    observes: Observable::MassLines,
    uses_priors: false,
    off_when: "the suspension or an elastic mode is near the band of the mass lines",
    doubted_by: &[],
    // The method starts from the motion of the body, which the sensors have to determine.
    is_blocked: |_, _| true,
    workspace: |_, _| 0,
};

/// The point about which the equations are set up. The answer is in the body frame in any case, but the
/// choice affects the bias from noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum ReferencePoint<R> {
    /// The mean of the sensor positions; it gives the least noise (theory, section 3).
    #[default]
    Centroid,
    /// The origin of the body frame.
    Origin,
    /// A point of the body frame, m.
    At(Vector3<R>),
}

/// Settings of the method.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InertiaRestraintSettings<R> {
    /// Reference point of the equations.
    pub reference: ReferencePoint<R>,
    /// Weights of the equations.
    pub weighting: Weighting<R>,
}

impl<R: Real> InertiaRestraintSettings<R> {
    /// The settings of the rig: about the sensors' centroid, weighted by the usual placement errors.
    pub fn weighted() -> Self {
        let weighting = Weighting::Placement(super::PlacementErrors::default());
        Self { reference: ReferencePoint::Centroid, weighting }
    }
}

impl<R> From<ReferencePoint<R>> for InertiaRestraintSettings<R> {
    /// Equal weights.
    fn from(reference: ReferencePoint<R>) -> Self {
        Self { reference, weighting: Weighting::Equal }
    }
}

/// The ten properties from the mass lines of at least three hit DOFs.
///
/// `dofs` contains the index of each hit in the layout and its mass lines. The attached bodies
/// ([`Layout::attached`]) are subtracted from the answer.
///
/// The covariance comes from the scatter between the hits, `A⁺ blkdiag(M₀ G⁺ (Sⱼ/n) G⁺ᵀ M₀ᵀ) A⁺ᵀ`, when every
/// DOF has at least [`HITS_FOR_SIGMA`] hits with scatter; `A⁺` is that of the weighted equations.
///
/// # Errors
/// Every diagnostic that keeps the data from determining the ten properties: too few sensors or hits, hits
/// all parallel or through one point, rank deficiency, numbers that are not finite, a hit that the layout
/// does not have.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::inertia_restraint::{ReferencePoint, InertiaRestraintSettings, solve};
/// let layout = frame::layout();
/// let dofs = frame::mass_lines(&layout);
/// // As in the literature: equal weights, here about the origin.
/// let estimate = solve(&layout, &dofs, ReferencePoint::Origin).unwrap();
/// // Exact readings give the exact body, up to rounding.
/// assert!((estimate.theta() - frame::body().theta()).norm() < 1e-12);
/// // Without the scatter of at least three hits per DOF there is no covariance.
/// assert!(estimate.covariance.is_none());
/// // The lines of two hits define a plane: rank nine.
/// assert!(solve(&layout, &dofs[..2], InertiaRestraintSettings::weighted()).is_err());
/// ```
pub fn solve<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
    settings: impl Into<InertiaRestraintSettings<R>>,
) -> Result<Estimate<R>, Diagnostics> {
    check_data(layout, dofs)?;
    let mut answer = with_all_that_hangs_on_it(layout, dofs, settings.into());
    if let Ok(estimate) = &mut answer {
        super::attached::take_off(estimate, &layout.attached)
            .map_err(|left| fatal(Code::AttachedTooHeavy, left))?;
        comment(estimate, layout);
    }
    answer
}

/// The ten properties of the object together with the attached bodies.
fn with_all_that_hangs_on_it<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
    settings: InertiaRestraintSettings<R>,
) -> Result<Estimate<R>, Diagnostics> {
    let reference = match settings.reference {
        ReferencePoint::Centroid => layout.sensor_centroid(),
        ReferencePoint::Origin => Vector3::zeros(),
        ReferencePoint::At(point) => point,
    };
    let length = layout.characteristic_length();
    let inverse = ResponseInverse::new(&layout.response_matrix(&reference), length)
        .ok_or_else(|| fatal(Code::LayoutNotFinite, length))?;
    if inverse.rank < 6 {
        return Err(rank_deficient(layout.sensors.len(), inverse.rank));
    }
    let hits = dofs.iter().filter_map(|(index, _)| layout.hits.get(*index));
    let diagnostics = check_hits(hits, length, None);
    if !diagnostics.is_empty() {
        return Err(diagnostics);
    }
    let mut regression = Regression::new(length);
    let mut factors = C::Hits::<Option<Triangle6<R>>>::default();
    for (index, lines) in dofs {
        if let Some(hit) = layout.hits.get(*index) {
            let motion = inverse.motion(&lines.accelerance);
            let force = hit.unit_force(&reference);
            let factor = weight_factor(&settings.weighting, hit, &reference, length, lines.hits);
            regression.add_weighted(&motion, &force, factor.as_ref());
            // A hit that is given twice and finds no room is unweighted in the covariance.
            let _ = factors.push(factor);
        }
    }
    let solution = regression.solve()?;
    if solution.body.mass <= R::zero() {
        return Err(fatal(Code::MassNotPositive, solution.body.mass));
    }
    let covariance = covariance(&regression, &solution.body, &inverse, dofs, &factors);
    let body = solution.body.shifted_to(&-reference);
    Ok(Estimate {
        method: Method::InertiaRestraint,
        body,
        covariance,
        condition: solution.condition,
        consistency: None,
        learned: None,
        diagnostics: Diagnostics::new(),
    })
}

/// Runs the method behind [`identify`](super::identify), in one step.
#[derive(Clone, Copy, Debug)]
pub(super) struct Solver<R>(InertiaRestraintSettings<R>);

impl<R: Real> method::Solver<R> for Solver<R> {
    fn start<C: Capacity, L: SpectrumBins<R>>(
        _observed: &Observations<'_, R, C, L>,
        settings: &super::IdentifySettings<R>,
        _start: Option<&RigidBody<R>>,
    ) -> Result<Self, Diagnostics> {
        Ok(Self(settings.inertia_restraint))
    }

    fn step<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        _observed: &Observations<'_, R, C, L>,
        _workspace: &mut [R],
    ) -> Result<Progress, Diagnostics> {
        Ok(Progress::Done)
    }

    fn finish<C: Capacity, L: SpectrumBins<R>>(
        &mut self,
        observed: &Observations<'_, R, C, L>,
        _workspace: &mut [R],
    ) -> Result<Estimate<R>, Diagnostics> {
        solve(observed.layout, observed.mass_lines, self.0)
    }
}

/// The balanced least squares problem of the method, hit by hit.
///
/// Also usable with motions that were not measured by the sensors of a layout.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::inertia_restraint::Regression;
/// # use massline_shared::nalgebra::Vector3;
/// let (layout, body) = (frame::layout(), frame::body());
/// let mut regression = Regression::new(layout.characteristic_length());
/// for hit in layout.hits.iter() {
///     let force = hit.unit_force(&Vector3::zeros());
///     let motion = body.acceleration(&force).unwrap();
///     regression.add(&motion, &force);
/// }
/// let solution = regression.solve().unwrap();
/// assert!((solution.body.mass - 1.23).abs() < 1e-12);
/// assert!((solution.condition - 21.0).abs() < 0.5); // theory, section 8
/// ```
#[derive(Clone, Debug)]
pub struct Regression<R> {
    equations: LeastSquares<R, 10>,
    length: R,
}

/// Solution of a [`Regression`], about its reference point.
#[derive(Clone, Debug, PartialEq)]
pub struct InertiaRestraintSolution<R> {
    /// [m, m c, J about the reference point].
    pub phi: SVector<R, 10>,
    /// The same result as a body whose origin is the reference point.
    pub body: RigidBody<R>,
    /// Rank of the balanced matrix: ten.
    pub rank: usize,
    /// Condition of the balanced matrix.
    pub condition: R,
    /// Root mean square of the residuals of all balanced equations.
    pub rms: R,
}

impl<R: Real> Regression<R> {
    /// A regression without hits; `length` is L in m.
    pub fn new(length: R) -> Self {
        Self { equations: LeastSquares::new(), length }
    }

    /// Adds the six equations of one hit from the motion `[a; α]` of the reference point and the
    /// force and torque `[F; T]` about it.
    pub fn add(&mut self, motion: &Vector6<R>, force: &Vector6<R>) {
        self.add_weighted(motion, force, None);
    }

    /// As [`Regression::add`], with the equations multiplied by the inverse of a lower triangular
    /// factor of their covariance.
    fn add_weighted(
        &mut self,
        motion: &Vector6<R>,
        force: &Vector6<R>,
        factor: Option<&Triangle6<R>>,
    ) {
        let mut rows = regressor(&balanced_motion(motion, self.length));
        let right: [R; 6] = balanced_force(force, self.length).into();
        let mut right = right.map(|value| [value]);
        if let Some(factor) = factor {
            whiten(factor, &mut rows);
            whiten(factor, &mut right);
        }
        for (row, [right]) in rows.into_iter().zip(right) {
            self.equations.push(row, right);
        }
    }

    /// Solves.
    ///
    /// # Errors
    /// `data_not_finite`, `ten_parameters_not_identifiable`.
    pub fn solve(&self) -> Result<InertiaRestraintSolution<R>, Diagnostics> {
        let Some(Spectrum { rank, condition }) = self.equations.spectrum() else {
            return Err(fatal(Code::DataNotFinite, R::zero()));
        };
        if rank < 10 {
            return Err(fatal(Code::TenParametersNotIdentifiable, R::of(rank as f64)));
        }
        let balanced = self
            .equations
            .solve()
            .ok_or_else(|| fatal(Code::TenParametersNotIdentifiable, R::of(9.0)))?;
        let phi = balanced.component_mul(&self.scale());
        let body =
            RigidBody::from_phi(&phi).ok_or_else(|| fatal(Code::DataNotFinite, R::zero()))?;
        Ok(InertiaRestraintSolution { phi, body, rank, condition, rms: self.equations.rms() })
    }

    /// [1, L, L, L, L² × 6]: scales of `phi` and of `theta` relative to the balanced variables.
    fn scale(&self) -> SVector<R, 10> {
        SVector::from_fn(|k, _| match k {
            0 => R::one(),
            1..4 => self.length,
            _ => self.length * self.length,
        })
    }
}

/// Factor of the covariance of a hit's equations; `None` for equal weights.
fn weight_factor<R: Real>(
    weighting: &Weighting<R>,
    hit: &Hit<R>,
    reference: &Vector3<R>,
    length: R,
    hits: u16,
) -> Option<Triangle6<R>> {
    match weighting {
        Weighting::Equal => None,
        Weighting::Placement(errors) => {
            let arm = Vector3::from(hit.position) - reference;
            errors.factor(&arm, &Vector3::from(hit.direction), length, hits)
        }
    }
}

/// `C⁻¹ W C⁻ᵀ`.
fn whiten_both_sides<R: Real>(factor: &Triangle6<R>, weight: &Matrix6<R>) -> Matrix6<R> {
    let mut rows: [[R; 6]; 6] = from_fn(|i| from_fn(|j| weight[(i, j)]));
    whiten(factor, &mut rows);
    rows = from_fn(|i| from_fn(|j| rows[j][i]));
    whiten(factor, &mut rows);
    Matrix6::from_fn(|i, j| rows[i][j])
}

/// Covariance of theta from the scatter of the hits, in balanced variables until the end. `Aⱼᵀ Wⱼ Aⱼ` is
/// summed over the hits and multiplied by `(Aᵀ A)⁻¹` on both sides.
fn covariance<R: Real, C: Capacity>(
    regression: &Regression<R>,
    body: &RigidBody<R>,
    inverse: &ResponseInverse<R, C>,
    dofs: &[DofMassLines<R, C>],
    factors: &[Option<Triangle6<R>>],
) -> Option<SMatrix<R, 10, 10>> {
    let scatters =
        |lines: &MassLines<R, C>| lines.hits >= HITS_FOR_SIGMA && !lines.scatter.is_zero();
    if !dofs.iter().all(|(_, lines)| scatters(lines)) {
        return None;
    }
    let length = regression.length;
    let balanced = RigidBody {
        mass: body.mass,
        center_of_mass: body.center_of_mass / length,
        inertia: body.inertia / (length * length),
    };
    // The transposed map from readings to balanced forces.
    let mut forces = inverse.transposed.clone();
    forces.0.iter_mut().skip(3).flat_map(Responses::iter_mut).for_each(|value| *value *= length);
    let forces = forces.times_matrix(&balanced.mass_matrix());
    let mut sum = SMatrix::<R, 10, 10>::zeros();
    for (number, (_, lines)) in dofs.iter().enumerate() {
        let spread = forces.0.each_ref().map(|force| lines.scatter.times(force));
        let hits = R::of(f64::from(lines.hits));
        let mut weight = Matrix6::from_fn(|i, j| spread[i].dot(&forces.0[j]) / hits);
        let motion = balanced_motion(&inverse.motion(&lines.accelerance), regression.length);
        let mut rows = regressor(&motion);
        if let Some(Some(factor)) = factors.get(number) {
            whiten(factor, &mut rows);
            weight = whiten_both_sides(factor, &weight);
        }
        add_congruence(&mut sum, &rows, &weight);
    }
    sum.fill_lower_triangle_with_upper_triangle();
    close(regression, &balanced, sum)
}

/// Covariance of theta from the sum of `Aⱼᵀ Wⱼ Aⱼ` over the hits.
fn close<R: Real>(
    regression: &Regression<R>,
    balanced: &RigidBody<R>,
    mut sum: SMatrix<R, 10, 10>,
) -> Option<SMatrix<R, 10, 10>> {
    // (AᵀA)⁻¹ S (AᵀA)⁻¹: applied on the left, then on the right by symmetry.
    for _side in 0..2 {
        if !regression.equations.solve_normal(&mut sum.data.0) {
            return None;
        }
        sum.transpose_mut();
    }
    congruence(&balanced.dtheta_dphi(), &mut sum);
    let scale = regression.scale();
    for j in 0..10 {
        for i in 0..=j {
            // The two halves differ by rounding.
            let mean = (sum[(i, j)] + sum[(j, i)]) * R::of(0.5);
            sum[(i, j)] = mean * scale[i] * scale[j];
            sum[(j, i)] = sum[(i, j)];
        }
    }
    all_finite(&sum).then_some(sum)
}

/// `sum += Aᵀ W A` for the six rows of one hit; zeros of A are skipped.
fn add_congruence<R: Real>(sum: &mut SMatrix<R, 10, 10>, rows: &[[R; 10]; 6], weight: &Matrix6<R>) {
    let zero = R::zero();
    for (i, left) in rows.iter().enumerate() {
        let mut weighted = [zero; 10];
        for (k, right) in rows.iter().enumerate() {
            let w = weight[(i, k)];
            for (to, v) in weighted.iter_mut().zip(right) {
                *to += w * *v;
            }
        }
        for (mut column, v) in sum.column_iter_mut().zip(left) {
            if *v != zero {
                for (to, w) in column.iter_mut().zip(&weighted) {
                    *to += *v * *w;
                }
            }
        }
    }
}

/// Refuses a layout or data that are not finite, and hits that the layout does not have.
fn check_data<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    dofs: &[DofMassLines<R, C>],
) -> Result<(), Diagnostics> {
    if !is_finite(layout) {
        return Err(fatal(Code::LayoutNotFinite, R::zero()));
    }
    super::check_mass_lines(layout, dofs)
}

fn rank_deficient(sensors: usize, rank: usize) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    if sensors < 3 {
        diagnostics = fatal::<f32>(Code::FewerThanThreeSensors, sensors as f32);
    } else if rank == 5 {
        // Three triaxial sensors miss only one motion: the rotation about the line through them.
        diagnostics = fatal::<f32>(Code::SensorsCollinear, 0.0);
    }
    let deficient = Diagnostic::whole(Code::ResponseRankDeficient, Severity::Error, rank as f32);
    let _ = diagnostics.push(deficient);
    diagnostics
}

/// Adds the diagnostics of an answer.
fn comment<R: Real, C: Capacity>(estimate: &mut Estimate<R>, layout: &Layout<R, C>) {
    let mut push_diagnostic = |code, severity, value: R| {
        // At most four are pushed.
        let _ = estimate.diagnostics.push(Diagnostic::whole(code, severity, value.to_f32()));
    };
    if !estimate.body.is_physically_consistent() {
        let margin = estimate.body.physical_margin().unwrap_or(R::zero());
        push_diagnostic(Code::NotPhysicallyConsistent, Severity::Warning, margin);
    }
    if estimate.condition > R::of(ILL_CONDITIONED) {
        push_diagnostic(Code::IllConditioned, Severity::Warning, estimate.condition);
    }
    if estimate.covariance.is_some() {
        push_diagnostic(Code::SigmaCoversScatterOnly, Severity::Note, R::zero());
    } else {
        push_diagnostic(Code::TooFewHitsForSigma, Severity::Warning, R::zero());
    }
    if layout.lacks_gravity() {
        push_diagnostic(Code::GravityNotGiven, Severity::Note, R::zero());
    }
}

#[cfg(test)]
mod tests;
