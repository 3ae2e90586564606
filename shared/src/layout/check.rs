//! Diagnosis of a layout: whether it can determine the ten properties at all.
//!
//! Every fact has a code; the thresholds are documented with the codes in [`crate::diagnosis::Code`].

use nalgebra::{Matrix3, Vector3};

use super::{Hit, Layout, Sensor};
use crate::body::{RigidBody, regressor};
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity, Subject};
use crate::linalg::{LeastSquares, Spectrum, symmetric_eigen3};
use crate::real::Real;

/// Below this fraction of its scale a quantity counts as nearly zero: collinear, parallel, concurrent,
/// through the centre of mass. 2 %.
pub const DEGENERACY_RATIO: f64 = 0.02;
/// Tolerance for unit length and right angles of axes: three digits of a typed direction. It costs 0.1 % of a
/// reading.
pub const AXES_TOLERANCE: f64 = 1e-3;
/// Sensors closer together than this count as one point, m.
const ONE_POINT: f64 = 1e-6;

/// The figures behind the diagnosis of a layout, about the origin of the body frame.
///
/// Theory, sections 4 and 8.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::diagnosis::Code;
/// # use massline_shared::layout::LayoutReport;
/// let mut layout = frame::layout();
/// let report = LayoutReport::new(&layout, Some(&frame::body()));
/// assert!(report.diagnostics.is_empty());
/// assert_eq!((report.rank_g, report.rank_a), (6, Some(10)));
/// // All three hits in one direction turn the body about two axes only.
/// for hit in layout.hits.iter_mut() {
///     hit.direction = [0.0, 0.0, 1.0];
/// }
/// let report = LayoutReport::new(&layout, Some(&frame::body()));
/// assert!(report.diagnostics.iter().any(|diagnostic| diagnostic.code == Code::HitsAllParallel));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutReport<R> {
    /// Everything that prevents an answer, as in [`check_geometry`].
    pub diagnostics: Diagnostics,
    /// Characteristic length L, m.
    pub length: R,
    /// Rank of `G diag(1, 1, 1, 1/L, 1/L, 1/L)`; six when the sensors determine every motion.
    pub rank_g: usize,
    /// Condition of that matrix.
    pub condition_g: R,
    /// Rank of the unit forces and their torques; six at most.
    pub rank_f: usize,
    /// Rank of the balanced regression matrix under the motion that the hits give the body; ten when all
    /// properties can be determined. `None` without a body.
    pub rank_a: Option<usize>,
    /// Condition of the balanced regression matrix. `None` without a body.
    pub condition_a: Option<R>,
}

/// Everything about sensors, hits and axes that prevents an answer of the inertia restraint method, each as
/// an error with its code.
///
/// `body` is the assumed body of the object, for the codes that need one (`hits_through_centre_of_mass`,
/// `ten_parameters_not_identifiable`); use [`assumed_body`] when nothing is known. Needs less than 6 KiB of
/// stack in single precision.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::diagnosis::Code;
/// # use massline_shared::layout::{assumed_body, check_geometry};
/// let mut layout = frame::layout();
/// // Only the positions of the object's nodes are known.
/// let guess = assumed_body(None, layout.sensors.iter().map(|sensor| sensor.position));
/// assert!(check_geometry(&layout, Some(&guess)).is_empty());
/// layout.sensors[1].position = [0.1, 0.0, 0.0];
/// let diagnostics = check_geometry(&layout, Some(&guess));
/// assert!(diagnostics.iter().any(|problem| problem.code == Code::SensorsCollinear));
/// ```
pub fn check_geometry<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    body: Option<&RigidBody<R>>,
) -> Diagnostics {
    LayoutReport::new(layout, body).diagnostics
}

