//! Diagnosis of a layout: can it determine the ten properties at all?
//!
//! Every fact has a code; the thresholds stand with the codes in [`crate::diagnosis::Code`].

use nalgebra::{Matrix3, SMatrix, Vector3};

use super::{Hit, Layout, Sensor};
use crate::Real;
use crate::body::{RigidBody, regressor};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::linalg::{Conditioned, LeastSquares, Spectrum, symmetric_eigen3};

/// What is below this part of its scale counts as nearly nothing: collinear, parallel, concurrent,
/// through the centre of mass. 2 %.
pub const NEARLY: f64 = 0.02;
/// Axes may miss unit length and right angles by this: three digits of a typed direction. It costs
/// 0.1 % of a reading.
pub const AXES_TOLERANCE: f64 = 1e-3;
/// Sensors closer than this are in one point, m.
const ONE_POINT: f64 = 1e-6;

/// The figures behind the diagnosis of a layout, about the origin of the body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct LayoutReport<R> {
    /// What stands in the way of an answer, as in [`check_geometry`].
    pub diagnostics: Diagnostics,
    /// Characteristic length L, m.
    pub length: R,
    /// Rank of `G diag(1, 1, 1, 1/L, 1/L, 1/L)`; six when the sensors tell every motion.
    pub rank_g: usize,
    /// Its condition.
    pub condition_g: R,
    /// Rank of the unit forces and their torques; six at most.
    pub rank_f: usize,
    /// Rank of the balanced regression matrix under the motion that the hits give the body; ten
    /// when all properties can be told. `None` without a body.
    pub rank_a: Option<usize>,
    /// Its condition. `None` without a body.
    pub condition_a: Option<R>,
}

/// Everything about sensors, hits and axes that keeps the inertia restraint method from an answer,
/// each as an error with its code.
///
/// `body` is what the object is thought to be, for the codes that need one
/// (`hits_through_centre_of_mass`, `ten_parameters_not_identifiable`); [`assumed_body`] helps when
/// nothing is known. Needs less than 6 KiB of stack in single precision.
pub fn check_geometry<R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    body: Option<&RigidBody<R>>,
) -> Diagnostics {
    LayoutReport::new(layout, body).diagnostics
}

impl<R: Real> LayoutReport<R> {
    /// Of a layout and, when something is known of it, the body.
    pub fn new<const S: usize, const H: usize>(
        layout: &Layout<R, S, H>,
        body: Option<&RigidBody<R>>,
    ) -> Self {
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
        for found in check_hits(layout.hits.iter(), report.length, body) {
            let _ = report.diagnostics.push(found);
        }
        report.look_at_forces(layout);
        if let Some(body) = body {
            report.look_at_regression(layout, body);
        }
        report
    }

    fn look_at_axes<const S: usize, const H: usize>(&mut self, layout: &Layout<R, S, H>) {
        for (i, sensor) in layout.sensors.iter().enumerate() {
            let axes = sensor.axes_matrix();
            let miss = (axes * axes.transpose() - Matrix3::identity()).amax();
            self.error_about(Code::AxesNotOrthonormal, i, miss, R::of(AXES_TOLERANCE));
        }
        for (j, hit) in layout.hits.iter().enumerate() {
            let miss = (Vector3::from(hit.direction).norm() - R::one()).abs();
            self.error_about(Code::AxesNotOrthonormal, S + j, miss, R::of(AXES_TOLERANCE));
        }
    }

    fn error_about(&mut self, code: Code, subject: usize, value: R, limit: R) {
        if value > limit {
            let found = Diagnostic::about(code, Severity::Error, subject as u16, value.to_f32());
            // Sixteen facts are enough to say; more are dropped.
            let _ = self.diagnostics.push(found);
        }
    }

