//! The criterion for comparing layouts: the uncertainty predicted for a body.

use nalgebra::SVector;

use super::Predict;
use crate::body::{RigidBody, scale};
use crate::capacity::Capacity;
use crate::identify::maximum_likelihood::{Bound, bound};
use crate::layout::Layout;
use crate::real::Real;
use crate::responses::Responses;

/// Noise of the accelerance of a single hit, relative to the accelerance 1/m of the mass: 0.5 %. On the
/// bench, the sensors and hammer of this rig reached 0.4 % to 0.6 % on 1.23 kg with hits of 18 to 30 N; a
/// heavier object takes harder hits.
pub const DEFAULT_NOISE: f64 = 0.005;

/// A body with the noise to predict its uncertainty with, and scales to compare the inertial parameters by.
/// Theory, section 8.
///
/// ```
/// # mod frame { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/doctests/frame.rs")); }
/// # use massline_shared::design::{Criterion, DEFAULT_NOISE, Predict, total};
/// # use massline_shared::identify::maximum_likelihood::workspace;
/// let mut layout = frame::layout();
/// let criterion = Criterion::new(frame::body(), 0.14, DEFAULT_NOISE);
/// let mut memory = vec![0.0; workspace(layout.sensors.len(), layout.hits.len())];
/// layout.apparatus.hammer_gain = 0.0;
/// let predicted = total(criterion.cost(&layout, &mut memory).unwrap());
/// // 0.78 % of scale with the default budget: theory, section 8.
/// assert!((predicted - 0.0078).abs() < 0.0001);
/// layout.hits.pop();
/// assert!(criterion.cost(&layout, &mut memory).is_none());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Criterion<R> {
    /// The assumed body of the object.
    pub body: RigidBody<R>,
    /// Standard deviation of the accelerance of a single hit, (m/s²)/N.
    pub noise: R,
    /// Scale of each inertial parameter.
    pub scale: SVector<R, 10>,
}

impl<R: Real> Criterion<R> {
    /// Criterion for a body of the size `length` in m; `noise` is relative to 1/m, like [`DEFAULT_NOISE`].
    pub fn new(body: RigidBody<R>, length: R, noise: R) -> Self {
        Self { body, noise: noise / body.mass, scale: scale(body.mass, length) }
    }

    /// The same criterion for a single property, given by its index in `theta`: the others do not count.
    pub fn of_property(self, property: usize) -> Self {
        let only = |k: usize, scale: R| if k == property { scale } else { R::of(f64::INFINITY) };
        Self { scale: SVector::from_fn(|k, _| only(k, self.scale[k])), ..self }
    }

    /// The smallest uncertainty that any unbiased method can reach under a layout with its error budget,
    /// priors and hits per DOF. `None` when the layout does not determine the ten properties. For `workspace`
    /// see [`maximum_likelihood::workspace`](crate::identify::maximum_likelihood::workspace).
    pub fn bound<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        workspace: &mut [R],
    ) -> Option<Bound<R>> {
        let hits = u16::from(layout.test.hits_per_dof.max(1));
        let averaged = self.noise / R::of(f64::from(hits)).sqrt();
        let noise = |_| Responses::repeat(layout.sensors.len(), averaged);
        bound(layout, &self.body, noise, hits, workspace)
    }
}

impl<R: Real> Predict<R> for Criterion<R> {
    fn scale(&self) -> &SVector<R, 10> {
        &self.scale
    }

    /// The diagonal of [`Self::bound`].
    fn variances<C: Capacity>(
        &self,
        layout: &Layout<R, C>,
        workspace: &mut [R],
    ) -> Option<SVector<R, 10>> {
        let sigma = self.bound(layout, workspace)?.sigma();
        Some(sigma.component_mul(&sigma))
    }

    fn with_noise(&self, factor: R) -> Self {
        Self { noise: self.noise * factor, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capacity::{Rig, Unbounded};
    use crate::identify::maximum_likelihood::workspace;
    use crate::layout::tests::{bar_body, bar_layout};
    use crate::layout::{HitUncertainty, SensorUncertainty};
    use std::vec;

    fn criterion() -> Criterion<f64> {
        Criterion::new(bar_body(), 0.14, DEFAULT_NOISE)
    }

    fn cost(layout: &Layout<f64, Rig>) -> Option<f64> {
        criterion().cost(layout, &mut vec![0.0; workspace(3, 12)])
    }

    /// A layout whose only errors are those that scatter from hit to hit.
    fn only_scatter() -> Layout<f64, Rig> {
        let mut layout = bar_layout();
        layout.apparatus.hammer_gain = 0.0;
        layout.sensors.iter_mut().for_each(|s| s.uncertainty = SensorUncertainty::none());
        for hit in layout.hits.iter_mut() {
            hit.uncertainty =
                HitUncertainty { position: 0.002, direction: 0.03, ..HitUncertainty::none() };
        }
        layout
    }

    #[test]
    fn four_times_the_hits_quarter_what_scatters_and_nothing_else() {
        let times = |layout: &Layout<f64, Rig>, hits_per_dof| {
            let mut layout = layout.clone();
            layout.test.hits_per_dof = hits_per_dof;
            cost(&layout).unwrap()
        };
        let scatter = only_scatter();
        // Rounding times the condition of the information, 2e4.
        assert!((times(&scatter, 20) / times(&scatter, 5) - 0.25).abs() < 1e-11);
        let layout = bar_layout();
        assert!(times(&layout, 20) > 0.5 * times(&layout, 5));
    }

    #[test]
    fn of_a_single_property_the_cost_is_its_own() {
        let mut memory = vec![0.0; workspace(3, 12)];
        let criterion = criterion();
        let sigma = criterion.bound(&bar_layout(), &mut memory).unwrap().sigma();
        for k in [0, 3, 9] {
            let cost = criterion.of_property(k).cost(&bar_layout(), &mut memory).unwrap();
            assert!((cost.sqrt() * criterion.scale[k] / sigma[k] - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn room_that_is_not_used_changes_nothing() {
        let wide: Layout<f64, Unbounded> = bar_layout().cast().unwrap();
        let wide = criterion().cost(&wide, &mut vec![0.0; workspace(3, 4)]).unwrap();
        assert!((wide / cost(&bar_layout()).unwrap() - 1.0).abs() < 1e-11);
    }

    #[test]
    fn what_cannot_be_determined_has_no_cost() {
        let mut layout = bar_layout();
        layout.hits.truncate(2);
        assert_eq!(cost(&layout), None);
        let mut layout = bar_layout();
        layout.sensors.truncate(1);
        assert_eq!(cost(&layout), None);
        let body = RigidBody { mass: 0.0, ..bar_body() };
        let nobody = Criterion::new(body, 0.14, DEFAULT_NOISE);
        assert_eq!(nobody.cost(&bar_layout(), &mut vec![0.0; workspace(3, 12)]), None);
    }
}