impl<R: Real> LayoutReport<R> {
    /// Examines a layout and, when something is known of it, the body.
    pub fn new<C: Capacity>(layout: &Layout<R, C>, body: Option<&RigidBody<R>>) -> Self {
        let mut report = Self {
            diagnostics: Diagnostics::new(),
            length: R::one(),
            rank_g: 0,
            condition_g: R::zero(),
            rank_f: 0,
            rank_a: None,
            condition_a: None,
        };
        if !is_finite(layout) {
            error(&mut report.diagnostics, Code::LayoutNotFinite, R::zero());
            return report;
        }
        report.length = layout.characteristic_length();
        report.look_at_axes(layout);
        report.look_at_sensors(layout);
        for diagnostic in check_hits(layout.hits.iter(), report.length, body) {
            let _ = report.diagnostics.push(diagnostic);
        }
        report.look_at_forces(layout);
        if let Some(body) = body {
            report.look_at_regression(layout, body);
        }
        report
    }

    fn look_at_axes<C: Capacity>(&mut self, layout: &Layout<R, C>) {
        for (i, sensor) in layout.sensors.iter().enumerate() {
            let axes = sensor.axes_matrix();
            let error = (axes * axes.transpose() - Matrix3::identity()).amax();
            self.axes_error(Subject::sensor(i), error);
        }
        for (j, hit) in layout.hits.iter().enumerate() {
            let error = (Vector3::from(hit.direction).norm() - R::one()).abs();
            self.axes_error(Subject::hit(j), error);
        }
    }

    fn axes_error(&mut self, subject: Subject, error: R) {
        if error > R::of(AXES_TOLERANCE) {
            let code = Code::AxesNotOrthonormal;
            let diagnostic = Diagnostic::about(code, Severity::Error, subject, error.to_f32());
            // There is room for sixteen diagnostics; any others are dropped.
            let _ = self.diagnostics.push(diagnostic);
        }
    }

    fn look_at_sensors<C: Capacity>(&mut self, layout: &Layout<R, C>) {
        let diagnostics = &mut self.diagnostics;
        for (i, sensor) in layout.sensors.iter().enumerate() {
            if layout.sensors.iter().take(i).any(|other| stand_together(sensor, other)) {
                let twice = Diagnostic::about(
                    Code::TwoSensorsOnOneNode,
                    Severity::Error,
                    Subject::sensor(i),
                    f32::from(sensor.node),
                );
                let _ = diagnostics.push(twice);
            }
        }
        if layout.sensors.len() < 3 {
            error(diagnostics, Code::FewerThanThreeSensors, R::of(layout.sensors.len() as f64));
        } else {
            let flatness = second_to_first(&sensor_spread(layout));
            if flatness < R::of(DEGENERACY_RATIO) {
                error(diagnostics, Code::SensorsCollinear, flatness);
            }
        }
        let mut responses = LeastSquares::<R, 6>::new();
        for sensor in layout.sensors.iter() {
            let rows = sensor.response_rows(&Vector3::zeros());
            for i in 0..3 {
                let over_length = |j: usize| if j < 3 { R::one() } else { R::one() / self.length };
                let row = core::array::from_fn(|j| rows[(i, j)] * over_length(j));
                responses.push(row, R::zero());
            }
        }
        let spectrum = spectrum_of(&responses);
        (self.rank_g, self.condition_g) = (spectrum.rank, spectrum.condition);
        if self.rank_g < 6 {
            error(diagnostics, Code::ResponseRankDeficient, R::of(self.rank_g as f64));
        }
    }

    fn look_at_forces<C: Capacity>(&mut self, layout: &Layout<R, C>) {
        let mut forces = LeastSquares::<R, 6>::new();
        for hit in layout.hits.iter() {
            let mut force = hit.unit_force(&Vector3::zeros());
            force.fixed_rows_mut::<3>(3).unscale_mut(self.length);
            forces.push(force.into(), R::zero());
        }
        self.rank_f = spectrum_of(&forces).rank;
    }

    fn look_at_regression<C: Capacity>(&mut self, layout: &Layout<R, C>, body: &RigidBody<R>) {
        let mut regression = LeastSquares::<R, 10>::new();
        for hit in layout.hits.iter() {
            let Some(mut motion) = body.acceleration(&hit.unit_force(&Vector3::zeros())) else {
                error(&mut self.diagnostics, Code::TenParametersNotIdentifiable, R::zero());
                return;
            };
            motion.fixed_rows_mut::<3>(3).scale_mut(self.length);
            for row in regressor(&motion) {
                regression.push(row, R::zero());
            }
        }
        let spectrum = spectrum_of(&regression);
        self.rank_a = Some(spectrum.rank);
        self.condition_a = Some(spectrum.condition);
        if spectrum.rank < 10 {
            let rank = R::of(spectrum.rank as f64);
            error(&mut self.diagnostics, Code::TenParametersNotIdentifiable, rank);
        }
    }
}