    fn look_at_sensors<const S: usize, const H: usize>(&mut self, layout: &Layout<R, S, H>) {
        let found = &mut self.diagnostics;
        for (i, sensor) in layout.sensors.iter().enumerate() {
            if layout.sensors.iter().take(i).any(|other| stand_together(sensor, other)) {
                let twice = Diagnostic::about(
                    Code::TwoSensorsOnOneNode,
                    Severity::Error,
                    i as u16,
                    f32::from(sensor.node),
                );
                let _ = found.push(twice);
            }
        }
        if layout.sensors.len() < 3 {
            error(found, Code::FewerThanThreeSensors, R::of(layout.sensors.len() as f64));
        } else {
            let flatness = second_to_first(&sensor_spread(layout));
            if flatness < R::of(NEARLY) {
                error(found, Code::SensorsCollinear, flatness);
            }
        }
        let mut responses = LeastSquares::<R, 6>::new();
        for sensor in &layout.sensors {
            let rows = sensor.response_rows(&Vector3::zeros());
            for i in 0..3 {
                let over_length = |j: usize| if j < 3 { R::one() } else { R::one() / self.length };
                let row = core::array::from_fn(|j| rows[(i, j)] * over_length(j));
                responses.push(row, R::zero());
            }
        }
        let spectrum = spectrum_of(&responses.factor());
        (self.rank_g, self.condition_g) = (spectrum.rank, spectrum.condition);
        if self.rank_g < 6 {
            error(found, Code::ResponseRankDeficient, R::of(self.rank_g as f64));
        }
    }

    fn look_at_forces<const S: usize, const H: usize>(&mut self, layout: &Layout<R, S, H>) {
        let mut forces = LeastSquares::<R, 6>::new();
        for hit in &layout.hits {
            let mut force = hit.unit_force(&Vector3::zeros());
            force.fixed_rows_mut::<3>(3).unscale_mut(self.length);
            forces.push(force.into(), R::zero());
        }
        self.rank_f = spectrum_of(&forces.factor()).rank;
    }

    fn look_at_regression<const S: usize, const H: usize>(
        &mut self,
        layout: &Layout<R, S, H>,
        body: &RigidBody<R>,
    ) {
        let mut regression = LeastSquares::<R, 10>::new();
        for hit in &layout.hits {
            let Some(mut motion) = body.acceleration(&hit.unit_force(&Vector3::zeros())) else {
                error(&mut self.diagnostics, Code::TenParametersNotIdentifiable, R::zero());
                return;
            };
            motion.fixed_rows_mut::<3>(3).scale_mut(self.length);
            for row in regressor(&motion) {
                regression.push(row, R::zero());
            }
        }
        let spectrum = spectrum_of(&regression.factor());
        self.rank_a = Some(spectrum.rank);
        self.condition_a = Some(spectrum.condition);
        if spectrum.rank < 10 {
            let rank = R::of(spectrum.rank as f64);
            error(&mut self.diagnostics, Code::TenParametersNotIdentifiable, rank);
        }
    }
}

/// What keeps these hits from determining the ten properties, each as an error: fewer than three,
/// all parallel, all through one point, all through the centre of mass. `length` is L in m.
pub fn check_hits<'a, R: Real>(
    hits: impl Iterator<Item = &'a Hit<R>> + Clone,
    length: R,
    body: Option<&RigidBody<R>>,
) -> Diagnostics {
    let mut found = Diagnostics::new();
    let count = hits.clone().count();
    if count < 3 {
        error(&mut found, Code::FewerThanThreeHits, R::of(count as f64));
    }
    if count < 2 {
        return found;
    }
    let mut spread = Matrix3::zeros();
    for hit in hits.clone() {
        let d = Vector3::from(hit.direction);
        spread += d * d.transpose();
    }
    let parallel = second_to_first(&spread);
    if parallel < R::of(NEARLY) {
        error(&mut found, Code::HitsAllParallel, parallel);
    }
    let miss = |point: &Vector3<R>| {
        hits.clone().map(|hit| lever(hit, point)).fold(R::zero(), |a, b| a.max(b)) / length
    };
    if let Some(miss) = nearest_point(hits.clone()).map(|point| miss(&point))
        && miss < R::of(NEARLY)
    {
        error(&mut found, Code::HitsConcurrent, miss);
    }
    if let Some(miss) = body.map(|body| miss(&body.center_of_mass))
        && miss < R::of(NEARLY)
    {
        error(&mut found, Code::HitsThroughCentreOfMass, miss);
    }
    found
}

