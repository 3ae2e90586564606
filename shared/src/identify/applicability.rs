//! Which methods can identify the object under a layout.
//!
//! [`LayoutReport`] names the facts of a layout; their consequences depend on the method. Sensors that do not
//! determine all six motions (fewer than three, or on a line) rule out the inertia restraint method, which
//! starts from the motion; maximum likelihood compares readings and still works. Hits that leave a
//! combination of the ten properties undetermined rule out every method, unless priors supply it.

use nalgebra::SVector;

use super::Method;
use crate::body::{RigidBody, regressor, scale};
use crate::capacity::Capacity;
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::layout::{Hit, Layout, LayoutReport, Prior, TestProfile};
use crate::linalg::{LeastSquares, Spectrum};
use crate::real::Real;

/// Applicability of each method under a layout.
///
/// The rules are in theory, section 4.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::{Applicability, Method};
/// let mut layout = frame::layout();
/// let methods = [Method::MaximumLikelihood, Method::InertiaRestraint];
/// let applicability = Applicability::new(&layout, &frame::body(), &methods);
/// assert!(applicability.diagnostics.is_empty() && applicability.rank == 10);
/// layout.sensors.pop();
/// let applicability = Applicability::new(&layout, &frame::body(), &methods);
/// assert!(applicability.admits(Method::MaximumLikelihood));
/// assert!(!applicability.admits(Method::InertiaRestraint));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Applicability<R> {
    /// Findings about the layout: an error when none of the requested methods can work, a warning when some
    /// can.
    pub diagnostics: Diagnostics,
    /// Figures of the geometry.
    pub geometry: LayoutReport<R>,
    /// Rank of the derivative of readings and priors with respect to the inertial parameters: ten when they
    /// can be determined.
    pub rank: usize,
    /// Condition of that derivative in balanced variables.
    pub condition: R,
    /// True when priors supply what the hits leave undetermined.
    prior_of_inertia: bool,
}

impl<R: Real> Applicability<R> {
    /// Examines a layout for `body`, the assumed body of the object; `methods` are the requested ones.
    pub fn new<C: Capacity>(
        layout: &Layout<R, C>,
        body: &RigidBody<R>,
        methods: &[Method],
    ) -> Self {
        let geometry = LayoutReport::new(layout, Some(body));
        let spectrum = information_spectrum(layout, body);
        let (rank, condition) = spectrum.unwrap_or((0, R::zero()));
        let mut diagnostics = geometry.diagnostics.clone();
        let unknown = Code::TenParametersNotIdentifiable;
        let reported = [unknown, Code::LayoutNotFinite];
        if rank < 10 && !diagnostics.iter().any(|d| reported.contains(&d.code)) {
            // There is room for sixteen diagnostics; any others are dropped.
            let _ = diagnostics.push(Diagnostic::whole(unknown, Severity::Error, rank as f32));
        }
        let prior_of_inertia = rank == 10 && layout.priors.iter().any(Prior::is_of_inertia);
        for diagnostic in &mut diagnostics {
            let blocks =
                |method: &Method| (method.entry().is_blocked)(diagnostic.code, prior_of_inertia);
            let blocked = methods.iter().all(blocks);
            diagnostic.severity = if blocked { Severity::Error } else { Severity::Warning };
        }
        Self { diagnostics, geometry, rank, condition, prior_of_inertia }
    }

    /// The codes that rule out a method; empty when it is applicable.
    pub fn obstacles(&self, method: Method) -> impl Iterator<Item = Code> + '_ {
        let codes = self.diagnostics.iter().map(|d| d.code);
        codes.filter(move |&code| (method.entry().is_blocked)(code, self.prior_of_inertia))
    }

    /// What there is to report of a layout for a test of this profile, whose methods must be the requested ones. Of the
    /// methods that use the modes, mass lines concern one alone (the modal constant): what rules out no other is its
    /// [obstacle](Self::obstacles) and no finding about the layout.
    pub fn findings(&self, profile: TestProfile) -> Diagnostics {
        let mut findings = self.diagnostics.clone();
        if profile == TestProfile::Suspension {
            findings.retain(Diagnostic::is_error);
        }
        findings
    }

    /// True when nothing rules out the method.
    pub fn admits(&self, method: Method) -> bool {
        self.obstacles(method).next().is_none()
    }
}

/// Rank and condition of the derivative of all readings and priors with respect to the ten properties, about
/// the sensors' centroid and in balanced units. The rank is ten when the inertial parameters can be
/// determined (theory, section 4: the rank of the information is that of its factor). `None` when the body
/// has no inertia or a number is not finite.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::information_spectrum;
/// let mut layout = frame::layout();
/// assert_eq!(information_spectrum(&layout, &frame::body()).unwrap().0, 10);
/// // Two hits leave one combination of the ten properties undetermined, whatever the number of sensors.
/// layout.hits.pop();
/// assert_eq!(information_spectrum(&layout, &frame::body()).unwrap().0, 9);
/// ```
pub fn information_spectrum<R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    body: &RigidBody<R>,
) -> Option<(usize, R)> {
    let Spectrum { rank, condition } = spectrum_under(layout, layout.hits.iter(), body)?;
    Some((rank, condition))
}

/// As [`information_spectrum`], for some of the hits.
// Never inlined: this saves 0.5 KB of the firmware's deepest stack.
#[inline(never)]
pub(super) fn spectrum_under<'h, R: Real, C: Capacity>(
    layout: &Layout<R, C>,
    hits: impl Iterator<Item = &'h Hit<R>>,
    body: &RigidBody<R>,
) -> Option<Spectrum<R>> {
    let centroid = layout.sensor_centroid();
    let body = body.shifted_to(&centroid);
    let length = layout.characteristic_length();
    // Per kilogram: every element of phi is proportional to the mass.
    let scale = scale(R::one(), length);
    let inverse = body.inverse_mass_matrix()?;
    let mut slopes = LeastSquares::<R, 10>::new();
    for hit in hits {
        let by_phi = regressor(&body.acceleration(&hit.unit_force(&centroid))?);
        for sensor in layout.sensors.iter() {
            // The accelerance is inversely proportional to the mass, and its derivative to the square of the
            // mass.
            let readings = sensor.response_rows(&centroid) * inverse * (body.mass * body.mass);
            for reading in readings.row_iter() {
                slopes.push(slope(&reading.transpose().into(), &by_phi, &scale), R::zero());
            }
        }
    }
    let by_theta = body.dtheta_dphi();
    for prior in &layout.priors {
        let k = usize::from(prior.property);
        if k < 10 {
            let scale = |j: usize| {
                scale[j] / scale[k] * if (1..4).contains(&k) { body.mass } else { R::one() }
            };
            slopes.push(core::array::from_fn(|j| by_theta[(k, j)] * scale(j)), R::zero());
        }
    }
    slopes.spectrum_of_unit_columns()
}

/// One row of `−G M₀⁻¹ Eₖ M₀⁻¹ f₀`, its columns multiplied by the scales of phi.
fn slope<R: Real>(reading: &[R; 6], by_phi: &[[R; 10]; 6], scale: &SVector<R, 10>) -> [R; 10] {
    core::array::from_fn(|k| {
        let sum = reading.iter().zip(by_phi).fold(R::zero(), |sum, (r, row)| sum - *r * row[k]);
        sum * scale[k]
    })
}

#[cfg(test)]
mod tests;