/// Everything that keeps these hits from determining the ten properties, each as an error: fewer than three,
/// all parallel, all through one point, all through the centre of mass. `length` is L in m.
pub fn check_hits<'a, R: Real>(
    hits: impl Iterator<Item = &'a Hit<R>> + Clone,
    length: R,
    body: Option<&RigidBody<R>>,
) -> Diagnostics {
    let mut diagnostics = Diagnostics::new();
    let count = hits.clone().count();
    if count < 3 {
        error(&mut diagnostics, Code::FewerThanThreeHits, R::of(count as f64));
    }
    if count < 2 {
        return diagnostics;
    }
    let mut spread = Matrix3::zeros();
    for hit in hits.clone() {
        let d = Vector3::from(hit.direction);
        spread += d * d.transpose();
    }
    let parallel = second_to_first(&spread);
    if parallel < R::of(DEGENERACY_RATIO) {
        error(&mut diagnostics, Code::HitsAllParallel, parallel);
    }
    let distance = |point: &Vector3<R>| {
        hits.clone().map(|hit| lever(hit, point)).fold(R::zero(), |a, b| a.max(b)) / length
    };
    if let Some(distance) = nearest_point(hits.clone()).map(|point| distance(&point))
        && distance < R::of(DEGENERACY_RATIO)
    {
        error(&mut diagnostics, Code::HitsConcurrent, distance);
    }
    if let Some(distance) = body.map(|body| distance(&body.center_of_mass))
        && distance < R::of(DEGENERACY_RATIO)
    {
        error(&mut diagnostics, Code::HitsThroughCentreOfMass, distance);
    }
    diagnostics
}

/// Vector from the mean of the nodes to the assumed centre of mass, over L.
const BESIDE: [f64; 3] = [0.060, -0.048, 0.064];

/// Assumed body for checking a layout when nothing better is known: the given mass or 1 kg, inertia `m L² I`
/// with the size L from [`extent`], centre of mass a tenth of L from the mean of the nodes.
///
/// The offset has no special direction, because the centre of an unknown body is at no special point: the
/// mean of nodes in a plane lies in that plane, and a layout that determines almost every body might not
/// determine one there.
pub fn assumed_body<R: Real>(
    mass: Option<R>,
    nodes: impl Iterator<Item = [R; 3]> + Clone,
) -> RigidBody<R> {
    let mass = mass.unwrap_or(R::one());
    let (centroid, length) = extent(nodes);
    let beside = Vector3::from(BESIDE.map(R::of)) * length;
    RigidBody {
        mass,
        center_of_mass: centroid + beside,
        inertia: Matrix3::from_diagonal_element(mass * length * length),
    }
}

/// Mean of the nodes and their root mean square distance from it, m; one metre when they are in one
/// point.
pub fn extent<R: Real>(nodes: impl Iterator<Item = [R; 3]> + Clone) -> (Vector3<R>, R) {
    let count = R::of(nodes.clone().count().max(1) as f64);
    let sum = nodes.clone().fold(Vector3::zeros(), |sum, node| sum + Vector3::from(node));
    let centroid = sum / count;
    let squares =
        nodes.fold(R::zero(), |sum, node| sum + (Vector3::from(node) - centroid).norm_squared());
    let length = (squares / count).sqrt();
    (centroid, if length > R::zero() { length } else { R::one() })
}

fn error<R: Real>(diagnostics: &mut Diagnostics, code: Code, value: R) {
    // There is room for sixteen diagnostics; any others are dropped.
    let _ = diagnostics.push(Diagnostic::whole(code, Severity::Error, value.to_f32()));
}