/// A body to check a layout with when nothing better is known: the given mass or 1 kg, centre of
/// mass at the mean of the node positions, inertia `m L² I`.
pub fn assumed_body<R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    mass: Option<R>,
    nodes: impl Iterator<Item = [R; 3]>,
) -> RigidBody<R> {
    let mass = mass.unwrap_or(R::one());
    let mut sum = Vector3::zeros();
    let mut count = R::zero();
    for node in nodes {
        sum += Vector3::from(node);
        count += R::one();
    }
    let length = layout.characteristic_length();
    RigidBody {
        mass,
        center_of_mass: sum / count.max(R::one()),
        inertia: Matrix3::from_diagonal_element(mass * length * length),
    }
}

fn error<R: Real>(found: &mut Diagnostics, code: Code, value: R) {
    // Sixteen facts are enough to say; more are dropped.
    let _ = found.push(Diagnostic::whole(code, Severity::Error, value.to_f32()));
}

/// True when no number of sensors, hits and gravity is NaN or infinite.
pub(crate) fn is_finite<R: Real, const S: usize, const H: usize>(layout: &Layout<R, S, H>) -> bool {
    let gravity = layout.gravity.iter().flatten();
    let sensors =
        layout.sensors.iter().flat_map(|s| s.position.iter().chain(s.axes.iter().flatten()));
    let hits = layout.hits.iter().flat_map(|h| h.position.iter().chain(h.direction.iter()));
    gravity.chain(sensors).chain(hits).all(|v| v.finite())
}

fn stand_together<R: Real>(a: &Sensor<R>, b: &Sensor<R>) -> bool {
    let apart = (Vector3::from(a.position) - Vector3::from(b.position)).norm();
    a.node == b.node || apart < R::of(ONE_POINT)
}

/// `Σ (p − p̄)(p − p̄)ᵀ` over the sensors.
fn sensor_spread<R: Real, const S: usize, const H: usize>(layout: &Layout<R, S, H>) -> Matrix3<R> {
    let centroid = layout.sensor_centroid();
    layout.sensors.iter().fold(Matrix3::zeros(), |sum, s| {
        let arm = Vector3::from(s.position) - centroid;
        sum + arm * arm.transpose()
    })
}

/// Second over first singular value of the vectors whose outer products sum up to `spread`. The
/// eigenvalues are the squares: 2 % shows as 4e-4, far above the rounding in single precision.
fn second_to_first<R: Real>(spread: &Matrix3<R>) -> R {
    match symmetric_eigen3(spread) {
        Some((values, _)) if values[2] > R::zero() => (values[1].max(R::zero()) / values[2]).sqrt(),
        _ => R::zero(),
    }
}

/// The point with the least sum of squared distances to the lines of action:
/// `Σ (I − d dᵀ) P = Σ (I − d dᵀ) q`, solved about the mean of the points of action. A direction
/// along which all lines are parallel is left out.
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
        // Lines within 1 mrad of each other meet nowhere that can be told.
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

