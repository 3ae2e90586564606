//! Which methods can identify under a layout.
//!
//! Facts of a layout are named by [`LayoutReport`]; what they mean differs. Sensors that do not tell all
//! six motions (fewer than three, or on a line) stop the inertia restraint method, which begins with
//! the motion; maximum likelihood compares readings and goes on. Hits that leave something of the ten
//! unmoved stop every method, unless a prior knows what they leave out.

use nalgebra::SVector;

use super::Method;
use crate::Real;
use crate::body::{RigidBody, regressor, scale};
use crate::diagnosis::{Code, Diagnostic, Diagnostics, Severity};
use crate::layout::{Hit, Layout, LayoutReport, Prior};
use crate::linalg::{LeastSquares, Spectrum};

/// What a layout lets each method do.
///
/// Theory, section 4, has the rules.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::{Applicability, Method};
/// let mut layout = frame::layout();
/// let methods = [Method::MaximumLikelihood, Method::InertiaRestraint];
/// let found = Applicability::new(&layout, &frame::body(), &methods);
/// assert!(found.diagnostics.is_empty() && found.rank == 10);
/// layout.sensors.pop();
/// let found = Applicability::new(&layout, &frame::body(), &methods);
/// assert!(found.admits(Method::MaximumLikelihood));
/// assert!(!found.admits(Method::InertiaRestraint));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Applicability<R> {
    /// What is in the way: an error leaves none of the methods that were asked for, a warning some.
    pub diagnostics: Diagnostics,
    /// The figures of the geometry.
    pub geometry: LayoutReport<R>,
    /// Rank of the readings' slopes by the inertial parameters with what is known of them: ten when the inertial parameters can be
    /// told.
    pub rank: usize,
    /// Condition of those slopes, in balanced variables.
    pub condition: R,
    /// The priors make up for what the hits do not tell.
    rescued: bool,
}

impl<R: Real> Applicability<R> {
    /// Of a layout for a body, which is what the object is thought to be; `methods` are those that
    /// are wanted.
    pub fn new<const S: usize, const H: usize>(
        layout: &Layout<R, S, H>,
        body: &RigidBody<R>,
        methods: &[Method],
    ) -> Self {
        let geometry = LayoutReport::new(layout, Some(body));
        let spectrum = information_spectrum(layout, body);
        let (rank, condition) = spectrum.unwrap_or((0, R::zero()));
        let mut diagnostics = geometry.diagnostics.clone();
        let unknown = Code::TenParametersNotIdentifiable;
        let said = [unknown, Code::LayoutNotFinite];
        if rank < 10 && !diagnostics.iter().any(|d| said.contains(&d.code)) {
            // Sixteen facts are enough to say; more are dropped.
            let _ = diagnostics.push(Diagnostic::whole(unknown, Severity::Error, rank as f32));
        }
        let rescued = rank == 10 && layout.priors.iter().any(Prior::is_of_inertia);
        for found in &mut diagnostics {
            let blocks = |method: &Method| (method.entry().is_blocked)(found.code, rescued);
            let blocked = methods.iter().all(blocks);
            found.severity = if blocked { Severity::Error } else { Severity::Warning };
        }
        Self { diagnostics, geometry, rank, condition, rescued }
    }

    /// What keeps a method from an answer; nothing when it is applicable.
    pub fn obstacles(&self, method: Method) -> impl Iterator<Item = Code> + '_ {
        let codes = self.diagnostics.iter().map(|d| d.code);
        codes.filter(move |&code| (method.entry().is_blocked)(code, self.rescued))
    }

    /// True when nothing keeps the method from an answer.
    pub fn admits(&self, method: Method) -> bool {
        self.obstacles(method).next().is_none()
    }
}

/// Rank and condition of the slopes of all readings by the ten, and of what is known of the ten, about
/// the sensors' centroid and every unknown in its own unit: rank ten when the inertial parameters can be told
/// (theory, section 4: the rank of the information is that of its factor). `None` when the body has no
/// inertia or a number is not finite.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::identify::information_spectrum;
/// let mut layout = frame::layout();
/// assert_eq!(information_spectrum(&layout, &frame::body()).unwrap().0, 10);
/// // Two hits leave one combination of the ten unseen, whatever the number of sensors.
/// layout.hits.pop();
/// assert_eq!(information_spectrum(&layout, &frame::body()).unwrap().0, 9);
/// ```
pub fn information_spectrum<R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    body: &RigidBody<R>,
) -> Option<(usize, R)> {
    let Spectrum { rank, condition } = spectrum_under(layout, layout.hits.iter(), body)?;
    Some((rank, condition))
}

/// As [`information_spectrum`] of some hits.
// Never inlined: 0.8 KB less of the firmware's deepest stack.
#[inline(never)]
pub(super) fn spectrum_under<'h, R: Real, const S: usize, const H: usize>(
    layout: &Layout<R, S, H>,
    hits: impl Iterator<Item = &'h Hit<R>>,
    body: &RigidBody<R>,
) -> Option<Spectrum<R>> {
    let centroid = layout.sensor_centroid();
    let body = body.shifted_to(&centroid);
    let length = layout.characteristic_length();
    // Per kilogram: phi has the mass in all of its elements.
    let scale = scale(R::one(), length);
    let inverse = body.inverse_mass_matrix()?;
    let mut slopes = LeastSquares::<R, 10>::new();
    for hit in hits {
        let by_phi = regressor(&body.acceleration(&hit.unit_force(&centroid))?);
        for sensor in &layout.sensors {
            // The accelerance falls with the mass, and its slope by the mass once more.
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

/// One row of `−G M₀⁻¹ Eₖ M₀⁻¹ f₀`, its columns over the scales of phi.
fn slope<R: Real>(reading: &[R; 6], by_phi: &[[R; 10]; 6], scale: &SVector<R, 10>) -> [R; 10] {
    core::array::from_fn(|k| {
        let sum = reading.iter().zip(by_phi).fold(R::zero(), |sum, (r, row)| sum - *r * row[k]);
        sum * scale[k]
    })
}

#[cfg(test)]
mod tests;