/// True when no number of a layout is NaN or infinite, no standard deviation is negative, and target, priors
/// and attached bodies are valid.
pub(crate) fn is_finite<R: Real, C: Capacity>(layout: &Layout<R, C>) -> bool {
    let gravity = layout.gravity.iter().flatten();
    let sensors =
        layout.sensors.iter().flat_map(|s| s.position.iter().chain(s.axes.iter().flatten()));
    let hits = layout.hits.iter().flat_map(|h| h.position.iter().chain(h.direction.iter()));
    let attached = layout.attached.iter().flat_map(|a| a.phi.iter());
    let deviations = layout.sensors.iter().flat_map(|s| s.uncertainty.values());
    let marks = layout.hits.iter().flat_map(|h| h.uncertainty.values());
    let masses = layout.attached.iter().map(|a| &a.relative_sigma);
    let shared = layout.apparatus.values();
    let mut deviations = deviations.chain(marks).chain(masses).chain(shared);
    let zero = R::zero();
    gravity.chain(sensors).chain(hits).chain(attached).all(|v| v.finite())
        && deviations.all(|v| v.finite() && *v >= zero)
        && layout
            .priors
            .iter()
            .all(|p| p.property < 10 && p.value.finite() && p.sigma.finite() && p.sigma > zero)
        && layout.attached.iter().all(|a| a.phi[0] > zero)
        && layout.target.requested_half_widths().all(|v| v.finite() && v > zero)
}

fn stand_together<R: Real>(a: &Sensor<R>, b: &Sensor<R>) -> bool {
    let distance = (Vector3::from(a.position) - Vector3::from(b.position)).norm();
    a.node == b.node || distance < R::of(ONE_POINT)
}

/// `Σ (p − p̄)(p − p̄)ᵀ` over the sensors.
fn sensor_spread<R: Real, C: Capacity>(layout: &Layout<R, C>) -> Matrix3<R> {
    let centroid = layout.sensor_centroid();
    layout.sensors.iter().fold(Matrix3::zeros(), |sum, s| {
        let arm = Vector3::from(s.position) - centroid;
        sum + arm * arm.transpose()
    })
}

/// Ratio of the second to the first singular value of the vectors whose outer products sum up to `spread`.
/// The eigenvalues are the squares: 2 % becomes 4e-4, far above the rounding in single precision.
fn second_to_first<R: Real>(spread: &Matrix3<R>) -> R {
    match symmetric_eigen3(spread) {
        Some((values, _)) if values[2] > R::zero() => (values[1].max(R::zero()) / values[2]).sqrt(),
        _ => R::zero(),
    }
}

/// The point with the least sum of squared distances to the lines of action:
/// `Σ (I − d dᵀ) P = Σ (I − d dᵀ) q`, solved about the mean of the points of action. A direction to which all
/// lines are parallel is left out.
fn nearest_point<'a, R: Real>(
    hits: impl Iterator<Item = &'a Hit<R>> + Clone,
) -> Option<Vector3<R>> {
    let mut mean = Vector3::zeros();
    let mut count = R::zero();
    for hit in hits.clone() {
        mean += Vector3::from(hit.position);
        count += R::one();
    }
    mean /= count.max(R::one());
    let mut normal = Matrix3::zeros();
    let mut right = Vector3::zeros();
    for hit in hits {
        let d = Vector3::from(hit.direction);
        let across = Matrix3::identity() - d * d.transpose();
        normal += across;
        right += across * (Vector3::from(hit.position) - mean);
    }
    let (values, vectors) = symmetric_eigen3(&normal)?;
    let mut point = mean;
    for k in 0..3 {
        // Lines within 1 mrad of each other have no usable intersection.
        if values[k] > R::of(1e-6) * values[2] {
            let axis = vectors.column(k);
            point += axis * (axis.dot(&right) / values[k]);
        }
    }
    Some(point)
}

/// Distance of a hit's line of action from a point.
fn lever<R: Real>(hit: &Hit<R>, point: &Vector3<R>) -> R {
    (Vector3::from(hit.position) - point).cross(&Vector3::from(hit.direction)).norm()
}

/// Rank and condition; rank zero when a number is not finite.
fn spectrum_of<R: Real, const N: usize>(equations: &LeastSquares<R, N>) -> Spectrum<R> {
    equations.spectrum().unwrap_or(Spectrum { rank: 0, condition: R::zero() })
}

#[cfg(test)]
mod tests;