/// Rank and condition; a factor that is not finite has the rank zero.
fn spectrum_of<R: Real, const N: usize>(factor: &SMatrix<R, N, N>) -> Spectrum<R>
where
    SMatrix<R, N, N>: Conditioned<R>,
{
    factor.spectrum().unwrap_or(Spectrum { rank: 0, condition: R::zero() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::tests::{bar_body, bar_layout, sensor};
    use nalgebra::Rotation3;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn codes(found: &Diagnostics) -> Vec<Code> {
        assert!(found.iter().all(Diagnostic::is_error));
        found.iter().map(|d| d.known_code().unwrap()).collect()
    }

    fn check(layout: &Layout<f64, 3, 4>) -> Vec<Code> {
        let double = codes(&check_geometry(layout, Some(&bar_body())));
        let single: Layout<f32, 3, 4> = layout.cast().unwrap();
        let body = RigidBody::from_theta(&bar_body().theta().map(|v| v as f32));
        let in_single = codes(&check_geometry(&single, Some(&body)));
        assert_eq!(double, in_single, "single precision sees the same");
        double
    }

    #[test]
    fn a_good_layout_has_nothing_said_about_it() {
        assert_eq!(check(&bar_layout()), []);
    }

    #[test]
    fn two_sensors_are_too_few() {
        let mut layout = bar_layout();
        layout.sensors.truncate(2);
        assert_eq!(check(&layout), [Code::FewerThanThreeSensors, Code::ResponseRankDeficient]);
        layout.sensors.clear();
        assert_eq!(check(&layout), [Code::FewerThanThreeSensors, Code::ResponseRankDeficient]);
    }

    #[test]
    fn sensors_on_a_line_are_named() {
        let mut layout = bar_layout();
        layout.sensors =
            (0..3).map(|i| sensor(i, [0.05 * f64::from(i), 0.02 * f64::from(i), 0.0])).collect();
        assert_eq!(check(&layout), [Code::SensorsCollinear, Code::ResponseRankDeficient]);
        // 1 % off the line: the responses tell six motions, but badly.
        layout.sensors[1].position[2] = 0.0005;
        assert_eq!(check(&layout), [Code::SensorsCollinear]);
    }

    #[test]
    fn two_sensors_on_one_node_are_named() {
        let mut layout = bar_layout();
        layout.sensors[2] = layout.sensors[1];
        assert_eq!(
            check(&layout),
            [Code::TwoSensorsOnOneNode, Code::SensorsCollinear, Code::ResponseRankDeficient]
        );
    }

    #[test]
    fn two_hits_are_too_few() {
        let mut layout = bar_layout();
        layout.hits.truncate(2);
        assert_eq!(check(&layout), [Code::FewerThanThreeHits, Code::TenParametersNotIdentifiable]);
        layout.hits.clear();
        assert_eq!(check(&layout), [Code::FewerThanThreeHits, Code::TenParametersNotIdentifiable]);
    }

    #[test]
    fn parallel_hits_are_named() {
        let mut layout = bar_layout();
        for hit in &mut layout.hits {
            hit.direction = [0.0, 0.6, 0.8];
        }
        assert_eq!(check(&layout), [Code::HitsAllParallel, Code::TenParametersNotIdentifiable]);
    }

    #[test]
    fn hits_through_one_point_are_named() {
        let mut layout = bar_layout();
        for hit in &mut layout.hits {
            // 30 cm back along their own lines from one corner.
            hit.position = core::array::from_fn(|k| 0.2 - 0.3 * hit.direction[k]);
        }
        assert_eq!(check(&layout), [Code::HitsConcurrent, Code::TenParametersNotIdentifiable]);
        // 1 mm beside it is still too near: 2 % of L are 2.7 mm.
        layout.hits[0].position[2] += 0.001;
        assert_eq!(check(&layout), [Code::HitsConcurrent]);
    }

    #[test]
    fn hits_through_the_centre_of_mass_are_named() {
        let mut layout = bar_layout();
        let c = bar_body().center_of_mass;
        for hit in &mut layout.hits {
            hit.position = core::array::from_fn(|k| c[k] + 0.1 * hit.direction[k]);
        }
        assert_eq!(
            check(&layout),
            [
                Code::HitsConcurrent,
                Code::HitsThroughCentreOfMass,
                Code::TenParametersNotIdentifiable
            ]
        );
    }

    #[test]
    fn axes_that_are_no_axes_are_named() {
        let mut layout = bar_layout();
        layout.sensors[1].axes[0] = [0.0, 1.0, 0.1];
        layout.hits[2].direction = [1.01, 0.0, 0.0];
        let found = check_geometry(&layout, None);
        assert_eq!(codes(&found), [Code::AxesNotOrthonormal; 2]);
        assert_eq!((found[0].subject, found[1].subject), (1, 3 + 2));
    }

    #[test]
    fn a_number_that_is_not_finite_is_named_and_nothing_else() {
        for spoil in [
            |l: &mut Layout<f64, 3, 4>| l.gravity = Some([f64::NAN; 3]),
            |l: &mut Layout<f64, 3, 4>| l.sensors[2].position[1] = f64::INFINITY,
            |l: &mut Layout<f64, 3, 4>| l.sensors[0].axes[2][2] = f64::NAN,
            |l: &mut Layout<f64, 3, 4>| l.hits[0].position[0] = f64::NAN,
            |l: &mut Layout<f64, 3, 4>| l.hits[1].direction[0] = f64::NEG_INFINITY,
        ] {
            let mut layout = bar_layout();
            spoil(&mut layout);
            assert_eq!(check(&layout), [Code::LayoutNotFinite]);
        }
    }

    #[test]
    fn a_body_that_cannot_turn_is_no_body_to_check_with() {
        let mut body = bar_body();
        body.inertia = Matrix3::zeros();
        assert_eq!(
            codes(&check_geometry(&bar_layout(), Some(&body))),
            [Code::TenParametersNotIdentifiable]
        );
    }

    #[test]
    fn the_assumed_body_sits_at_the_mean_of_the_nodes() {
        let layout = bar_layout();
        let nodes = [[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]];
        let body = assumed_body(&layout, None, nodes.into_iter());
        assert_eq!((body.mass, body.center_of_mass), (1.0, Vector3::new(0.5, 1.0, 1.5)));
        let heavy = assumed_body(&layout, Some(2.0), nodes.into_iter());
        let length = layout.characteristic_length();
        assert_eq!(heavy.inertia, Matrix3::from_diagonal_element(2.0 * length * length));
    }

    proptest! {
        #[test]
        fn the_diagnosis_does_not_depend_on_the_frame(
            turn in prop::array::uniform3(-3.0..3.0_f64),
            which in 0..4_usize,
        ) {
            let mut layout = bar_layout();
            match which {
                0 => layout.sensors[1].position = layout.sensors[0].position.map(|v| v + 0.2),
                1 => layout.hits.iter_mut().for_each(|h| h.position = [0.1; 3]),
                2 => layout.hits.iter_mut().for_each(|h| h.direction = [0.0, 0.0, 1.0]),
                _ => {}
            }
            let before = check(&layout);
            let r = Rotation3::new(Vector3::from(turn));
            let turned = |v: [f64; 3]| -> [f64; 3] { (r * Vector3::from(v)).into() };
            for s in &mut layout.sensors {
                s.position = turned(s.position);
                s.axes = s.axes.map(turned);
            }
            for h in &mut layout.hits {
                h.position = turned(h.position);
                h.direction = turned(h.direction);
            }
            let b = bar_body();
            let body = RigidBody {
                center_of_mass: r * b.center_of_mass,
                inertia: r * b.inertia * r.transpose(),
                ..b
            };
            prop_assert_eq!(codes(&check_geometry(&layout, Some(&body))), before.clone());
            let single: Layout<f32, 3, 4> = layout.cast().unwrap();
            let body = RigidBody::from_theta(&body.theta().map(|v| v as f32));
            prop_assert_eq!(codes(&check_geometry(&single, Some(&body))), before);
        }
    }

    #[test]
    fn more_facts_than_fit_are_dropped_without_harm() {
        let mut layout: Layout<f64, 8, 24> = bar_layout().cast().unwrap();
        while layout.hits.push(layout.hits[0]).is_ok() {}
        layout.hits.iter_mut().for_each(|h| h.direction = [2.0, 0.0, 0.0]);
        assert_eq!(codes(&check_geometry(&layout, None)), [Code::AxesNotOrthonormal; 16]);
    }

    #[test]
    fn the_report_has_the_condition_of_the_theory() {
        let report = LayoutReport::new(&bar_layout(), Some(&bar_body()));
        assert_eq!((report.rank_g, report.rank_f, report.rank_a), (6, 3, Some(10)));
        // Theory, section 8: cond A of test 1 is 21.
        assert!((report.condition_a.unwrap() - 21.0).abs() < 0.5);
    }
}
